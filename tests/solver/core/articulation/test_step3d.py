"""Steps in joint coordinates in 3D: order, momentum, friction, statics, hinges and sliders."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Ball, Box, Capsule, Hinge, Plane, Slider, Sphere, Weld
from tests.solver.core.articulation.opened import articulated
from tests.solver.core.articulation.test_dynamics import Tree

Array = np.ndarray[Any, Any]
G = 9.81
FAR = 1e4  # m


def space(weight: float = G) -> Scene:
    """A scene with a disabled hinge far away, so that one kernel steps all of them."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, -weight))
    scene.add_body("far", "static", shapes=[Plane()], position=(0.0, 0.0, -FAR))
    scene.add_body("farther", shapes=[Sphere(radius=0.1)], position=(FAR, 0.0, FAR), enabled=False)
    scene.add_joint("nothing", Hinge("far", "farther", axis=(1.0, 0.0, 0.0), enabled=False))
    return scene


def floating(seed: int, gravity: float = 0.0) -> Scene:
    """A random tree of five boxes on ball joints."""
    tree = Tree(seed, True, 5)
    scene = space(gravity)
    for k, p in enumerate(tree.parents):
        scene.add_body(
            f"b{k}",
            shapes=[Box(half_extents=(0.1, 0.1, 0.1), mask=0)],
            position=tree.positions[k],
            orientation=tree.rotations[k],
            mass=tree.masses[k],
            inertia=tree.inertias[k],
            linear_velocity=tree.speeds[k],
            angular_velocity=tree.spins[k],
        )
        if p >= 0:
            scene.add_joint(f"j{k}", Ball(f"b{p}", f"b{k}", anchor=tree.pin(k)))
    return scene


