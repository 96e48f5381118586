"""Kernels as plain Python: what coverage sees with NUMBA_DISABLE_JIT=1; compiled, a short smoke run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World
from gsenv.solver.planar import (
    Box,
    Circle,
    Distance,
    Gear,
    HalfPlane,
    Polygon,
    Prismatic,
    Revolute,
    Target,
    Terrain,
    Weld,
    Wheel,
)

pytestmark = pytest.mark.nojit
G = 9.81


def test_a_scene_without_shapes_steps() -> None:
    scene = Scene()
    scene.add_body("wall", "static")
    scene.add_body("bob", mass=1.0, inertia=1.0, position=(1.0, 0.0))
    scene.add_joint("pin", Revolute("wall", "bob", anchor=(0.0, 0.0)))
    world = World(scene)
    world.step(2)
    assert world.position[0, 1, 1] < 0.0
    assert world.diagnostics().penetration[0] == 0.0


def test_a_mixed_scene_steps() -> None:
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("ramp", "static", [Terrain(vertices=[(4.0, 0.0), (6.0, 0.1), (8.0, 0.0)])])
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, 0.5))
    scene.add_body("top", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, 1.5))
    scene.add_body("ball", shapes=[Circle(radius=0.2, restitution=0.8)], position=(2.0, 0.21), linear_velocity=(0, -2))
    wedge = Polygon(vertices=[(0, 0), (1, 0), (0, 0.5)])
    scene.add_body("wedge", shapes=[wedge], position=(5.0, 0.2))
    scene.add_joint("hold", Weld("box", "top"))
    scene.add_joint("drive", Target("ball", max_force=1.0))
    world = World(scene)
    mass = world.parameters.mass[0]
    world.step(3)
    contacts = world.contacts(0)
    under = (contacts.body_a == 0) & (contacts.body_b == 2)
    load = contacts.impulse[under, 0].sum()
    assert load == pytest.approx((mass[2] + mass[3]) * G * world.timestep, rel=1e-2)
    assert world.linear_velocity[0, 4, 1] > 0.0  # the ball has bounced
    assert np.isfinite(world.position).all()
    assert world.diagnostics().joint_error[0] < 1e-6


def test_every_joint_steps() -> None:
    scene = Scene()
    scene.add_body("frame", "static")
    for name, x in (("arm", 0.5), ("hand", 1.5), ("slider", 2.0), ("wheel", -1.0), ("ball", -3.0), ("skid", -5.0)):
        scene.add_body(name, shapes=[Circle(radius=0.2)], position=(x, 0), angular_velocity=0.1)
    servo: dict[str, Any] = {"motor_speed": 2.0, "motor_effort": 3.0, "frequency": 2.0, "damping_ratio": 2.0}
    scene.add_joint("hinge", Revolute("frame", "arm", anchor=(0, 0), limits=(-0.001, 2), **servo))
    scene.add_joint("elbow", Revolute("arm", "hand", anchor=(1, 0)))
    scene.add_joint("slide", Prismatic("hand", "slider", axis=(1, 0), limits=(0, 0.3), **servo))
    scene.add_joint("axle", Wheel("frame", "wheel", axis=(0, 1), stiffness=1e6, limits=(-1, 1), motor_effort=1.0))
    scene.add_joint("spin", Revolute("frame", "wheel"))
    scene.add_joint("gear", Gear("hinge", "spin", ratio=2.0))
    scene.add_joint("rod", Distance("wheel", "ball"))
    scene.add_joint("cord", Distance("ball", "frame", limits=(0, 3.0), stiffness=5.0))
    scene.add_joint("glue", Weld("ball", "skid", damping=3.0))
    scene.add_constraint("edge", ["skid"], [0, 1, 0], frame="body", update=lambda world: {"error": -1e-3, "upper": 0.0})
    scene.add_actuator("push", "axle", mode="torque")
    scene.add_actuator("turn", "hinge", mode="velocity")
    scene.add_actuator("hold", "slide", mode="position")
    world = World(scene)
    world.control[:] = (0.5, 1.0, 0.1)
    world.step(2)
    assert np.isfinite(world.position).all()
    assert world.joint_coordinate("gear")[0] == pytest.approx(0.0, abs=1e-6)
    assert world.joint_reaction("axle")[0, 2] == pytest.approx(0.5, rel=1e-6)
    assert world.diagnostics().joint_error[0] < 1e-5
