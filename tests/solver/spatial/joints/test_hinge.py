"""Hinge: closed forms of pendulum, torque, motor, limits and springs; turns that are counted; drift."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, World
from gsenv.solver.spatial import Box, Hinge, JointSensor
from tests.solver.spatial.joints.rigs import (
    ACCURATE,
    AWAKE,
    AXES,
    FINE,
    INERTIA,
    MASS,
    G,
    held,
    multiplied,
    oscillator,
    pendulum_period,
    quaternion,
    scene_of,
    tensor,
    travel,
)
from tests.solver.spatial.one_kernel import full_world, space

every_axis = pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
TILT = quaternion((0.36, 0.48, 0.8), 0.7)  # of the body in the hinge: its principal axes are not the hinge's


def hinge(axis: Any = (0, 1, 0), **given: Any) -> Hinge:
    return Hinge("base", "it", anchor=(0, 0, 0), axis=axis, **given)


def about(axis: Any, orientation: Any = (1, 0, 0, 0)) -> float:
    """Moment of inertia of the body about an axis through its centre."""
    return float(np.asarray(axis) @ tensor(orientation) @ np.asarray(axis))


@pytest.mark.parametrize("amplitude", [0.1, 1.5, 2.8])
def test_physical_pendulum_has_the_period_of_the_elliptic_integral(amplitude: float) -> None:
    reach = 0.5
    start = (reach * math.sin(amplitude), 0.0, -reach * math.cos(amplitude))
    world = held(hinge(), G, ACCURATE, position=start, orientation=quaternion((0, -1, 0), amplitude))
    period = pendulum_period(INERTIA[1] + MASS * reach**2, MASS, reach, amplitude)
    energy = world.diagnostics().energy[0]
    crossings, before = [], 0.0
    for k in range(1, int(3.1 * period / world.timestep)):
        world.step()
        angle = amplitude - world.joint_coordinate("joint")[0]  # from the vertical; q grows as it swings down
        if before > 0.0 >= angle:
            crossings.append((k - angle / (angle - before)) * world.timestep)
        before = angle
        assert world.diagnostics().energy[0] == pytest.approx(energy, abs=2e-3 * MASS * G * reach)
    assert crossings[-1] - crossings[0] == pytest.approx((len(crossings) - 1) * period, rel=2e-3)
    assert crossings[0] == pytest.approx(0.25 * period, rel=4e-3)


@every_axis
def test_torque_divided_by_inertia_is_the_acceleration(axis: Any) -> None:
    """A torque actuator on a body whose principal axes are oblique to the axis, through its centre."""
    world = held(
        hinge(axis, motor_effort=5.0), orientation=TILT, actuator={"mode": "torque", "lower": -5.0, "upper": 5.0}
    )
    world.control[:] = 0.8
    world.step(30)
    t = 30 * world.timestep
    alpha = 0.8 / about(axis, TILT)
    assert world.joint_rate("joint")[0] == pytest.approx(alpha * t, rel=1e-4)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.5 * alpha * t * t, rel=2e-3)
    assert_allclose(world.position[0, 1], 0.0, atol=1e-9)
    assert world.joint_reaction("joint")[0, 3:] @ np.asarray(axis) == pytest.approx(0.8, rel=1e-3)


@every_axis
def test_turns_are_counted_and_the_axis_stays(axis: Any) -> None:
    world = held(hinge(axis, motor_speed=9.0, motor_effort=1e3), orientation=TILT)
    world.step(300)  # 45 rad: seven turns
    assert world.joint_coordinate("joint")[0] == pytest.approx(45.0, abs=0.1)
    assert world.joint_rate("joint")[0] == pytest.approx(9.0, rel=2e-3)
    wanted = multiplied(quaternion(axis, world.joint_coordinate("joint")[0]), TILT)
    assert abs(world.orientation[0, 1] @ wanted) == pytest.approx(1.0, abs=1e-7)
    assert world.diagnostics().joint_error[0] < 1e-3


def test_turns_survive_snapshot_and_batch() -> None:
    scene = scene_of(hinge(motor_speed=9.0, motor_effort=1e3), G, position=(0.1, 0, 0))
    alone = full_world(scene)
    alone.step(250)
    saved = alone.save()
    alone.step(50)
    batch = World(scene, 3, options=AWAKE)
    batch.step(100)
    batch.restore(saved)
    batch.step(50)
    for w in range(3):
        assert batch.state.bodies[w].tobytes() == alone.state.bodies[0].tobytes()
        assert batch.state.joints[w].tobytes() == alone.state.joints[0].tobytes()
    assert batch.joint_coordinate("joint")[0] == alone.joint_coordinate("joint")[0]
    assert alone.joint_coordinate("joint")[0] > 40.0


def test_motor_stalls_at_its_torque() -> None:
    """A motor of 1.5 N m lifts an arm to where the moment of the weight is 1.5 N m, and holds it there."""
    reach, effort = 0.3, 1.5
    damping = {"damping": 3.0}
    world = held(hinge((0, -1, 0), motor_speed=2.0, motor_effort=effort, **damping), G, position=(0, 0, -reach))
    world.step(1200)
    angle = math.asin(effort / (MASS * G * reach))
    assert world.joint_coordinate("joint")[0] == pytest.approx(angle, abs=1e-3)
    assert world.joint_rate("joint")[0] == pytest.approx(0.0, abs=1e-3)
    assert world.joint_reaction("joint")[0, 4] == pytest.approx(-effort, rel=1e-3)


def test_motor_with_gain_is_a_velocity_drive() -> None:
    """I w' = k (s - w): the speed approaches s exponentially; the bound makes the first part linear."""
    gain, speed, inertia = 0.4, 3.0, INERTIA[1]
    world = held(hinge(motor_speed=speed, motor_effort=1e3, motor_gain=gain))
    for k in range(1, 61):
        world.step()
        t = k * world.timestep
        assert world.joint_rate("joint")[0] == pytest.approx(speed * (1 - math.exp(-gain * t / inertia)), abs=1e-6)
    bounded = held(hinge(motor_speed=speed, motor_effort=0.3, motor_gain=gain))
    bounded.step(30)
    assert bounded.joint_rate("joint")[0] == pytest.approx(0.3 / inertia * 30 * bounded.timestep, rel=1e-6)


