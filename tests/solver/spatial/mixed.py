"""One scene of everything in space, and worlds of it that all differ."""

from __future__ import annotations

import numpy as np

from gsenv.solver import Scene, World
from gsenv.solver.spatial.shapes import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Sphere

ROCK = ((-0.3, -0.2, -0.2), (0.3, -0.2, -0.2), (0.0, 0.3, -0.2), (0.1, 0.0, 0.3))
SHELF = -20.0  # m, x of the idle stack


def hills(half: float = 5.0, count: int = 11) -> Heightfield:
    """A bumpy bowl."""
    x = np.linspace(-half, half, count)
    x, y = np.meshgrid(x, x)
    heights = 0.06 * (x * x + y * y) + 0.1 * np.sin(2.0 * x) * np.cos(1.7 * y)
    return Heightfield(heights=heights, size=(2 * half, 2 * half), friction=0.8)


def mixed() -> Scene:
    """All shapes and joints, restitution, all frictions, a drive, a fast body, islands that fall asleep."""
    scene = Scene(dim=3)
    scene.add_body("hills", "static", shapes=[hills()])
    scene.add_body("floor", "static", shapes=[Plane(offset=-2.0)])
    scene.add_body("shelf", "static", shapes=[Box(half_extents=(2, 2, 0.1))], position=(SHELF, 0, 0))
    for k in range(2):  # asleep after half a second
        scene.add_body(f"idle_{k}", shapes=[Box(half_extents=(0.2, 0.2, 0.2))], position=(SHELF, 0, 0.3 + 0.4 * k))
    for k in range(2):
        box = Box(half_extents=(0.3, 0.2, 0.25))
        scene.add_body(f"box_{k}", shapes=[box], position=(0.1 * k, 0, 1 + 0.6 * k), rotation=(1, 0.3 * k, 0.1, 0.2))
    ball = Sphere(radius=0.2, restitution=0.6, torsional_friction=0.02, rolling_friction=0.01)
    scene.add_body(
        "ball_0", shapes=[ball], position=(1, 0.3, 2), linear_velocity=(-1, 0, -2), angular_velocity=(0, 0, 9)
    )
    scene.add_body("ball_1", shapes=[ball], position=(-1.2, 0.3, 2.5), linear_velocity=(0, -1, -8), fast=True)
    scene.add_body(
        "drum", shapes=[Cylinder(half_length=0.2, radius=0.25)], position=(0, -1.2, 1), rotation=(1, 1, 0.1, 0)
    )
    scene.add_body("rock", shapes=[Hull(vertices=ROCK)], position=(1.3, -0.8, 1.2), angular_velocity=(3, 2, 1))
    pill = Capsule(half_length=0.3, radius=0.1)
    scene.add_body("pill", shapes=[pill], position=(-1, 1, 1.5), rotation=(1, 0.4, 0.2, 0))
    scene.add_body("tail", shapes=[Box(half_extents=(0.1, 0.1, 0.1))], position=(-1.5, 1, 1.5))
    scene.add_joint("spring", "weld", "pill", "tail", frequency=4.0, damping_ratio=0.3)
    scene.add_body("bob", shapes=[Sphere(radius=0.1)], position=(-1.5, 1.4, 1.5))
    scene.add_joint("hook", "ball", "tail", "bob", anchor=(-1.5, 1.2, 1.5))
    scene.add_body("load", shapes=[Sphere(radius=0.1)], position=(-1.5, 2, 1.5))
    scene.add_joint("rope", "distance", "bob", "load", limits=(0.0, 0.7))
    hand = Box(half_extents=(0.2, 0.2, 0.05), friction=1.0)
    scene.add_body("hand", shapes=[hand], position=(2, 2, 1.5), gravity_scale=0.0)
    scene.add_joint("arm", "target", body_b="hand", max_force=60.0, max_torque=10.0)
    scene.add_actuator("arm_x", "arm", "x")
    scene.add_actuator("arm_turn", "arm", "turn_z", lower=-1.0, upper=1.0)
    return scene


def randomised(world: World, numbers: range) -> World:
    """World w gets the parameters and the control of number numbers[w]."""
    for w, number in enumerate(numbers):
        friction, mass, gravity, half, pull, x, turn = np.random.default_rng(number).uniform(0.0, 1.0, 7)
        world.parameters.set("box_1", friction=friction, worlds=w)
        world.parameters.set("drum", mass=10.0 * mass + 1.0, worlds=w)
        world.parameters.set("rock", inertia=(0.02 + 0.01 * mass, 0.03, 0.03), worlds=w)
        world.parameters.set("box_0", half_extents=(0.2 + 0.2 * half, 0.2, 0.25), worlds=w)
        world.parameters.set("ball_0", torsional_friction=0.1 * half, worlds=w)
        world.parameters.set(gravity=(0.0, 0.0, -5.0 - 6.0 * gravity), worlds=w)
        if number % 3 == 0:
            world.parameters.set("ball_1", enabled=False, worlds=w)
        world.apply_force("pill", (2.0 * pull, 0.0, 0.0), torque=(0.0, 0.1 * turn, 0.0), worlds=w)
        world.control[w] = (-2.0 * x, 1.0 - 2.0 * turn)
    return world
