"""Balls: cone and twist limits, springs, motors and friction about three axes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver.spatial import Ball
from tests.solver.spatial.joints.rigs import FINE, MASS, G, held, multiplied, quaternion, scene_of
from tests.solver.spatial.one_kernel import full_world

ROUND = (0.4, 0.4, 0.4)


def ball(**given: Any) -> Ball:
    return Ball("base", "it", anchor=(0, 0, 0), **given)


def value(world: Any, word: str) -> float:
    return float(world.joint_coordinate(f"joint/{word}")[0])


@pytest.mark.parametrize("cone", [0.3, 1.2, 2.2])
@pytest.mark.parametrize("azimuth", [0.0, 1.0, 4.0])
def test_cone_holds_in_all_directions(cone: float, azimuth: float) -> None:
    """Thrown from the middle against the cone, with a twist about the axis, which stays free."""
    spin = (3.0 * math.cos(azimuth), 3.0 * math.sin(azimuth), 1.0)
    world = held(ball(axis=(0, 0, 1), cone=cone), angular_velocity=spin, inertia=ROUND)
    swings = []
    for _ in range(90):
        world.step()
        swings.append(value(world, "swing"))
    assert max(swings) == pytest.approx(cone, abs=5e-3)
    assert max(swings) < cone + 1e-3
    # an inelastic limit keeps the body at the cone, which it slides along
    assert swings[-1] > 0.5 * cone
    assert world.diagnostics().energy[0] < 0.5 * 0.4 * 10.0 * (1 + 1e-9)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.6, -0.48, 0.64)])
def test_angle_holds_about_all_axes(axis: tuple[float, float, float]) -> None:
    """Also where the frames of cone and twist are others."""
    for given in ({}, {"axis": (0, 1, 0), "cone": 2.5}):
        world = held(ball(angle=0.9, **given), angular_velocity=3.0 * np.array(axis), inertia=ROUND)
        angles = []
        for _ in range(60):
            world.step()
            angles.append(value(world, "angle"))
        assert max(angles) == pytest.approx(0.9, abs=1e-3)
        assert_allclose(world.angular_velocity[0, 1], 0.0, atol=1e-6)
        turned = 2.0 * math.acos(abs(world.orientation[0, 1, 0]))
        assert turned == pytest.approx(angles[-1], abs=1e-9)


def test_angle_lets_a_body_slide_along_it() -> None:
    """A tilted body spins about the vertical: its rotation vector's length alone is limited."""
    world = held(ball(angle=0.5), angular_velocity=(2.0, 0, 0), inertia=(0.4, 0.4, 0.4))
    world.step(30)
    world.set_velocity("it", angular=(0.0, 0.7, 0.0))
    before = world.orientation[0, 1].copy()
    for _ in range(60):
        world.step()
        assert value(world, "angle") < 0.5 + 2e-3
    assert abs(world.orientation[0, 1] - before).max() > 0.1


def test_cone_reflects_with_its_restitution() -> None:
    world = held(ball(axis=(0, 0, 1), cone=0.4, limit_restitution=0.7), angular_velocity=(2.0, 0, 0), inertia=ROUND)
    world.step(20)
    assert_allclose(world.angular_velocity[0, 1], (-1.4, 0, 0), atol=1e-6)


@pytest.mark.parametrize("tilt", [0.0, 0.6])
def test_twist_stays_within_its_range(tilt: float) -> None:
    """A torque twists the body to the limit; also when its axis is swung aside."""
    world = held(ball(axis=(0, 0, 1), cone=tilt + 0.01, twist=(-0.4, 0.7)), inertia=ROUND)
    world.set_pose("it", orientation=quaternion((0, 1, 0), tilt))
    axis = np.array((math.sin(tilt), 0, math.cos(tilt)))
    for sign, limit in ((1.0, 0.7), (-1.0, -0.4)):
        for _ in range(120):
            world.apply_force("it", torque=2.0 * sign * axis)
            world.step()
        assert value(world, "twist") == pytest.approx(limit, abs=2e-3)
    assert value(world, "swing") < tilt + 0.02


