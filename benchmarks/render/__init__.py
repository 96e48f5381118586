"""CPU time of a rendered frame on one core, and of the first frame of a process with an empty kernel cache.

In 2D beside pygame-ce with the dummy driver, which draws the same shapes without anti-aliasing; its times are
from an earlier run. --quick leaves out the first frame.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from benchmarks.common.files import packed, unpacked
from benchmarks.common.processes import run_python
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from benchmarks.common.timing import call_time

SIZES = ((84, 84), (480, 480), (1280, 720))
SECONDS, QUICK_SECONDS = 0.4, 0.1  # in each round
PYGAME_MS = {(84, 84): 0.42, (480, 480): 1.76, (1280, 720): 7.9}
PYGAME_RATIO = 2.5  # target: times faster than pygame
FRAME_RATES = {("high", 480): 50.0, ("fast", 84): 1500.0}  # targets in 3D, frames/s
QUALITIES = {2: ("2D",), 3: ("high", "fast")}

FIRST_FRAME = """
from time import process_time
from benchmarks.render import frame
draw = frame("{quality}", 84, 84)
start = process_time()
draw()
print(process_time() - start)
"""


@dataclass(frozen=True)
class Frame:
    """CPU time of a frame, ms."""

    quality: str
    width: int
    height: int
    ms: float


def frame(quality: str, width: int, height: int) -> Callable[[], object]:
    """Return a function that draws the frame, in "2D" or with a quality of the 3D renderer."""
    if quality == "2D":
        from .planar import make_renderer

        return make_renderer(width, height).render
    from gsenv.render.spatial import PrimitiveRenderer

    from .spatial import CAMERA, make_scene

    renderer = PrimitiveRenderer(width, height, "high" if quality == "high" else "fast")
    return partial(renderer.draw, CAMERA, make_scene())


def first_frame(quality: str) -> float:
    """Return the CPU time in s of the first frame in a process with an empty kernel cache."""
    with tempfile.TemporaryDirectory() as cache:
        return float(run_python(FIRST_FRAME.format(quality=quality), cache).output)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: this benchmark has no options of its own."""


def measure(run: Run) -> dict[str, Any]:
    qualities = QUALITIES[run.dim]
    with progress_bar("frames", len(SIZES) * len(qualities)) as bar:

        def frames() -> Iterator[Frame]:
            for quality in qualities:
                for width, height in SIZES:
                    draw = frame(quality, width, height)
                    seconds = call_time(draw, QUICK_SECONDS if run.quick else SECONDS)
                    yield Frame(quality, width, height, 1e3 * seconds)
                    bar.advance()

        measured = packed(frames())
        bar.describe("first frames")
        first = {} if run.quick else {quality: first_frame(quality) for quality in qualities}
    return {"dim": run.dim, "frames": measured, "first": first}


def report(results: Mapping[str, Any]) -> Report:
    frames = unpacked(Frame, results["frames"])
    parts: list[Part] = [planar_table(frames) if results["dim"] == 2 else spatial_table(frames)]
    parts += [
        f"First frame without a kernel cache, {quality}: {seconds:.1f} s of CPU time."
        for quality, seconds in results["first"].items()
    ]
    return Report(f"{results['dim']}D frames, CPU ms on one core", parts)


def planar_table(frames: list[Frame]) -> Table:
    rows = []
    for f in frames:
        pygame = PYGAME_MS[f.width, f.height]
        ratio = pygame / f.ms
        verdict = "met" if ratio >= PYGAME_RATIO else "missed"
        size = f"{f.width} x {f.height}"
        rows.append([size, f"{f.ms:.3f}", f"{1e3 / f.ms:.0f}", f"{pygame:g}", f"{ratio:.1f}", verdict])
    return Table(["size", "frame", "frames/s", "pygame", "ratio", f"target {PYGAME_RATIO:g}x"], rows)


def spatial_table(frames: list[Frame]) -> Table:
    rows = []
    for f in frames:
        target = FRAME_RATES.get((f.quality, f.width))
        verdict = "" if target is None else f"{target:g}: {'met' if 1e3 / f.ms >= target else 'missed'}"
        rows.append([f.quality, f"{f.width} x {f.height}", f"{f.ms:.3f}", f"{1e3 / f.ms:.0f}", verdict])
    return Table(["quality", "size", "frame", "frames/s", "target"], rows, words=2)
