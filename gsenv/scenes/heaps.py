"""Heaps of falling boxes, and dominoes."""

from __future__ import annotations

import math

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Box

from .stacks import ground


def cube_drop(count: int = 50, seed: int = 1) -> Scene:
    """Build ``count`` boxes that fall into a bin; sides of 0.3 to 0.8 m and angles are random, drawn with ``seed``."""
    rng = np.random.default_rng(seed)
    scene = Scene()
    ground(scene)
    for side, x in (("left", -3.2), ("right", 3.2)):
        wall = Box(half_extents=(0.2, 2.0), friction=0.3)
        scene.add_body(f"wall_{side}", kind="static", shapes=[wall], position=(x, 2.0))
    columns, pitch = 5, 1.15  # far enough apart that no two boxes touch at any angle
    for k in range(count):
        half = 0.5 * rng.uniform(0.3, 0.8, 2)
        row, column = divmod(k, columns)
        x = pitch * (column - 0.5 * (columns - 1)) + 0.2 * (row % 2) - 0.1
        y = 1.2 + pitch * row
        box = Box(half_extents=half, friction=0.5)
        scene.add_body(f"box_{k}", shapes=[box], position=(x, y), angle=rng.uniform(-math.pi, math.pi))
    return scene


def dominoes(count: int = 16, height: float = 0.5, growth: float = 1.1, lean: float = 14.0) -> Scene:
    """Build a row of ``count`` dominoes; the first is ``height`` m high, and each next one is ``growth`` times larger.

    The first one leans by ``lean`` degrees on its lower right corner, so that it falls.
    """
    scene = Scene()
    ground(scene)
    edge = 0.0  # m, x of the next domino's lower right corner
    for k in range(count):
        size = height * growth**k
        half_width, half_height = 0.065 * size, 0.5 * size
        angle = -math.radians(lean) if k == 0 else 0.0
        c, s = math.cos(angle), math.sin(angle)
        corner = (c * half_width + s * half_height, s * half_width - c * half_height)
        domino = Box(half_extents=(half_width, half_height), friction=0.4)
        position = (edge - corner[0], -corner[1])
        scene.add_body(f"domino_{k}", shapes=[domino], position=position, angle=angle)
        edge += 0.5 * size * growth
    return scene
