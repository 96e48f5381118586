"""Welds among linked joints, rigid and soft: reactions, momentum, springs by stiffness."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Revolute, Target, Weld
from tests.solver.joints import make_joint
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, G, angular_momentum, energy, held, joint, oscillator

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)
T = np.arange(1, 151) / 60.0


@every_fidelity
def test_cantilever_reactions(options: Options) -> None:
    # five bars of 1 m in a row, hinged to nothing: weld k carries 5 - k of them; one hinge hangs at the end
    scene = Scene()
    before = scene.add_body("wall", "static")
    for k in range(5):
        bar = scene.add_body(f"bar_{k}", shapes=[Box(half_extents=(0.5, 0.1))], mass=0.2, position=(0.5 + k, 0))
        scene.add_joint(f"weld_{k}", Weld(before, bar, anchor=(k, 0)))
        before = bar
    scene.add_body("lamp", shapes=[Box(half_extents=(0.1, 0.5))], mass=1.0, position=(5, -0.5))
    scene.add_joint("hinge", Revolute(before, "lamp", anchor=(5, 0)))
    world = World(scene, options=options)
    world.step(60)
    for k in range(5):
        hangs, w = 5 - k, 0.2 * G
        expected = (0, hangs * w + G, hangs**2 / 2 * w + hangs * G)
        np.testing.assert_allclose(world.joint_reaction(f"weld_{k}")[0], expected, rtol=1e-4, atol=1e-4)
    assert world.diagnostics().joint_error[0] < 1e-7


@every_fidelity
def test_turning_weld_keeps_momentum_and_energy(options: Options) -> None:
    # two bars that turn as one at 3 rad/s, one of them a hinged pair's carrier
    scene = Scene(gravity=(0, 0))
    for name, x in (("a", 0.0), ("b", 1.0), ("c", 2.0)):
        motion: dict[str, Any] = {"linear_velocity": (0, 3.0 * (x - 1)), "angular_velocity": 3.0}
        scene.add_body(name, shapes=[Box(half_extents=(0.5, 0.2))], position=(x, 0), angle=x, **motion)
    scene.add_joint("weld", Weld("a", "b", anchor=(0.5, 0)))
    scene.add_joint("hinge", Revolute("b", "c", anchor=(1.5, 0)))
    world = World(scene, options=options)
    spin, start = angular_momentum(world), energy(world)
    for _ in range(120):
        world.step()
        assert angular_momentum(world) == pytest.approx(spin, rel=1e-4)
        assert energy(world) == pytest.approx(start, rel=2e-4)
        assert world.angle[0, 1] - world.angle[0, 0] == pytest.approx(1.0, abs=1e-6)
    assert world.diagnostics().joint_error[0] < 1e-5


def test_soft_weld_by_stiffness() -> None:
    # 2 kg on 300 N/m and 3 kg m^2 on 300 N m/rad, both with 5 N s/m: each swings by itself
    world = held("weld", velocity=(1, 0), spin=1.0, stiffness=300.0, damping=5.0)
    x, angle = np.zeros(len(T)), np.zeros(len(T))
    for k in range(len(T)):
        world.step()
        x[k], angle[k] = world.position[0, 1, 0], world.angle[0, 1]
    for found, m in ((x, 2.0), (angle, 3.0)):
        omega = math.sqrt(300.0 / m)
        exact = oscillator(T, 0.0, 1.0, omega, 5.0 / (2.0 * omega * m))
        np.testing.assert_allclose(found, exact, atol=3e-3 * abs(exact).max())


def test_soft_weld_sags_and_twists_by_statics() -> None:
    # held at its left end: m g / k down, and m g / 2 over k of twist
    world = held("weld", gravity=G, anchor=(-0.5, 0), stiffness=500.0, damping=60.0)
    world.step(900)
    twist = world.angle[0, 1]
    assert twist == pytest.approx(-2 * G * 0.5 * math.cos(twist) / 500.0, rel=1e-5)
    end = world.position[0, 1] + 0.5 * np.array((-math.cos(twist), -math.sin(twist)))
    np.testing.assert_allclose(end, (-0.5, -2 * G / 500.0), atol=1e-6)
    assert world.diagnostics().spring_energy[0] == pytest.approx(250.0 * ((2 * G / 500.0) ** 2 + twist**2), rel=1e-4)
    assert world.diagnostics().joint_error[0] == 0.0


def test_weld_made_soft_and_hard_again() -> None:
    world = held("weld", gravity=G)
    world.step(30)
    np.testing.assert_allclose(world.position[0, 1], 0, atol=1e-9)
    world.parameters.set(joint(world), frequency=1.0, damping_ratio=1.0)
    world.step(600)
    assert world.position[0, 1, 1] == pytest.approx(-G / (2 * math.pi) ** 2, rel=1e-6)
    world.parameters.set(joint(world), frequency=0.0)
    highest = 0.0
    for _ in range(120):
        world.step()
        highest = max(highest, world.diagnostics().kinetic_energy[0])
    np.testing.assert_allclose(world.position[0, 1], 0, atol=1e-6)
    assert highest < 1e-3 * G  # it is put back, not thrown


@pytest.mark.parametrize("kind", ["revolute", "weld"])
def test_target_pulls_what_is_jointed(kind: str) -> None:
    # a hand of 5 Hz moves the first bar, the second hangs on it
    scene = Scene()
    scene.add_body("first", shapes=[Box(half_extents=(0.1, 0.3))], mass=1)
    scene.add_body("second", shapes=[Box(half_extents=(0.1, 0.3))], mass=1, position=(0, -0.6), angular_damping=5.0)
    scene.add_joint("link", make_joint(kind, "first", "second", anchor=(0, -0.3)))
    scene.add_joint("hand", Target("first"))
    world = World(scene, options=AWAKE)
    world.set_target("hand", position=(0.5, 0.2))
    world.step(600)
    sag = 2 * G / (1.0 * (10 * math.pi) ** 2)  # the spring is that of the first bar's 1 kg
    np.testing.assert_allclose(world.position[0, 0], (0.5, 0.2 - sag), atol=2e-3)
    np.testing.assert_allclose(world.joint_reaction("hand")[0, :2], (0, 2 * G), atol=0.05 * G)
