"""Heaps of falling boxes and balls."""

from __future__ import annotations

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.spatial import Box, Heightfield, Sphere

from ..palette import AMBER, COOL, PLUM, SAGE, WARM
from .stacks import ground

COLORS = (WARM, AMBER, SAGE, COOL, PLUM)


def bin_walls(scene: Scene, half: float, height: float, friction: float = 0.3) -> None:
    """Add four walls of ``height`` m around a square with sides of 2 ``half`` m."""
    thick = 0.2
    for name, x, y in (("left", -1, 0), ("right", 1, 0), ("front", 0, -1), ("back", 0, 1)):
        extents = (thick if x else half, thick if y else half + 2 * thick, 0.5 * height)  # walls do not overlap
        wall = Box(half_extents=extents, friction=friction)
        position = (x * (half + thick), y * (half + thick), 0.5 * height)
        scene.add_body(f"wall_{name}", kind="static", shapes=[wall], position=position)


def cube_rain(count: int = 60, seed: int = 1) -> Scene:
    """Build ``count`` boxes that fall into a bin; sides of 0.3 to 0.7 m and orientations are drawn with ``seed``."""
    rng = np.random.default_rng(seed)
    scene = Scene(dim=3)
    ground(scene)
    bin_walls(scene, 1.8, 1.5)
    side, pitch = 3, 1.2  # far enough apart that no two boxes touch in any orientation
    for k in range(count):
        layer, place = divmod(k, side * side)
        x, y = (pitch * (i - 0.5 * (side - 1)) for i in divmod(place, side))
        half = 0.5 * rng.uniform(0.3, 0.7, 3)
        q = rng.normal(size=4)
        box = Box(half_extents=tuple(half.tolist()), friction=0.5)
        scene.add_body(
            f"box_{k}",
            shapes=[box],
            position=(x, y, 1.0 + pitch * layer),
            orientation=tuple((q / np.linalg.norm(q)).tolist()),
        )
    return scene


def sphere_grid(
    side: int = 6, radius: float = 0.5, mass: float = 10.0, pitch: float = 1.05, noise: float = 0.02,
    height: float = 0.8, friction: float = 0.0, seed: int = 0,
) -> Scene:  # fmt: skip
    """Build a cubic grid of ``side``^3 balls, ``pitch`` m apart, that falls.

    Each ball is shifted by up to ``noise`` m along each axis; the lowest layer's lowest points are about ``height`` m
    above the ground.
    """
    rng = np.random.default_rng(seed)
    scene = Scene(dim=3)
    ground(scene, friction=friction)
    for k in range(side**3):
        layer, place = divmod(k, side * side)
        i, j = divmod(place, side)
        middle = 0.5 * (side - 1)
        nominal = np.array([(i - middle) * pitch, (j - middle) * pitch, height + radius + layer * pitch])
        ball = Sphere(radius=radius, friction=friction)
        position = tuple((nominal + rng.uniform(-noise, noise, 3)).tolist())
        scene.add_body(f"ball_{k}", shapes=[ball], position=position, mass=mass, color=COLORS[layer % len(COLORS)])
    return scene


def sphere_rain(count: int = 666, radius: float = 0.12, seed: int = 2) -> Scene:
    """Build ``count`` balls that rain into a bin."""
    rng = np.random.default_rng(seed)
    scene = Scene(dim=3)
    ground(scene)
    bin_walls(scene, 1.5, 2.0)
    side, pitch = 8, 0.34
    for k in range(count):
        layer, place = divmod(k, side * side)
        i, j = divmod(place, side)
        shift = rng.uniform(-0.04, 0.04, 3)
        middle = 0.5 * (side - 1)
        position = ((i - middle) * pitch + shift[0], (j - middle) * pitch + shift[1], 1.0 + 0.5 * layer + shift[2])
        ball = Sphere(radius=radius, friction=0.3, restitution=0.3)
        scene.add_body(
            f"ball_{k}", shapes=[ball], position=tuple(map(float, position)), color=COLORS[layer % len(COLORS)]
        )
    return scene


def marble_bowl(count: int = 40, size: float = 4.0, depth: float = 1.0, points: int = 33, seed: int = 3) -> Scene:
    """Build marbles that roll down a bowl: a heightfield z = depth (x^2 + y^2) / (size / 2)^2, in m."""
    rng = np.random.default_rng(seed)
    scene = Scene(dim=3)
    x = np.linspace(-1.0, 1.0, points)
    heights = depth * (x[:, None] ** 2 + x[None, :] ** 2)
    bowl = Heightfield(heights=heights, size=(size, size), friction=0.4)
    scene.add_body("bowl", kind="static", shapes=[bowl])
    radius = 0.1
    for k in range(count):
        angle, ring = 2.4 * k, 0.3 + 0.02 * k  # the golden angle (rad) keeps the marbles apart
        a, b = ring * size / 2 * np.cos(angle), ring * size / 2 * np.sin(angle)
        z = depth * ring**2 + radius + 0.15 + 0.05 * rng.random()
        ball = Sphere(radius=radius, friction=0.4)
        position = (float(a), float(b), float(z))
        scene.add_body(f"marble_{k}", shapes=[ball], position=position, color=COLORS[k % len(COLORS)])
    return scene
