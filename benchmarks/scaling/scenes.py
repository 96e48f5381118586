"""Scenes of any number of boxes, planar and spatial."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Box, HalfPlane
from gsenv.solver.spatial import Box as Block
from gsenv.solver.spatial import Plane

Families = dict[str, tuple[Callable[[int], Scene], int]]  # scene of so many boxes, steps to settle


# ------------------------------------------------------------------ plane


def grounded() -> Scene:
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane(normal=(0, 1), friction=0.5)])
    return scene


def add_box(scene: Scene, x: float, y: float, half: tuple[float, float] = (0.5, 0.5), angle: float = 0.0) -> None:
    name = f"box_{len(scene.bodies)}"
    scene.add_body(name, shapes=[Box(half_extents=half, friction=0.5)], position=(x, y), angle=angle)


def towers(count: int, pitch: float = 2.0) -> Scene:
    """Return towers of ten that do not touch: one island each."""
    scene = grounded()
    for k in range(count):
        add_box(scene, pitch * (k // 10), 0.5 + k % 10)
    return scene


def row(count: int) -> Scene:
    """Return the same towers side by side and touching: one island, ten boxes high."""
    return towers(count, 1.0)


def tower(count: int) -> Scene:
    """Return one tower."""
    scene = grounded()
    for k in range(count):
        add_box(scene, 0.0, 0.5 + k)
    return scene


def course_of_bricks(course: int, width: int, gap: float = 0.0) -> list[tuple[float, float]]:
    """Return place and half length in m of the bricks of a course in running bond, `gap` in m apart.

    There are half bricks at the ends of every second course: a whole one would be about to tilt over the edge below.
    """
    pitch = 1.0 + gap
    if course % 2 == 0:
        return [(pitch * k, 0.5) for k in range(width)]
    ends = [(-0.25, 0.25), (pitch * (width - 1) + 0.25, 0.25)]
    return [*((pitch * k + 0.5, 0.5) for k in range(width - 1)), *ends]


def bricks(count: int) -> Iterator[tuple[float, float, float]]:
    """Yield place, height and half length in m of bricks in running bond, at most 50 side by side."""
    width = min(50, round(math.sqrt(count)))
    for course in range(count):
        for x, half in sorted(course_of_bricks(course, width))[:count]:
            yield x, 0.25 + 0.5 * course, half
            count -= 1


def wall(count: int) -> Scene:
    """Return a wall about as many bricks wide as high."""
    scene = grounded()
    for x, y, half in bricks(count):
        add_box(scene, x, y, (half, 0.25))
    return scene


def pile(count: int) -> Scene:
    """Return boxes of all sizes and angles, dropped between two walls."""
    random = np.random.default_rng(count)
    scene = grounded()
    width = max(4, round(math.sqrt(2 * count)))
    for x in (-1.0, width + 0.0):
        wall_box = Box(half_extents=(0.5, 2.0 * width), friction=0.5)
        scene.add_body(f"side_{x:g}", kind="static", shapes=[wall_box], position=(x, 2.0 * width))
    for k in range(count):
        x, y = k % width + random.uniform(-0.05, 0.05), k // width + 0.7
        half_x, half_y = random.uniform(0.15, 0.45, 2)
        add_box(scene, x, y, (half_x, half_y), random.uniform(0.0, math.pi) if half_x + half_y < 0.6 else 0.0)
    return scene


# ------------------------------------------------------------------ space


def floored() -> Scene:
    scene = Scene(dim=3)
    scene.add_body("ground", kind="static", shapes=[Plane(friction=0.5)])
    return scene


def add_block(
    scene: Scene, at: tuple[float, float, float], half: tuple[float, float, float] = (0.5, 0.5, 0.5), turn: float = 0.0
) -> None:
    rotation = (math.cos(0.5 * turn), 0.6 * math.sin(0.5 * turn), 0.0, 0.8 * math.sin(0.5 * turn))
    shapes = [Block(half_extents=half, friction=0.5)]
    scene.add_body(f"box_{len(scene.bodies)}", shapes=shapes, position=at, orientation=rotation)


def cube_towers(count: int, pitch: float = 2.0) -> Scene:
    """Return towers of ten on a square grid; with a pitch of 1 they touch."""
    scene = floored()
    side = max(1, math.ceil(math.sqrt(count / 10)))
    for k in range(count):
        place = k // 10
        add_block(scene, (pitch * (place % side), pitch * (place // side), 0.5 + k % 10))
    return scene


def cube_tower(count: int) -> Scene:
    scene = floored()
    for k in range(count):
        add_block(scene, (0.0, 0.0, 0.5 + k))
    return scene


def brick_wall(count: int) -> Scene:
    scene = floored()
    for x, z, half in bricks(count):
        add_block(scene, (x, 0.0, z), (half, 0.25, 0.25))
    return scene


def cube_pile(count: int) -> Scene:
    """Return boxes of all sizes and orientations, dropped into a bin."""
    random = np.random.default_rng(count)
    scene = floored()
    side = max(2, round((count / 2) ** (1 / 3)))
    half = 0.5 * side + 0.5
    for x, y in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        box = Block(half_extents=(0.5 + half * (x == 0), 0.5 + half * (y == 0), 2.0 * side), friction=0.5)
        place = (x * (half + 0.5), y * (half + 0.5), side)
        scene.add_body(f"side_{x}_{y}", kind="static", shapes=[box], position=place)
    for k in range(count):
        cell = np.array([k % side, k // side % side, k // side**2], float)
        at = cell - [0.5 * (side - 1), 0.5 * (side - 1), -0.7] + random.uniform(-0.05, 0.05, 3)
        sizes = random.uniform(0.15, 0.42, 3)
        turn = random.uniform(0.0, math.pi) if sizes.sum() < 0.8 else 0.0
        add_block(scene, (at[0], at[1], at[2]), (sizes[0], sizes[1], sizes[2]), turn)
    return scene


# ------------------------------------------------------------------ both

FAMILIES: dict[int, Families] = {
    2: {
        "towers": (towers, 10),
        "row": (row, 10),
        "tower": (tower, 10),
        "wall": (wall, 10),
        "pile": (pile, 200),
    },
    3: {
        "towers": (cube_towers, 10),
        "row": (partial(cube_towers, pitch=1.0), 10),
        "tower": (cube_tower, 10),
        "wall": (brick_wall, 10),
        "pile": (cube_pile, 200),
    },
}


def with_awake_tower(scene: Scene) -> Scene:
    """Add a tower of ten, far away, on a plate that creeps along: it can't fall asleep."""
    if scene.dim == 3:
        block = Block(half_extents=(2.0, 2.0, 0.25), friction=0.5)
        place, way = (-30.0, 0.0, 2.0), (1e-3, 0.0, 0.0)
        scene.add_body("plate", kind="kinematic", shapes=[block], position=place, linear_velocity=way)
        for k in range(10):
            add_block(scene, (-30.0, 0.0, 2.75 + k))
        return scene
    plate = Box(half_extents=(2.0, 0.25), friction=0.5)
    scene.add_body("plate", kind="kinematic", shapes=[plate], position=(-30.0, 2.0), linear_velocity=(1e-3, 0.0))
    for k in range(10):
        add_box(scene, -30.0, 2.75 + k)
    return scene
