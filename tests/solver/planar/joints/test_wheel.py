"""Wheel joints: suspension, drive and its reaction on the chassis, travel limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, HalfPlane, Wheel
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, INF, G, held

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)
STIFFNESS = 2000.0  # N/m, of each axle


def car(options: Options = AWAKE, gravity: float = G, ground: bool = True, **given: Any) -> World:
    """A chassis of 10 kg on two sprung wheels of 1 kg and 0.3 m, the rear one (x < 0) driven."""
    scene = Scene(gravity=(0, -gravity))
    if ground:
        scene.add_body("ground", "static", [HalfPlane(friction=1.0)])
    scene.add_body("chassis", shapes=[Box(half_extents=(1, 0.2))], mass=10, position=(0, 0.8))
    for name, x in (("rear", -0.8), ("front", 0.8)):
        scene.add_body(name, shapes=[Circle(radius=0.3, friction=1.0)], mass=1, position=(x, 0.3))
        spring: dict[str, Any] = {"stiffness": STIFFNESS, "damping": 150.0, **given}
        motor: dict[str, Any] = {"motor_effort": 15.0} if name == "rear" else {}
        scene.add_joint(f"{name}_axle", Wheel("chassis", name, axis=(0, 1), **spring, **motor))
    return World(scene, options=options)


@every_fidelity
def test_suspension_sags_by_the_weight_of_the_chassis(options: Options) -> None:
    world = car(options)
    world.step(300)
    for name in ("rear", "front"):
        # wheels go up in the chassis
        assert world.joint_coordinate(f"{name}_axle")[0] == pytest.approx(10 * G / 2 / STIFFNESS, rel=1e-3)
        np.testing.assert_allclose(world.joint_reaction(f"{name}_axle")[0], (0, -5 * G, 0), atol=1e-3 * 5 * G)
    assert world.diagnostics().joint_error[0] < 1e-6


def test_axle_stays_on_its_line_and_turns_freely() -> None:
    world = held("wheel", position=(1, 2), velocity=(0.6, 0.8), spin=7.0, axis=(0.6, 0.8))
    for k in range(1, 121):
        world.step()
        np.testing.assert_allclose(world.position[0, 1], np.array((1, 2)) + k / 60.0 * np.array((0.6, 0.8)), rtol=1e-9)
        assert world.angular_velocity[0, 1] == pytest.approx(7, rel=1e-12)
        assert world.diagnostics().joint_error[0] < 1e-9
    assert world.joint_coordinate("joint")[0] == pytest.approx(2, rel=1e-9)
    assert world.joint_rate("joint")[0] == pytest.approx(1, rel=1e-9)


def test_drive_pushes_the_car_and_lifts_its_nose() -> None:
    # a wheel that is driven clockwise rolls to +x; the motor's counter-torque turns the chassis back,
    # which loads the rear axle and lightens the front one by torque / wheelbase
    world = car()
    world.step(300)
    world.set_motor("rear_axle", speed=-100.0)
    speeds = []
    for _ in range(90):
        world.step()
        speeds.append(world.linear_velocity[0, 1, 0])
        assert world.joint_reaction("rear_axle")[0, 2] == pytest.approx(-15, rel=1e-9)
    inertia = world.parameters.inertia[0, 2]
    acceleration = 15.0 / 0.3 / (12.0 + 2.0 * inertia / 0.3**2)  # all roll: T / r = (m + 2 I / r^2) a
    assert (speeds[-1] - speeds[29]) / 1.0 == pytest.approx(acceleration, rel=1e-2)
    assert world.angle[0, 1] > 0.005  # nose up
    # moments about the rear contact: both wheels' spin and all masses' way gain angular momentum
    shift = (12.0 * acceleration * 0.3 + 10.0 * acceleration * 0.5 + 2 * inertia * acceleration / 0.3) / 1.6
    front = -world.joint_reaction("front_axle")[0, 1]
    assert front == pytest.approx(5 * G - shift, rel=3e-2)


def test_motor_turns_a_free_wheel_against_its_chassis() -> None:
    world = car(gravity=0.0, ground=False, frequency=3.0, stiffness=0.0, damping=0.0)
    world.set_motor("rear_axle", speed=1e4)
    world.step(30)
    rates = world.angular_velocity[0]
    inertia = world.parameters.inertia[0]
    assert rates[1] == pytest.approx(15.0 * 0.5 / inertia[1], rel=1e-9)
    assert rates[0] < 0.0
    assert rates[2] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("speed", [1.0, 20.0, -20.0])
def test_travel_limits_stop_at_speed(speed: float) -> None:
    world = held("wheel", velocity=(0, speed), spin=3.0, axis=(0, 1), limits=(-0.2, 0.3))
    lowest, highest = INF, -INF
    for _ in range(60):
        world.step()
        q = world.joint_coordinate("joint")[0]
        lowest, highest = min(lowest, q), max(highest, q)
    assert highest < 0.3 + 1e-6
    assert lowest > -0.2 - 1e-6
    assert q == pytest.approx(0.3 if speed > 0 else -0.2, abs=1e-6)
    assert world.angular_velocity[0, 1] == pytest.approx(3, rel=1e-9)  # the stop does not brake the wheel


def test_overloaded_suspension_rests_on_its_stop() -> None:
    world = car(stiffness=50.0, damping=10.0, limits=(-0.1, 0.1))
    world.step(300)
    for name in ("rear", "front"):
        assert world.joint_coordinate(f"{name}_axle")[0] == pytest.approx(0.1, abs=1e-5)
        assert world.joint_reaction(f"{name}_axle")[0, 1] == pytest.approx(-5 * G, rel=1e-3)


def test_axle_follows_a_chassis_that_turns() -> None:
    # in free fall, all turning at 4 rad/s: nothing pushes, the axles stay where they are in the chassis
    world = car(gravity=0.0, ground=False)
    for b in range(3):
        arm = world.center_of_mass[0, b] - world.center_of_mass[0, 0]
        world.set_velocity(b, linear=4.0 * np.array((-arm[1], arm[0])), angular=4.0)
    for _ in range(120):
        world.step()
        assert world.diagnostics().joint_error[0] < 1e-5
        assert abs(world.joint_coordinate("front_axle")[0]) < 0.02  # the springs give to the centrifugal force
