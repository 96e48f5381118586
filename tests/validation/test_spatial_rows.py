"""Reference scenes in space with known answers, at default and accurate settings. Numbers are rows of the design's
table; linkages are in test_spatial_joints.py.

Each answer is a closed form, derived here or standard; tolerances are upper limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.accuracy.errors3d import crossings
from benchmarks.accuracy.geometry3d import conjugate, rotated
from gsenv.scenes.spatial import (
    block_on_incline,
    block_overhang,
    bouncing_spheres,
    cube_mass_ratio,
    cube_pyramid,
    cube_stack,
    roller_on_incline,
    sliding_roller,
    sphere_grid,
    spinning_box,
    thrown_box,
)
from gsenv.scenes.spatial.turning import Vec, about, level
from gsenv.solver import Scene, World
from gsenv.solver.spatial.shapes import Box
from tests.validation.fidelity import BOTH, G, awake_world, tolerance, world_of

Array = NDArray[np.float64]
ROUND = pytest.mark.parametrize(("kind", "inertia"), [("sphere", 0.4), ("cylinder", 0.5)])  # over m r^2
# where the plane falls to, and how the block is turned on it, degrees
DIRECTIONS = pytest.mark.parametrize(("heading", "turn"), [(0, 0), (30, 0), (45, 0), (90, 0), (0, 30), (45, 20)])


def run(world: World, seconds: float) -> World:
    world.step(round(seconds / world.timestep))
    return world


def length(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


def downhill(degrees: float, heading: float) -> Array:
    a, h = math.radians(degrees), math.radians(heading)
    return np.array([math.cos(a) * math.cos(h), math.cos(a) * math.sin(h), -math.sin(a)])


def energy_excess(world: World, seconds: float) -> float:
    """Largest energy above the initial one, over the scene's scale sum m g L."""
    start = world.diagnostics().energy[0]
    mass = np.where(world.model.bodies["kind"] == 2, world.parameters.mass[0], 0.0)
    height = np.ptp(world.center_of_mass[0, mass > 0.0, 2]) + 1.0
    worst = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        worst = max(worst, world.diagnostics().energy[0] - start)
    return float(worst / (mass.sum() * G * height))


@BOTH
def test_1_stack_loads(fidelity: str) -> None:
    count = 10
    world = run(world_of(cube_stack(count), fidelity), 5.0)
    contacts = world.contacts(0)
    for k in range(count):  # k-th box from below, counted from 0
        body = k + 1
        below = (contacts.body_b == body) & (contacts.body_a == body - 1)
        load = contacts.impulse[below, 0].sum()
        assert load == pytest.approx((count - k) * G * world.timestep, rel=tolerance(fidelity, 1e-2, 1e-6))


@BOTH
@pytest.mark.parametrize("attitude", [0.0, 37.0])
def test_4_tumbling(fidelity: str, attitude: float) -> None:
    """Flips at 10.9169135 s, then every 19.5528671 s; energy and the vector of angular momentum are kept."""
    inertia = np.array([1.0, 2.0, 3.0])
    world = awake_world(spinning_box(rotation=about(0, attitude)), fidelity)
    steps = round(60.0 / world.timestep)
    turns, spins = np.empty((steps + 1, 4)), np.empty((steps + 1, 3))
    turns[0], spins[0] = world.orientation[0, 0], world.angular_velocity[0, 0]
    for k in range(1, steps + 1):
        world.step()
        turns[k], spins[k] = world.orientation[0, 0], world.angular_velocity[0, 0]
    own = rotated(conjugate(turns), spins)
    close = tolerance(fidelity, 1e-3, 1e-6)
    flips = crossings(np.linspace(0.0, 60.0, steps + 1), own[:, 1])
    np.testing.assert_allclose(flips, 10.9169135 + 19.5528671 * np.arange(3), rtol=close)
    energy = 0.5 * (inertia * own**2).sum(-1)
    np.testing.assert_allclose(energy, energy[0], rtol=close)
    momentum = rotated(turns, inertia * own)
    assert length(momentum - momentum[0]).max() < close * length(momentum[0])


