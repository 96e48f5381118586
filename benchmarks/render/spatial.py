"""The 3D picture that is timed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.quaternions import multiply
from gsenv.render.spatial import Primitives, SpatialCamera, make_primitives
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, PLANE, SPHERE
from gsenv.render.spatial.style import GROUND_COLOR
from gsenv.render.theme import PALETTE

CAMERA = SpatialCamera(eye=(4.6, -4.4, 2.7), target=(-0.1, -0.2, 0.72))
VERMILION, AMBER, SAGE, SKY_BLUE, NAVY, PLUM, JADE, PEACH = PALETTE
TYRE = (48, 51, 60)

FloatArray = NDArray[np.float64]


def turn(axis: tuple[float, float, float], angle: float) -> FloatArray:
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * np.array(axis))])


def turn_z_to(direction: FloatArray) -> FloatArray:
    """Return the shortest rotation from z to a direction."""
    d = direction / np.linalg.norm(direction)
    q = np.array([1.0 + d[2], -d[1], d[0], 0.0])
    return q / np.linalg.norm(q) if d[2] > -0.9999 else np.array([0.0, 1.0, 0.0, 0.0])


class Builder:
    """Collects rows of primitives."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, FloatArray, FloatArray, tuple[float, ...], float, Any, int]] = []

    def add(
        self, kind: int, at: Any, rotation: FloatArray, size: tuple[float, ...], radius: float, color: Any, mark: int
    ) -> None:
        self.rows.append((kind, np.asarray(at, float), rotation, size, radius, color, mark))

    def add_capsule(self, a: Any, b: Any, radius: float, color: Any) -> None:
        p, q = np.asarray(a, float), np.asarray(b, float)
        half = 0.5 * float(np.linalg.norm(q - p))
        self.add(CAPSULE, 0.5 * (p + q), turn_z_to(q - p), (0.0, 0.0, half), radius, color, 0)

    def build(self) -> Primitives:
        kind, at, rotation, size, radius, color, mark = zip(*self.rows, strict=True)
        return make_primitives(kind, at, rotation, size, radius, color, mark=mark)


def make_scene() -> Primitives:
    """Return a pyramid of boxes, a car, a figure and a ball: 23 primitives and a plane."""
    still = turn((0, 0, 1), 0.0)
    scene = Builder()
    scene.add(PLANE, (0, 0, 0), still, (0, 0, 0), 0.0, GROUND_COLOR, 0)
    k = 0
    for level in range(3):
        for i in range(3 - level):
            at = (-1.9, (i - (2 - level) / 2) * 0.66, 0.3 + 0.6 * level)
            angle = 0.06 * ((i * 7 + level * 3) % 5 - 2)
            scene.add(BOX, at, turn((0, 0, 1), angle), (0.3, 0.3, 0.3), 0.0, (VERMILION, AMBER)[k % 2], 1)
            k += 1
    add_car(scene, np.array([0.2, -1.6, 0.0]), turn((0, 0, 1), -0.5))
    add_figure(scene, np.array([0.35, 0.75, 0.0]))
    scene.add(SPHERE, (1.7, 0.1, 0.32), turn((1, 0, 0), 0.6), (0, 0, 0), 0.32, JADE, 1)
    return scene.build()


def add_car(scene: Builder, at: FloatArray, rotation: FloatArray) -> None:
    c, s = 1.0 - 2.0 * rotation[3] ** 2, 2.0 * rotation[0] * rotation[3]
    frame = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    scene.add(BOX, at + frame @ [0, 0, 0.52], rotation, (0.85, 0.38, 0.16), 0.0, SKY_BLUE, 1)
    scene.add(BOX, at + frame @ [-0.1, 0, 0.82], rotation, (0.42, 0.33, 0.16), 0.0, (206, 228, 240), 1)
    for x in (-0.55, 0.55):
        for y in (-0.46, 0.46):
            wheel = multiply(rotation, multiply(turn((1, 0, 0), 0.5 * np.pi), turn((0, 0, 1), 0.4 + x)))
            scene.add(CYLINDER, at + frame @ [x, y, 0.29], wheel, (0, 0, 0.1), 0.29, TYRE, 1)


def add_figure(scene: Builder, at: FloatArray) -> None:
    limbs = (
        ((0, 0, 1.0), (0, 0, 1.38), 0.17, PLUM),
        ((0, -0.11, 0.93), (0.22, -0.16, 0.55), 0.10, NAVY),
        ((0.22, -0.16, 0.53), (0.1, -0.18, 0.1), 0.08, PEACH),
        ((0, 0.11, 0.93), (-0.12, 0.2, 0.53), 0.10, NAVY),
        ((-0.12, 0.2, 0.52), (-0.32, 0.22, 0.12), 0.08, PEACH),
        ((0, -0.25, 1.38), (0.18, -0.5, 1.2), 0.07, PLUM),
        ((0.18, -0.5, 1.2), (0.42, -0.45, 1.4), 0.06, PEACH),
        ((0, 0.25, 1.38), (-0.15, 0.5, 1.25), 0.07, PLUM),
        ((-0.15, 0.5, 1.25), (0.05, 0.68, 1.05), 0.06, PEACH),
    )
    for a, b, radius, color in limbs:
        scene.add_capsule(at + a, at + b, radius, color)
    scene.add(SPHERE, at + np.array([0.02, 0, 1.78]), turn((0, 0, 1), 0.0), (0, 0, 0), 0.17, PEACH, 0)