@every_axis
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_limit_reflects_the_speed_times_the_restitution(axis: Any, restitution: float) -> None:
    spin = 2.0 * np.asarray(axis)
    world = held(hinge(axis, limits=(-0.3, 0.4), limit_restitution=restitution), angular_velocity=spin)
    q = travel(world, 20)
    assert q.max() == pytest.approx(0.4, abs=0.02)
    assert q.max() < 0.4 + 1e-4
    assert world.joint_rate("joint")[0] == pytest.approx(-2.0 * restitution, abs=1e-3)
    world.step(25 if restitution == 1.0 else 0)
    if restitution == 1.0:  # and at the lower one
        assert world.joint_rate("joint")[0] == pytest.approx(2.0, abs=1e-3)
        energy = 0.5 * about(axis) * 4.0
        assert energy * (1 - 1e-4) < world.diagnostics().energy[0] < energy * (1 + 1e-9)


def test_arm_falls_to_rest_on_its_limit() -> None:
    world = held(hinge(limits=(-1.0, 0.6), limit_restitution=0.3), G, position=(0.4, 0, 0))
    world.step(240)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.6, abs=2e-3)
    assert abs(world.joint_rate("joint")[0]) < 1e-3
    assert world.joint_reaction("joint")[0, 4] == pytest.approx(-MASS * G * 0.4 * math.cos(0.6), rel=1e-3)


def test_soft_limit_is_a_spring_beyond_the_limit() -> None:
    f, inertia = 3.0, INERTIA[1]
    joint = hinge(limits=(-1.0, 0.2), limit_frequency=f, limit_damping_ratio=0.0)
    world = held(joint, options=FINE, angular_velocity=(0, 2.0, 0))
    start = world.diagnostics().energy[0]
    omega = 2.0 * math.pi * f
    q = travel(world, 200)
    assert q.max() == pytest.approx(0.2 + 2.0 / omega, rel=0.02)
    k = int(q.argmax())
    assert k * world.timestep == pytest.approx(0.1 + 0.25 / f, abs=2.5 * world.timestep)
    assert -2.0 * 1.0001 < world.joint_rate("joint")[0] < -2.0 * 0.95
    assert world.diagnostics().energy[0] <= start * (1 + 1e-6)
    pushed = held(joint, actuator=None)
    pushed.set_pose("it", orientation=quaternion((0, 1, 0), 0.3))
    assert pushed.diagnostics().spring_energy[0] == pytest.approx(0.5 * inertia * (omega * 0.1) ** 2, rel=1e-9)