@BOTH
@ROUND
@pytest.mark.parametrize("heading", [0.0, 30.0])
def test_6_slides_then_rolls(fidelity: str, kind: str, inertia: float, heading: float) -> None:
    """Rolls at v0 / (1 + k), k = I / (m r^2), after slowing down at mu g."""
    speed, friction, radius = 3.0, 0.3, 0.5
    world = world_of(sliding_roller(kind, speed, friction, radius, heading), fidelity)
    close, forward = tolerance(fidelity, 1e-2, 1e-4), np.array(level(heading))
    axle = np.cross([0.0, 0.0, 1.0], forward)
    final = speed / (1.0 + inertia)
    end = (speed - final) / (friction * G)  # 2 v0 / (7 mu g) of a sphere, v0 / (3 mu g) of a cylinder
    # the slip falls linearly; its zero by extrapolation of two readings
    times, slips = [], []
    for _ in range(60):
        world.step()
        slips.append(world.linear_velocity[0, 1] @ forward - radius * world.angular_velocity[0, 1] @ axle)
        times.append(world.time[0])
        if slips[-1] < 0.5 * speed and len(slips) > 2:
            break
    a, b = slips[-2], slips[-1]
    zero = times[-1] + b * (times[-1] - times[-2]) / (a - b)
    assert zero == pytest.approx(end, rel=close)
    world.step(60)
    v, w = world.linear_velocity[0, 1] @ forward, world.angular_velocity[0, 1] @ axle
    assert v == pytest.approx(final, rel=close)
    assert radius * w == pytest.approx(v, rel=min(close, 1e-3))
    t = float(world.time[0])
    distance = speed * end - 0.5 * friction * G * end**2 + final * (t - end)
    place = np.array([0.0, 0.0, radius]) + distance * forward
    assert length(world.position[0, 1] - place) < min(close, 1e-3) * distance


@BOTH
@ROUND
@pytest.mark.parametrize("heading", [0.0, 45.0])
def test_7_rolls_down(fidelity: str, kind: str, inertia: float, heading: float) -> None:
    scene = roller_on_incline(kind, 20.0, heading)
    start = World(scene).position[0, 1]
    world = run(world_of(scene, fidelity), 2.0)
    distance = 0.5 * G * math.sin(math.radians(20.0)) / (1.0 + inertia) * 2.0**2
    away = world.position[0, 1] - start - distance * downhill(20.0, heading)
    assert length(away) < tolerance(fidelity, 1e-2, 1e-4) * distance


@BOTH
@DIRECTIONS
def test_8_block_slides(fidelity: str, heading: float, turn: float) -> None:
    alpha = math.radians(35.0)
    scene = block_on_incline(35.0, heading, turn)
    start = World(scene).position[0, 1]
    world = run(world_of(scene, fidelity), 2.0)
    distance = 0.5 * G * (math.sin(alpha) - 0.5 * math.cos(alpha)) * 2.0**2
    away = world.position[0, 1] - start - distance * downhill(35.0, heading)
    assert length(away) < tolerance(fidelity, 1e-2, 1e-4) * distance


@BOTH
@DIRECTIONS
def test_8_block_does_not_creep(fidelity: str, heading: float, turn: float) -> None:
    scene = block_on_incline(20.0, heading, turn)
    start = World(scene).position[0, 1]
    world = run(awake_world(scene, fidelity), 5.0)
    assert length(world.position[0, 1] - start) < tolerance(fidelity, 1e-4, 1e-6)


@BOTH
@pytest.mark.parametrize(("heading", "turn"), [(0, 0), (30, 20)])
@pytest.mark.parametrize("above", [False, True])
def test_9_slides_at_the_friction_angle(fidelity: str, above: bool, heading: float, turn: float) -> None:
    """tan(alpha) > mu, within half a degree; a flat box that cannot tip."""
    degrees = math.degrees(math.atan(0.5)) + (0.5 if above else -0.5)
    scene = block_on_incline(degrees, heading, turn, half_extents=(0.5, 0.5, 0.1))
    start = World(scene).position[0, 1]
    world = run(world_of(scene, fidelity), 4.0)
    alpha = math.radians(degrees)
    moved = length(world.position[0, 1] - start)
    slide = 0.5 * G * (math.sin(alpha) - 0.5 * math.cos(alpha)) * 16.0
    assert moved > 0.5 * slide if above else moved < 1e-3


@BOTH
@pytest.mark.parametrize("heading", [0, 30])
@pytest.mark.parametrize("above", [False, True])
def test_9_tips_at_the_angle_of_its_edge(fidelity: str, above: bool, heading: float) -> None:
    """tan(alpha) > w/h, within half a degree; a rough box that cannot slide."""
    half = (0.2, 0.2, 0.5)
    degrees = math.degrees(math.atan(half[0] / half[2])) + (0.5 if above else -0.5)
    scene = block_on_incline(degrees, heading, friction=2.0, half_extents=half)
    start = World(scene).orientation[0, 1]
    world = run(world_of(scene, fidelity), 4.0)
    turned = 2.0 * math.acos(min(1.0, abs(float(start @ world.orientation[0, 1]))))
    assert turned > 0.5 if above else turned < 1e-2


