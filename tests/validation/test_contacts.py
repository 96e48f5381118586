"""Sliding, rolling, tipping and stacking against closed forms, at default and accurate settings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes import mass_ratio_stack, overhang, pyramid, stack
from gsenv.scenes.spatial import block_overhang, cube_mass_ratio, cube_pyramid, cube_stack, sphere_grid
from gsenv.solver import World
from tests.validation.reference import (
    BOTH,
    CREEP,
    HEAVY_STACKING,
    LOAD,
    MOTION,
    MOVED,
    PENETRATION,
    PLANE_AND_SPACE,
    STACKING,
    Array,
    G,
    Tolerance,
    awake_world,
    length,
    run,
    world_of,
)
from tests.validation.slopes import Direction, Roller, turned_by

STACK = {2: stack, 3: cube_stack}
PYRAMID = {2: pyramid, 3: cube_pyramid}
MASS_RATIO = {2: mass_ratio_stack, 3: cube_mass_ratio}
OVERHANG = {2: overhang, 3: block_overhang}
ABOVE = pytest.mark.parametrize("above", [False, True], ids=["below", "above"])


def directions(*headings_and_turns: tuple[float, float]) -> pytest.MarkDecorator:
    """2D, and 3D towards these headings with the block turned on the slope."""
    chosen = [Direction(2), *(Direction(3, *each) for each in headings_and_turns)]
    return pytest.mark.parametrize("direction", chosen, ids=str)


def rollers(heading: float) -> pytest.MarkDecorator:
    chosen = [Roller("disk"), *(Roller(kind, h) for kind in ("sphere", "cylinder") for h in (0.0, heading))]
    return pytest.mark.parametrize("roller", chosen, ids=str)


ALL_DIRECTIONS = directions((0, 0), (30, 0), (45, 0), (90, 0), (0, 30), (45, 20))


# ---------------------------------------------------------------- sliding, rolling, tipping


@BOTH
@rollers(30.0)
def test_sliding_body_starts_to_roll(fidelity: str, roller: Roller) -> None:
    """Rolls at v0 / (1 + k), k = I / (m r^2), after slowing down at mu g."""
    speed, friction, radius = 3.0, 0.3, 0.5
    world = world_of(roller.sliding(speed, friction, radius), fidelity)
    close = MOTION.at(fidelity)
    rolled = min(close, 1e-3)  # the slip is 0 and the way is an integral: both closer than the speed itself
    final = speed / (1.0 + roller.inertia)
    end = (speed - final) / (friction * G)  # 2 v0 / (7 mu g) of a sphere, v0 / (3 mu g) of a cylinder and a disk
    # the slip falls linearly; its zero by extrapolation of two readings
    times, slips = [], []
    for _ in range(60):
        world.step()
        v, w = roller.speeds(world)
        slips.append(v - radius * w)
        times.append(world.time[0])
        if slips[-1] < 0.5 * speed and len(slips) > 2:
            break
    a, b = slips[-2], slips[-1]
    zero = times[-1] + b * (times[-1] - times[-2]) / (a - b)
    assert zero == pytest.approx(end, rel=close)
    world.step(60)
    v, w = roller.speeds(world)
    assert v == pytest.approx(final, rel=close)
    assert radius * w == pytest.approx(v, rel=rolled)
    t = float(world.time[0])
    distance = speed * end - 0.5 * friction * G * end**2 + final * (t - end)
    forward = roller.direction.forward()
    place = radius * np.eye(len(forward))[-1] + distance * forward
    assert length(world.position[0, 1] - place) < rolled * distance


@BOTH
@rollers(45.0)
def test_round_body_rolls_down_a_slope(fidelity: str, roller: Roller) -> None:
    scene = roller.on_slope(20.0)
    start = World(scene).position[0, 1]
    world = run(world_of(scene, fidelity), 2.0)
    distance = 0.5 * G * math.sin(math.radians(20.0)) / (1.0 + roller.inertia) * 2.0**2
    away = world.position[0, 1] - start - distance * roller.direction.downhill(20.0)
    assert length(away) < MOTION.at(fidelity) * distance


@BOTH
@ALL_DIRECTIONS
def test_block_slides_down_a_slope(fidelity: str, direction: Direction) -> None:
    alpha = math.radians(35.0)
    scene = direction.block(35.0)
    start = World(scene).position[0, 1]
    world = run(world_of(scene, fidelity), 2.0)
    distance = 0.5 * G * (math.sin(alpha) - 0.5 * math.cos(alpha)) * 2.0**2
    away = world.position[0, 1] - start - distance * direction.downhill(35.0)
    assert length(away) < MOTION.at(fidelity) * distance


@BOTH
@ALL_DIRECTIONS
def test_block_does_not_creep_down_a_slope(fidelity: str, direction: Direction) -> None:
    scene = direction.block(20.0)
    start = World(scene).position[0, 1]
    world = run(awake_world(scene, fidelity), 5.0)
    assert length(world.position[0, 1] - start) < CREEP.at(fidelity)


@BOTH
@directions((0, 0), (30, 20))
@ABOVE
def test_block_slides_at_the_friction_angle(fidelity: str, above: bool, direction: Direction) -> None:
    """tan(alpha) > mu, within half a degree; a flat box that cannot tip."""
    degrees = math.degrees(math.atan(0.5)) + (0.5 if above else -0.5)
    scene = direction.block(degrees, half_width=0.5)
    start = World(scene).position[0, 1]
    world = run(world_of(scene, fidelity), 4.0)
    alpha = math.radians(degrees)
    moved = length(world.position[0, 1] - start)
    slide = 0.5 * G * (math.sin(alpha) - 0.5 * math.cos(alpha)) * 4.0**2
    assert moved > 0.5 * slide if above else moved < 1e-3  # m; a slide is .6 m


@BOTH
@directions((0, 0), (30, 0))
@ABOVE
def test_block_tips_at_the_angle_of_its_edge(fidelity: str, above: bool, direction: Direction) -> None:
    """tan(alpha) > w/h, within half a degree; a rough box that cannot slide."""
    degrees = math.degrees(math.atan(0.2 / 0.5)) + (0.5 if above else -0.5)
    scene = direction.block(degrees, friction=2.0, half_width=0.2, half_height=0.5)
    world = run(world_of(scene, fidelity), 4.0)
    turned = turned_by(world, World(scene))
    assert turned > 0.5 if above else turned < 1e-2  # rad; one that tips ends on its side


# ---------------------------------------------------------------- stacking


@BOTH
@PLANE_AND_SPACE
def test_contacts_carry_the_weight_above(fidelity: str, dim: int) -> None:
    count = 10
    world = run(world_of(STACK[dim](count), fidelity), 5.0)
    contacts = world.contacts(0)
    for k in range(count):  # k-th box from below, counted from 0
        body = k + 1
        below = (contacts.body_b == body) & (contacts.body_a == body - 1)
        load = contacts.impulse[below, 0].sum()
        assert load == pytest.approx((count - k) * G * world.timestep, rel=LOAD.at(fidelity))


def layer_error(world: World, nominal: Array) -> float:
    """m: deepest penetration, or the mean height error of a layer of boxes over its number, whichever is larger."""
    error = world.position[0, 1:, -1] - nominal
    means = [abs(error[nominal == level].mean()) / (1 + i) for i, level in enumerate(np.unique(nominal))]
    return max(float(world.diagnostics().penetration[0]), *means)


def check_stands(world: World, seconds: float, tolerance: float) -> None:
    """Boxes of 1 m are where they were, without overlaps, and at rest."""
    start = world.position[0]
    run(world, seconds)
    assert layer_error(world, np.round(start[1:, -1], 6)) < tolerance
    assert np.abs((world.position[0] - start)[1:, :-1]).max() < MOVED
    assert length(world.linear_velocity[0]).max() < MOVED


@BOTH
@PLANE_AND_SPACE
@pytest.mark.parametrize("count", [10, 20, 50])
def test_tower_stands(fidelity: str, dim: int, count: int) -> None:
    check_stands(awake_world(STACK[dim](count), fidelity), 10.0, STACKING.at(fidelity))


@BOTH
@PLANE_AND_SPACE
@pytest.mark.parametrize(("ratio", "tolerance"), [(10, STACKING), (100, STACKING), (1000, HEAVY_STACKING)])
def test_light_box_carries_a_heavy_one(fidelity: str, dim: int, ratio: float, tolerance: Tolerance) -> None:
    check_stands(awake_world(MASS_RATIO[dim](ratio), fidelity), 5.0, tolerance.at(fidelity))


@BOTH
@PLANE_AND_SPACE
@pytest.mark.parametrize("base", [10, 20])
def test_pyramid_stands(fidelity: str, dim: int, base: int) -> None:
    check_stands(awake_world(PYRAMID[dim](base), fidelity), 10.0, STACKING.at(fidelity))


@PLANE_AND_SPACE
@pytest.mark.parametrize(
    ("fidelity", "count"), [*(("balanced", n) for n in range(1, 6)), *(("accurate", n) for n in range(1, 11))]
)
@pytest.mark.parametrize("fraction", [0.99, 1.01])
def test_overhang_topples_beyond_its_reach(dim: int, fidelity: str, count: int, fraction: float) -> None:
    scene = OVERHANG[dim](count, fraction)
    world = run(world_of(scene, fidelity), 10.0)
    dropped = (World(scene).position - world.position)[0, 1:, -1].max()
    assert dropped < 5e-3 if fraction < 1.0 else dropped > 0.1  # m; blocks are .4 m high


@BOTH
def test_balls_fall_apart_without_overlap(fidelity: str) -> None:
    """Deepest overlap of 216 frictionless balls, by their own positions, over 2 s."""
    world = awake_world(sphere_grid(), fidelity)
    deepest = 0.0
    for _ in range(round(2.0 / world.timestep)):
        world.step()
        place = world.position[0, 1:]
        apart = length(place[:, None] - place[None]) + 2.0 * np.eye(len(place))
        deepest = max(deepest, 1.0 - float(apart.min()), 0.5 - float(place[:, 2].min()))
    assert deepest < PENETRATION.at(fidelity)
    assert np.isfinite(world.position).all()