@every_axis
@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.8])
def test_spring_swings_at_its_frequency_and_damping_ratio(axis: Any, ratio: float) -> None:
    """The frequency is that on 1 / (u I^-1 u); about an oblique axis u the body turns with u I u, which is more."""
    f, rest = 1.5, 0.5
    world = held(hinge(axis, frequency=f, damping_ratio=ratio, rest=rest), orientation=TILT, options=FINE)
    t = np.arange(1, 241) / 240.0
    q = travel(world, 240)
    inverse = float(np.asarray(axis) @ np.linalg.inv(tensor(TILT)) @ np.asarray(axis))
    slower = 1.0 / math.sqrt(inverse * about(axis, TILT))
    assert 0.8 < slower < 1.0
    wave = oscillator(t, -rest, 0.0, 2.0 * math.pi * f * slower, ratio * slower)
    assert_allclose(q - rest, wave, atol=3e-3)


def test_spring_of_given_stiffness_and_its_bound() -> None:
    k, inertia = 6.0, INERTIA[1]
    world = held(hinge(stiffness=k, rest=0.7), options=FINE)
    start = world.diagnostics()
    assert start.spring_energy[0] == pytest.approx(0.5 * k * 0.49, rel=1e-9)
    q = travel(world, 240)
    t = np.arange(1, 241) / 240.0
    assert_allclose(q - 0.7, oscillator(t, -0.7, 0.0, math.sqrt(k / inertia), 0.0), atol=1e-3)
    assert world.diagnostics().energy[0] == pytest.approx(start.energy[0], rel=2e-3)
    bounded = held(hinge(stiffness=1e4, damping=100.0, rest=2.0, spring_effort=0.5))
    bounded.step(30)
    assert bounded.joint_rate("joint")[0] == pytest.approx(0.5 / inertia * 0.5, rel=1e-6)


def test_position_actuator_moves_the_rest() -> None:
    drive = {"frequency": 4.0, "damping_ratio": 1.0}
    world = held(hinge(**drive), actuator={"mode": "position", "lower": -3.0, "upper": 3.0})
    world.control[:] = 0.9
    world.step(120)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.9, abs=1e-4)


def test_dry_friction_stops_at_a_constant_rate() -> None:
    world = held(hinge(friction_effort=0.6), angular_velocity=(0, 2.0, 0))
    q = travel(world, 60)
    alpha = 0.6 / INERTIA[1]
    stops = 2.0 / alpha
    assert q[59] == pytest.approx(2.0 * 1.0 - 0.5 * alpha, rel=1e-3)
    world.step(60)
    assert 120 * world.timestep > stops
    assert world.joint_rate("joint")[0] == pytest.approx(0.0, abs=1e-9)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.5 * 4.0 / alpha, rel=1e-2)
    world.apply_force("it", torque=(0, 0.5, 0))
    world.step()
    assert world.joint_rate("joint")[0] == pytest.approx(0.0, abs=1e-9)


def test_a_door_on_two_hinges_hangs_calm_and_swings() -> None:
    scene = space(G)
    scene.add_body("frame", "static")
    door = Box(half_extents=(0.45, 0.02, 1.0))
    scene.add_body("door", shapes=[door], position=(0.45, 0, 0), angular_velocity=(0, 0, 1.0), mass=20.0)
    for k, z in enumerate((-0.8, 0.8)):
        scene.add_joint(f"hinge_{k}", Hinge("frame", "door", anchor=(0, 0, z), axis=(0, 0, 1)))
    world = full_world(scene)
    for _ in range(240):
        world.step()
        d = world.diagnostics()
        assert d.joint_error[0] < 1e-3
        assert d.unconverged[0] == 0
    # it keeps turning: v of its centre was 0 at the start, so the hinges jerk it to L / I first
    inertia = 20.0 * (0.9**2 + 0.04**2) / 12.0
    rate = inertia / (inertia + 20.0 * 0.45**2)
    assert world.joint_rate("hinge_0")[0] == pytest.approx(rate, rel=1e-2)
    for name in ("hinge_0", "hinge_1"):
        assert world.joint_coordinate(name)[0] == pytest.approx(4.0 * rate, rel=1e-2)
    total = sum(world.joint_reaction(f"hinge_{k}")[0, :3] for k in range(2))
    inward = 20.0 * 0.45 * rate**2
    angle = world.joint_coordinate("hinge_0")[0]
    expected = (-inward * math.cos(angle), -inward * math.sin(angle), 20.0 * G)
    assert_allclose(total, expected, atol=0.02 * inward + 0.05)