def apexes(world: World, body: int, seconds: float, radius: float) -> list[float]:
    """Heights of the lowest point at the tops of the flight parabolas."""
    tops = []
    z, v = world.position[0, body, 2], world.linear_velocity[0, body, 2]
    for _ in range(round(seconds / world.timestep)):
        world.step()
        z2, v2 = world.position[0, body, 2], world.linear_velocity[0, body, 2]
        # free flight through the top: the parabola's apex from this state
        if v > 0.0 >= v2 and v - v2 == pytest.approx(G * world.timestep, rel=1e-9):
            tops.append(float(z + v * v / (2 * G) - radius))
        z, v = z2, v2
    return tops


@BOTH
def test_10_bounces_keep_their_ratio(fidelity: str) -> None:
    tops = apexes(world_of(bouncing_spheres([0.8]), fidelity), 1, 4.0, 0.1)
    assert len(tops) >= 8
    for k, top in enumerate(tops[:8], start=1):
        assert top == pytest.approx(0.8 ** (2 * k), rel=tolerance(fidelity, 1e-3, 1e-5))
    assert all(a > b for a, b in pairwise(tops))


@BOTH
def test_10_bouncing_stops_in_time(fidelity: str) -> None:
    end = math.sqrt(2.0 / G) * (1 + 0.8) / (1 - 0.8)
    assert end == pytest.approx(4.0637128, abs=1e-6)
    world = awake_world(bouncing_spheres([0.8]), fidelity)
    last = 0.0
    for _ in range(300):
        world.step()
        if abs(world.linear_velocity[0, 1, 2]) > 1e-6 or world.position[0, 1, 2] > 0.1 + 1e-4:
            last = float(world.time[0])
    assert last == pytest.approx(end, abs=world.timestep + tolerance(fidelity, 1e-3, 1e-5) * end)
    assert world.position[0, 1, 2] == pytest.approx(0.1, abs=tolerance(fidelity, 1e-4, 1e-5))


@BOTH
def test_10_elastic_ball_keeps_its_height_for_100_bounces(fidelity: str) -> None:
    world = world_of(bouncing_spheres([1.0]), fidelity)
    tops = apexes(world, 1, 100 * 2 * math.sqrt(2.0 / G) + 0.5, 0.1)
    assert len(tops) >= 100
    np.testing.assert_allclose(tops[:100], 1.0, rtol=tolerance(fidelity, 1e-3, 1e-5))
    assert max(tops) <= 1.0 + 1e-9


@BOTH
def test_10_dead_ball_stays_down(fidelity: str) -> None:
    world = awake_world(bouncing_spheres([0.0]), fidelity)
    top, close = 0.0, tolerance(fidelity, 1e-3, 1e-5)
    for _ in range(120):
        world.step()
        if world.time[0] > 0.5:
            top = max(top, float(world.position[0, 1, 2]) - 0.1)
    assert top < close
    assert world.position[0, 1, 2] == pytest.approx(0.1, abs=close)


@pytest.mark.parametrize(
    ("fidelity", "count"), [*(("balanced", n) for n in range(1, 6)), *(("accurate", n) for n in range(1, 11))]
)
@pytest.mark.parametrize("fraction", [0.99, 1.01])
def test_12_overhang(fidelity: str, count: int, fraction: float) -> None:
    scene = block_overhang(count, fraction)
    world = run(world_of(scene, fidelity), 10.0)
    dropped = (World(scene).position - world.position)[0, 1:, 2].max()
    assert dropped < 5e-3 if fraction < 1.0 else dropped > 0.1


def layer_error(world: World, boxes: NDArray[np.intp], nominal: Array) -> float:
    """Deepest penetration or the mean height error of a layer, whichever is larger."""
    height = world.position[0, boxes, 2]
    levels = np.unique(nominal)
    means = [abs((height - nominal)[nominal == level].mean()) / (1 + i) for i, level in enumerate(levels)]
    return max(float(world.diagnostics().penetration[0]), *means)


def stands(world: World, seconds: float, tolerated: float) -> None:
    """Cubes of 1 m are where they were, without overlaps, and at rest."""
    start = world.position[0].copy()
    run(world, seconds)
    boxes = np.arange(1, len(start))
    assert layer_error(world, boxes, np.round(start[1:, 2], 6)) < tolerated
    assert np.abs((world.position[0] - start)[1:, :2]).max() < 1e-2
    assert length(world.linear_velocity[0]).max() < 1e-2


