"""Every scene runs for its whole duration; then each one's own point. Closed forms are in tests/validation."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.scenes import (
    SCENES,
    car,
    cradle,
    double_pendulum,
    hanging_chain,
    hanging_mode,
    jelly,
    make_world,
    motor_rig,
    pendulum,
    plank_bridge,
    spring_mass,
)
from gsenv.solver import Scene, World

Array = NDArray[Any]

PLANAR = [name for name, spec in SCENES.items() if spec.dim == 2]
DRIVEN = {"mixer", "car", "burnout"}  # by motors
LINKS = {  # m, of the scenes whose bodies are held together without springs
    "pendulum": 1.0,
    "double_pendulum": 1.0,
    "cradle": 1.0,
    "chain": 0.25,
    "heavy_chain": 0.25,
    "hanging_chain": 0.1,
    "rope": 0.2,
    "bridge": 0.6,
    "mixer": 1.1,
    "car": 1.1,
    "burnout": 1.1,
    "wrecking_ball": 0.5,
}


@dataclass
class Run:
    """A scene from its start to its end; arrays have one entry for the start and one for each step."""

    world: World
    position: Array  # m (step, body, 2)
    angle: Array  # rad (step, body)
    energy: Array  # J (step,)
    joint_error: Array  # m (step,)
    energy_scale: float  # J, of motion at the start and of all weights over the heights that they reach

    def body(self, name: str) -> int:
        return self.world.model.body_names.index(name)

    def bodies(self, prefix: str) -> list[int]:
        return [k for k, name in enumerate(self.world.model.body_names) if name.startswith(prefix)]


@functools.cache
def run(name: str) -> Run:
    world = make_world(name)
    start = world.diagnostics()
    position, angle = [world.position[0]], [world.angle[0]]
    energy, error = [start.energy[0]], [start.joint_error[0]]
    for _ in range(round(SCENES[name].duration / world.timestep)):
        world.step()
        reading = world.diagnostics()
        position.append(world.position[0])
        angle.append(world.angle[0])
        energy.append(reading.energy[0])
        error.append(reading.joint_error[0])
    dynamic = world.model.bodies["kind"] == 2
    heights = np.array(position)[:, dynamic, 1]
    weight = 9.81 * world.parameters.bodies["mass"][0, dynamic].sum()
    scale = start.kinetic_energy[0] + weight * np.ptp(heights)
    return Run(world, np.array(position), np.array(angle), np.array(energy), np.array(error), float(scale))


@pytest.mark.parametrize("name", PLANAR)
def test_runs_to_its_end(name: str) -> None:
    done = run(name)
    assert np.isfinite(done.position).all()
    assert np.isfinite(done.angle).all()
    assert np.isfinite(done.energy).all()


@pytest.mark.parametrize("name", [name for name in PLANAR if name not in DRIVEN])
def test_gains_no_energy(name: str) -> None:
    done = run(name)
    assert done.energy.max() - done.energy[0] <= 1e-3 * done.energy_scale


@pytest.mark.parametrize("name", LINKS)
def test_holds_together(name: str) -> None:
    assert run(name).joint_error.max() < 0.01 * LINKS[name]


@pytest.mark.parametrize("name", [name for name, spec in SCENES.items() if spec.view is not None])
def test_view_shows_what_moves(name: str) -> None:
    """Four out of five moving bodies are in the view at the end, in both directions."""
    done = run(name)
    left, bottom, right, top = SCENES[name].view or (0.0, 0.0, 0.0, 0.0)
    x, y = done.position[-1, done.world.model.bodies["kind"] == 2].T
    assert np.mean((left < x) & (x < right) & (bottom < y) & (y < top)) >= 0.8


@pytest.mark.parametrize("name", [name for name, spec in SCENES.items() if spec.follow is not None])
def test_followed_body_exists_and_travels(name: str) -> None:
    done = run(name)
    assert np.ptp(done.position[:, done.body(SCENES[name].follow or ""), 0]) > 10.0


# ------------------------------------------------------------- each one's point


def test_all_dominoes_fall_one_after_the_other() -> None:
    done = run("dominoes")
    leaning = np.abs(done.angle[:, done.bodies("domino_")]) > math.radians(20.0)
    assert leaning[-1].all()
    begun = leaning.argmax(0)
    assert (np.diff(begun) > 0).all()


def test_cubes_stay_in_their_bin_and_come_to_rest() -> None:
    done = run("cubes")
    boxes = done.bodies("box_")
    assert len(boxes) == 50
    assert (np.abs(done.position[-1, boxes, 0]) < 3.0).all()
    assert (done.position[-1, boxes, 1] > 0.0).all()
    assert np.abs(done.position[-1, boxes] - done.position[-31, boxes]).max() < 0.02


def test_bridge_sags_and_holds_its_load() -> None:
    done = run("bridge")
    planks, boxes = done.bodies("plank_"), done.bodies("box_")
    assert (done.position[:, planks, 1].min(1) > -1.6).all()
    assert done.position[-1, planks, 1].min() < -0.7
    x, y = done.position[-1, boxes].T
    assert (np.abs(x) < 4.2).all()
    assert (y > -1.5).all()


def test_bridge_without_load_hangs_as_long_as_it_is() -> None:
    count, span, slack = 10, 5.0, 0.05
    scene = plank_bridge(count, span, slack, loads=0)
    lengths = [2.0 * scene.bodies[f"plank_{k}"].shapes[0].half_length for k in range(count)]
    assert lengths == pytest.approx([(1.0 + slack) * span / count] * count, rel=1e-9)


def test_rope_drapes_over_its_drum() -> None:
    done = run("rope")
    links = done.bodies("link_")
    x, y = done.position[-1, links].T
    assert (np.hypot(x, y) > 1.04).all()  # on the drum, not in it
    assert y.max() > 1.0
    assert x[0] < -0.8
    assert x[-1] > 0.8
    assert max(y[0], y[-1]) < -1.0


def test_wrecking_ball_breaks_the_wall() -> None:
    done = run("wrecking_ball")
    bricks = done.bodies("brick_")
    moved = np.hypot(*(done.position[-1, bricks] - done.position[0, bricks]).T)
    assert np.mean(moved > 1.0) > 0.5
    assert done.position[-1, bricks, 1].max() < 0.75 * done.position[0, bricks, 1].max()


def test_wall_stands_until_it_is_hit() -> None:
    done = run("wrecking_ball")
    bricks = done.bodies("brick_")
    moved = np.abs(done.position[:60, bricks] - done.position[0, bricks])
    assert moved.max() < 1e-3


def test_jelly_is_squashed_and_recovers() -> None:
    done = run("jelly")
    balls = done.bodies("ball_")
    spans = np.ptp(done.position[:, balls], axis=1)  # (step, 2)
    assert (spans[:, 1] / spans[0, 1]).min() < 0.8
    assert (spans[:, 0] / spans[0, 0]).max() > 1.05
    assert spans[-1] == pytest.approx(spans[0], rel=0.05)
    assert done.position[-1, balls, 1].min() == pytest.approx(0.12, abs=1e-3)  # the lowest ones lie on the ground


def test_jelly_keeps_its_place_without_weight() -> None:
    """Springs are relaxed at the initial poses."""
    scene = jelly(4, 3)
    world = World(scene)
    world.parameters.set(gravity=(0.0, 0.0))
    start = world.position
    world.step(60)
    assert np.abs(world.position - start).max() < 1e-9


def test_gear_of_the_mixer_holds_and_its_balls_are_mixed() -> None:
    world = make_world("mixer", world_count=4)
    ball = world.model.body_names.index("ball_0")
    world.state.bodies["velocity"][:, ball, 0] += 1e-6 * np.arange(4)  # chaotic: how often they stall it varies
    speeds, errors = [], []
    for _ in range(600):
        world.step()
        turned = world.joint_coordinate("motor")[0], world.joint_coordinate("axle")[0]
        errors.append(abs(turned[0] + turned[1]))
        speeds.append(world.joint_rate("motor").copy())
    assert max(errors) < 1e-3
    assert np.mean(np.abs(np.array(speeds) + 2.0) < 0.02) > 0.95  # the balls seldom stall it
    assert turned[1] == pytest.approx(20.0, rel=0.05)
    balls = [k for k, name in enumerate(world.model.body_names) if name.startswith("ball_")]
    x, y = world.position[0, balls].T
    assert (np.abs(x) < 2.7).all()  # none has left the tub
    assert (y > 0.0).all()
    left = np.arange(len(balls)) % 16 < 8  # those that started on the left
    assert np.mean(x[left] > 0.0) > 0.2
    assert np.mean(x[~left] < 0.0) > 0.2


def test_car_gets_over_the_hills_on_its_wheels() -> None:
    done = run("car")
    chassis = done.body("chassis")
    assert done.position[-1, chassis, 0] > 5.0 + 9.0 * 4
    assert np.abs(done.angle[:, chassis]).max() < math.radians(50.0)
    travel = [abs(done.world.joint_coordinate(f"{end}_axle")[0]) for end in ("rear", "front")]
    assert max(travel) < 0.01  # back on flat ground, where it carries its chassis at the initial height


def test_rigid_car_that_brakes_slides_as_far_as_friction_lets_it() -> None:
    world = World(car(speed=10.0, locked=True, friction=0.5))
    world.step(180)
    assert world.position[0, 1, 0] == pytest.approx(10.0**2 / (2.0 * 0.5 * 9.81), rel=2e-3)
    assert np.abs(world.linear_velocity).max() < 1e-6


def test_car_without_torque_keeps_its_speed() -> None:
    world = World(car(speed=5.0, torque=0.0))
    world.step(120)
    assert world.linear_velocity[0, 1, 0] == pytest.approx(5.0, rel=1e-6)


@pytest.mark.parametrize("raised", [1, 2, 3])
def test_cradle_passes_on_as_many_balls_as_were_raised(raised: int) -> None:
    world = World(cradle(raised))
    half_period = round(1.03 / world.timestep)  # s, 2 pi sqrt(1 m / g) / 2 and 2 % for 30 degrees
    world.step(half_period)
    degrees = np.degrees(world.angle[0, 1:])
    assert degrees[-raised:] == pytest.approx([30.0] * raised, abs=0.3)
    assert np.abs(degrees[:-raised]).max() < 0.3


# ------------------------------------------------------------- builders


@pytest.mark.parametrize(("count", "frequency"), [(1, 1.224745), (2, 1.210135), (10, 1.202777), (20, 1.202505)])
def test_hanging_mode_has_the_known_frequencies(count: int, frequency: float) -> None:
    omega, shape = hanging_mode(count)
    assert omega == pytest.approx(frequency, abs=1e-6)
    assert shape[-1] == 1.0
    assert (np.diff(shape) > 0.0).all()


def test_hanging_mode_of_many_rods_is_that_of_a_rope() -> None:
    """J0(2 omega sqrt(L / g)) = 0 at 2.404826, up to the second order in the rods' length."""
    assert hanging_mode(200)[0] == pytest.approx(2.404826 / 2.0, rel=1e-5)


