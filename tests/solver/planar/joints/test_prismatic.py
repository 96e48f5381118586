"""Prismatic joints: slides by the closed form, momentum on moving bodies, limits, motors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Prismatic, Revolute
from tests.solver.joints import make_joint
from tests.solver.planar.joints.rigs import FIDELITIES, INF, G, angular_momentum, energy, held, travel

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)
SLOPE = 0.5  # rad


@every_fidelity
def test_slides_down_a_tilted_axis(options: Options) -> None:
    axis = (math.cos(SLOPE), -math.sin(SLOPE))
    world = held("prismatic", gravity=G, position=(1, 2), angle=0.7, axis=axis, options=options)
    t = np.arange(1, 121) / 60.0
    np.testing.assert_allclose(travel(world, 120), 0.5 * G * math.sin(SLOPE) * t**2, atol=1e-9)
    assert world.joint_rate("joint")[0] == pytest.approx(2.0 * G * math.sin(SLOPE), rel=1e-9)
    np.testing.assert_allclose(
        world.position[0, 1], np.array((1, 2)) + world.joint_coordinate("joint") * axis, atol=1e-7
    )
    assert world.angle[0, 1] == pytest.approx(0.7, abs=1e-9)
    across = 2.0 * G * math.cos(SLOPE)
    np.testing.assert_allclose(
        world.joint_reaction("joint")[0], (across * math.sin(SLOPE), across * math.cos(SLOPE), 0), atol=1e-4 * across
    )


def test_guide_carries_the_moment_of_an_overhang() -> None:
    # a bar that slides upright, held at its left end: its weight hangs 0.5 m to the right of the guide
    world = held("prismatic", gravity=G, anchor=(-0.5, 0), axis=(0, 1), motor_effort=INF)
    world.step(60)
    np.testing.assert_allclose(world.joint_reaction("joint")[0], (0, 2 * G, G), rtol=1e-5, atol=1e-4)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0, abs=1e-6)


def turning_slide(options: Options, spin: float = 2.0, speed: float = 1.0, **given: Any) -> World:
    """A bar that turns and drifts freely with a box that slides along a tilted line on it, off its centre."""
    scene = Scene(gravity=(0, 0))
    drift = np.array((0.3, -0.2))
    axis = np.array((math.cos(0.6), math.sin(0.6)))
    place = 0.5 * axis + 0.3 * np.array((-axis[1], axis[0]))
    scene.add_body(
        "bar", shapes=[Box(half_extents=(1, 0.2))], mass=3, angle=0.4, linear_velocity=drift, angular_velocity=spin
    )
    velocity = drift + spin * np.array((-place[1], place[0])) + speed * axis
    box = Box(half_extents=(0.2, 0.2))
    scene.add_body("box", shapes=[box], mass=1, position=place, linear_velocity=velocity, angular_velocity=spin)
    scene.add_joint("joint", make_joint(given.pop("kind", "prismatic"), "bar", "box", axis=axis, **given))
    return World(scene, options=options)


def drifts(world: World, steps: int = 120) -> tuple[float, float, float, float]:
    """Largest relative change of angular momentum and energy, change of momentum, and joint error, m."""
    spin, start, momentum = angular_momentum(world), energy(world), world.diagnostics().momentum.copy()
    worst = np.zeros(4)
    for _ in range(steps):
        world.step()
        now = world.diagnostics()
        found = (
            abs(angular_momentum(world) / spin - 1.0),
            abs(now.energy[0] / start - 1.0),
            abs(now.momentum - momentum).max(),
            now.joint_error[0],
        )
        worst = np.maximum(worst, found)
    spin_change, energy_change, momentum_change, error = worst.tolist()
    return spin_change, energy_change, momentum_change, error


@pytest.mark.parametrize("kind", ["prismatic", "wheel"])
def test_slider_on_a_free_turning_body(kind: str) -> None:
    coarse, fine = (drifts(turning_slide(Options(substeps=n, sleep=False), kind=kind)) for n in (2, 4))
    assert coarse[0] < 1e-4
    assert coarse[1] < 2e-4
    assert coarse[2] < 1e-9
    assert coarse[3] < 1e-5
    assert fine[0] < coarse[0] / 3.0
    assert fine[1] < coarse[1] / 3.0


def test_sprung_slider_on_a_free_turning_body() -> None:
    coarse, fine = (
        drifts(turning_slide(Options(substeps=n, sleep=False), frequency=1.0, damping_ratio=0.0)) for n in (2, 4)
    )
    assert max(coarse[:2]) < 3e-4
    assert fine[1] < coarse[1] / 3.0


def test_slider_reaches_its_limit_on_a_turning_body() -> None:
    # a plastic hit inside: momentum stays, energy falls to that of a rigid body or below, and stays
    world = turning_slide(Options(sleep=False), limits=(-0.5, 0.8))
    spin, _, momentum, error = drifts(world, 120)
    assert spin < 5e-3
    assert momentum < 1e-9
    assert error < 1e-4
    assert world.joint_coordinate("joint")[0] == pytest.approx(0.8, abs=1e-4)  # flung out
    calm = drifts(world, 120)
    assert calm[1] < 1e-3


@pytest.mark.parametrize("solid", [True, False], ids=["solid", "without shapes"])
@pytest.mark.parametrize("speed", [0.7, 8.0, -50.0])
def test_limit_stops_at_speed(speed: float, solid: bool) -> None:
    world = held("prismatic", velocity=(0, speed), solid=solid, axis=(0, 1), limits=(-0.4, 0.7))
    q = travel(world, 90)
    end = 0.7 if speed > 0 else -0.4
    assert q.max() < 0.7 + 1e-6
    assert q.min() > -0.4 - 1e-6
    assert q[-1] == pytest.approx(end, abs=1e-6)


@every_fidelity
def test_load_rests_on_a_limit(options: Options) -> None:
    world = held("prismatic", gravity=G, axis=(0, 1), limits=(-0.3, INF), options=options)
    q = travel(world, 120)
    assert q.min() > -0.3 - 1e-6
    np.testing.assert_allclose(q[-60:], -0.3, atol=1e-6)
    np.testing.assert_allclose(world.joint_reaction("joint")[0], (0, 2 * G, 0), rtol=1e-4, atol=1e-6)


@every_fidelity
def test_motor_lifts_a_weight_with_its_bound(options: Options) -> None:
    # 4 N more than the weight: 2 m/s^2 up to 1 m/s, then the weight alone
    world = held("prismatic", gravity=G, axis=(0, 1), motor_speed=1.0, motor_effort=2 * G + 4, options=options)
    for k in range(1, 30):
        world.step()
        assert world.joint_reaction("joint")[0, 1] == pytest.approx(2 * G + 4, rel=1e-12)
        assert world.joint_rate("joint")[0] == pytest.approx(2 * k / 60, rel=1e-10)
    world.step(10)
    assert world.joint_rate("joint")[0] == pytest.approx(1, rel=1e-10)
    assert world.joint_reaction("joint")[0, 1] == pytest.approx(2 * G, rel=1e-9)


def test_motor_with_exactly_the_weight_only_holds_it() -> None:
    world = held("prismatic", gravity=G, axis=(0, 1), motor_speed=1.0, motor_effort=2 * G)
    world.step(120)
    assert world.joint_rate("joint")[0] == pytest.approx(0, abs=1e-9)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0, abs=1e-9)


def test_no_motor_is_stronger_than_a_limit() -> None:
    world = held("prismatic", gravity=G, axis=(0, 1), limits=(-0.2, 0.5), motor_speed=3.0, motor_effort=INF)
    q = travel(world, 120)
    assert q.max() < 0.5 + 1e-6
    assert q[-1] == pytest.approx(0.5, abs=1e-6)


def test_order_of_convergence_of_a_slider_on_a_swinging_bar() -> None:
    def after(steps: int) -> np.ndarray:
        scene = Scene()
        scene.add_body("frame", "static")
        scene.add_body("bar", shapes=[Box(half_extents=(1, 0.1))], position=(0.3, 0))
        scene.add_body("box", shapes=[Box(half_extents=(0.2, 0.2))], position=(0.5, 0.1))
        scene.add_joint("hinge", Revolute("frame", "bar", anchor=(0, 0)))
        scene.add_joint("joint", Prismatic("bar", "box", axis=(1, 0)))
        step: dict[str, Any] = {"timestep": 0.7 / steps, "substeps": 1, "max_substeps": 1}
        exact = Options(**step, sleep=False, tolerance=1e-9, articulated=False)
        world = World(scene, options=exact)
        world.step(steps)
        return np.append(world.angle[0, 1], world.joint_coordinate("joint"))

    exact = after(4480)
    errors = [abs(after(steps) - exact).max() for steps in (70, 140)]
    assert errors[0] < 5e-3
    assert 3.5 < errors[0] / errors[1] < 5.0
