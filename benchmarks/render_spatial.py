"""CPU time of 3D frames on one core, and of the first frame of a process that has no cache.

python benchmarks/render_spatial.py
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from gsenv.render.spatial import PrimitiveRenderer, Primitives, SpatialCamera, make_primitives
from gsenv.render.spatial.primitives import BOX, CAPSULE, CYLINDER, PLANE, SPHERE
from gsenv.render.spatial.renderer import Quality
from gsenv.render.spatial.style import GROUND_COLOR
from gsenv.render.theme import PALETTE

SIZES = ((84, 84), (480, 480), (1280, 720))
# frames/s
TARGETS: dict[Quality, tuple[float | None, ...]] = {"high": (None, 50.0, None), "fast": (1500.0, None, None)}
ROUNDS = 5  # the best of so many counts
SECONDS = 0.4  # in each round

FIRST_FRAME = """
from time import process_time
from benchmarks.render_spatial import CAMERA, make_scene
from gsenv.render.spatial import PrimitiveRenderer
renderer, scene = PrimitiveRenderer(84, 84, "{quality}"), make_scene()
start = process_time()
renderer.draw(CAMERA, scene)
print(process_time() - start)
"""

CAMERA = SpatialCamera(eye=(4.6, -4.4, 2.7), target=(-0.1, -0.2, 0.72))
VERMILION, AMBER, SAGE, SKY_BLUE, NAVY, PLUM, JADE, PEACH = PALETTE
TYRE = (48, 51, 60)

FloatArray = NDArray[np.float64]


def multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """Quaternion of first q, then p."""
    w = p[0] * q[0] - p[1:] @ q[1:]
    return np.array([w, *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def turn(axis: tuple[float, float, float], angle: float) -> FloatArray:
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * np.array(axis))])


def turn_z_to(direction: FloatArray) -> FloatArray:
    """Shortest rotation from z to a direction."""
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
    """A pyramid of boxes, a car, a figure and a ball: 23 primitives and a plane."""
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


def measure(function: Callable[[], object]) -> float:
    """Best mean CPU time of a call in ms."""
    function()
    best = np.inf
    for _ in range(ROUNDS):
        count, start = 0, process_time()
        while process_time() - start < SECONDS:
            function()
            count += 1
        best = min(best, (process_time() - start) / count)
    return 1e3 * float(best)


def measure_first_frame(quality: Quality) -> float:
    """CPU s of the first frame in a process with an empty kernel cache."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-c", FIRST_FRAME.format(quality=quality)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    scene = make_scene()
    table = Table(title=f"3D frames, {len(scene.kind) - 1} primitives on a plane, one core")
    for column in ("quality", "size", "CPU ms", "frames/s", "target"):
        table.add_column(column, justify="right")
    for quality in TARGETS:
        for (width, height), target in zip(SIZES, TARGETS[quality], strict=True):
            renderer = PrimitiveRenderer(width, height, quality)
            ms = measure(lambda renderer=renderer: renderer.draw(CAMERA, scene))
            verdict = "" if target is None else f"{target:g}: {'met' if 1e3 / ms >= target else 'missed'}"
            table.add_row(quality, f"{width} x {height}", f"{ms:.3f}", f"{1e3 / ms:.0f}", verdict)
    console = Console()
    console.print(table)
    for quality in TARGETS:
        seconds = measure_first_frame(quality)
        console.print(f"First {quality} frame without a kernel cache: {seconds:.1f} s of CPU time")


if __name__ == "__main__":
    main()
