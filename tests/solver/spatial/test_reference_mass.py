"""A frequency of a 3D joint means one stiffness at all poses, so that springs and soft limits conserve energy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene
from gsenv.solver.spatial import Axis, Box, Hinge, SixAxis, Universal
from tests.solver.spatial.one_kernel import full_world

FREQUENCY = 1.5  # Hz
ARM = 0.3  # m
MASS = 2.0  # kg
INERTIA = (0.05, 0.02, 0.04)  # kg m^2


def swinging(axes: dict[str, Any]) -> Scene:
    """A body on a joint at an arm from its centre, to a fixed body; it moves sideways and spins."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    scene.add_body("base", "static")
    shape = Box(half_extents=(0.1, 0.1, 0.1), mask=0)
    moving: dict[str, Any] = {"linear_velocity": (0.4, -0.5, 0.2), "angular_velocity": (0.3, -1.0, 3.0)}
    scene.add_body("body", shapes=[shape], position=(ARM, 0.0, 0.0), mass=MASS, inertia=INERTIA, **moving)
    scene.add_joint("joint", SixAxis("base", "body", anchor=(0.0, 0.0, 0.0), **axes))
    return scene


@pytest.mark.parametrize("articulated", [True, False])
@pytest.mark.parametrize(
    "axes",
    [
        {"x": Axis(frequency=FREQUENCY, damping_ratio=0.0), "turn_z": Axis()},
        {"turn_x": Axis(frequency=FREQUENCY, damping_ratio=0.0), "turn_y": Axis()},
        {"x": Axis(limits=(-0.01, 0.01), limit_frequency=FREQUENCY, limit_damping_ratio=0.0), "turn_z": Axis()},
    ],
    ids=["translation", "rotation", "limits"],
)
def test_energy_is_conserved(axes: dict[str, Any], articulated: bool) -> None:
    world = full_world(swinging(axes), options=Options(timestep=5e-4, articulated=articulated, sleep=False))
    world.step()
    start = world.diagnostics().energy[0]
    off = []
    for _ in range(60):
        world.step(100)
        off.append(world.diagnostics().energy[0] - start)
    assert np.abs(off).max() < 2e-3 * start


def test_the_stiffness_is_that_of_the_pose_in_which_the_joint_was_made() -> None:
    scene = swinging({"y": Axis(frequency=FREQUENCY), "turn_z": Axis()})
    world = full_world(scene)
    stiffness = (2.0 * math.pi * FREQUENCY) ** 2 / (1.0 / MASS + ARM**2 / INERTIA[2])
    for turn in (0.0, 0.7, 2.0):
        half = 0.5 * turn
        middle = np.array([ARM * math.cos(turn), 0.1 + ARM * math.sin(turn), 0.0])
        world.state.bodies["position"][0, 1] = middle
        world.state.bodies["rotation"][0, 1] = (math.cos(half), 0.0, 0.0, math.sin(half))
        assert world.diagnostics().spring_energy[0] == pytest.approx(0.5 * stiffness * 0.1**2, rel=1e-9)


@pytest.mark.parametrize("articulated", [True, False])
def test_a_hinge_swings_with_its_frequency(articulated: bool) -> None:
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    scene.add_body("base", "static")
    shape = Box(half_extents=(0.1, 0.1, 0.1), mask=0)
    scene.add_body("body", shapes=[shape], mass=MASS, inertia=INERTIA, angular_velocity=(0.0, 0.0, 1.0))
    scene.add_joint("joint", Hinge("base", "body", axis=(0.0, 0.0, 1.0), frequency=FREQUENCY, damping_ratio=0.0))
    world = full_world(scene, options=Options(timestep=1.0 / 120.0, articulated=articulated, sleep=False))
    world.step(200)
    omega = 2.0 * math.pi * FREQUENCY
    assert world.joint_coordinate("joint")[0] == pytest.approx(math.sin(omega * 200 / 120) / omega, abs=1e-6)


def test_soft_limits_of_universal_joints_gain_no_energy() -> None:
    """Links that spin by a radian in a step: substeps whose rates do not settle are divided."""
    soft = Axis(limits=(-0.3, 0.3), limit_frequency=4.0, limit_damping_ratio=0.1)
    scene = Scene(dim=3, gravity=(0.0, 0.0, -9.81))
    scene.add_body("base", "static")
    for k in range(4):
        shape = Box(half_extents=(0.02, 0.03, 0.1), mask=0)
        scene.add_body(f"body_{k}", shapes=[shape], position=(0.05 * k, 0.0, -0.2 * k - 0.1))
        joint = Universal(
            f"body_{k - 1}" if k else "base", f"body_{k}", axis_a=(1.0, 0.0, 0.0), axis_b=(0.0, 1.0, 0.0),
            anchor=(0.05 * k, 0.0, -0.2 * k), turn_a=soft, turn_b=soft,
        )  # fmt: skip
        scene.add_joint(f"joint_{k}", joint)
    world = full_world(scene, options=Options(timestep=0.02, sleep=False))
    world.state.bodies["velocity"][0, -1, 3:] = (20.0, -30.0, 10.0)
    world.step()
    start = world.diagnostics().energy[0]
    most = 0.0
    for _ in range(300):
        world.step()
        most = max(most, world.diagnostics().energy[0] - start)
    assert most < 1e-3 * abs(start)
