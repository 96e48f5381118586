"""The solvers that Options chooses among: the same physics, no energy from transients, the same bits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gsenv.scenes import box_on_incline, mass_ratio_stack, stack
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, HalfPlane, Revolute
from tests.solver.bits import everything
from tests.stress.measure import LIMIT, EnergyMeter

G = 9.81
SETTINGS = {
    "pgs": Options(solver="pgs"),
    "nncg": Options(solver="nncg"),
    "subspace": Options(solver="subspace"),
    "newton": Options(solver="newton"),
    "soft": Options(solver="soft", substeps=4, sweeps=1),
}
each_solver = pytest.mark.parametrize("name", SETTINGS)


def awake(name: str) -> Options:
    return replace(SETTINGS[name], sleep=False)


# ---------------------------------------------------------------- closed forms


@each_solver
def test_loads_in_a_stack(name: str) -> None:
    world = World(stack(5), options=awake(name))
    world.step(120)
    contacts = world.contacts()
    loads = [contacts.impulse[contacts.body_b == b, 0].sum() / world.timestep for b in range(1, 6)]
    np.testing.assert_allclose(loads, G * np.arange(5.0, 0.0, -1.0), rtol=1e-4)


@each_solver
def test_a_stack_falls_asleep(name: str) -> None:
    world = World(stack(5), options=SETTINGS[name])
    world.step(120)
    assert world.asleep[0, 1:].all()


@each_solver
def test_friction_on_an_incline(name: str) -> None:
    """tan 20 deg < 1/2 holds; at 35 deg the way is a t^2 / 2. Soft contacts creep while they sink in."""
    held = World(box_on_incline(20.0), options=awake(name))
    start = held.position[0, 1]
    held.step(120)
    assert math.dist(held.position[0, 1], start) < (1e-3 if name == "soft" else 1e-5)
    sliding = World(box_on_incline(35.0), options=awake(name))
    start = sliding.position[0, 1]
    sliding.step(60)
    angle = math.radians(35.0)
    way = 0.5 * G * (math.sin(angle) - 0.5 * math.cos(angle))
    assert math.dist(sliding.position[0, 1], start) == pytest.approx(way, rel=5e-3 if name == "soft" else 1e-5)


def hanging_chain(links: int = 5, length: float = 0.25) -> Scene:
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[])
    before = "ground"
    for k in range(links):
        link = Box(half_extents=(0.02, 0.5 * length))
        scene.add_body(f"link_{k}", shapes=[link], mass=1.0, position=(0.0, -(k + 0.5) * length))
        scene.add_joint(f"joint_{k}", Revolute(before, f"link_{k}", anchor=(0.0, -k * length)))
        before = f"link_{k}"
    return scene


@each_solver
def test_tension_of_a_hanging_chain(name: str) -> None:
    """One sweep a substep leaves soft chains swinging up and down a little: its figure is a mean over 1 s."""
    world = World(hanging_chain(), options=awake(name))
    world.step(60)
    tension = np.zeros(5)
    for _ in range(60):
        world.step()
        tension += [world.joint_reaction(f"joint_{k}")[0, 1] / 60.0 for k in range(5)]
    np.testing.assert_allclose(tension, G * np.arange(5.0, 0.0, -1.0), rtol=1e-2 if name == "soft" else 1e-6)


@each_solver
def test_motor_at_its_bound(name: str) -> None:
    scene = Scene()
    scene.add_body("ground", "static", [])
    scene.add_body("disk", shapes=[Circle(radius=0.5)], mass=2.0)
    scene.add_joint("axle", Revolute("ground", "disk", anchor=(0.0, 0.0), motor_speed=100.0, motor_effort=1.5))
    world = World(scene, options=SETTINGS[name])
    world.step(30)
    inertia = 0.5 * 2.0 * 0.5**2
    assert world.joint_reaction("axle")[0, 2] == pytest.approx(1.5, rel=1e-9)
    assert world.angular_velocity[0, 1] == pytest.approx(1.5 / inertia * 0.5, rel=1e-9)


# ---------------------------------------------------------------- transients


def random_heap(seed: int) -> Scene:
    """Boxes and balls that fall, sheared at random, every other heap from deep inside each other."""
    rng = np.random.default_rng(seed)
    deep = seed % 2 == 1
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(friction=0.8)])
    spread = 0.3 if deep else 1.0
    for k in range(int(rng.integers(2, 9))):
        size, friction = float(rng.uniform(0.1, 0.4)), float(rng.uniform(0.0, 1.0))
        box = Box(half_extents=(size, size * float(rng.uniform(0.2, 1.0))), friction=friction)
        place = (spread * float(rng.uniform(-1.0, 1.0)), 0.4 + (0.3 if deep else 0.8 * k))
        scene.add_body(
            f"body_{k}",
            shapes=[box if rng.random() < 0.7 else Circle(radius=size, friction=friction)],
            position=place,
            angle=float(rng.uniform(-3.0, 3.0)),
            linear_velocity=(float(rng.normal(0.0, 5.0)), float(rng.normal(0.0, 2.0))),
            angular_velocity=float(rng.normal(0.0, 10.0)),
        )
    return scene


@each_solver
def test_transients_make_no_energy(name: str) -> None:
    """200 heaps: never more than at the start and in the overlap, as tests/stress has it, and no NaN."""
    for seed in range(200):
        scene = random_heap(seed)
        world = World(scene, options=SETTINGS[name])
        meter = EnergyMeter(world, overlapping=True)
        for _ in range(60):
            world.step()
            excess = meter.energy() - meter.start - meter.overlap
            assert excess <= LIMIT * meter.scale, f"seed {seed}"  # False for NaN, too


@each_solver
@pytest.mark.parametrize("round_body", [False, True])
def test_press_against_the_ground(name: str, round_body: bool) -> None:
    """Rows that contradict each other: no impulse grows without bound."""
    scene = Scene()
    scene.add_body("ground", "static", [Box(half_extents=(20.0, 1.0))], position=(0.0, -1.0))
    shape = Circle(radius=0.2) if round_body else Box(half_extents=(0.2, 0.2))
    scene.add_body("body", shapes=[shape], position=(0.0, 0.2))
    scene.add_body("press", "kinematic", [Circle(radius=0.5)], position=(-0.15, 0.95), linear_velocity=(0.0, -1.0))
    world = World(scene, options=SETTINGS[name])
    for step in range(100):
        if step == 40:
            world.set_velocity("press", linear=(0.0, 0.0))
        world.step()
        assert np.abs(world.linear_velocity[0, 1]).max() < 3.0
        assert np.abs(world.contacts().impulse).max(initial=0.0) < 1e4


# ---------------------------------------------------------------- bits


def busy() -> Scene:
    """A heap, a swinging chain with a motor, an idle box that falls asleep."""
    scene = hanging_chain(3)
    scene.add_body("floor", "static", [HalfPlane(offset=-2.0)])
    arm = Box(half_extents=(0.3, 0.05))
    scene.add_body("arm", shapes=[arm], position=(3.0, -1.0), angular_velocity=3.0)
    scene.add_joint("hinge", Revolute("ground", "arm", anchor=(2.7, -1.0), motor_speed=2.0, motor_effort=1.0))
    for k in range(6):
        shape = Circle(radius=0.2) if k % 2 else Box(half_extents=(0.25, 0.15))
        scene.add_body(f"body_{k}", shapes=[shape], position=(0.1 * k - 0.4, -1.6 + 0.35 * k), angle=0.4 * k)
    scene.add_body("idle", shapes=[Box(half_extents=(0.2, 0.2))], position=(-5.0, -1.8))
    return scene


def busy_world(name: str, numbers: range, threads: int = 1) -> World:
    world = World(busy(), len(numbers), threads=threads, options=SETTINGS[name])
    for w, number in enumerate(numbers):
        world.apply_force("link_2", force=(3.0 + number, 0.0), worlds=w)
        world.parameters.set("body_1", mass=0.5 + number, worlds=w)
    return world


@each_solver
def test_threads_and_world_count_change_nothing(name: str) -> None:
    batch = busy_world(name, range(4))
    batch.step(60)
    threaded = busy_world(name, range(4), threads=2)
    threaded.step(60)
    assert everything(threaded) == everything(batch)
    alone = busy_world(name, range(3, 4))
    alone.step(60)
    assert everything(alone, 0) == everything(batch, 3)


@each_solver
def test_a_restored_world_goes_on_bit_for_bit(name: str) -> None:
    world = busy_world(name, range(2))
    world.step(25)
    saved = world.save(1)
    world.step(30)
    other = World(busy(), options=SETTINGS[name])
    other.restore(saved)
    other.step(30)
    assert everything(other, 0) == everything(world, 1)


def test_the_solver_may_change_between_steps() -> None:
    """The last solver alone decides, whatever ran before."""
    world = World(stack(3), options=awake("pgs"))
    for name in ("newton", "soft", "nncg", "subspace", "newton"):
        world.options = awake(name)
        world.step(60)
    resting = World(stack(3), options=awake("newton"))
    resting.restore(world.save())
    world.step(10)
    resting.step(10)
    assert everything(world) == everything(resting)
    assert np.abs(world.position[0, 1:, 1] - [0.5, 1.5, 2.5]).max() < 1e-2


# ---------------------------------------------------------------- newton


def test_newton_keeps_sliding_bodies_on_the_ground() -> None:
    """The convex law alone would hold the box h mu v = 1.7 cm above the ground."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(friction=0.4)])
    box = Box(half_extents=(0.5, 0.2), friction=0.4)
    scene.add_body("box", shapes=[box], position=(0.0, 0.2), linear_velocity=(5.0, 0.0))
    world = World(scene, options=awake("newton"))
    for _ in range(30):
        world.step()
        assert abs(world.position[0, 1, 1] - 0.2) < 1e-4
    assert world.linear_velocity[0, 1, 0] == pytest.approx(5.0 - 0.4 * G * 0.5, rel=1e-4)


