"""What the tests of the reference table share: both fidelities, worlds at them, and their tolerances."""

from __future__ import annotations

from typing import Any

import pytest

from gsenv.solver import Options, Scene, World

G = 9.81
BOTH = pytest.mark.parametrize("fidelity", ["balanced", "accurate"])


def world_of(scene: Scene, fidelity: str, **changes: Any) -> World:
    """A world at the options of a fidelity, some of them changed."""
    return World(scene, options=Options.preset(fidelity, **changes))


def awake_world(scene: Scene, fidelity: str, **changes: Any) -> World:
    """The same where nothing may sleep: what is measured goes on moving, or must not rest by decree."""
    return world_of(scene, fidelity, sleep=False, **changes)


def tolerance(fidelity: str, default: float, accurate: float) -> float:
    return default if fidelity == "balanced" else accurate