@BOTH
@pytest.mark.parametrize("count", [10, 20, 50])
def test_14_towers(fidelity: str, count: int) -> None:
    stands(awake_world(cube_stack(count), fidelity), 10.0, tolerance(fidelity, 5e-3, 5e-4))


@BOTH
@pytest.mark.parametrize(("ratio", "default"), [(10, 5e-3), (100, 5e-3), (1000, 3e-2)])
def test_15_heavy_on_light(fidelity: str, ratio: float, default: float) -> None:
    stands(awake_world(cube_mass_ratio(ratio), fidelity), 5.0, tolerance(fidelity, default, 5e-4))


@BOTH
@pytest.mark.parametrize("base", [10, 20])
def test_16_pyramids(fidelity: str, base: int) -> None:
    stands(awake_world(cube_pyramid(base), fidelity), 10.0, tolerance(fidelity, 5e-3, 5e-4))


@BOTH
def test_19_balls_fall_apart(fidelity: str) -> None:
    """Deepest overlap of 216 frictionless balls, by their own positions, over 2 s."""
    world = awake_world(sphere_grid(), fidelity)
    deepest = 0.0
    for _ in range(round(2.0 / world.timestep)):
        world.step()
        place = world.position[0, 1:]
        apart = length(place[:, None] - place[None]) + 2.0 * np.eye(len(place))
        deepest = max(deepest, 1.0 - float(apart.min()), 0.5 - float(place[:, 2].min()))
    assert deepest < tolerance(fidelity, 3e-2, 1e-2)
    assert np.isfinite(world.position).all()


@BOTH
def test_20_projectile_is_a_parabola(fidelity: str) -> None:
    velocity = np.array([5.0, 1.0, 7.0])
    world = world_of(thrown_box((5.0, 1.0, 7.0)), fidelity)
    for k in range(1, 121):
        world.step()
        t = k * world.timestep
        x = np.array([0.0, 0.0, 1.0]) + velocity * t + 0.5 * np.array([0.0, 0.0, -G]) * t**2
        np.testing.assert_allclose(world.position[0, 0], x, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(world.linear_velocity[0, 0], velocity - [0.0, 0.0, G * t], atol=1e-12)


@BOTH
def test_20_ball_turns_evenly(fidelity: str) -> None:
    """A body of equal moments keeps its spin, and its attitude is that of t seconds of it."""
    spin: Vec = (1.0, 2.0, 3.0)
    world = awake_world(spinning_box((2.0, 2.0, 2.0), spin), fidelity)
    rate = float(length(np.array(spin)))
    for k in range(1, 121):
        world.step()
        half = 0.5 * rate * k * world.timestep
        expected = np.array([math.cos(half), *(math.sin(half) / rate * np.array(spin))])
        np.testing.assert_allclose(world.angular_velocity[0, 0], spin, rtol=1e-12)
        assert abs(float(expected @ world.orientation[0, 0])) == pytest.approx(1.0, abs=1e-12)


@BOTH
def test_20_momentum_of_an_isolated_heap_is_kept(fidelity: str) -> None:
    """Bodies that collide without gravity: total momentum to round-off."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    for k in range(6):
        box = Box(half_extents=(0.4, 0.3, 0.35), restitution=0.5 * (k % 2), friction=0.6)
        scene.add_body(
            f"box_{k}",
            shapes=[box],
            position=(1.5 * (k % 3), 1.2 * (k // 3), 0.1 * k),
            rotation=about(k % 3, 17.0 * k),
            linear_velocity=((1.0 - k % 3) * 2.0, 1.0 - 2.0 * (k // 3), 0.2 - 0.1 * k),
            angular_velocity=(k - 2.0, 0.3 * k, -0.5),
        )
    world = world_of(scene, fidelity)
    start = world.diagnostics().momentum[0]
    scale = (world.parameters.mass[0] * length(world.linear_velocity[0])).sum()
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
        lambda: cube_stack(10),
        lambda: cube_pyramid(10),
        lambda: cube_mass_ratio(1000.0),
        lambda: bouncing_spheres(),
        lambda: block_on_incline(35.0, 30.0, 20.0),
        lambda: roller_on_incline("cylinder"),
        lambda: sliding_roller("sphere"),
        lambda: block_overhang(5, 1.01),
        lambda: sphere_grid(3),
    ],
    ids=["stack", "pyramid", "mass_ratio", "bounce", "incline", "roll", "slide", "overhang", "balls"],
)
def test_energy_is_never_made(fidelity: str, build: Callable[[], Scene]) -> None:
    assert energy_excess(world_of(build(), fidelity), 3.0) < tolerance(fidelity, 1e-3, 1e-6)
