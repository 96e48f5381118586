"""The check of a world's sizes and speeds that saves looking at its contacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World, planar, spatial
from gsenv.solver.core.detection import collide_pairs
from gsenv.solver.core.secondary import all_slow, any_fall, any_impact
from gsenv.solver.records.bundle import select_world


def pile(dim: int, half: float) -> Scene:
    scene = Scene(dim=dim)
    scene.add_body("ground", "static", shapes=[planar.HalfPlane() if dim == 2 else spatial.Plane()])
    for k in range(3):
        box = planar.Box(half_extents=(half, half)) if dim == 2 else spatial.Box(half_extents=(half, half, half))
        height = (2 * k + 1) * half
        scene.add_body(f"box{k}", shapes=[box], position=(0.0, height) if dim == 2 else (0.0, 0.0, height))
    return scene


@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.slow)])  # it compiles the narrowphase anew
@pytest.mark.parametrize("half", [0.5, 0.04, 0.01])
def test_slow_worlds_have_no_impact_and_no_fall(dim: int, half: float) -> None:
    world = World(pile(dim, half))
    world.step()
    kernel_world: Any = world._calls[0][1]
    select_world(kernel_world, 0)
    count = collide_pairs(kernel_world, int(world.state.worlds["pair_count"][0]), 0.0)
    assert count >= 3
    rng = np.random.default_rng(3)
    bodies, parameters = world.state.bodies[0], world.parameters.bodies[0]
    gravity = world.parameters.worlds["gravity"][0]
    found = kernel_world.scratch.found
    seen = set()
    for exponent in np.linspace(-5.0, 0.0, 60):
        speed = half * 10.0**exponent
        v = rng.normal(size=(3, bodies["velocity"].shape[1]))
        v[:, dim:] /= half
        bodies["velocity"][1:] = speed * v
        slow = bool(all_slow(kernel_world))
        fast = any_impact(found, count, bodies, world.timestep)
        falls = any_fall(found, count, parameters, gravity, world.timestep)
        assert not slow or not (fast or falls)
        seen.add((slow, bool(fast or falls)))
    assert (False, True) in seen
    assert ((True, False) in seen) == (half > 0.03)  # the smallest boxes fall too far in a step
