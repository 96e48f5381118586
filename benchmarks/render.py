"""CPU time of 2D frames on one core, and of the first frame of a process that has no cache.

python benchmarks/render.py
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from time import process_time

import numpy as np
from rich.console import Console
from rich.table import Table

from gsenv.render.camera import Camera
from gsenv.render.scene_renderer import SceneRenderer
from gsenv.solver.planar.shapes import Box, Capsule, Circle, HalfPlane, Polygon
from gsenv.solver.scene import Scene
from gsenv.solver.world import World

SIZES = ((84, 84), (480, 480), (1280, 720))
PYGAME_MS = (0.42, 1.76, 7.9)  # pygame-ce with the dummy driver, the same shapes, no anti-aliasing
TARGET_RATIO = 2.5
ROUNDS = 7  # the best of so many counts
SECONDS = 0.25  # in each round

FIRST_FRAME = """
from time import process_time
from benchmarks.render import SIZES, make_renderer
renderer = make_renderer(*SIZES[0])
start = process_time()
renderer.render()
print(process_time() - start)
"""


def make_world() -> World:
    """A pyramid of 28 boxes, a polygon, a circle and a capsule on a half-plane."""
    rng = np.random.default_rng(1)
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    for level in range(7):
        for k in range(7 - level):
            position = (-2.2 + (k - (6 - level) / 2) * 0.66, 0.3 + 0.605 * level)
            shapes = [Box(half_extents=(0.3, 0.3))]
            angle = 0.02 * rng.standard_normal()
            scene.add_body(f"box {level} {k}", shapes=shapes, position=position, angle=angle)
    corners = [(-0.55, -0.3), (0.5, -0.35), (0.7, 0.1), (0.1, 0.5), (-0.6, 0.3)]
    scene.add_body("polygon", shapes=[Polygon(vertices=corners)], position=(2.0, 0.42))
    scene.add_body("ball", shapes=[Circle(radius=0.45)], position=(3.6, 0.45))
    rod = Capsule(half_length=0.45, radius=0.18)
    scene.add_body("rod", shapes=[rod], position=(0.9, 0.9), angle=1.0)
    return World(scene)


def make_renderer(width: int, height: int) -> SceneRenderer:
    camera = Camera((0.0, 1.9), max(5.33, 9.6 * height / width))
    return SceneRenderer(make_world(), width, height, camera)


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


def measure_first_frame() -> float:
    """CPU s of the first frame in a process with an empty kernel cache."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-c", FIRST_FRAME]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    table = Table(title="2D frames, 31 shapes, CPU ms on one core")
    for column in ("size", "frame", "frames/s", "pygame", "ratio", f"target {TARGET_RATIO:g}x"):
        table.add_column(column, justify="right")
    for (width, height), pygame_ms in zip(SIZES, PYGAME_MS, strict=True):
        ms = measure(make_renderer(width, height).render)
        ratio = pygame_ms / ms
        verdict = "met" if ratio >= TARGET_RATIO else "missed"
        size = f"{width} x {height}"
        table.add_row(
            size, f"{ms:.3f}", f"{1e3 / ms:.0f}", f"{pygame_ms:g}", f"{ratio:.1f}", verdict
        )
    console = Console()
    console.print(table)
    console.print(f"First frame without a kernel cache: {measure_first_frame():.1f} s of CPU time")


if __name__ == "__main__":
    main()
