"""Towers, boxes on slopes and heaps at rest, kept awake: they stay where they are, and seldom need a direct step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.scenes import cube_drop, stack
from gsenv.scenes.spatial.stacks import cube_pyramid, cube_stack
from gsenv.solver import Options, Scene, World, planar, spatial

MOVED = 5e-5  # m; boxes have sides of 0.3 to 1 m
SELDOM = 0.1  # of the steps


def tower(dim: int, count: int, friction: float) -> Scene:
    if dim == 2:
        return stack(count, friction=friction)
    return cube_stack(count, friction=friction)


def wall(dim: int, width: int, courses: int, speed: float = 0.0) -> Scene:
    """Bricks of 1 m by 0.5 m that touch sideways, with half bricks at the ends of every second course.

    The floor, and all on it, moves at a speed in m/s along the wall.
    """
    scene = Scene(dim)
    flat = (0.0,) * (dim - 2)
    motion: dict[str, Any] = {"linear_velocity": (speed, *flat, 0.0)} if speed else {}
    slab = planar.Box((20.0, 0.5)) if dim == 2 else spatial.Box((20.0, 3.0, 0.5))
    scene.add_body("floor", "kinematic" if speed else "static", [slab], position=(0.0, *flat, -0.5), **motion)
    for course in range(courses):
        bricks = [(float(k), 0.5) for k in range(width)]  # centre and half length
        if course % 2:
            bricks = [(-0.25, 0.25), *((k + 0.5, 0.5) for k in range(width - 1)), (width - 0.75, 0.25)]
        for k, (x, half) in enumerate(bricks):
            brick = planar.Box((half, 0.25)) if dim == 2 else spatial.Box((half, 0.25, 0.25))
            place = (x, *flat, 0.25 + 0.5 * course)
            scene.add_body(f"brick_{course}_{k}", shapes=[brick], position=place, **motion)
    return scene


def kept_awake(scene: Scene, settled: int) -> World:
    world = World(scene, options=Options(sleep=False))
    world.step(settled)
    return world


def check_rest(world: World, steps: int) -> None:
    """Check that in so many steps no body moves far, and few steps take more than the one sweep of each island."""
    way, direct = way_at_rest(world, steps)
    assert way < MOVED
    assert direct < SELDOM


def way_at_rest(world: World, steps: int) -> tuple[float, float]:
    """Return how far a body moves in so many steps, and the share of those with more than a sweep of each island."""
    start = world.state.bodies["position"].copy()
    direct = 0
    for _ in range(steps):
        world.step()
        readings = world.diagnostics()
        direct += int(readings.sweeps[0] > readings.islands[0])
    return float(np.abs(world.state.bodies["position"] - start).max()), direct / steps


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


def test_heaps_stay() -> None:
    """All but one in ten, in which a box still settles after 10 s, at less than 0.1 mm/s."""
    rests = [way_at_rest(kept_awake(cube_drop(50, seed), 600), 600) for seed in range(40)]
    moved, direct = np.transpose(rests)
    assert np.median(moved) < 0.1 * MOVED
    assert np.quantile(moved, 0.9) < MOVED
    assert max(moved) < 1e-3
    assert np.quantile(direct, 0.9) < SELDOM


def test_pyramid_stays_with_few_direct_steps() -> None:
    """A few of its contacts slide a little, for which steps started from impulses that set it in motion again."""
    check_rest(kept_awake(cube_pyramid(20), 120), 300)


@pytest.mark.parametrize("fidelity", ["balanced", "fast"])
@pytest.mark.parametrize("dim", [2, 3])
def test_wall_settles_and_stays(dim: int, fidelity: str) -> None:
    """In 3D, which of its contacts side by side carry load changed from step to step, as did those on edges.

    Each step took ten sweeps and a few factors, and with the fidelity fast, bricks jittered by millimetres.
    """
    world = World(wall(dim, 16, 16), options=Options.preset(fidelity, sleep=False))
    start = world.state.bodies["position"].copy()
    unconverged = 0
    for _ in range(60):
        world.step()
        unconverged += int(world.diagnostics().unconverged[0])
    assert unconverged <= 1
    check_rest(world, 400)
    assert np.abs(world.state.bodies["position"] - start).max() < 1e-3


@pytest.mark.parametrize("fidelity", ["balanced", "fast"])
@pytest.mark.parametrize("dim", [2, 3])
def test_wall_on_a_moving_floor_stays(dim: int, fidelity: str) -> None:
    """The function that direct steps lower left the floor's velocity out: none was taken, and 3D walls collapsed."""
    world = World(wall(dim, 8, 8, 5.0), options=Options.preset(fidelity, sleep=False))
    start = world.state.bodies["position"][0].copy()
    unconverged = 0
    for _ in range(200):
        world.step()
        unconverged += int(world.diagnostics().unconverged[0])
    moved = world.state.bodies["position"][0] - start
    assert unconverged <= 2
    assert np.abs(moved - moved[0]).max() < 1e-3