def test_a_chain_of_hinges_carries_what_hangs_below_and_keeps_energy() -> None:
    scene = space(G)
    last: Any = scene.add_body("base", "static")
    for k in range(4):
        link = Box(half_extents=(0.25, 0.05, 0.05), mask=0)  # links pass each other
        scene.add_body(f"link_{k}", shapes=[link], mass=1.0, position=(0.25 + 0.5 * k, 0, 0))
        axis = (0, 1, 0) if k % 2 == 0 else (0, 0.6, 0.8)
        scene.add_joint(f"hinge_{k}", Hinge(last, f"link_{k}", anchor=(0.5 * k, 0, 0), axis=axis))
        last = f"link_{k}"
    world = full_world(scene, options=ACCURATE)
    start = world.diagnostics().energy[0]
    scale = 4.0 * G * 1.0
    for _ in range(300):
        world.step()
        d = world.diagnostics()
        assert d.joint_error[0] < 2e-3
        assert d.energy[0] < start + 0.01 * scale
    assert d.energy[0] > start - 0.05 * scale


def test_a_hinge_that_was_turned_out_of_line_comes_back() -> None:
    """Errors of the axis up to nearly half a turn converge, the shorter way round."""
    for angle in (1.0, 2.5, 3.1):
        world = held(hinge((0, 1, 0)), options=Options(sleep=False))
        world.set_pose("it", orientation=quaternion((1, 0, 0), angle))
        errors = []
        for _ in range(120):
            world.step()
            errors.append(world.diagnostics().joint_error[0])
        assert errors[-1] < 1e-6
        assert all(b <= a + 1e-9 for a, b in itertools.pairwise(errors))


def test_long_spin_has_no_drift() -> None:
    """A minute about an oblique axis through the centre: the rate is constant and the axis stays."""
    axis = np.asarray(AXES["oblique"])
    world = held(hinge(axis), orientation=TILT, angular_velocity=4.0 * axis)
    world.step(60)
    rate = world.joint_rate("joint")[0]
    world.step(3600)
    assert rate * (1 - 5e-4) < world.joint_rate("joint")[0] < rate * (1 + 1e-9)
    assert rate == pytest.approx(4.0, rel=1e-3)
    assert world.diagnostics().joint_error[0] < 1e-4


def test_sensor_reads_coordinate_rate_and_reaction() -> None:
    scene = scene_of(hinge(motor_speed=1.0, motor_effort=3.0), G, position=(0.2, 0, 0))
    scene.add_sensor("sensor", JointSensor("joint"))
    world = full_world(scene)
    world.step(20)
    reading = world.sensor("sensor")[0]
    assert reading[0] == world.joint_coordinate("joint")[0]
    assert reading[1] == world.joint_rate("joint")[0]
    assert_allclose(reading[2:], world.joint_reaction("joint")[0])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"axis": (0, 0, 0)}, "axis must have a direction"),
        ({"axis": (0, 1)}, "axis must be 3 numbers"),
        ({"limits": (1, -1)}, "the lower limit must not be above the upper one"),
        ({"limit_restitution": 1.5}, "limit_restitution must not exceed 1"),
        ({"limit_restitution": 0.5, "limit_frequency": 2.0}, "give limit_restitution or limit_frequency, not both"),
        ({"motor_speed": 1.0}, "a motor needs a motor_effort"),
        ({"motor_gain": 0.0}, "motor_gain must be positive"),
        ({"friction_effort": -1.0}, "friction_effort must not be negative"),
        ({"frequency": 1.0, "stiffness": 2.0}, "by frequency or by stiffness and damping, not both"),
    ],
)
def test_bad_arguments_are_named(given: dict[str, Any], message: str) -> None:
    scene = scene_of(hinge())
    with pytest.raises(ValueError, match=message):
        scene.add_joint("another", hinge(**given))
    assert list(scene.joints) == ["joint"]
