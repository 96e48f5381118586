"""One scene with everything in each dimension, and worlds of it that all differ."""

from __future__ import annotations

import numpy as np

from gsenv.solver import Scene, World, planar, spatial

ROCK = ((-0.3, -0.2, -0.2), (0.3, -0.2, -0.2), (0.0, 0.3, -0.2), (0.1, 0.0, 0.3))
SHELF = -20.0  # m, x of the idle stack


def hills(half: float = 5.0, count: int = 11) -> spatial.Heightfield:
    """A bumpy bowl."""
    x = np.linspace(-half, half, count)
    x, y = np.meshgrid(x, x)
    heights = 0.06 * (x * x + y * y) + 0.1 * np.sin(2.0 * x) * np.cos(1.7 * y)
    return spatial.Heightfield(heights=heights, size=(2 * half, 2 * half), friction=0.8)


def mixed(dim: int) -> Scene:
    return planar_mixed() if dim == 2 else spatial_mixed()


def planar_mixed() -> Scene:
    """One of everything: all shapes, terrain, restitution, welds, a drive, islands that fall asleep."""
    scene = Scene()
    x = np.linspace(-6.0, 6.0, 25)
    hills = np.stack([x, 0.2 * (x / 3.0) ** 2 * (1.0 - (x / 9.0) ** 2)], 1)
    scene.add_body("hills", kind="static", shapes=[planar.Terrain(vertices=hills, friction=0.8)])
    scene.add_body("shelf", kind="static", shapes=[planar.Box(half_extents=(2, 0.1))], position=(-20, 0))
    for k in range(2):  # asleep after half a second
        scene.add_body(f"idle_{k}", shapes=[planar.Box(half_extents=(0.2, 0.2))], position=(-20, 0.3 + 0.4 * k))
    for k in range(3):
        box = planar.Box(half_extents=(0.3, 0.2))
        scene.add_body(f"box_{k}", shapes=[box], position=(0.1 * k, 1.0 + 0.5 * k), angle=0.3 * k)
    for k in range(2):
        ball = planar.Circle(radius=0.2, restitution=0.6)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(1.0 - 2.2 * k, 2.5 + k), linear_velocity=(1 - k, -2))
    pill = planar.Capsule(half_length=0.3, radius=0.1)
    scene.add_body("pill", shapes=[pill], position=(-1.0, 1.5), angle=0.7, angular_velocity=4.0)
    rock = planar.Polygon(vertices=[(-0.3, -0.2), (0.3, -0.2), (0.1, 0.3)])
    scene.add_body("rock", shapes=[rock], position=(1.4, 1.2))
    scene.add_joint("stick", planar.Weld("pill", "rock", collide=True, enabled=False))
    scene.add_body("tail", shapes=[planar.Box(half_extents=(0.1, 0.1))], position=(-1.5, 1.5))
    scene.add_joint("spring", planar.Weld("pill", "tail", frequency=4.0, damping_ratio=0.3))
    hand = planar.Box(half_extents=(0.2, 0.05), friction=1.0)
    scene.add_body("hand", shapes=[hand], position=(3.0, 1.5), gravity_scale=0.0)
    scene.add_joint("arm", planar.Target("hand", max_force=60.0, max_torque=10.0))
    scene.add_actuator("arm_x", "arm", "x")
    scene.add_actuator("arm_y", "arm", "y", lower=-1.0, upper=1.0)
    return scene


