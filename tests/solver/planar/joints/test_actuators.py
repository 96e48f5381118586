"""Actuators of joints: what a control does, and how it is clipped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Revolute
from tests.solver.planar.joints.rigs import FIDELITIES, G, held, joint, slot

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)


@every_fidelity
@pytest.mark.parametrize("kind", ["revolute", "prismatic", "wheel"])
def test_torque_is_the_control(kind: str, options: Options) -> None:
    axis: dict[str, Any] = {} if kind == "revolute" else {"axis": (0.6, 0.8)}
    world = held(kind, actuator={"mode": "torque"}, motor_effort=4.0, options=options, **axis)
    speed = 0.0
    for control, applied in ((1.0, 1.0), (-2.5, -2.5), (9.0, 4.0), (-9.0, -4.0), (0.0, 0.0)):
        world.control[:] = control
        world.step()
        force = np.array((0.6, 0.8, 0.0)) if kind == "prismatic" else np.array((0.0, 0.0, 1.0))
        np.testing.assert_allclose(world.joint_reaction("joint")[0], applied * force, rtol=1e-12, atol=1e-12)
        speed += applied / (2.0 if kind == "prismatic" else 3.0) / 60.0
        np.testing.assert_allclose(world.state.bodies["velocity"][0, 1], speed * force, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_velocity(kind: str) -> None:
    axis: dict[str, Any] = {} if kind == "revolute" else {"axis": (0.6, 0.8)}
    world = held(kind, actuator={"mode": "velocity", "lower": -2.0, "upper": 1.5}, motor_effort=10.0, worlds=3, **axis)
    world.control[:, 0] = (5.0, 0.7, -5.0)
    world.step(120)
    np.testing.assert_allclose(world.joint_rate("joint"), (1.5, 0.7, -2.0), rtol=1e-9)
    world.control[:, 0] = 0.0
    world.step(120)
    np.testing.assert_allclose(world.joint_rate("joint"), 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_servo_goes_to_the_commanded_position_within_its_effort(kind: str) -> None:
    axis: dict[str, Any] = {} if kind == "revolute" else {"axis": (0.6, 0.8)}
    world = held(
        kind, actuator={"mode": "position", "lower": -1.0, "upper": 1.0}, worlds=3, frequency=2.0, spring_effort=9.0,
        **axis,
    )  # fmt: skip
    world.control[:, 0] = (5.0, 0.3, -5.0)
    largest = 0.0
    for _ in range(300):
        world.step()
        reaction = world.joint_reaction("joint")
        largest = max(largest, abs(reaction[:, 2] if kind == "revolute" else reaction[:, :2] @ (0.6, 0.8)).max())
    np.testing.assert_allclose(world.joint_coordinate("joint"), (1.0, 0.3, -1.0), atol=1e-6)
    assert largest == pytest.approx(9.0, rel=1e-9)


def test_servo_gives_way_to_a_load_above_its_effort() -> None:
    world = held("prismatic", gravity=G, actuator={"mode": "position"}, axis=(0, 1), frequency=5.0, spring_effort=G)
    world.step(60)
    assert world.joint_rate("joint")[0] == pytest.approx(-G / 2.0, rel=1e-2)  # it carries half of the weight
    assert slot(world, 4) == pytest.approx(G, rel=1e-12)


def test_a_motor_and_a_spring_driven_side_by_side() -> None:
    scene = Scene(gravity=(0, 0))
    scene.add_body("frame", "static")
    scene.add_body("bar", shapes=[Box(half_extents=(0.5, 0.2))], mass=2.0, inertia=3.0)
    scene.add_joint("joint", Revolute("frame", "bar", motor_effort=8.0, stiffness=20.0, damping=20.0))
    scene.add_actuator("push", "joint", mode="torque")
    scene.add_actuator("hold", "joint", mode="position")
    world = World(scene)
    world.control[0] = (6.0, 0.5)
    world.step(900)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.5 + 6.0 / 20.0, abs=1e-6)


@pytest.mark.parametrize(
    ("given", "actuator", "message"),
    [
        ({}, {"mode": "velocity"}, "has no motor"),
        ({}, {"mode": "torque"}, "has no motor"),
        ({"motor_effort": 1.0}, {"mode": "position"}, "has no spring"),
        ({"motor_effort": 1.0}, {"mode": "velocity", "axis": "x"}, "only a target has an axis"),
        ({"motor_effort": 1.0}, {"mode": "speed"}, "unknown"),
        ({"motor_effort": 1.0}, {"mode": "torque", "lower": 1.0, "upper": 0.0}, "lower must not be above upper"),
    ],
)
def test_refusals(given: dict[str, Any], actuator: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"actuator 'actuator'.*{message}"):
        held("revolute", actuator=actuator, **given)


def test_one_actuator_for_a_motor() -> None:
    scene = Scene()
    scene.add_body("frame", "static")
    scene.add_body("bar", shapes=[Box(half_extents=(0.5, 0.2))])
    scene.add_joint("joint", Revolute("frame", "bar", motor_effort=8.0))
    scene.add_actuator("one", "joint", mode="torque")
    with pytest.raises(ValueError, match="actuator 'two': 'one' drives the same part of joint 'joint'"):
        scene.add_actuator("two", "joint", mode="velocity")


def test_bad_controls_move_nothing() -> None:
    world = held("revolute", actuator={"mode": "torque"}, motor_effort=4.0, gravity=G)
    world.control[:] = np.nan
    with pytest.raises(ValueError, match="control of actuator 'actuator' in world 0 must be finite"):
        world.step()
    assert world.state.worlds["step"][0] == 0


def test_motor_set_by_hand() -> None:
    world = held("revolute", motor_effort=4.0, worlds=2)
    world.set_motor("joint", speed=[1.0, -1.0])
    world.step(60)
    np.testing.assert_allclose(world.joint_rate("joint"), (1.0, -1.0), rtol=1e-9)
    with pytest.raises(ValueError, match="set_motor of joint 'joint': it has no spring"):
        world.set_motor("joint", rest=1.0)
    with pytest.raises(ValueError, match=r"set_motor of joint 'joint'.*must be finite"):
        world.set_motor("joint", speed=np.inf)
    world.parameters.set(joint(world), motor_effort=0.0, frequency=2.0)
    with pytest.raises(ValueError, match="it has no motor"):
        world.set_motor("joint", speed=1.0)
    world.set_motor("joint", rest=0.25)
    world.step(300)
    np.testing.assert_allclose(world.joint_coordinate("joint"), 0.25, atol=1e-6)
