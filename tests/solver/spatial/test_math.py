"""Rotations near the identity against Python's own functions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver.spatial.math import near_turn_of, near_unit


@pytest.mark.nojit
def test_small_turns_are_exact_to_rounding() -> None:
    """Also on both sides of 0.2 rad, where the series ends."""
    rng = np.random.default_rng(0)
    for size in (0.0, 1e-12, 1e-5, 0.01, 0.1, 0.1999999, 0.2000001, 1.0, 3.0):
        axis = rng.normal(size=3)
        x, y, z = (axis / np.linalg.norm(axis)).tolist()
        expected = [math.cos(0.5 * size), *(math.sin(0.5 * size) * d for d in (x, y, z))]
        assert_allclose(near_turn_of((size * x, size * y, size * z)), expected, rtol=0.0, atol=3e-16)


@pytest.mark.nojit
@pytest.mark.parametrize("excess", [0.0, 1e-15, -3e-9, 3e-9, 0.1])
def test_quaternions_become_units(excess: float) -> None:
    w, x, y, z = (math.sqrt(1.0 + excess) * d for d in (0.1, -0.7, 0.5, 0.5))
    assert_allclose(near_unit((w, x, y, z)), (0.1, -0.7, 0.5, 0.5), rtol=0.0, atol=2e-16)
