"""Towers, boxes on slopes and heaps at rest, kept awake: they stay where they are, and seldom need a direct step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes import cube_drop, stack
from gsenv.scenes.spatial.stacks import cube_pyramid, cube_stack
from gsenv.solver import Options, Scene, World

MOVED = 5e-5  # m; boxes have sides of 0.3 to 1 m
SELDOM = 0.1  # of the steps


def tower(dim: int, count: int, friction: float) -> Scene:
    if dim == 2:
        return stack(count, friction=friction)
    return cube_stack(count, friction=friction)


def kept_awake(scene: Scene, settled: int) -> World:
    world = World(scene, options=Options(sleep=False))
    world.step(settled)
    return world


def check_rest(world: World, steps: int) -> None:
    """Check that in so many steps no body moves far, and few steps take more than the one sweep of each island."""
    start = world.state.bodies["position"].copy()
    direct = 0
    for _ in range(steps):
        world.step()
        readings = world.diagnostics()
        direct += int(readings.sweeps[0] > readings.islands[0])
    assert np.abs(world.state.bodies["position"] - start).max() < MOVED
    assert direct < SELDOM * steps


@pytest.mark.parametrize("dim", [2, 3])
def test_tower_stays_with_few_direct_steps(dim: int) -> None:
    """What stops a tower that leans must not set it in motion again: that took a direct step in one of four steps."""
    check_rest(kept_awake(tower(dim, 50, 0.5), 60), 1800)


@pytest.mark.parametrize("degrees", [8.0, 10.0, 12.0, 16.0])
@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_on_a_slope_stay(dim: int, degrees: float) -> None:
    """Friction holds up to 16.7 degrees; some corners slide before, whose load must not be taken for that of rest."""
    world = kept_awake(tower(dim, 3, 0.3), 60)
    for step in range(1, 481):
        angle = math.radians(degrees) * step / 480
        gravity = np.zeros(dim)
        gravity[0], gravity[-1] = 9.81 * math.sin(angle), -9.81 * math.cos(angle)
        world.parameters.worlds["gravity"][:] = gravity
        world.step()
    world.step(120)
    check_rest(world, 600)


@pytest.mark.parametrize("seed", [1, 2, 3, 5, 8])
def test_heap_stays(seed: int) -> None:
    check_rest(kept_awake(cube_drop(50, seed), 600), 600)


def test_pyramid_stays_with_few_direct_steps() -> None:
    """A few of its contacts slide a little, for which steps started from impulses that set it in motion again."""
    check_rest(kept_awake(cube_pyramid(20), 120), 300)
