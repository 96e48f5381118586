"""Free motion, spin and bounces."""

from __future__ import annotations

from collections.abc import Sequence

from gsenv.solver import Scene
from gsenv.solver.spatial.shapes import Box, Sphere

from .stacks import ground
from .turning import UPRIGHT, Quaternion, Vec, turned


def thrown_box(velocity: Vec = (5.0, 1.0, 7.0), spin: Vec = (1.0, 2.0, 3.0), gravity: float = 9.81) -> Scene:
    """A spinning box in free flight; nothing to hit."""
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
    inertia: Vec = (1.0, 2.0, 3.0), spin: Vec = (0.01, 1.0, 0.01), rotation: Quaternion = UPRIGHT
) -> Scene:
    """A body of principal moments ``inertia`` (kg m^2) without weight, turning at ``spin`` rad/s, both along its own
    axes, nearly about the middle one: it flips over again and again (Dzhanibekov's wing nut)."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    box = Box(half_extents=(1.0, 0.6, 0.2))
    scene.add_body(
        "box", shapes=[box], rotation=rotation, mass=6.0, inertia=inertia, angular_velocity=turned(rotation, spin)
    )
    return scene


def bouncing_spheres(
    restitutions: Sequence[float] = (0.0, 0.3, 0.6, 0.8, 0.9, 1.0), height: float = 1.0, radius: float = 0.1
) -> Scene:
    """Balls dropped side by side, their lowest points ``height`` m above the ground."""
    scene = Scene(dim=3)
    ground(scene)
    for k, restitution in enumerate(restitutions):
        ball = Sphere(radius=radius, restitution=restitution)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0.5 * k, 0.0, height + radius))
    return scene
