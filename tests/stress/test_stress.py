"""The solver under stress: random scenes, heaps that must come to rest, extreme numbers.

What "no energy explosion" means is defined in generator.py; benchmarks/stress.py tabulates the same cases.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Capsule, Circle, HalfPlane, Polygon
from tests.stress.batches import batches
from tests.stress.cases import Array, random_polygon
from tests.stress.generator import random_case
from tests.stress.measure import LIMIT, EnergyMeter, problems, run_case

G = 9.81
STEPS = 200


@batches(count=2000, size=50, nightly_from=300)
def test_random_scenes(seeds: range) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds in 200 steps of each scene."""
    broken = [problems(run_case(random_case(seed), STEPS)) for seed in seeds]
    assert not any(broken), "\n".join(filter(None, broken))


@pytest.mark.parametrize("seed", [70012138, 71019448, 71050108, 71066188, 71068198, 71071378])
def test_nothing_is_thrown_from_between_kinematic_bodies(seed: int) -> None:
    """Bodies jammed between others that move, so that no velocity obeys all contacts."""
    broken = problems(run_case(random_case(seed), STEPS))
    assert not broken, broken


def ground(scene: Scene, **material: Any) -> None:
    scene.add_body("ground", "static", [HalfPlane(**material)])


def box_walls(scene: Scene, width: float, height: float, **material: Any) -> None:
    """A closed box from 0 to width and height, of half-planes."""
    for name, normal, offset in (
        ("floor", (0.0, 1.0), 0.0),
        ("ceiling", (0.0, -1.0), -height),
        ("left", (1.0, 0.0), 0.0),
        ("right", (-1.0, 0.0), -width),
    ):
        scene.add_body(name, "static", [HalfPlane(normal=normal, offset=offset, **material)])


def relative_penetration(world: World) -> float:
    """Deepest overlap over the smaller extent of its bodies."""
    contacts = world.contacts(0)
    if not len(contacts):
        return 0.0
    extent = world.parameters.bodies["extent"][0]
    smaller = np.minimum(extent[contacts.body_a], extent[contacts.body_b])
    return float((-contacts.separation / smaller).max())


def dynamic(world: World) -> Array:
    return np.asarray(world.model.bodies["kind"] == 2)


# ---------------------------------------------------------------- rest


@pytest.mark.parametrize("seed", range(10))
def test_a_dropped_heap_comes_to_rest(seed: int) -> None:
    """Mixed bodies in a box: all asleep within 15 s, with no overlap above 1 % of the extent left.

    The angular damping stands for rolling resistance: without any, a polygon on a circle rocks for ever.
    """
    rng = np.random.default_rng(seed)
    scene = Scene()
    box_walls(scene, 6.0, 100.0)
    for k in range(12):
        size = float(rng.uniform(0.2, 0.5))
        shape = [
            Box(half_extents=(size, size * float(rng.uniform(0.3, 1.0)))),
            Circle(radius=size),
            Capsule(half_length=size, radius=0.4 * size),
            Polygon(vertices=random_polygon(rng, size)),
        ][int(rng.integers(4))]
        place = (1.2 + 1.2 * (k % 4), 1.0 + 1.2 * (k // 4))
        angle = float(rng.uniform(-3.0, 3.0))
        scene.add_body(f"body_{k}", shapes=[shape], position=place, angle=angle, angular_damping=1.0)
    world = World(scene)
    meter = EnergyMeter(world)
    for _ in range(15 * 60):
        world.step()
        assert meter.energy() <= meter.start + LIMIT * meter.scale
    assert world.asleep[0, dynamic(world)].all()
    assert relative_penetration(world) < 0.01


def random_tower(seed: int) -> Scene:
    """10 boxes of random sizes, masses and offsets, the load inside each support by a tenth of it."""
    rng = np.random.default_rng(seed)
    half = rng.uniform((0.3, 0.2), (0.6, 0.5), (10, 2))
    mass = np.exp(rng.uniform(np.log(0.3), np.log(3.0), 10))
    while True:
        x = np.cumsum(rng.uniform(-0.15, 0.15, 10))
        for k in range(1, 10):
            load = float((mass[k:] * x[k:]).sum() / mass[k:].sum())
            left = max(x[k] - half[k, 0], x[k - 1] - half[k - 1, 0])
            right = min(x[k] + half[k, 0], x[k - 1] + half[k - 1, 0])
            spare = 0.1 * (right - left)
            if not left + spare < load < right - spare:
                break
        else:
            break
    scene = Scene()
    ground(scene)
    y = 0.0
    for k in range(10):
        box = Box(half_extents=(float(half[k, 0]), float(half[k, 1])), friction=0.6)
        scene.add_body(f"box_{k}", shapes=[box], position=(x[k], y + half[k, 1]), mass=float(mass[k]))
        y += 2.0 * float(half[k, 1])
    return scene


@pytest.mark.parametrize("seed", range(20))
def test_random_towers_stand(seed: int) -> None:
    world = World(random_tower(seed))
    start = world.center_of_mass.copy()
    world.step(5 * 60)
    moved = np.abs(world.center_of_mass - start)[0, 1:]
    assert moved.max() < 5e-3
    assert np.abs(world.angle[0, 1:]).max() < 5e-3
    assert world.asleep[0, 1:].all()


@pytest.mark.parametrize("angle", [0.0, 0.1, math.pi / 4, 1.2])
@pytest.mark.parametrize("spin", [20.0, -200.0])
def test_spinning_box_dropped_on_its_edge(angle: float, spin: float) -> None:
    scene = Scene()
    ground(scene, friction=0.8)
    box = Box(half_extents=(0.5, 0.3), friction=0.8)
    scene.add_body(
        "box", shapes=[box], position=(0.0, 2.0), angle=angle, linear_velocity=(0.0, -10.0), angular_velocity=spin
    )
    world = World(scene)
    meter = EnergyMeter(world)
    least = meter.start
    for _ in range(30 * 60):
        world.step()
        energy = meter.energy()
        assert energy <= least + LIMIT * meter.scale  # passive: below all that was before, too
        least = min(least, energy)
    assert world.asleep[0, 1]
    assert relative_penetration(world) < 0.01


@pytest.mark.parametrize("count", [2, 20])
def test_boxes_in_one_place_part_calmly(count: int) -> None:
    """No speed beyond a fall from as high as they pile up, and at last no overlap."""
    scene = Scene()
    ground(scene)
    for k in range(count):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, 0.5))
    world = World(scene)
    meter = EnergyMeter(world, overlapping=True)
    fastest = highest = 0.0
    for _ in range(20 * 60):
        world.step()
        fastest = max(fastest, meter.top_speed())
        highest = max(highest, float(world.center_of_mass[0, 1:, 1].max()))
        assert meter.energy() <= meter.start + meter.overlap + LIMIT * meter.scale
    assert fastest < math.sqrt(2.0 * G * highest)
    assert relative_penetration(world) < 0.01