def test_hanging_in_the_cone_rests_on_it() -> None:
    world = held(ball(axis=(1, 0, 0), cone=0.5), G, position=(0.4, 0, 0))
    world.step(240)
    assert value(world, "swing") == pytest.approx(0.5, abs=1e-3)
    assert np.abs(world.angular_velocity[0, 1]).max() < 1e-3
    reaction = world.joint_reaction("joint")[0]
    assert_allclose(reaction[:3], (0, 0, MASS * G), atol=1e-2)
    assert_allclose(reaction[3:], (0, -MASS * G * 0.4 * math.cos(0.5), 0), atol=2e-2)


def test_spring_brings_it_back_at_its_frequency() -> None:
    """An isotropic spring on a round body: a pendulum of torsion about the axis of the first rotation."""
    f, angle, axis = 1.2, 0.8, np.array((0.6, -0.48, 0.64))
    world = held(ball(frequency=f, damping_ratio=0.0), inertia=ROUND, options=FINE)
    world.set_pose("it", orientation=quaternion(axis, angle))
    omega = 2.0 * math.pi * f
    assert world.diagnostics().spring_energy[0] == pytest.approx(0.5 * 0.4 * omega**2 * angle**2, rel=1e-6)
    for k in range(1, 241):
        world.step()
        turn = np.array([value(world, f"turn_{letter}") for letter in "xyz"])
        assert_allclose(turn, angle * math.cos(omega * k / 240.0) * axis, atol=4e-3)


def test_motors_about_each_axis_of_body_a() -> None:
    scene = scene_of(ball(motor_effort=2.0), inertia=ROUND)
    for letter in "xyz":
        scene.add_actuator(letter, f"joint/turn_{letter}", mode="torque", lower=-5, upper=5)
    world = full_world(scene)
    world.control[:] = (0.3, -0.5, 4.0)  # the last is more than the motor can
    world.step(6)
    rate = np.array((0.3, -0.5, 2.0)) * 6 * world.timestep / 0.4
    assert_allclose(world.angular_velocity[0, 1], rate, rtol=1e-6)
    assert_allclose(world.joint_reaction("joint")[0, 3:], (0.3, -0.5, 2.0), rtol=1e-6)


def test_friction_brings_it_to_rest() -> None:
    world = held(ball(friction_effort=0.5), angular_velocity=(1.0, 0, 0), inertia=ROUND)
    world.step(30)
    assert world.angular_velocity[0, 1, 0] == pytest.approx(1.0 - 0.5 * 0.5 / 0.4, abs=1e-6)
    world.step(30)
    assert_allclose(world.angular_velocity[0, 1], 0.0, atol=1e-9)


def test_coordinates_of_large_rotations() -> None:
    world = held(ball(axis=(0, 0, 1), cone=3.0, twist=(-3, 3), stiffness=1.0))
    swing, twist = quaternion((0.6, 0.8, 0), 2.0), quaternion((0, 0, 1), -2.5)
    world.set_pose("it", orientation=multiplied(swing, twist))
    assert value(world, "swing") == pytest.approx(2.0, rel=1e-12)
    assert value(world, "twist") == pytest.approx(-2.5, rel=1e-12)
    axis = np.array((0.0, 0.6, 0.8))
    world.set_pose("it", orientation=quaternion(axis, 3.0))
    assert_allclose([value(world, f"turn_{letter}") for letter in "xyz"], 3.0 * axis, atol=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cone": 0.5}, "axis, which cone and twist need, is missing"),
        ({"cone": 4.0, "axis": (0, 0, 1)}, "cone must be below pi"),
        ({"cone": 0.0, "axis": (0, 0, 1)}, "cone must be positive"),
        ({"angle": 3.2}, "angle must be below pi, got 3.2"),
        ({"twist": (-4, 1), "axis": (0, 0, 1)}, "twist must be within"),
        ({"limits": (-1, 1)}, "a ball has no limits; give cone, twist or angle"),
    ],
)
def test_bad_arguments_are_named(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        scene_of(ball(**given))


def test_several_coordinates_must_be_named() -> None:
    world = held(ball(axis=(0, 0, 1), cone=1.0, twist=(-1, 1)))
    with pytest.raises(ValueError, match="joint 'joint' has the coordinates 'joint/swing', 'joint/twist'"):
        world.joint_coordinate("joint")
    scene = scene_of(ball(motor_effort=1.0))
    with pytest.raises(ValueError, match=r"has the coordinates 'joint/turn_x'.*drive one of these"):
        scene.add_actuator("motor", "joint", mode="torque")
