"""Machines with hinges, sliders and wheels: a door and a cart."""

from __future__ import annotations

from typing import Any

from gsenv.solver import Scene
from gsenv.solver.spatial import Axis, Box, Cylinder, Hinge, Plane, Sphere, Wheel

from ..palette import AMBER, GRAPHITE, STEEL, WARM
from .turning import about

WHEEL_RADIUS = 0.32  # m


def cart(speed: float = 6.0, steering: float = 0.25) -> Scene:
    """A cart on four sprung wheels coasts over the ground, its front wheels steered.

    Args:
        speed: m/s, at the start, along x.
        steering: rad, which a spring holds.
    """
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[Plane(friction=0.9)])
    height = WHEEL_RADIUS + 0.1
    scene.add_body(
        "chassis", shapes=[Box(half_extents=(1.0, 0.45, 0.12))], position=(0.0, 0.0, height + 0.1), mass=300.0,
        linear_velocity=(speed, 0.0, 0.0), color=STEEL,
    )  # fmt: skip
    for name, x, y in (("front_left", 0.8, 0.6), ("front_right", 0.8, -0.6), ("rear_left", -0.8, 0.6),
                       ("rear_right", -0.8, -0.6)):  # fmt: skip
        scene.add_body(
            name, shapes=[Cylinder(half_length=0.1, radius=WHEEL_RADIUS, friction=0.9)], mass=15.0,
            position=(x, y, WHEEL_RADIUS), orientation=about(0, -90.0), color=GRAPHITE,
            linear_velocity=(speed, 0.0, 0.0), angular_velocity=(0.0, speed / WHEEL_RADIUS, 0.0),
        )  # fmt: skip
        held = Axis(frequency=8.0, rest=steering) if x > 0.0 else None
        suspension: dict[str, Any] = {"stiffness": 25e3, "damping": 2e3, "limits": (-0.15, 0.15)}
        wheel = Wheel("chassis", name, axis=(0, 0, 1), spin_axis=(0, 1, 0), steering=held, **suspension)
        scene.add_joint(f"{name}_wheel", wheel)
    return scene


def swing_door() -> Scene:
    """A ball hits a door on two hinges, which opens to its limit and is closed by a spring."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", shapes=[Plane()])
    scene.add_body(
        "post", "static", shapes=[Box(half_extents=(0.05, 0.05, 1.0), position=(0.0, 0.0, 1.0))], color=GRAPHITE
    )
    scene.add_body("door", shapes=[Box(half_extents=(0.4, 0.02, 0.9))], position=(0.5, 0.0, 1.0), mass=12.0, color=WARM)
    for name, z in (("lower", 0.4), ("upper", 1.6)):
        closer: dict[str, Any] = {"stiffness": 3.0, "damping": 2.0, "limits": (-0.05, 1.7)} if name == "lower" else {}
        scene.add_joint(f"{name}_hinge", Hinge("post", "door", anchor=(0.07, 0.0, z), axis=(0, 0, 1), **closer))
    scene.add_body(
        "ball", shapes=[Sphere(radius=0.15)], position=(0.7, -1.2, 1.2), mass=2.0, linear_velocity=(0.0, 6.0, 1.0),
        color=AMBER,
    )  # fmt: skip
    return scene