def test_nothing_sleeps_inside_the_ground() -> None:
    scene = Scene()
    ground(scene)
    scene.add_body("rod", shapes=[Box(half_extents=(0.5, 0.02))], position=(0.0, -0.08))
    world = World(scene)
    world.step(10 * 60)
    assert world.asleep[0, 1]
    assert relative_penetration(world) < 0.01


# ---------------------------------------------------------------- extreme numbers


def small_stack(size: float, gravity: float, origin: float) -> Scene:
    scene = Scene(gravity=(0.0, -gravity))
    pad = Box(half_extents=(20.0 * size, size))
    scene.add_body("ground", "static", [pad], position=(origin, origin - size))
    for k in range(5):
        box = Box(half_extents=(0.5 * size, 0.5 * size))
        scene.add_body(f"box_{k}", shapes=[box], position=(origin, origin + (k + 0.5) * size))
    return scene


at_any_scale = pytest.mark.parametrize(
    ("size", "gravity", "origin"), list(itertools.product([1e-3, 1.0, 100.0], [0.0, G, 1000.0], [0.0, 1e4, 1e6]))
)


@at_any_scale
def test_a_small_stack_stands_at_any_scale(size: float, gravity: float, origin: float) -> None:
    """Five boxes from 1 mm to 100 m, at any weight, anywhere; nothing may fall farther than its size in a step."""
    timestep = 1.0 / 60.0 if gravity == 0.0 else min(1.0 / 60.0, math.sqrt(size / gravity))
    world = World(small_stack(size, gravity, origin), options=Options(timestep=timestep))
    start = world.center_of_mass.copy()
    world.step(3 * 60)
    assert np.abs(world.center_of_mass - start).max() < 0.02 * size
    assert np.abs(world.angle).max() < 0.02
    assert relative_penetration(world) < 0.02


@at_any_scale
def test_no_scale_explodes_at_the_default_timestep(size: float, gravity: float, origin: float) -> None:
    """Also where a free fall of one step is 278 times the bodies' size (1 mm, 1000 m/s^2)."""
    world = World(small_stack(size, gravity, origin))
    meter = EnergyMeter(world)
    meter.scale = max(float(meter.mass.sum()) * gravity * 5.0 * size, 1e-12)  # not of the distance to the origin
    for _ in range(3 * 60):
        world.step()
        assert meter.energy() - meter.start <= LIMIT * meter.scale + 1e-9 * abs(meter.start)  # and round-off


