"""Wheel: suspension, steering and spin; a flywheel's reaction to precession."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Scene, World
from gsenv.solver.spatial import Axis, Box, Cylinder, Hinge, Wheel
from tests.solver.spatial.joints.rigs import FINE, INERTIA, MASS, G, held, oscillator, scene_of
from tests.solver.spatial.one_kernel import full_world, space

LYING = (math.sqrt(0.5), math.sqrt(0.5), 0, 0)  # of a cylinder: its axis along y


def wheel(**given: Any) -> Wheel:
    return Wheel("base", "it", axis=(0, 0, 1), spin_axis=(0, 1, 0), **given)


@pytest.mark.parametrize("steered", [False, True])
def test_suspension_sags_by_m_g_over_k(steered: bool) -> None:
    steering = {"steering": Axis(frequency=5.0)} if steered else {}
    world = held(wheel(stiffness=400.0, damping=30.0, **steering), G)
    world.step(300)
    assert world.joint_coordinate("joint")[0] == pytest.approx(-MASS * G / 400.0, rel=1e-6)
    assert world.diagnostics().spring_energy[0] == pytest.approx(0.5 * (MASS * G) ** 2 / 400.0, rel=1e-5)
    assert_allclose(world.position[0, 1, :2], 0.0, atol=1e-9)


def test_suspension_swings_at_its_frequency_and_stops_at_its_limit() -> None:
    world = held(wheel(frequency=1.5, damping_ratio=0.2, rest=0.2), options=FINE)
    for k in range(1, 121):
        world.step()
        wave = oscillator(np.array([k / 240.0]), -0.2, 0.0, 3.0 * math.pi, 0.2)[0]
        assert world.joint_coordinate("joint")[0] == pytest.approx(0.2 + wave, abs=2e-3)
    stopped = held(wheel(stiffness=10.0, limits=(-0.1, 0.1)), G)
    stopped.step(120)
    assert stopped.joint_coordinate("joint")[0] == pytest.approx(-0.1, abs=1e-3)


@pytest.mark.parametrize("angle", [0.0, 0.5, -1.0])
def test_spin_axis_follows_the_steering(angle: float) -> None:
    """The wheel spins about its own axis, which has turned by the steering angle about the suspension."""
    steering = Axis(frequency=4.0, rest=angle)
    world = held(wheel(stiffness=400.0, damping=30.0, motor_speed=5.0, motor_effort=20.0, steering=steering))
    world.step(180)
    assert world.joint_coordinate("joint/steering")[0] == pytest.approx(angle, abs=1e-3)
    assert world.joint_rate("joint/spin")[0] == pytest.approx(5.0, rel=1e-3)
    assert world.joint_coordinate("joint/spin")[0] == pytest.approx(15.0 - 0.5 * 25.0 * INERTIA[1] / 20.0, rel=2e-3)
    axis = (-math.sin(angle), math.cos(angle), 0)
    assert_allclose(world.angular_velocity[0, 1], 5.0 * np.array(axis), atol=2e-2)


def test_motor_is_bounded_and_friction_stops_the_wheel() -> None:
    world = held(wheel(motor_speed=100.0, motor_effort=2.0))
    world.step(30)
    assert world.joint_rate("joint/spin")[0] == pytest.approx(2.0 * 0.5 / INERTIA[1], rel=1e-3)
    braked = held(wheel(friction_effort=1.0), angular_velocity=(0, 0.9, 0))
    braked.step(60)
    assert braked.joint_rate("joint/spin")[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("speed", [20.0, 60.0, 100.0])
def test_a_flywheel_on_a_turning_arm_reacts_with_its_gyroscopic_torque(speed: float) -> None:
    """Forced precession: the arm keeps its rate w, and the pivot carries the torque I speed w across both axes."""
    scene = space()
    scene.add_body("base", "static")
    scene.add_body(
        "arm", shapes=[Box(half_extents=(0.3, 0.05, 0.05), mask=0)], position=(0.3, 0, 0), mass=1.0,
        angular_velocity=(0, 0, 2.0), linear_velocity=(0, 0.6, 0),
    )  # fmt: skip
    scene.add_body(
        "wheel", shapes=[Cylinder(half_length=0.05, radius=0.3, mask=0)], position=(0.6, 0, 0), mass=2.0,
        orientation=(math.sqrt(0.5), 0, math.sqrt(0.5), 0), angular_velocity=(speed, 0, 2.0),
        linear_velocity=(0, 1.2, 0),
    )  # fmt: skip
    scene.add_joint("pivot", Hinge("base", "arm", anchor=(0, 0, 0), axis=(0, 0, 1)))
    scene.add_joint("axle", Hinge("arm", "wheel", anchor=(0.6, 0, 0), axis=(1, 0, 0)))
    world = full_world(scene)
    world.step(10)
    torques = []
    for _ in range(60):
        world.step()
        torques.append(np.hypot.reduce(world.joint_reaction("pivot")[0, 3:5]))
        assert world.joint_rate("pivot")[0] == pytest.approx(2.0, rel=1e-2)
        assert world.diagnostics().joint_error[0] < 1e-4
    assert np.mean(torques) == pytest.approx(0.5 * 2.0 * 0.3**2 * speed * 2.0, rel=2e-2)


def test_a_flywheel_too_fast_for_the_substeps_gains_no_energy() -> None:
    scene = space()
    scene.add_body("base", "static")
    scene.add_body("arm", shapes=[Box(half_extents=(0.3, 0.05, 0.05), mask=0)], position=(0.3, 0, 0), mass=1.0)
    scene.add_body(
        "wheel", shapes=[Cylinder(half_length=0.05, radius=0.3, mask=0)], position=(0.6, 0, 0), mass=2.0,
        orientation=(math.sqrt(0.5), 0, math.sqrt(0.5), 0), angular_velocity=(800.0, 0, 2.0),
    )  # fmt: skip
    scene.add_joint("pivot", Hinge("base", "arm", anchor=(0, 0, 0), axis=(0, 0, 1)))
    scene.add_joint("axle", Hinge("arm", "wheel", anchor=(0.6, 0, 0), axis=(1, 0, 0)))
    world = full_world(scene)
    start = world.diagnostics().energy[0]
    for _ in range(60):
        world.step()
        assert world.diagnostics().energy[0] < start * 1.002
        assert world.diagnostics().joint_error[0] < 1e-2


def test_bad_arguments_are_named() -> None:
    with pytest.raises(ValueError, match="joint 'joint': spin_axis is missing"):
        scene_of(Wheel("base", "it", axis=(0, 0, 1)))
    with pytest.raises(ValueError, match="axis and spin_axis must be perpendicular"):
        scene_of(Wheel("base", "it", axis=(0, 0, 1), spin_axis=(0, 1, 1)))


def test_the_motor_of_a_wheel_has_the_name_of_the_wheel() -> None:
    scene = Scene(dim=3)
    scene.add_body("frame", "static")
    scene.add_body("wheel", mass=1.0, inertia=(1.0, 1.0, 1.0))
    scene.add_joint("w", Wheel("frame", "wheel", axis=(0, 0, 1), spin_axis=(0, 1, 0), motor_effort=5.0))
    with pytest.raises(ValueError, match="the motor of a wheel is driven by the wheel's own name, 'w'"):
        scene.add_actuator("drive", "w/spin", mode="torque")
    scene.add_actuator("drive", "w", mode="torque")
    parameters = World(scene).parameters
    with pytest.raises(ValueError, match="the rotation of a wheel is set by the wheel's own name, 'w'"):
        parameters.set("w/spin", motor_effort=2.0)
    assert parameters.joints["motor_effort"].tolist() == [[5.0, 0.0]]
    parameters.set("w", motor_effort=2.0)
    assert parameters.joints["motor_effort"].tolist() == [[2.0, 0.0]]