def end_of(on: bool, rate: int, seed: int = 1) -> Array:
    options = Options(timestep=1.0 / rate, substeps=1, max_substeps=1, sleep=False, articulated=on)
    world = World(floating(seed), options=options)
    world.step(rate // 2)
    return world.position[0, 2:]


def test_a_floating_tree_converges_with_second_order_to_the_motion_of_rows() -> None:
    ends = [end_of(True, rate) for rate in (240, 480, 960, 1920)]
    steps = [np.linalg.norm(b - a) for a, b in pairwise(ends)]
    assert_allclose(np.divide(steps[:-1], steps[1:]), 4.0, rtol=0.15)
    assert_allclose(end_of(False, 3840), ends[-1], atol=3e-5)


def test_a_floating_tree_keeps_momentum_and_energy() -> None:
    world = articulated(floating(2), timestep=1.0 / 960, substeps=1, sleep=False)
    start = world.diagnostics()
    world.step(960)
    end = world.diagnostics()
    assert end.rows[0] == 0
    assert end.joint_error[0] < 1e-14
    drift = [end.momentum - start.momentum, end.angular_momentum - start.angular_momentum]
    print(drift, end.energy - start.energy)
    assert_allclose(drift, 0.0, atol=1e-3)
    assert_allclose(end.energy, start.energy, rtol=1e-4)


def sliding(degrees: float, friction: float, joint: Any) -> World:
    """Two boxes of different size, joined, on a slope: gravity is tilted by ``degrees`` about y."""
    scene = space()
    scene.add_body("ground", "static", shapes=[Plane(friction=friction)])
    for k, size in enumerate((0.1, 0.2)):
        box = Box(half_extents=(0.2, 0.15, size), friction=friction)
        scene.add_body(f"box_{k}", shapes=[box], position=(0.5 * k, 0.0, size))
    scene.add_joint("joint", joint)
    world = articulated(scene, sleep=False)
    tilt = np.radians(degrees)
    world.parameters.set(gravity=(G * np.sin(tilt), 0.0, -G * np.cos(tilt)))
    return world


JOINTS = [
    Ball("box_0", "box_1", anchor=(0.25, 0.0, 0.0)),
    Weld("box_1", "box_0", anchor=(0.25, 0.0, 0.1)),
    Hinge("box_0", "box_1", axis=(0.0, 1.0, 0.0), anchor=(0.25, 0.0, 0.0)),
]


@pytest.mark.parametrize("joint", JOINTS, ids=["ball", "weld", "hinge"])
def test_friction_holds_and_slides_by_coulombs_law(joint: Any) -> None:
    world = sliding(20.0, 0.4, joint)
    world.step(60)
    before = world.position[0, 3:]
    world.step(60)
    assert_allclose(world.position[0, 3:], before, atol=1e-5)
    contacts = world.contacts()
    force = contacts.force_vector(world.timestep)[contacts.body_a == 2].sum(0)
    weight = world.parameters.mass[0, 3:].sum() * G
    assert_allclose(
        force, weight * np.array([-np.sin(np.radians(20)), 0.0, np.cos(np.radians(20))]), rtol=1e-3, atol=1e-3 * weight
    )
    world = sliding(35.0, 0.4, joint)
    world.step(60)
    speed = (np.sin(np.radians(35)) - 0.4 * np.cos(np.radians(35))) * G
    assert_allclose(world.linear_velocity[0, 3:, 0], speed, rtol=1e-3)


def test_a_heap_of_dolls_carries_its_weight() -> None:
    """Two small dolls: a ball with three legs on ball joints, one on top of the other."""
    scene = space()
    scene.add_body("ground", "static", shapes=[Plane(friction=0.8)])
    for n in range(2):
        height = 0.5 + 0.5 * n
        scene.add_body(f"head_{n}", shapes=[Sphere(radius=0.12, friction=0.8)], position=(0.01 * n, 0.0, height))
        for k in range(3):
            turn = 2.0 * np.pi * (k / 3.0 + 0.1 * n)
            x, y = np.cos(turn), np.sin(turn)
            leg = Capsule(half_length=0.12, radius=0.05, friction=0.8)
            half = np.sqrt(0.5)
            rotation = (half, -half * y, half * x, 0.0)
            at = (0.3 * x + 0.01 * n, 0.3 * y, height)
            scene.add_body(f"leg_{n}{k}", shapes=[leg], position=at, orientation=rotation, angular_damping=0.5)
            scene.add_joint(
                f"hip_{n}{k}", Ball(f"head_{n}", f"leg_{n}{k}", anchor=(0.13 * x + 0.01 * n, 0.13 * y, height))
            )
    world = articulated(scene)
    world.step(420)
    contacts = world.contacts()
    force = contacts.force_vector(world.timestep)[contacts.body_a == 2].sum(0)
    weight = world.parameters.mass[0, 3:].sum() * G
    assert_allclose(force, [0.0, 0.0, weight], atol=5e-3 * weight)
    diagnostics = world.diagnostics()
    assert diagnostics.penetration[0] < 1e-3
    assert diagnostics.joint_error[0] < 1e-14


@pytest.mark.parametrize("flipped", [False, True])
def test_a_hinge_swings_with_the_period_of_its_pendulum(flipped: bool) -> None:
    """Small oscillations of a rod about a tilted axis, with a second rod welded to it."""
    tilt = np.radians(30.0)
    axis = np.array([0.0, np.cos(tilt), np.sin(tilt)])
    down = np.array([0.0, np.sin(tilt), -np.cos(tilt)])  # across the axis, lowest
    swing = 0.01
    side = np.cross(axis, down)
    along = np.cos(swing) * down + np.sin(swing) * side
    scene = space()
    scene.add_body("hook", "static")
    for k in range(2):
        box = Box(half_extents=(0.05, 0.05, 0.05), mask=0)
        given: dict[str, Any] = {"mass": 1.0, "inertia": (1e-3, 1e-3, 1e-3)}
        scene.add_body(f"box_{k}", shapes=[box], position=(1.0 + k) * along, **given)
    pair = ("box_0", "hook") if flipped else ("hook", "box_0")
    scene.add_joint("hinge", Hinge(*pair, axis=axis, anchor=(0.0, 0.0, 0.0)))
    scene.add_joint("weld", Weld("box_0", "box_1"))
    world = articulated(scene, timestep=1.0 / 240, substeps=1, sleep=False)
    inertia = 1.0 + 4.0 + 2e-3
    period = 2.0 * np.pi * np.sqrt(inertia / (3.0 * G * np.cos(tilt)))
    steps = round(period * 240)
    world.step(steps)
    phase = 2.0 * np.pi * steps / 240 / period
    turned = swing * (1.0 - np.cos(phase)) * (1.0 if flipped else -1.0)
    assert_allclose(world.joint_coordinate("hinge"), turned, atol=2e-6)
    assert world.diagnostics().joint_error[0] < 1e-12
    assert world.diagnostics().rows[0] == 0


def test_a_motor_turns_a_hinge_many_times() -> None:
    scene = space(0.0)
    scene.add_body("hook", "static")
    box = Box(half_extents=(0.1, 0.2, 0.3), mask=0)
    scene.add_body("box", shapes=[box], position=(0.0, 0.0, 0.5), mass=1.0)
    scene.add_joint(
        "hinge",
        Hinge("hook", "box", axis=(0.0, 0.0, 1.0), anchor=(0.0, 0.0, 0.0), motor_speed=7.0, motor_effort=np.inf),
    )
    world = articulated(scene, sleep=False)
    world.step(120)
    # in the first substep the mean of old and new speed
    assert_allclose(world.joint_coordinate("hinge"), 7.0 * (2.0 - 0.5 / 120.0), rtol=1e-9)
    assert_allclose(world.joint_rate("hinge"), 7.0, rtol=1e-9)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_slider_with_a_spring_and_limits(flipped: bool) -> None:
    """1 kg on 100 N/m oscillates at 10 rad/s; without a spring it falls to its limit."""
    scene = space()
    scene.add_body("rail", "static")
    settings: tuple[dict[str, Any], ...] = ({"stiffness": 100.0}, {"limits": (-0.2, 0.3)})
    for k, given in enumerate(settings):
        box = Box(half_extents=(0.1, 0.2, 0.3), mask=0)
        scene.add_body(f"box_{k}", shapes=[box], position=(0.0, 3.0 * k, 0.5), mass=1.0)
        pair = (f"box_{k}", "rail") if flipped else ("rail", f"box_{k}")
        scene.add_joint(f"slider_{k}", Slider(*pair, axis=(1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0), **given))
    world = articulated(scene, timestep=1.0 / 120, sleep=False)
    world.step(120)
    fall = 0.01 * G * 2.0 / 3.0 * (1.0 - np.cos(10.0))
    assert_allclose(world.joint_coordinate("slider_0"), fall if flipped else -fall, atol=1e-4)
    assert_allclose(world.joint_coordinate("slider_1"), 0.3 if flipped else -0.2, atol=1e-5)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_limit_holds_where_another_one_pushes_its_joint_to_it(flipped: bool) -> None:
    """As in 2D: two rods turn as one until the limit of the first stops it and throws the second against its own."""
    scene = space(0.0)
    scene.add_body("hook", "static")
    for k in range(2):
        rod = Box(half_extents=(0.5, 0.05, 0.05), mask=0)
        scene.add_body(f"rod_{k}", shapes=[rod], position=(k + 0.5, 0.0, 0.0), mass=1.0)
        pair = ("hook" if k == 0 else "rod_0", f"rod_{k}")
        swap = flipped and k == 1
        limits = (-0.05, 0.1) if swap else (-0.1, 0.05)
        joint = Hinge(*(pair[::-1] if swap else pair), anchor=(k, 0.0, 0.0), axis=(0.6, 0.0, 0.8), limits=limits)
        scene.add_joint(f"joint_{k}", joint)
    world = articulated(scene, timestep=1.0 / 120, sleep=False)
    world.set_joint("joint_0", rate=10.0)  # 0.083 rad in a step
    world.step()
    for name in ("joint_0", "joint_1"):
        assert_allclose(abs(world.joint_coordinate(name)), 0.05, atol=1e-5)
