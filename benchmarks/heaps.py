"""CPU time per box and step of heaps that settle and rest, and their largest overlaps; nothing sleeps.

    python -m benchmarks heaps --box2d-source FOLDER
    python -m benchmarks heaps --dim 3 --box3d-source FOLDER

A stack of 50 boxes, a pyramid with a base of 20 and a wall of 16 courses of bricks that touch sideways, too, at 60
steps per second, and a pile of 200 boxes of all sizes that fall between walls: gsenv's fidelities balanced and fast,
the latter also with undivided steps, its method of soft substeps in the usual setting of Box2D v3 and Box3D, and,
built from the folders of their sources, these two. Boxes start exactly touching, those of the pile apart.
"Settling" are the first 60 steps, 150 of the pile, "resting" the 60 steps after 5 s. All settings take turns on one
core, each run in a new world; times are medians. Overlaps are exact, from the poses of one more run.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.built import add_source_options, given_sources
from benchmarks.accuracy.engines import Setting, Simulation
from benchmarks.accuracy.geometry import deepest_overlap
from benchmarks.accuracy.geometry3d import deepest_box_overlap
from benchmarks.accuracy.settings_built import STIFF
from benchmarks.accuracy.suites import Suite, suite_of
from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time, median_ratio
from benchmarks.scaling.scenes import course_of_bricks, cube_pile, pile
from gsenv.scenes import pyramid, stack
from gsenv.scenes.spatial import cube_pyramid, cube_stack
from gsenv.solver import Model, Scene, planar, spatial
from gsenv.solver.api.options import FIDELITIES
from gsenv.solver.records.model import BodyKind
from gsenv.train.arguments import positive

Array = NDArray[np.float64]

FRICTION = 0.5


def wall(dim: int, width: int, courses: int, gap: float) -> Scene:
    """Return bricks of 1 m by 0.5 m in running bond, with half bricks at the ends of every second course.

    Args:
        dim: 2 or 3.
        width: bricks in the first course.
        courses: how many.
        gap: m, between bricks side by side.
    """
    scene = Scene(dim)
    ground = planar.HalfPlane(friction=FRICTION) if dim == 2 else spatial.Plane(friction=FRICTION)
    scene.add_body("ground", kind="static", shapes=[ground])
    for course in range(courses):
        for x, half in course_of_bricks(course, width, gap):
            height, name = 0.25 + 0.5 * course, f"brick_{len(scene.bodies)}"
            if dim == 2:
                scene.add_body(name, shapes=[planar.Box((half, 0.25), friction=FRICTION)], position=(x, height))
            else:
                brick = spatial.Box((half, 0.25, 0.25), friction=FRICTION)
                scene.add_body(name, shapes=[brick], position=(x, 0.0, height))
    return scene


STEPS, REST = 60, 300  # steps that are timed, and those before the resting ones


@dataclass(frozen=True)
class Heap:
    """A scene of boxes: the steps that it takes to settle, and whether they should stay where they begin."""

    build: Callable[[], Scene]
    settling: int = STEPS
    stays: bool = True


@dataclass(frozen=True)
class Phase:
    """A part of a heap's time: its name, and its steps after those ``before`` it."""

    name: str
    before: int
    steps: int


def phases_of(heap: Heap) -> tuple[Phase, Phase]:
    """Return the phases in which the stages of steps are timed."""
    return Phase("settling", 0, heap.settling), Phase("at rest", REST - STEPS, STEPS)


