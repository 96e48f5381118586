"""Slider: incline, springs, motors and limits against closed forms; rotation and momentum of the pair."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options
from gsenv.solver.spatial import Box, Slider
from tests.solver.spatial.joints.rigs import (
    AWAKE,
    AXES,
    FINE,
    MASS,
    G,
    held,
    oscillator,
    quaternion,
    travel,
)
from tests.solver.spatial.one_kernel import full_world, space

every_axis = pytest.mark.parametrize("axis", AXES.values(), ids=AXES)
TILT = quaternion((0.36, 0.48, 0.8), 0.7)


def slider(axis: Any = (1, 0, 0), **given: Any) -> Slider:
    return Slider("base", "it", axis=axis, **given)


@pytest.mark.parametrize("angle", [0.2, 0.8, 1.5])
def test_slides_down_an_incline_with_g_sin(angle: float) -> None:
    axis = np.array((0.6 * math.cos(angle), 0.8 * math.cos(angle), -math.sin(angle)))
    world = held(slider(axis), G, orientation=TILT)
    for k in range(1, 61):
        world.step()
        t = k * world.timestep
        assert world.joint_rate("joint")[0] == pytest.approx(G * math.sin(angle) * t, rel=1e-6)
        assert world.joint_coordinate("joint")[0] == pytest.approx(0.5 * G * math.sin(angle) * t * t, rel=1e-6)
    assert_allclose(world.position[0, 1], world.joint_coordinate("joint")[0] * axis, atol=1e-6)
    assert_allclose(world.orientation[0, 1], TILT, atol=1e-6)
    force = world.joint_reaction("joint")[0, :3]
    assert_allclose(force, MASS * G * (np.array((0, 0, 1)) + math.sin(angle) * axis), atol=1e-5 * MASS * G)


def test_dry_friction_reduces_the_acceleration_or_holds() -> None:
    axis = (math.cos(0.5), 0, -math.sin(0.5))
    pull = MASS * G * math.sin(0.5)
    world = held(slider(axis, friction_effort=0.4 * pull), G)
    world.step(60)
    assert world.joint_rate("joint")[0] == pytest.approx(0.6 * pull / MASS, rel=1e-6)
    stuck = held(slider(axis, friction_effort=1.1 * pull), G)
    stuck.step(60)
    assert stuck.joint_coordinate("joint")[0] == pytest.approx(0.0, abs=1e-8)


@every_axis
@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_spring_swings_at_its_frequency(axis: Any, ratio: float) -> None:
    f, rest = 1.5, 0.2
    joint = slider(axis, frequency=f, damping_ratio=ratio, rest=rest)
    world = held(joint, orientation=TILT, options=FINE)
    t = np.arange(1, 241) / 240.0
    q = travel(world, 240)
    assert_allclose(q - rest, oscillator(t, -rest, 0.0, 2.0 * math.pi * f, ratio), atol=2e-3)


def test_spring_sags_by_m_g_over_k_and_counts_its_energy() -> None:
    world = held(slider((0, 0, 1), stiffness=200.0, damping=20.0), G)
    world.step(400)
    sag = MASS * G / 200.0
    assert world.joint_coordinate("joint")[0] == pytest.approx(-sag, rel=1e-6)
    assert world.diagnostics().spring_energy[0] == pytest.approx(0.5 * 200.0 * sag**2, rel=1e-5)


def test_force_actuator_and_motor_bound() -> None:
    world = held(slider(motor_effort=3.0), actuator={"mode": "torque", "lower": -9.0, "upper": 9.0})
    world.control[:] = 8.0  # more than the motor can
    world.step(60)
    assert world.joint_rate("joint")[0] == pytest.approx(3.0 / MASS, rel=1e-6)
    speed = held(slider(motor_speed=0.7, motor_effort=3.0))
    speed.step(60)
    assert speed.joint_rate("joint")[0] == pytest.approx(0.7, rel=1e-9)
    assert speed.joint_coordinate("joint")[0] == pytest.approx(0.7 - 0.5 * 0.7**2 / 1.5, rel=5e-3)


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_limit_reflects_the_speed_times_the_restitution(restitution: float) -> None:
    world = held(slider(limits=(-0.2, 0.3), limit_restitution=restitution), linear_velocity=(1.5, 0, 0))
    q = travel(world, 15)
    assert 0.28 < q.max() < 0.3 + 1e-5
    assert world.joint_rate("joint")[0] == pytest.approx(-1.5 * restitution, abs=1e-6)


def test_a_ball_bounces_on_a_limit_to_e_squared_of_its_height() -> None:
    world = held(slider((0, 0, 1), limits=(-1.0, np.inf), limit_restitution=0.8), G, options=FINE)
    q = travel(world, 300)
    lowest = int(q[:130].argmin())
    assert lowest / 240.0 == pytest.approx(math.sqrt(2.0 / G), abs=2.5 / 240.0)
    assert 1.0 + q[lowest:].max() == pytest.approx(0.64, abs=0.02)
    assert 1.0 + q[lowest:].max() < 0.64 + 0.36 * 4.43 / 240.0  # it turns round up to one substep above the limit


def test_pair_in_space_keeps_momenta_and_turns_as_one() -> None:
    """A sliding pair thrown with a spin keeps its relative orientation, momenta and energy."""
    scene = space()
    spin = (0.5, 1.0, 2.0)
    for k in range(2):
        scene.add_body(
            f"b{k}", shapes=[Box(half_extents=(0.3, 0.2, 0.1 + 0.1 * k))], position=(0.8 * k, 0, 0), mass=1.0 + k,
            linear_velocity=tuple(np.cross(spin, (0.8 * k, 0, 0))), angular_velocity=spin,
        )  # fmt: skip
    scene.add_joint("joint", Slider("b0", "b1", anchor=(0.4, 0, 0), axis=(1, 0.2, 0), stiffness=30.0, damping=1.0))
    world = full_world(scene, options=Options(timestep=1 / 120, sleep=False))
    start = world.diagnostics()
    for _ in range(240):
        world.step()
        d = world.diagnostics()
        assert d.joint_error[0] < 2e-3
        assert_allclose(d.momentum, start.momentum, atol=1e-9)
        assert d.energy[0] < start.energy[0] * 1.005
    momentum = np.hypot.reduce(start.angular_momentum[0])
    assert_allclose(d.angular_momentum, start.angular_momentum, atol=0.01 * momentum)


def test_disabled_joint_lets_go_and_is_enabled_again() -> None:
    world = held(slider(), G, options=AWAKE)
    world.parameters.set("joint", enabled=False)
    world.step(30)
    assert world.position[0, 1, 2] == pytest.approx(-0.5 * G * 0.25, rel=1e-6)
    world.parameters.set("joint", enabled=True)
    world.step(120)
    assert_allclose(world.position[0, 1, 1:], 0.0, atol=1e-4)


def test_a_spring_too_weak_for_the_substep_does_nothing() -> None:
    world = held(slider(stiffness=1e-9), linear_velocity=(1.0, 0, 0))
    world.step(60)
    assert world.joint_coordinate("joint")[0] == pytest.approx(1.0, abs=1e-8)
