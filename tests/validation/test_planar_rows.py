"""Reference scenes with known answers, at default and accurate settings. Numbers are rows of the design's table.

Each answer is a closed form, derived here or standard; tolerances are upper limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from gsenv.scenes import (
    bouncing_balls,
    box_on_incline,
    disk_on_incline,
    mass_ratio_stack,
    overhang,
    projectile,
    pyramid,
    sliding_disk,
    stack,
)
from gsenv.solver import Box, Scene, World
from tests.validation.fidelity import BOTH, G, awake_world, tolerance, world_of


def run(world: World, seconds: float) -> World:
    world.step(round(seconds / world.timestep))
    return world


def energy_excess(world: World, seconds: float) -> float:
    """Largest energy above the initial one, over the scene's scale sum m g L."""
    start = world.diagnostics().energy[0]
    mass = np.where(world.model.bodies["kind"] == 2, world.parameters.mass[0], 0.0)
    height = np.ptp(world.center_of_mass[0, mass > 0.0, 1]) + 1.0
    worst = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        worst = max(worst, world.diagnostics().energy[0] - start)
    return float(worst / (mass.sum() * G * height))


@BOTH
def test_1_stack_loads(fidelity: str) -> None:
    count = 10
    world = run(world_of(stack(count), fidelity), 5.0)
    contacts = world.contacts(0)
    for k in range(count):  # k-th box from below, counted from 0
        body = k + 1
        below = (contacts.body_b == body) & (contacts.body_a == body - 1)
        load = contacts.impulse[below, 0].sum()
        assert load == pytest.approx((count - k) * G * world.timestep, rel=tolerance(fidelity, 1e-2, 1e-6))


@BOTH
def test_6_sliding_disk_starts_to_roll(fidelity: str) -> None:
    speed, friction, radius = 3.0, 0.3, 0.5
    world = world_of(sliding_disk(speed, friction, radius), fidelity)
    close = tolerance(fidelity, 1e-2, 1e-4)
    # slip = v - r w falls linearly: v0 - 3 mu g t; its zero by extrapolation of two readings
    times, slips = [], []
    for _ in range(60):
        world.step()
        v = world.linear_velocity[0, 1, 0]
        slips.append(v + radius * world.angular_velocity[0, 1])
        times.append(world.time[0])
        if slips[-1] < 0.5 * speed and len(slips) > 2:
            break
    a, b = slips[-2], slips[-1]
    zero = times[-1] + b * (times[-1] - times[-2]) / (a - b)
    assert zero == pytest.approx(speed / (3 * friction * G), rel=close)
    world.step(60)
    v = world.linear_velocity[0, 1, 0]
    assert v == pytest.approx(2 / 3 * speed, rel=close)
    assert radius * world.angular_velocity[0, 1] == pytest.approx(-v, rel=min(close, 1e-3))
    # distance: mu g t^2/2 of slowing down until the slip ends, then 2/3 v0
    t = float(world.time[0])
    t1 = speed / (3 * friction * G)
    distance = speed * t1 - 0.5 * friction * G * t1**2 + 2 / 3 * speed * (t - t1)
    assert world.position[0, 1, 0] == pytest.approx(distance, rel=min(close, 1e-3))


@BOTH
def test_7_rolling_on_incline(fidelity: str) -> None:
    world = run(world_of(disk_on_incline(20.0), fidelity), 2.0)
    start = World(disk_on_incline(20.0)).position[0, 1]
    distance = np.hypot(*(world.position[0, 1] - start))
    expected = 0.5 * (2 / 3) * G * math.sin(math.radians(20.0)) * 2.0**2
    assert distance == pytest.approx(expected, rel=tolerance(fidelity, 1e-2, 1e-4))


@BOTH
def test_8_block_slides(fidelity: str) -> None:
    alpha = math.radians(35.0)
    start = World(box_on_incline(35.0)).position[0, 1]
    world = run(world_of(box_on_incline(35.0), fidelity), 2.0)
    distance = np.hypot(*(world.position[0, 1] - start))
    expected = 0.5 * G * (math.sin(alpha) - 0.5 * math.cos(alpha)) * 2.0**2
    assert distance == pytest.approx(expected, rel=tolerance(fidelity, 1e-2, 1e-4))


@BOTH
def test_8_block_does_not_creep(fidelity: str) -> None:
    start = World(box_on_incline(20.0)).position[0, 1]
    world = run(awake_world(box_on_incline(20.0), fidelity), 5.0)
    assert np.hypot(*(world.position[0, 1] - start)) < tolerance(fidelity, 1e-4, 1e-6)


