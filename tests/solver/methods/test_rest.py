"""Towers at rest, kept awake: they stay where they are, and seldom need a direct step."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.scenes.spatial.stacks import cube_stack
from gsenv.solver import Options, World

STEPS = 1800
SETTLED = 60  # steps
MOVED = 5e-5  # of the side of a box
SELDOM = 0.1  # of the steps


@pytest.mark.parametrize("dim", [2, 3])
def test_tower_stays_with_few_direct_steps(dim: int) -> None:
    """What stops a tower that leans must not set it in motion again: that took a direct step in one of four steps."""
    world = World(stack(50) if dim == 2 else cube_stack(50), options=Options(sleep=False))
    world.step(SETTLED)
    start = world.state.bodies["position"].copy()
    direct = 0
    for _ in range(STEPS):
        world.step()
        direct += int(world.diagnostics().sweeps[0] > 1)
    assert np.abs(world.state.bodies["position"] - start).max() < MOVED
    assert direct < SELDOM * STEPS