@pytest.mark.parametrize("count", [1, 10])
def test_hanging_chain_swings_in_its_mode(count: int) -> None:
    """After half a period all rods are where they were, on the other side."""
    world = World(hanging_chain(count, length=1.0, degrees=1.0))
    start = world.angle[0, 1:] + 0.5 * math.pi
    omega = hanging_mode(count)[0] * math.sqrt(9.81)
    steps = round(math.pi / omega / world.timestep)
    world.step(steps)
    expected = start * math.cos(omega * steps * world.timestep)
    assert world.angle[0, 1:] + 0.5 * math.pi == pytest.approx(expected, abs=0.01 * start[-1])


@pytest.mark.parametrize("point", [False, True])
def test_pendulum_starts_at_its_angle_with_the_inertia_of_its_kind(point: bool) -> None:
    world = World(pendulum(30.0, length=2.0, point=point))
    reach = 2.0 if point else 1.0  # of the centre of mass
    expected = (reach * math.sin(math.radians(30.0)), -reach * math.cos(math.radians(30.0)))
    assert world.center_of_mass[0, 1] == pytest.approx(expected, rel=1e-12)
    world.step()  # from rest: angular acceleration g sin / length of the equivalent simple pendulum
    speed = np.hypot(*world.linear_velocity[0, 1])
    equal = 2.0 if point else 4.0 / 3.0
    assert speed == pytest.approx(9.81 * 0.5 / equal * reach * world.timestep, rel=1e-3)


