"""Revolute joints: reactions by statics and dynamics, limits, motors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Distance, Revolute
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, INF, G, chain, held, joint, slot, travel

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)


def test_beam_on_two_supports() -> None:
    # hinged at the left end, hung on a rod at 3/4 of its length: N = m g (1/2) / (3/4)
    scene = Scene()
    scene.add_body("frame", "static")
    scene.add_body("beam", shapes=[Box(half_extents=(1.0, 0.1))], mass=3.0, position=(1, 0))
    scene.add_joint("hinge", Revolute("frame", "beam", anchor=(0, 0)))
    scene.add_joint("rod", Distance("frame", "beam", anchor_a=(1.5, 2), anchor_b=(0.5, 0)))
    world = World(scene, options=AWAKE)
    world.step(60)
    weight = 3.0 * G
    np.testing.assert_allclose(world.joint_reaction("rod")[0], (0, weight * 2 / 3, 0), atol=1e-4 * weight)
    np.testing.assert_allclose(world.joint_reaction("hinge")[0], (0, weight / 3, 0), atol=1e-4 * weight)


@every_fidelity
def test_hanging_chain_carries_what_is_below(options: Options) -> None:
    world = chain(4, options=options)
    for k in range(4):  # hang it straight down, at rest
        world.set_pose(f"bar_{k}", position=(0, -0.5 - k), angle=-math.pi / 2)
    world.step(60)
    for k in range(4):
        np.testing.assert_allclose(world.joint_reaction(f"hinge_{k}")[0], (0, (4 - k) * G, 0), atol=1e-4 * 4 * G)
    assert world.diagnostics().joint_error[0] < 1e-9


@every_fidelity
def test_pin_of_a_pendulum_pulls_as_it_swings(options: Options) -> None:
    # along the arm m (g cos a + l w^2), across it m (l w' + g sin a), no torque; means over the step
    world = held("revolute", gravity=G, position=(0.6, 0.0), anchor=(0, 0), options=options)
    arm, mass = 0.6, 2.0
    fall = mass * arm * G / (3.0 + mass * arm**2)  # w' = -fall sin a, a from hanging down
    before = None
    for _ in range(180):
        world.step()
        a, w = world.angle[0, 1] + math.pi / 2, world.angular_velocity[0, 1]
        along = mass * (G * math.cos(a) + arm * w**2)
        across = mass * (-arm * fall * math.sin(a) + G * math.sin(a))
        force = np.array([-math.sin(a) * along + math.cos(a) * across, math.cos(a) * along + math.sin(a) * across])
        if before is not None:
            reaction = world.joint_reaction("joint")[0]
            np.testing.assert_allclose(reaction[:2], 0.5 * (before + force), atol=2e-3 * mass * G)
            assert reaction[2] == pytest.approx(0, abs=1e-9)
        before = force


@pytest.mark.parametrize("solid", [True, False], ids=["solid", "without shapes"])
@pytest.mark.parametrize("spin", [0.5, 5.0, 30.0, -30.0, 100.0])
def test_limit_stops_at_speed(spin: float, solid: bool) -> None:
    world = held("revolute", spin=spin, solid=solid, limits=(-1.0, 0.7))
    q = travel(world, 150)
    end = 0.7 if spin > 0 else -1.0
    assert q.max() < 0.7 + 1e-6
    assert q.min() > -1.0 - 1e-6
    reached = int(np.argmax(np.abs(q - end) < 1e-6))
    np.testing.assert_allclose(q[reached:], end, atol=1e-6)  # no bounce
    assert reached <= abs(end / spin) * 60 + 1
    assert world.joint_rate("joint")[0] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("spin", [5.0, 30.0, 100.0, -100.0])
def test_narrow_range_is_not_left_within_a_step(spin: float) -> None:
    world = held("revolute", spin=spin, limits=(-0.05, 0.03))
    q = travel(world, 30)
    assert q.max() < 0.03 + 1e-6
    assert q.min() > -0.05 - 1e-6


@every_fidelity
def test_load_rests_on_a_limit(options: Options) -> None:
    # an arm falls on its stop from 0.3 rad above: then the stop's torque is that of the weight
    world = held("revolute", gravity=G, anchor=(-0.5, 0), limits=(-0.3, 1.0), options=options)
    q = travel(world, 200)
    assert q.min() > -0.3 - 1e-6
    stopped = int(np.argmax(q < -0.3 + 1e-6))
    np.testing.assert_allclose(q[stopped:], -0.3, atol=1e-6)
    weight = 2.0 * G
    reaction = world.joint_reaction("joint")[0]
    np.testing.assert_allclose(reaction, (0, weight, 0.5 * weight * math.cos(0.3)), atol=1e-4 * weight)


def test_limits_count_turns() -> None:
    world = held("revolute", spin=8.0, limits=(-20.0, 15.0))
    q = travel(world, 150)
    assert q.max() < 15.0 + 1e-6
    assert q[-1] == pytest.approx(15.0, abs=1e-6)
    world.set_velocity("bar", angular=-12.0)
    q = travel(world, 240)
    assert q.min() > -20.0 - 1e-6
    assert q[-1] == pytest.approx(-20.0, abs=1e-6)


def test_equal_limits_lock_the_angle() -> None:
    world = held("revolute", gravity=G, anchor=(-0.5, 0), limits=(0.0, 0.0))
    world.step(60)
    assert world.joint_coordinate("joint")[0] == pytest.approx(0, abs=1e-8)
    np.testing.assert_allclose(world.joint_reaction("joint")[0], (0, 2 * G, G), rtol=1e-6, atol=1e-5)


def test_motor_speeds_up_with_its_bound() -> None:
    # I dw/dt = 6 N m for 2.5 s, then 5 rad/s and no torque
    world = held("revolute", motor_speed=5.0, motor_effort=6.0)
    for k in range(1, 150):
        world.step()
        assert world.joint_reaction("joint")[0, 2] == pytest.approx(6, rel=1e-12)
        assert world.joint_rate("joint")[0] == pytest.approx(2 * k / 60, rel=1e-11)
    world.step(10)
    assert world.joint_rate("joint")[0] == pytest.approx(5, rel=1e-12)
    assert world.joint_reaction("joint")[0, 2] == pytest.approx(0, abs=1e-9)
    world.set_motor("joint", speed=-1.0)
    world.step()
    assert world.joint_reaction("joint")[0, 2] == pytest.approx(-6, rel=1e-12)


def test_motor_between_free_bodies_pushes_both() -> None:
    scene = Scene(gravity=(0, 0))
    for name, size in (("rotor", 0.2), ("stator", 0.5)):
        scene.add_body(name, shapes=[Box(half_extents=(size, size))])
    scene.add_joint("axle", Revolute("stator", "rotor", motor_speed=1000.0, motor_effort=0.3))
    world = World(scene, options=AWAKE)
    world.step(60)
    np.testing.assert_allclose(
        world.angular_velocity[0], np.array([0.3, -0.3]) / world.parameters.inertia[0], rtol=1e-9
    )


@every_fidelity
def test_motor_at_its_stop_shows_its_bound(options: Options) -> None:
    world = held("revolute", motor_speed=3.0, motor_effort=5.0, limits=(-1.0, 0.5), options=options)
    q = travel(world, 120)
    assert abs(q).max() < 0.5 + 1e-6
    assert slot(world, 3) == pytest.approx(5, rel=1e-12)
    assert slot(world, 2) == pytest.approx(-5, rel=1e-5)
    assert world.joint_reaction("joint")[0, 2] == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize("effort", [1e3, 1e6, INF])
@pytest.mark.parametrize("speed", [1.0, -100.0])
def test_no_motor_is_stronger_than_a_limit(effort: float, speed: float) -> None:
    world = held("revolute", gravity=G, anchor=(-0.5, 0), limits=(-0.5, 0.5), motor_speed=speed, motor_effort=effort)
    q = travel(world, 120)
    assert abs(q).max() < 0.5 + 1e-5
    assert q[-1] == pytest.approx(math.copysign(0.5, speed), abs=1e-6)
    torque = G * math.cos(0.5)
    assert world.joint_reaction("joint")[0, 2] == pytest.approx(torque, rel=1e-4)


def test_motor_at_rest_is_a_brake() -> None:
    # slips at its bound, 4 N m, under a torque of 10 N m; holds 3 N m
    world = held("revolute", motor_effort=4.0)
    for k in range(1, 31):
        world.apply_force("bar", torque=10.0)
        world.step()
        assert world.joint_rate("joint")[0] == pytest.approx(2 * k / 60, rel=1e-10)
    world.step(60)
    for _ in range(30):
        world.apply_force("bar", torque=3.0)
        world.step()
        assert world.joint_rate("joint")[0] == pytest.approx(0, abs=1e-10)
        assert world.joint_reaction("joint")[0, 2] == pytest.approx(-3, rel=1e-9)


def test_limits_and_motor_set_at_run_time() -> None:
    world = held("revolute", spin=2.0, worlds=2)
    world.parameters.set(joint(world), lower=-0.1, upper=0.4, worlds=1)
    world.step(60)
    np.testing.assert_allclose(world.joint_coordinate("joint"), (2.0, 0.4), rtol=1e-9)
    world.parameters.set(joint(world), motor_effort=[3.0, 6.0], lower=-INF, upper=INF)
    world.set_motor("joint", speed=[-10.0, 10.0])
    world.step(30)
    np.testing.assert_allclose(world.joint_rate("joint"), (1.5, 1.0), rtol=1e-9)


def test_energy_and_order_of_a_double_pendulum() -> None:
    # a chaotic double pendulum keeps its energy; its pose after 1 s converges with the square of dt
    def after(steps: int) -> tuple[np.ndarray, float]:
        step: dict[str, Any] = {"timestep": 1.0 / steps, "substeps": 1, "max_substeps": 1}
        world = chain(2, options=Options(**step, sleep=False, tolerance=1e-9, articulated=False))
        start = world.diagnostics().energy[0]
        world.step(steps)
        return world.angle[0, 1:], abs(world.diagnostics().energy[0] - start) / (2.0 * G)

    exact, _ = after(7680)
    (coarse, drift), (fine, _) = after(120), after(240)
    errors = abs(coarse - exact).max(), abs(fine - exact).max()
    assert errors[0] < 1e-3
    assert 3.5 < errors[0] / errors[1] < 5.0
    assert drift < 1e-3
