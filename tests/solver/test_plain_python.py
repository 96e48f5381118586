"""Kernels as plain Python: what coverage sees with NUMBA_DISABLE_JIT=1; compiled, a short smoke run."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver import Box, Circle, HalfPlane, Polygon, Scene, Terrain, World

pytestmark = pytest.mark.nojit
G = 9.81


def test_a_mixed_scene_steps() -> None:
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("ramp", "static", [Terrain(vertices=[(4.0, 0.0), (6.0, 0.1), (8.0, 0.0)])])
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, 0.5))
    scene.add_body("top", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.0, 1.5))
    scene.add_body("ball", shapes=[Circle(radius=0.2, restitution=0.8)], position=(2.0, 0.21), linear_velocity=(0, -2))
    wedge = Polygon(vertices=[(0, 0), (1, 0), (0, 0.5)])
    scene.add_body("wedge", shapes=[wedge], position=(5.0, 0.2))
    scene.add_joint("hold", "weld", "box", "top")
    scene.add_joint("drive", "target", body_b="ball", max_force=1.0)
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