@BOTH
@pytest.mark.parametrize("above", [False, True])
def test_9_slides_at_the_friction_angle(fidelity: str, above: bool) -> None:
    """tan(alpha) > mu, within half a degree; a flat box that cannot tip."""
    degrees = math.degrees(math.atan(0.5)) + (0.5 if above else -0.5)
    start = World(box_on_incline(degrees, half_extents=(0.5, 0.1))).position[0, 1]
    world = run(world_of(box_on_incline(degrees, half_extents=(0.5, 0.1)), fidelity), 4.0)
    moved = np.hypot(*(world.position[0, 1] - start))
    alpha = math.radians(degrees)
    slide = 0.5 * G * (math.sin(alpha) - 0.5 * math.cos(alpha)) * 16.0
    assert moved > 0.5 * slide if above else moved < 1e-3


@BOTH
@pytest.mark.parametrize("above", [False, True])
def test_9_tips_at_the_angle_of_its_corner(fidelity: str, above: bool) -> None:
    """tan(alpha) > w/h, within half a degree; a rough box that cannot slide."""
    half = (0.2, 0.5)
    degrees = math.degrees(math.atan(half[0] / half[1])) + (0.5 if above else -0.5)
    world = run(world_of(box_on_incline(degrees, friction=2.0, half_extents=half), fidelity), 4.0)
    turned = abs(world.angle[0, 1] + math.radians(degrees))
    assert turned > 0.5 if above else turned < 1e-2


def apexes(world: World, body: int, seconds: float, radius: float) -> list[float]:
    """Heights of the lowest point at the tops of the flight parabolas."""
    tops = []
    y, v = world.position[0, body, 1], world.linear_velocity[0, body, 1]
    for _ in range(round(seconds / world.timestep)):
        world.step()
        y2, v2 = world.position[0, body, 1], world.linear_velocity[0, body, 1]
        # free flight through the top: the parabola's apex from this state
        if v > 0.0 >= v2 and v - v2 == pytest.approx(G * world.timestep, rel=1e-9):
            tops.append(float(y + v * v / (2 * G) - radius))
        y, v = y2, v2
    return tops


@BOTH
def test_10_bounces_keep_their_ratio(fidelity: str) -> None:
    world = world_of(bouncing_balls([0.8]), fidelity)
    tops = apexes(world, 1, 4.0, 0.1)
    assert len(tops) >= 8
    for k, top in enumerate(tops[:8], start=1):
        assert top == pytest.approx(0.8 ** (2 * k), rel=tolerance(fidelity, 1e-3, 1e-5))
    assert all(a > b for a, b in pairwise(tops))


@BOTH
def test_10_bouncing_stops_in_time(fidelity: str) -> None:
    fall = math.sqrt(2.0 / G)
    end = fall * (1 + 0.8) / (1 - 0.8)
    assert end == pytest.approx(4.0637128, abs=1e-6)
    world = awake_world(bouncing_balls([0.8]), fidelity)
    last = 0.0
    for _ in range(300):
        world.step()
        if abs(world.linear_velocity[0, 1, 1]) > 1e-6 or world.position[0, 1, 1] > 0.1 + 1e-4:
            last = float(world.time[0])
    assert last == pytest.approx(end, abs=world.timestep + tolerance(fidelity, 1e-3, 1e-5) * end)
    assert world.position[0, 1, 1] == pytest.approx(0.1, abs=tolerance(fidelity, 1e-4, 1e-5))


@BOTH
def test_10_elastic_ball_keeps_its_height_for_100_bounces(fidelity: str) -> None:
    world = world_of(bouncing_balls([1.0]), fidelity)
    tops = apexes(world, 1, 100 * 2 * math.sqrt(2.0 / G) + 0.5, 0.1)
    assert len(tops) >= 100
    np.testing.assert_allclose(tops[:100], 1.0, rtol=tolerance(fidelity, 1e-3, 1e-5))
    assert max(tops) <= 1.0 + 1e-9


@BOTH
def test_10_dead_ball_stays_down(fidelity: str) -> None:
    world = awake_world(bouncing_balls([0.0]), fidelity)
    top = 0.0
    for _ in range(120):
        world.step()
        if world.time[0] > 0.5:
            top = max(top, float(world.position[0, 1, 1]) - 0.1)
    close = tolerance(fidelity, 1e-3, 1e-5)
    assert top < close
    assert world.position[0, 1, 1] == pytest.approx(0.1, abs=close)


@pytest.mark.parametrize(
    ("fidelity", "count"), [*(("balanced", n) for n in range(1, 6)), *(("accurate", n) for n in range(1, 11))]
)
@pytest.mark.parametrize("fraction", [0.99, 1.01])
def test_12_overhang(fidelity: str, count: int, fraction: float) -> None:
    world = run(world_of(overhang(count, fraction), fidelity), 10.0)
    dropped = (World(overhang(count, fraction)).position - world.position)[0, 1:, 1].max()
    assert dropped < 5e-3 if fraction < 1.0 else dropped > 0.1