@pytest.mark.parametrize("seed", range(5))
def test_timestep_changes_between_steps(seed: int) -> None:
    """A tower stands and makes no energy while the timestep jumps between 1/1000 and 1/30 s."""
    rng = np.random.default_rng(seed)
    world = World(random_tower(seed), options=Options(sleep=False))
    meter = EnergyMeter(world)
    start = world.center_of_mass.copy()
    for _ in range(400):
        world.options = replace(world.options, timestep=math.exp(rng.uniform(math.log(1e-3), math.log(1.0 / 30.0))))
        world.step()
        assert meter.energy() <= meter.start + LIMIT * meter.scale
    assert np.abs(world.center_of_mass - start).max() < 1e-2


@pytest.mark.parametrize("masses", [(1.0, 1e6), (1e6, 1.0), (1e-3, 1e3), (1e6, 1.0, 1e6)])
def test_mass_ratio_of_a_million(masses: tuple[float, ...]) -> None:
    """Nothing is thrown out: no energy is made, and the pile keeps its order and its place."""
    scene = Scene()
    ground(scene)
    for k, mass in enumerate(masses):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, k + 0.5), mass=mass)
    world = World(scene)
    meter = EnergyMeter(world)
    for _ in range(5 * 60):
        world.step()
        assert meter.energy() <= meter.start + LIMIT * meter.scale
        assert meter.top_speed() < 0.5
    place = world.center_of_mass[0, 1:]
    assert np.abs(place[:, 0]).max() < 0.05
    assert np.abs(place[:, 1] - (np.arange(len(masses)) + 0.5)).max() < 0.1


@pytest.mark.parametrize("solver", ["subspace", "nncg", "pgs"])
@pytest.mark.parametrize("round_body", [False, True])
def test_press_against_the_ground(solver: str, round_body: bool) -> None:
    """Rows that contradict each other: speeds stay near the press's, impulses near those it needs."""
    scene = Scene()
    scene.add_body("ground", "static", [Box(half_extents=(20.0, 1.0))], position=(0.0, -1.0))
    shape = Circle(radius=0.2) if round_body else Box(half_extents=(0.2, 0.2))
    scene.add_body("body", shapes=[shape], position=(0.0, 0.2))
    scene.add_body("neighbour", shapes=[Box(half_extents=(0.2, 0.2))], position=(0.405, 0.2))
    scene.add_body("press", "kinematic", [Circle(radius=0.5)], position=(-0.15, 0.95), linear_velocity=(0.0, -1.0))
    world = World(scene, options=Options(solver=solver))
    fastest = hardest = 0.0
    for step in range(200):
        if step in (40, 80):  # a pause at the bottom, then up again
            world.set_velocity("press", linear=(0.0, 0.0 if step == 40 else 1.0))
        world.step()
        assert np.isfinite(world.state.bodies["velocity"]).all()
        fastest = max(fastest, float(np.abs(world.linear_velocity[0, 1:3]).max()))
        contacts = world.contacts(0)
        hardest = max([hardest, *contacts.impulse[:, 0]])
    assert fastest < 3.0
    assert hardest < 1e4  # 0.16 kg, 1 m/s: 30 sweeps of 2 substeps ask for less than 1e3 N s


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("friction", [0.0, 100.0])
def test_friction_of_nothing_and_of_a_hundred(friction: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = Scene()
    box_walls(scene, 5.0, 100.0, friction=friction)
    for k in range(8):
        half = rng.uniform(0.2, 0.5, 2)
        place = (0.8 + 1.4 * (k % 3), 1.0 + 1.4 * (k // 3))
        box = Box(half_extents=(float(half[0]), float(half[1])), friction=friction)
        scene.add_body(f"box_{k}", shapes=[box], position=place, angle=float(rng.uniform(-3.0, 3.0)))
    world = World(scene)
    meter = EnergyMeter(world)
    least = meter.start
    for _ in range(10 * 60):
        world.step()
        energy = meter.energy()
        assert energy <= least + LIMIT * meter.scale
        least = min(least, energy)
    assert meter.kinetic() < 1e-3 * meter.scale
    assert relative_penetration(world) < 0.01


@pytest.mark.parametrize("boxes", [False, True])
def test_elastic_heap_keeps_its_energy(boxes: bool) -> None:
    """Restitution 1 without friction in a closed box, 2,000 steps: never more energy, and most of it left."""
    rng = np.random.default_rng(1)
    scene = Scene()
    material: dict[str, Any] = {"restitution": 1.0, "friction": 0.0}
    box_walls(scene, 6.0, 6.0, **material)
    for k in range(12):
        half = float(rng.uniform(0.2, 0.4))
        shape = Box(half_extents=(half, half), **material) if boxes else Circle(radius=half, **material)
        place = (0.9 + 1.4 * (k % 4), 0.9 + 1.4 * (k // 4))
        scene.add_body(f"body_{k}", shapes=[shape], position=place, linear_velocity=rng.normal(0.0, 4.0, 2).tolist())
    world = World(scene)
    meter = EnergyMeter(world)
    for _ in range(2000):
        world.step()
        assert meter.energy() <= meter.start + LIMIT * meter.scale
    assert meter.energy() > 0.5 * meter.start