def test_links_are_uniform_rods_of_the_given_mass() -> None:
    world = World(double_pendulum(length=1.0))
    assert world.parameters.bodies["mass"][0, 1:] == pytest.approx([1.0, 1.0])
    assert world.parameters.bodies["inertia"][0, 1:] == pytest.approx([1.0 / 12.0] * 2)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.2])
def test_mass_bobs_as_a_damped_oscillator(damping_ratio: float) -> None:
    world = World(spring_mass(2.0, damping_ratio, stretch=0.1))
    omega = 2.0 * math.pi * 2.0
    sag = 9.81 / omega**2
    decay, swing = damping_ratio * omega, math.sqrt(1.0 - damping_ratio**2) * omega
    world.step(75)
    t = float(world.time[0])
    bob = (0.1 - sag) * math.exp(-decay * t) * (math.cos(swing * t) + decay / swing * math.sin(swing * t))
    assert -1.0 - world.position[0, 1, 1] == pytest.approx(sag + bob, abs=1e-3 * 0.1)


def test_motor_rig_speeds_up_with_its_motor_and_stops_at_its_limit() -> None:
    world = World(motor_rig(motor_speed=10.0, motor_effort=2.0, inertia=0.5))
    world.step(60)
    assert world.joint_rate("hinge")[0] == pytest.approx(2.0 / 0.5 * 1.0, rel=1e-3)
    world.step(120)
    assert world.joint_rate("hinge")[0] == pytest.approx(10.0, rel=1e-6)
    world = World(motor_rig(motor_effort=0.0, spin=3.0, limits=(-1.0, 1.0)))
    world.step(120)
    assert world.joint_coordinate("hinge")[0] == pytest.approx(1.0, abs=1e-3)


def test_each_builder_makes_a_new_scene() -> None:
    for name, spec in SCENES.items():
        first, second = spec.build(), spec.build()
        assert isinstance(first, Scene), name
        assert first is not second
        assert first.compile().digest == second.compile().digest, name
