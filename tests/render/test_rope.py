"""Slack ropes against the length that their parabola has."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render.rope import find_sag

LENGTH = 2.0


def arc_length(across: float, along: float, sag: float) -> float:
    """m, of the parabola through both ends, by summing up short chords."""
    t = np.linspace(0.0, 1.0, 20001)
    x, y = across * t, along * t + 4.0 * sag * t * (1.0 - t)
    return float(np.hypot(np.diff(x), np.diff(y)).sum())


def one_sag(across: float, along: float, length: float = LENGTH) -> float:
    arrays: list[NDArray[np.float64]] = [np.array([value]) for value in (across, along, length)]
    return float(find_sag(*arrays)[0])


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2, np.pi / 2.0 - 1e-6, np.pi / 2.0, 2.8, -2.0])
@pytest.mark.parametrize("chord", [1e-3, 0.3, 1.2, 1.9, 1.9999])
def test_the_parabola_has_the_length_of_the_rope(angle: float, chord: float) -> None:
    across, along = chord * np.cos(angle), chord * np.sin(angle)
    sag = one_sag(across, along)
    assert arc_length(across, along, sag) == pytest.approx(LENGTH, rel=1e-6)


def test_a_level_rope_that_is_nearly_taut_hangs_as_the_shallow_formula_says() -> None:
    chord = LENGTH * (1.0 - 1e-5)
    assert one_sag(chord, 0.0) == pytest.approx(np.sqrt(0.375 * chord * (LENGTH - chord)), rel=1e-4)


def test_a_folded_rope_hangs_down_by_half_of_what_is_left() -> None:
    # A point that moves by y = c t + 4 s t (1 - t) goes down to (c + 4 s)^2 / 16 s and back up to c.
    assert one_sag(0.0, 0.0) == pytest.approx(0.5 * LENGTH)
    assert one_sag(0.0, 1.2) == pytest.approx(0.25 * (LENGTH + 1.6))


@pytest.mark.parametrize("length", [1.0, 0.7, 0.0, np.inf])
def test_taut_ropes_and_lines_without_a_length_are_straight(length: float) -> None:
    assert one_sag(0.6, 0.8, length) == 0.0