WALL = (16, 16, 0.0)
HEAPS: dict[int, dict[str, Heap]] = {
    2: {
        "stack of 50": Heap(partial(stack, 50)),
        "pyramid, base 20": Heap(partial(pyramid, 20)),
        "wall of 16 courses": Heap(partial(wall, 2, *WALL)),
        "pile of 200": Heap(partial(pile, 200), 150, stays=False),
    },
    3: {
        "stack of 50": Heap(partial(cube_stack, 50)),
        "pyramid, base 20": Heap(partial(cube_pyramid, 20)),
        "wall of 16 courses": Heap(partial(wall, 3, *WALL)),
        "pile of 200": Heap(partial(cube_pile, 200), 150, stays=False),
    },
}
TIMESTEP = 1.0 / 60.0
RUNS, QUICK_RUNS = 15, 3
UNDIVIDED: dict[str, Any] = {"halvings": 0}  # steps in which overlaps grow are not taken again in parts
OURS: dict[str, dict[str, Any]] = {
    "balanced": FIDELITIES["balanced"],
    "fast": FIDELITIES["fast"],
    "fast, undivided": FIDELITIES["fast"] | UNDIVIDED,
    "soft, 4 substeps": {"solver": "soft", "substeps": 4, "sweeps": 1} | UNDIVIDED,
}
PLAIN, SCALAR = "4 substeps", "4 substeps, scalar"  # the usual setting of Box2D v3 and Box3D, of each build


@dataclass(frozen=True)
class Timing:
    """A setting on a heap, settling and resting.

    Attributes:
        heap, engine, setting: which.
        settling, resting: us per box and step.
        settling_ratio, resting_ratio: over the time of gsenv's balanced fidelity, median of the runs' ratios.
        settling_overlap, resting_overlap: m, the largest of all steps.
        sunk: m, how far the highest box is below its place at the end; None where boxes fall.
        drift: m, the farthest that a box is sideways from its place at the end; None where boxes fall.
    """

    heap: str
    engine: str
    setting: str
    settling: float
    resting: float
    settling_ratio: float
    resting_ratio: float
    settling_overlap: float
    resting_overlap: float
    sunk: float | None
    drift: float | None


def add_options(parser: argparse.ArgumentParser) -> None:
    add_source_options(parser)
    parser.add_argument("--runs", type=positive, help=f"timed runs of each setting; default: {RUNS}")


def settings_of(suite: Suite) -> list[Setting]:
    """Return gsenv's settings and, of engines that are built from sources, the default and stiff ones."""
    out = [Setting("gsenv", label, TIMESTEP, values | {"sleep": False}) for label, values in OURS.items()]
    ways: dict[str, dict[str, Any]] = {
        PLAIN: {"substeps": 4},
        "4 substeps, not recycled": {"substeps": 4, "recycle": False},
        "16 substeps, stiff": {"substeps": 16, **STIFF},
        "64 substeps, stiff": {"substeps": 64, **STIFF},
    }
    for engine in suite.sources:
        out += [Setting(engine, label, TIMESTEP, values) for label, values in ways.items()]
        if "scalar" in suite.module(engine).PEER.variants:
            out.append(Setting(engine, SCALAR, TIMESTEP, {"substeps": 4, "build": "scalar"}))
    return out


def times_of(simulation: Simulation, settling: int) -> tuple[float, float]:
    """Return the CPU time in s of a settling and of a resting step."""
    first = cpu_time(lambda: simulation.step(settling)) / settling
    simulation.step(REST - settling)
    return first, cpu_time(lambda: simulation.step(STEPS)) / STEPS


def overlap_of(model: Model, states: Array) -> float:
    """Return the deepest overlap in m of boxes and into the ground."""
    boxes = np.flatnonzero(model.bodies["kind"] == BodyKind.DYNAMIC)
    half = model.nominal_shapes["size"][model.bodies["shape_first"][boxes]]
    if model.dim == 2:
        return deepest_overlap(states[boxes, 0:2], states[boxes, 2], half)
    return deepest_box_overlap(states[boxes, 0:3], states[boxes, 3:7], half)


def worst_overlap(simulation: Simulation, model: Model, steps: int) -> float:
    """Take the steps one by one; return the largest overlap in m."""
    worst = 0.0
    for _ in range(steps):
        simulation.step(1)
        worst = max(worst, overlap_of(model, simulation.read()))
    return worst


