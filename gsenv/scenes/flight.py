"""Free flight and bouncing."""

from __future__ import annotations

from collections.abc import Sequence

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Circle, HalfPlane


def projectile(velocity: tuple[float, float] = (5.0, 7.0), spin: float = 3.0, gravity: float = 9.81) -> Scene:
    """Build a spinning box in free flight, with nothing to hit.

    velocity: m/s; spin: rad/s; gravity: m/s^2
    """
    scene = Scene(gravity=(0.0, -gravity))
    scene.add_body(
        "box",
        shapes=[Box(half_extents=(0.3, 0.2))],
        position=(0.0, 1.0),
        linear_velocity=velocity,
        angular_velocity=spin,
    )
    return scene


def bouncing_balls(
    restitutions: Sequence[float] = (0.0, 0.3, 0.6, 0.8, 0.9, 1.0),
    height: float = 1.0,
    radius: float = 0.1,
) -> Scene:
    """Build balls that are dropped side by side, with their lowest points ``height`` m above the ground."""
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    for k, restitution in enumerate(restitutions):
        ball = Circle(radius=radius, restitution=restitution)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(0.5 * k, height + radius))
    return scene
