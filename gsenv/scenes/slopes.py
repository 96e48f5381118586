"""Sliding and rolling on inclined planes and on terrain."""

from __future__ import annotations

import math

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Circle, HalfPlane, Terrain


def box_on_incline(
    degrees: float = 35.0,
    friction: float = 0.5,
    half_extents: tuple[float, float] = (0.25, 0.1),
) -> Scene:
    """Build a box at rest on a plane that slopes down to the right by ``degrees``."""
    alpha = math.radians(degrees)
    scene = Scene()
    normal = (math.sin(alpha), math.cos(alpha))
    scene.add_body("slope", kind="static", shapes=[HalfPlane(normal=normal, friction=friction)])
    h = half_extents[1]
    scene.add_body(
        "box",
        shapes=[Box(half_extents=half_extents, friction=friction)],
        position=(h * normal[0], h * normal[1]),
        angle=-alpha,
    )
    return scene


def disk_on_incline(degrees: float = 20.0, radius: float = 0.5, friction: float = 0.5) -> Scene:
    """Build a disk at rest on a plane that slopes down to the right by ``degrees``."""
    alpha = math.radians(degrees)
    scene = Scene()
    normal = (math.sin(alpha), math.cos(alpha))
    scene.add_body("slope", kind="static", shapes=[HalfPlane(normal=normal, friction=friction)])
    scene.add_body(
        "disk",
        shapes=[Circle(radius=radius, friction=friction)],
        position=(radius * normal[0], radius * normal[1]),
    )
    return scene


def sliding_disk(speed: float = 3.0, friction: float = 0.3, radius: float = 0.5) -> Scene:
    """Build a disk that slides without rotation on level ground, until friction makes it roll."""
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane(friction=friction)])
    scene.add_body(
        "disk",
        shapes=[Circle(radius=radius, friction=friction)],
        position=(0.0, radius),
        linear_velocity=(speed, 0.0),
    )
    return scene


def terrain_slide(length: float = 24.0) -> Scene:
    """Build hills of ``length`` m with a ball and boxes that move down them."""
    x = np.linspace(0.0, length, 97)
    y = 1.2 * np.cos(2.0 * np.pi * x / 8.0) + 3.0 * (1.0 - x / length) ** 2
    scene = Scene()
    hills = Terrain(vertices=np.stack([x, y], 1), friction=0.7)
    scene.add_body("hills", kind="static", shapes=[hills])
    scene.add_body("ball", shapes=[Circle(radius=0.4, friction=0.7)], position=(0.6, y[2] + 0.6))
    for k in range(4):
        box = Box(half_extents=(0.3, 0.2 + 0.05 * k), friction=0.3)
        scene.add_body(f"box_{k}", shapes=[box], position=(8.5 + 1.2 * k, 4.0 + 0.5 * k))
    return scene