def places_of(simulation: Simulation, model: Model, heap: Heap) -> tuple[float, float, float | None, float | None]:
    """Return in m the largest overlaps, settling and resting, how far the top has sunk, and the largest drift."""
    up = model.dim - 1
    start = simulation.read()
    settling = worst_overlap(simulation, model, heap.settling)
    simulation.step(REST - heap.settling)
    resting = worst_overlap(simulation, model, STEPS)
    if not heap.stays:
        return settling, resting, None, None
    end = simulation.read()
    top = int(start[:, up].argmax())
    drift = np.linalg.norm((end - start)[:, :up], axis=1).max()
    return settling, resting, float(start[top, up] - end[top, up]), float(drift)


def time_heap(suite: Suite, name: str, runs: int, advance: Callable[[], None]) -> list[Timing]:
    """Return the timings of all settings on one heap, measured by turns."""
    heap = HEAPS[suite.dim][name]
    model = heap.build().compile()
    count = int((model.bodies["kind"] == BodyKind.DYNAMIC).sum())
    settings = settings_of(suite)
    times: list[list[tuple[float, float]]] = [[] for _ in settings]
    for _ in range(runs):
        for setting, found in zip(settings, times, strict=True):
            found.append(times_of(suite.build(setting.engine)(model, setting), heap.settling))
        advance()
    out = []
    base = [list(column) for column in zip(*times[0], strict=True)]
    for setting, found in zip(settings, times, strict=True):
        phases = [list(column) for column in zip(*found, strict=True)]
        us = [1e6 * statistics.median(phase) / count for phase in phases]
        ratios = [median_ratio(phase, other) for phase, other in zip(phases, base, strict=True)]
        places = places_of(suite.build(setting.engine)(model, setting), model, heap)
        out.append(Timing(name, setting.engine, setting.label, us[0], us[1], ratios[0], ratios[1], *places))
    return out


def measure(run: Run) -> dict[str, Any]:
    sources: dict[str, Path] = given_sources(run.options, run.dim)
    suite = suite_of(run.dim, sources)
    versions = {engine: suite.version(engine) for engine in sources}
    run.stamp["versions"] = run.stamp["versions"] | versions
    runs = run.options.runs or (QUICK_RUNS if run.quick else RUNS)
    timings: list[Timing] = []
    with progress_bar("", runs * len(HEAPS[run.dim])) as bar:
        for name in HEAPS[run.dim]:
            bar.describe(name)
            timings += time_heap(suite, name, runs, bar.advance)
    return {"dim": run.dim, "runs": runs, "timings": packed(timings)}


def report(results: Mapping[str, Any]) -> Report:
    timings = unpacked(Timing, results["timings"])
    text = (
        f"CPU us per box and step, median of {results['runs']} runs; ratios are over gsenv's balanced. Settling: the"
        " first 60 steps from boxes that just touch, or the first 150 of a pile, whose boxes fall between walls;"
        f" resting: {STEPS} steps after {REST * TIMESTEP:g} s. Overlaps are the largest of two boxes, or of a box and"
        " the ground, at any of these steps, in mm; sunk: how far the highest box is below its place at the end; drift:"
        " the farthest that a box is sideways from its place."
        ' Undivided: steps in which overlaps grow are not taken again in parts (`halvings=0`); so are those of "soft",'
        " which sweeps once over soft and once over rigid rows in each substep, as the other engine does."
    )
    return Report(f"Heaps in {results['dim']}D", [text, *(table(timings, heap) for heap in HEAPS[results["dim"]])])


def table(timings: Sequence[Timing], heap: str) -> Table:
    rows = [
        [
            f"{t.engine}, {t.setting}", f"{t.settling:.3f}", f"{t.resting:.3f}",
            f"{t.settling_ratio:.2f}", f"{t.resting_ratio:.2f}",
            *(f"{1e3 * value:.3f}" for value in (t.settling_overlap, t.resting_overlap)),
            *("-" if value is None else f"{1e3 * value:.2f}" for value in (t.sunk, t.drift)),
        ]
        for t in timings
        if t.heap == heap
    ]  # fmt: skip
    header = ["us", "us at rest", "ratio", "at rest", "overlap", "at rest", "sunk", "drift"]
    return Table([heap, *header], rows)
