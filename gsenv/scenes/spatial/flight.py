"""Free flight, free rotation and bouncing."""

from __future__ import annotations

from collections.abc import Sequence

from gsenv.solver import Scene
from gsenv.solver.spatial import Box, Sphere

from .stacks import ground
from .turning import UPRIGHT, Quaternion, Vec, turned


def thrown_box(velocity: Vec = (5.0, 1.0, 7.0), spin: Vec = (1.0, 2.0, 3.0), gravity: float = 9.81) -> Scene:
    """Build a tumbling box in free flight, with nothing to hit.

    velocity: m/s; spin: rad/s; gravity: m/s^2
    """
    scene = Scene(dim=3, gravity=(0.0, 0.0, -gravity))
    scene.add_body(
        "box",
        shapes=[Box(half_extents=(0.3, 0.2, 0.1))],
        position=(0.0, 0.0, 1.0),
        linear_velocity=velocity,
        angular_velocity=spin,
    )
    return scene


def spinning_box(
    inertia: Vec = (1.0, 2.0, 3.0), spin: Vec = (0.01, 1.0, 0.01), orientation: Quaternion = UPRIGHT
) -> Scene:
    """Build a weightless body that rotates nearly about its intermediate axis and flips periodically (Dzhanibekov).

    inertia: kg m^2, principal moments about the body's axes; spin: rad/s, in the body's axes
    """
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    box = Box(half_extents=(1.0, 0.6, 0.2))
    scene.add_body(
        "box",
        shapes=[box],
        orientation=orientation,
        mass=6.0,
        inertia=inertia,
        angular_velocity=turned(orientation, spin),
    )
    return scene


def bouncing_spheres(
    restitutions: Sequence[float] = (0.0, 0.3, 0.6, 0.8, 0.9, 1.0), height: float = 1.0, radius: float = 0.1
) -> Scene:
    """Build balls that are dropped side by side, with their lowest points ``height`` m above the ground."""
    scene = Scene(dim=3)
    ground(scene)
    for k, restitution in enumerate(restitutions):
        ball = Sphere(radius=radius, restitution=restitution)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0.5 * k, 0.0, height + radius))
    return scene
