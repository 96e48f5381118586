"""Restitution and softness of limits, dry friction, motors with a gain, and springs that hardly pull."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.solver.planar.joints.rigs import FINE, held, travel

SLIDE: dict[str, Any] = {"axis": (1, 0)}


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_limit_reflects_the_speed_times_the_restitution(kind: str, restitution: float) -> None:
    motion: dict[str, Any] = {"spin": 2.0} if kind == "revolute" else {"velocity": (2.0, 0.0), **SLIDE}
    world = held(kind, limits=(-0.3, 0.4), limit_restitution=restitution, **motion)
    q = travel(world, 20)
    assert 0.38 < q.max() < 0.4 + 1e-4
    assert world.joint_rate("joint")[0] == pytest.approx(-2.0 * restitution, abs=1e-6)


def test_soft_limit_turns_round_within_half_a_period() -> None:
    """It loses some energy in the substep in which it begins to push, and never gains any."""
    f = 2.0
    limit: dict[str, Any] = {"limits": (-5.0, 0.2), "limit_frequency": f, "limit_damping_ratio": 0.0}
    world = held("revolute", spin=2.0, options=FINE, **limit)
    q = travel(world, 60)
    assert q.max() == pytest.approx(0.2 + 2.0 / (2.0 * math.pi * f), rel=0.05)
    assert -2.0 * 1.0001 < world.joint_rate("joint")[0] < -2.0 * 0.9
    world.set_pose("bar", angle=0.3)
    assert world.diagnostics().spring_energy[0] == pytest.approx(0.5 * 3.0 * (2.0 * math.pi * f * 0.1) ** 2, rel=1e-9)


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "wheel"])
def test_dry_friction_stops_at_a_constant_rate(kind: str) -> None:
    given: dict[str, Any] = {} if kind == "revolute" else SLIDE
    speed: dict[str, Any] = {"velocity": (1.0, 0.0)} if kind == "prismatic" else {"spin": 1.0}
    inertia = 2.0 if kind == "prismatic" else 3.0
    world = held(kind, friction_effort=1.2, **speed, **given)

    def rate() -> float:
        return float(world.linear_velocity[0, 1, 0] if kind == "prismatic" else world.angular_velocity[0, 1])

    world.step(60)
    assert rate() == pytest.approx(1.0 - 1.2 / inertia, rel=1e-6)
    world.step(120)
    assert rate() == pytest.approx(0.0, abs=1e-9)


def test_motor_with_gain_is_a_velocity_drive() -> None:
    world = held("revolute", motor_speed=3.0, motor_effort=1e3, motor_gain=2.0)
    for k in range(1, 61):
        world.step()
        expected = 3.0 * (1.0 - math.exp(-2.0 * k * world.timestep / 3.0))
        assert world.joint_rate("joint")[0] == pytest.approx(expected, abs=1e-6)


def test_a_spring_too_weak_for_the_substep_does_nothing() -> None:
    world = held("revolute", spin=1.0, stiffness=1e-9)
    world.step(60)
    assert world.joint_rate("joint")[0] == pytest.approx(1.0, abs=1e-8)
    assert np.isfinite(world.position).all()