def spatial_mixed() -> Scene:
    """All shapes and joints, restitution, all frictions, a drive, a continuous body, islands that fall asleep."""
    scene = Scene(dim=3)
    scene.add_body("hills", "static", shapes=[hills()])
    scene.add_body("floor", "static", shapes=[spatial.Plane(offset=-2.0)])
    scene.add_body("shelf", "static", shapes=[spatial.Box(half_extents=(2, 2, 0.1))], position=(SHELF, 0, 0))
    for k in range(2):  # asleep after half a second
        box = spatial.Box(half_extents=(0.2, 0.2, 0.2))
        scene.add_body(f"idle_{k}", shapes=[box], position=(SHELF, 0, 0.3 + 0.4 * k))
    for k in range(2):
        box = spatial.Box(half_extents=(0.3, 0.2, 0.25))
        scene.add_body(f"box_{k}", shapes=[box], position=(0.1 * k, 0, 1 + 0.6 * k), orientation=(1, 0.3 * k, 0.1, 0.2))
    ball = spatial.Sphere(radius=0.2, restitution=0.6, torsional_friction=0.02, rolling_friction=0.01)
    scene.add_body(
        "ball_0", shapes=[ball], position=(1, 0.3, 2), linear_velocity=(-1, 0, -2), angular_velocity=(0, 0, 9)
    )
    scene.add_body("ball_1", shapes=[ball], position=(-1.2, 0.3, 2.5), linear_velocity=(0, -1, -8), continuous=True)
    scene.add_body(
        "drum",
        shapes=[spatial.Cylinder(half_length=0.2, radius=0.25)],
        position=(0, -1.2, 1),
        orientation=(1, 1, 0.1, 0),
    )
    scene.add_body("rock", shapes=[spatial.Hull(vertices=ROCK)], position=(1.3, -0.8, 1.2), angular_velocity=(3, 2, 1))
    pill = spatial.Capsule(half_length=0.3, radius=0.1)
    scene.add_body("pill", shapes=[pill], position=(-1, 1, 1.5), orientation=(1, 0.4, 0.2, 0))
    scene.add_body("tail", shapes=[spatial.Box(half_extents=(0.1, 0.1, 0.1))], position=(-1.5, 1, 1.5))
    scene.add_joint("spring", spatial.Weld("pill", "tail", frequency=4.0, damping_ratio=0.3))
    scene.add_body("bob", shapes=[spatial.Sphere(radius=0.1)], position=(-1.5, 1.4, 1.5))
    scene.add_joint("hook", spatial.Ball("tail", "bob", anchor=(-1.5, 1.2, 1.5)))
    scene.add_body("load", shapes=[spatial.Sphere(radius=0.1)], position=(-1.5, 2, 1.5))
    scene.add_joint("rope", spatial.Distance("bob", "load", limits=(0.0, 0.7)))
    hand = spatial.Box(half_extents=(0.2, 0.2, 0.05), friction=1.0)
    scene.add_body("hand", shapes=[hand], position=(2, 2, 1.5), gravity_scale=0.0)
    scene.add_joint("arm", spatial.Target("hand", max_force=60.0, max_torque=10.0))
    scene.add_actuator("arm_x", "arm", "x")
    scene.add_actuator("arm_turn", "arm", "turn_z", lower=-1.0, upper=1.0)
    return scene


def randomised(world: World, numbers: range) -> World:
    """World w gets the parameters and the control of number numbers[w]."""
    for w, number in enumerate(numbers):
        parts = np.random.default_rng(number).uniform(0.0, 1.0, 7)
        if world.model.dim == 2:
            _set_planar(world, w, parts.tolist())
        else:
            _set_spatial(world, w, parts.tolist())
        if number % 3 == 0:
            world.parameters.set("ball_1", enabled=False, worlds=w)
    return world


def _set_planar(world: World, w: int, parts: list[float]) -> None:
    friction, mass, gravity, half, pull, x, y = parts
    world.parameters.set("box_1", friction=friction, worlds=w)
    world.parameters.set("box_2", mass=0.1 + 5.0 * mass, worlds=w)
    world.parameters.set("box_0", half_extents=(0.2 + 0.2 * half, 0.2), worlds=w)
    world.parameters.set(gravity=(0.0, -5.0 - 6.0 * gravity), worlds=w)
    world.apply_force("pill", force=(20.0 * pull, 0.0), worlds=w)
    world.control[w] = (-2.0 * x, 1.0 - 2.0 * y)


def _set_spatial(world: World, w: int, parts: list[float]) -> None:
    friction, mass, gravity, half, pull, x, turn = parts
    world.parameters.set("box_1", friction=friction, worlds=w)
    world.parameters.set("drum", mass=10.0 * mass + 1.0, worlds=w)
    world.parameters.set("rock", inertia=(0.02 + 0.01 * mass, 0.03, 0.03), worlds=w)
    world.parameters.set("box_0", half_extents=(0.2 + 0.2 * half, 0.2, 0.25), worlds=w)
    world.parameters.set("ball_0", torsional_friction=0.1 * half, worlds=w)
    world.parameters.set(gravity=(0.0, 0.0, -5.0 - 6.0 * gravity), worlds=w)
    world.apply_force("pill", force=(2.0 * pull, 0.0, 0.0), torque=(0.0, 0.1 * turn, 0.0), worlds=w)
    world.control[w] = (-2.0 * x, 1.0 - 2.0 * turn)