def layer_error(world: World, boxes: np.ndarray, nominal: np.ndarray) -> float:
    """Deepest penetration or the mean height error of a layer, whichever is larger."""
    height = world.position[0, boxes, 1]
    levels = np.unique(nominal)
    means = [abs((height - nominal)[nominal == level].mean()) / (1 + i) for i, level in enumerate(levels)]
    return max(float(world.diagnostics().penetration[0]), *means)


def final_speed(world: World) -> float:
    return float(np.hypot(*world.linear_velocity[0].T).max())


@BOTH
@pytest.mark.parametrize("count", [10, 20, 50])
def test_14_towers(fidelity: str, count: int) -> None:
    world = awake_world(stack(count), fidelity)
    start = world.position[0].copy()
    world.step(600)
    assert layer_error(world, np.arange(1, count + 1), 0.5 + np.arange(count)) < tolerance(fidelity, 5e-3, 5e-4)
    assert abs(world.position[0, 1:, 0] - start[1:, 0]).max() < 1e-2
    assert final_speed(world) < 1e-2


@BOTH
@pytest.mark.parametrize(("ratio", "default"), [(10, 5e-3), (100, 5e-3), (1000, 3e-2)])
def test_15_heavy_on_light(fidelity: str, ratio: float, default: float) -> None:
    world = run(awake_world(mass_ratio_stack(ratio), fidelity), 5.0)
    assert layer_error(world, np.array([1, 2]), np.array([0.5, 1.5])) < tolerance(fidelity, default, 5e-4)
    assert final_speed(world) < 1e-2


@BOTH
@pytest.mark.parametrize("base", [10, 20])
def test_16_pyramids(fidelity: str, base: int) -> None:
    scene = pyramid(base)
    world = awake_world(scene, fidelity)
    start = world.position[0].copy()
    world.step(600)
    boxes = np.arange(1, len(start))
    assert layer_error(world, boxes, np.round(start[1:, 1], 6)) < tolerance(fidelity, 5e-3, 5e-4)
    assert abs(world.position[0, 1:, 0] - start[1:, 0]).max() < 1e-2
    assert final_speed(world) < 1e-2


@BOTH
def test_20_projectile_is_a_parabola(fidelity: str) -> None:
    velocity, spin = np.array([5.0, 7.0]), 3.0
    world = world_of(projectile(tuple(velocity), spin), fidelity)
    for k in range(1, 121):
        world.step()
        t = k * world.timestep
        x = np.array([0.0, 1.0]) + velocity * t + 0.5 * np.array([0.0, -G]) * t**2
        np.testing.assert_allclose(world.position[0, 0], x, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(world.linear_velocity[0, 0], velocity - [0, G * t], atol=1e-12)
        assert world.angle[0, 0] == pytest.approx(spin * t, rel=1e-12)


@BOTH
def test_20_momentum_of_an_isolated_heap_is_kept(fidelity: str) -> None:
    """Bodies that collide without gravity: total momentum to round-off."""
    scene = Scene(gravity=(0.0, 0.0))
    for k in range(6):
        box = Box(half_extents=(0.4, 0.3), restitution=0.5 * (k % 2), friction=0.6)
        scene.add_body(
            f"box_{k}",
            shapes=[box],
            position=(1.5 * (k % 3), 1.2 * (k // 3)),
            angle=0.3 * k,
            linear_velocity=((1.0 - k % 3) * 2.0, 1.0 - 2.0 * (k // 3)),
            angular_velocity=k - 2.0,
        )
    world = world_of(scene, fidelity)
    start = world.diagnostics().momentum[0]
    scale = (world.parameters.mass[0] * np.hypot(*world.linear_velocity[0].T)).sum()
    impacts = 0
    for _ in range(180):
        world.step()
        impacts += int(world.diagnostics().impacts[0])
    assert impacts > 0
    assert abs(world.diagnostics().momentum[0] - start).max() < 1e-12 * scale


@BOTH
@pytest.mark.parametrize(
    "build",
    [
        lambda: stack(10),
        lambda: pyramid(10),
        lambda: mass_ratio_stack(1000.0),
        lambda: bouncing_balls(),
        lambda: box_on_incline(35.0),
        lambda: overhang(5, 1.01),
    ],
    ids=["stack", "pyramid", "mass_ratio", "bounce", "incline", "overhang"],
)
def test_energy_is_never_made(fidelity: str, build: Callable[[], Scene]) -> None:
    assert energy_excess(world_of(build(), fidelity), 3.0) < tolerance(fidelity, 1e-3, 1e-6)
