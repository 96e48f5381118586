"""Rotors (armature) in joint coordinates: closed forms, Runge-Kutta steps, the rows of joints, MuJoCo."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.mjcf import build_scene, coordinates, set_coordinates
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Prismatic
from tests.mjcf.test_motion import both
from tests.solver.core.articulation.opened import articulated
from tests.solver.core.articulation.test_step import G, rods, servo, tip

Array = np.ndarray[Any, Any]
ROTOR = 0.2  # kg m^2


def runge_kutta(seconds: float, steps: int) -> Array:
    """Where the end of two uniform rods is that start level at rest, with a rotor on each joint."""

    def rate(y: Array) -> Array:
        (a, b), (u, w) = y[:2], y[2:]
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[4.0 / 3.0 + 2.0 * ROTOR, 0.5 * c - ROTOR], [0.5 * c - ROTOR, 1.0 / 3.0 + ROTOR]])
        force = [-0.5 * w * w * s - 1.5 * G * np.sin(a), 0.5 * u * u * s - 0.5 * G * np.sin(b)]
        return np.concatenate([y[2:], np.linalg.solve(mass, force)])

    y = np.array([np.pi / 2, np.pi / 2, 0.0, 0.0])
    h = seconds / steps
    for _ in range(steps):
        k = rate(y)
        m = rate(y + 0.5 * h * k)
        n = rate(y + 0.5 * h * m)
        y = y + h / 6.0 * (k + 2.0 * m + 2.0 * n + rate(y + h * n))
    return np.array([np.sin(y[0]) + np.sin(y[1]), -np.cos(y[0]) - np.cos(y[1])])


@pytest.mark.parametrize("flipped", [False, True])
def test_a_double_pendulum_with_rotors_converges_with_second_order(flipped: bool) -> None:
    exact = runge_kutta(1.5, 20_000)
    errors = []
    for rate in (240, 480, 960):
        scene = rods(flipped=flipped, armature=ROTOR)
        world = articulated(scene, timestep=1.0 / rate, substeps=1, sleep=False)
        world.step(rate * 3 // 2)
        errors.append(np.linalg.norm(tip(world, 2) - exact))
        assert world.diagnostics().rows[0] == 0
    assert errors[-1] < 1e-4
    assert_allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.2)


def test_a_motor_turns_its_rotor_too() -> None:
    world = servo(motor_speed=2.0, motor_effort=0.5, armature=ROTOR)
    world.step(12)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_rate(joint), 0.2 * 0.5 / (1.0 / 3.0 + ROTOR), rtol=1e-9)
        assert_allclose(abs(world.joint_reaction(joint)[0, 2]), 0.5 / 3.0 / (1.0 / 3.0 + ROTOR), rtol=1e-5)


def test_a_slide_with_a_rotor_falls_more_slowly() -> None:
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("rail", "static")
    for k in range(2):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.1, 0.1), mask=0)], mass=2.0)
        pair = ("rail", f"box_{k}") if k else (f"box_{k}", "rail")
        scene.add_joint(f"slide_{k}", Prismatic(*pair, axis=(0.0, 1.0), armature=1.0))
    world = World(scene, 2, options=Options(articulated=True, sleep=False))
    world.parameters.set("slide_1", armature=6.0, worlds=1)
    world.step(60)
    assert_allclose(world.linear_velocity[:, 1:, 1], -G * np.array([[2 / 3, 2 / 3], [2 / 3, 0.25]]), rtol=1e-9)


def test_a_spring_with_a_rotor_oscillates_at_its_frequency() -> None:
    world = servo(stiffness=3.0, rest=0.1, armature=ROTOR)
    omega = (3.0 / (1.0 / 3.0 + ROTOR)) ** 0.5
    world.step(120)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_coordinate(joint), 0.1 - 0.1 * np.cos(2.0 * omega), atol=2e-4)


def test_reactions_and_impulses_are_those_of_rows() -> None:
    """So that the island may take the rows of its joints at any step."""
    worlds = []
    for on in (True, False):
        options = Options(timestep=1e-4, substeps=1, sleep=False, articulated=on)
        world = World(rods(2, armature=ROTOR, damping=0.1), options=options)
        world.step(2000)
        worlds.append(world)
    ours, rows = worlds
    for joint in ("joint_0", "joint_1"):
        assert_allclose(ours.joint_reaction(joint), rows.joint_reaction(joint), rtol=2e-3, atol=2e-3)
    for name in ("impulse", "rate"):
        assert_allclose(ours.state.joints[name], rows.state.joints[name], rtol=2e-3, atol=2e-6)


def test_gymnasiums_ant_moves_as_in_mujoco() -> None:
    """Rotors of 1 kg m^2, dampers and torques, from random velocities."""
    ours, theirs = both("ant.xml")
    rng = np.random.default_rng(0)
    data = mujoco.MjData(theirs)
    data.qvel[:] = 0.5 * rng.normal(size=theirs.nv)
    data.ctrl[:] = 0.02 * rng.uniform(-1.0, 1.0, theirs.nu)
    start, speeds = data.qpos.copy(), data.qvel.copy()
    for _ in range(round(1.0 / theirs.opt.timestep)):
        mujoco.mj_step(theirs, data)
    assert abs(data.qpos - start)[7:].max() > 0.3
    scene, names = build_scene(ours)
    errors = []
    for rate in (200, 400):
        world = World(scene, options=Options(timestep=1.0 / rate, substeps=1, sleep=False, articulated=True))
        set_coordinates(world, ours, names, start, speeds)
        world.control[0] = data.ctrl
        world.step(rate)
        assert world.diagnostics().rows[0] == 0
        q, _ = coordinates(world, ours, names)
        errors.append(abs(q[0] - data.qpos).max())
    print(errors)
    assert errors[0] < 1e-5
    assert errors[1] < 0.35 * errors[0]
