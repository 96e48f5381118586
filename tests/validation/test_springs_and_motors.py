"""A mass on a spring, motors and limits against closed forms, at default and accurate settings."""

from __future__ import annotations

import math

import pytest

from gsenv.scenes import motor_rig, spring_mass
from tests.validation.reference import BOTH, MOTOR, ROUND_OFF, SPRING, G, awake_world


@BOTH
@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0])
def test_mass_on_a_spring(fidelity: str, ratio: float) -> None:
    world = awake_world(spring_mass(2.0, ratio), fidelity)
    omega = 2.0 * math.pi * 2.0
    damped = math.sqrt(max(1.0 - ratio**2, 0.0)) * omega
    sag = G / omega**2
    amplitude = 0.1 - sag  # below the place of rest
    for _ in range(round(5.0 / 2.0 / world.timestep)):
        world.step()
        t = float(world.time[0])
        shape = math.cos(damped * t) + ratio * omega * (math.sin(damped * t) / damped if damped else t)
        expected = amplitude * math.exp(-ratio * omega * t) * shape
        here = -1.0 - sag - world.position[0, 1, 1]
        assert here == pytest.approx(expected, abs=SPRING.at(fidelity) * amplitude)
    if ratio == 1.0:
        world.step(300)
        assert -1.0 - world.position[0, 1, 1] == pytest.approx(sag, rel=1e-9)


@BOTH
def test_motor_pushes_with_its_bound_and_stops_at_its_speed(fidelity: str) -> None:
    speed, effort, inertia = 10.0, 2.0, 0.5
    world = awake_world(motor_rig(speed, effort, inertia=inertia), fidelity)
    close = MOTOR.at(fidelity)
    while world.time[0] < 5.0:
        world.step()
        torque = float(world.joint_reaction("hinge")[0, 2])
        assert torque <= effort * (1.0 + ROUND_OFF)
        if world.time[0] <= inertia * speed / effort - world.timestep:
            assert torque == pytest.approx(effort, rel=close)
            assert world.angular_velocity[0, 1] == pytest.approx(effort / inertia * world.time[0], rel=close)
    assert world.angular_velocity[0, 1] == pytest.approx(speed, rel=close)
    assert world.joint_reaction("hinge")[0, 2] == pytest.approx(0.0, abs=close)


@BOTH
def test_stalled_motor_shows_its_bound(fidelity: str) -> None:
    world = awake_world(motor_rig(10.0, 2.0, limits=(-1.0, 0.0)), fidelity)
    for _ in range(30):
        world.step()
        assert world.joint_coordinate("hinge")[0] == pytest.approx(0.0, abs=MOTOR.at(fidelity))
    impulses = world.state.joints["total_impulse"][0, 0] / world.timestep
    assert impulses[3] == pytest.approx(2.0, rel=ROUND_OFF)  # the motor's row
    assert impulses[2] == pytest.approx(-2.0, rel=1e-6)  # the limit's
    assert world.joint_reaction("hinge")[0, 2] == pytest.approx(0.0, abs=1e-5)


@BOTH
def test_limit_hit_at_speed(fidelity: str) -> None:
    world = awake_world(motor_rig(0.0, 0.0, spin=8.0, limits=(-1.0, 1.0)), fidelity)
    farthest = 0.0
    while world.time[0] < 1.0:
        world.step()
        farthest = max(farthest, float(world.joint_coordinate("hinge")[0]))
    close = MOTOR.at(fidelity)
    assert farthest == pytest.approx(1.0, abs=close)
    assert world.joint_coordinate("hinge")[0] == pytest.approx(1.0, abs=close)
    assert world.angular_velocity[0, 1] == pytest.approx(0.0, abs=close)