def heap_in_a_bin(count: int) -> Scene:
    rng = np.random.default_rng(3)
    scene = Scene()
    for name, normal, offset in (("floor", (0.0, 1.0), 0.0), ("left", (1.0, 0.0), -1.5), ("right", (-1.0, 0.0), -1.5)):
        scene.add_body(name, "static", [HalfPlane(normal=normal, offset=offset, friction=0.6)])
    for k in range(count):
        box = Box(half_extents=tuple(rng.uniform(0.2, 0.4, 2)), friction=0.6)
        place = (-1.0 + 1.0 * (k % 3), 0.6 + 0.9 * (k // 3))
        scene.add_body(f"box_{k}", shapes=[box], position=place, angle=float(rng.uniform(-3.0, 3.0)))
    return scene


def unconverged(name: str, scene: Scene, steps: int) -> int:
    world = World(scene, options=awake(name))
    total = 0
    for _ in range(steps):
        world.step()
        total += int(world.diagnostics().unconverged[0])
    return total


def test_newton_converges_where_sweeps_run_out() -> None:
    assert 3 * unconverged("newton", heap_in_a_bin(15), 120) < unconverged("nncg", heap_in_a_bin(15), 120)


def test_newton_carries_a_thousand_times_its_mass() -> None:
    world = World(mass_ratio_stack(1000.0), options=awake("newton"))
    world.step(300)
    assert np.abs(world.position[0, 1:, 1] - [0.5, 1.5]).max() < 1e-4


def test_newton_leaves_large_islands_to_sweeps() -> None:
    newton, nncg = (World(stack(31), options=awake(name)) for name in ("newton", "nncg"))
    for world in (newton, nncg):
        world.step(5)
    assert everything(newton) == everything(nncg)


# ---------------------------------------------------------------- soft


def test_soft_overlaps_leave_without_a_jump() -> None:
    """At the push speed at most, of which no velocity is left."""
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, 0.2))
    options = replace(awake("soft"), push_speed=0.4)
    world = World(scene, options=options)
    height = 0.2
    for _ in range(120):
        world.step()
        assert np.abs(world.linear_velocity[0, 1]).max() < 1e-6
        risen = world.position[0, 1, 1] - height
        height = world.position[0, 1, 1]
        assert -1e-12 <= risen <= options.push_speed * 0.5 * options.timestep * (1.0 + 1e-6)
    assert 0.45 < height < 0.5 + 1e-6


def test_soft_bodies_bounce() -> None:
    """Restitution has its own phase: apexes at e^2 of the height before."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(restitution=0.8)])
    scene.add_body("ball", shapes=[Circle(radius=0.1, restitution=0.8)], position=(0.0, 1.1))
    world = World(scene, options=awake("soft"))
    highest = 0.0
    for step in range(80):
        world.step()
        if step > 30 and world.position[0, 1, 1] > highest:
            highest = float(world.position[0, 1, 1])
    assert highest == pytest.approx(0.1 + 0.64, abs=2e-3)
