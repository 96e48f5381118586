"""Times of scenes of growing size."""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.files import packed
from benchmarks.common.progress import Bar, progress_bar
from benchmarks.common.run import Run
from benchmarks.common.timing import ROUNDS, cpu_time, step_time
from gsenv.solver import Options, Scene, World
from gsenv.solver.records.model import BodyKind

from .scenes import FAMILIES, Families, with_awake_tower

SIZES = (10, 30, 100, 300, 1000, 3000, 5000)
QUICK_SIZES = (10, 100, 300)
BASE = 100  # boxes: what ratios refer to
SWEEPS = 10  # of each of the two substeps
FIXED = Options(sweeps=SWEEPS, tolerance=0.0, sleep=False)
SETTLING = Options(sleep=False)
SOLVERS = ("pgs", "nncg", "subspace")
DISTURBANCE = 1e-3  # m/s: without it a tower reaches the exact answer, where sweeps end early
STEPS = 10  # of a timed call
BUDGET = 0.02  # CPU s of a round: small scenes are timed more than once in it
SLEEPING_SIZES = (100, 1000, 5000)
RESTING = ("towers", "wall", "pile")  # families that are put to sleep


@dataclass(frozen=True)
class Timing:
    """A scene at a fixed number of sweeps."""

    family: str
    solver: str
    bodies: int
    rows: int
    islands: int
    sweeps: float  # per island and substep
    microseconds: float  # per step

    @property
    def per_body(self) -> float:
        return self.microseconds / self.bodies

    @property
    def per_row(self) -> float:
        return self.microseconds / self.rows


@dataclass(frozen=True)
class Rest:
    """A settled scene at default options, us per step."""

    family: str
    bodies: int
    awake: float
    asleep: float
    tower: float  # the tower on the moving plate alone
    beside: float  # the same with the sleeping scene beside it

    @property
    def asleep_share(self) -> float:
        return self.asleep / self.awake

    @property
    def beside_share(self) -> float:
        """Cost of the sleeping boxes beside an awake island, over their cost awake."""
        return (self.beside - self.tower) / self.awake


def microseconds(world: World, steps: int) -> float:
    """Return the median CPU time of a step in us."""
    return 1e6 * step_time(world, steps)


def boxes_of(world: World) -> NDArray[np.intp]:
    """Return the indices of the dynamic bodies."""
    return np.flatnonzero(world.model.bodies["kind"] == BodyKind.DYNAMIC)


class Settled:
    """A scene of a family, and the state that each timing starts from."""

    def __init__(self, families: Families, family: str, count: int) -> None:
        build, settle = families[family]
        self.world = World(build(count), options=SETTLING)
        self.world.step(settle)
        self.count = count
        self.snapshot = self.world.save()
        self.boxes = boxes_of(self.world)
        ndof = self.world.state.bodies["velocity"].shape[-1]
        self.disturbance = DISTURBANCE * np.random.default_rng(0).uniform(-1.0, 1.0, (count, ndof))

    def time(self, solver: str) -> float:
        """Return the CPU time in s of a step, for small scenes the median of several calls."""
        self.world.options = replace(FIXED, solver=solver)
        times: list[float] = []
        while not times or (sum(times) < BUDGET and len(times) < 20):
            self.world.restore(self.snapshot)
            self.world.state.bodies["velocity"][0, self.boxes] += self.disturbance
            self.world.step(1)  # buffers grow here
            times.append(cpu_time(lambda: self.world.step(STEPS)) / STEPS)
        return statistics.median(times)


def time_awake(
    families: Families, family: str, sizes: Sequence[int], advance: Callable[[int], object]
) -> Iterator[Timing]:
    """Time all sizes by turns, so that a machine that is slow for a while is slow for all of them."""
    scenes = [Settled(families, family, n) for n in sizes]
    for solver in SOLVERS:
        times: dict[int, list[float]] = {n: [] for n in sizes}
        for _ in range(ROUNDS):
            for scene in scenes:
                times[scene.count].append(scene.time(solver))
                advance(scene.count)
        for scene in scenes:
            scene.time(solver)
            n, d = scene.count, scene.world.diagnostics()
            assert d.awake[0] == n, f"{family} of {n}: {d.awake[0]} are awake"
            sweeps = float(d.sweeps[0] / (d.islands[0] * FIXED.substeps))
            spent = 1e6 * statistics.median(times[n])
            yield Timing(family, solver, n, int(d.rows[0]), int(d.islands[0]), sweeps, spent)


def put_to_sleep(world: World) -> None:
    """Put all boxes to sleep except ten on the plate, if there is one; waiting until thousands rest would be slow."""
    boxes = boxes_of(world)
    if "plate" in world.model.body_names:
        boxes = boxes[:-10]
    world.state.bodies["asleep"][0, boxes] = 1
    world.state.bodies["velocity"][0, boxes] = 0.0


def time_asleep(families: Families, family: str, count: int, alone: float) -> Rest:
    """Time the scene awake, asleep, and asleep beside a tower that is awake."""
    build, settle = families[family]
    world = World(build(count), options=SETTLING)
    world.step(settle)
    awake = microseconds(world, STEPS)
    world.options = Options()
    put_to_sleep(world)
    asleep = microseconds(world, 100 * STEPS)
    assert world.diagnostics().awake[0] == 0, family
    beside = World(with_awake_tower(build(count)), options=SETTLING)
    beside.step(settle)
    beside.options = Options()
    put_to_sleep(beside)
    both = microseconds(beside, 10 * STEPS)
    assert beside.diagnostics().awake[0] == 10, family
    return Rest(family, count, awake, asleep, alone, both)


def awake_tower_alone(dim: int) -> float:
    world = World(with_awake_tower(Scene(dim)))
    world.step(20)
    return microseconds(world, 10 * STEPS)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: this benchmark has no options of its own."""


def measure(run: Run) -> dict[str, Any]:
    sizes = QUICK_SIZES if run.quick else SIZES
    sleeping = [n for n in SLEEPING_SIZES if n <= max(sizes)]
    families = FAMILIES[run.dim]
    total = sum(sizes) * len(families) * len(SOLVERS) * ROUNDS + sum(sleeping) * len(RESTING) * 10
    with progress_bar("compiling", total) as bar:
        World(families["tower"][0](2), options=FIXED).step()
        World(families["towers"][0](200), options=FIXED).step()
        timings = list(all_awake(families, sizes, bar))
        rests = list(all_asleep(families, sleeping, awake_tower_alone(run.dim), bar))
    return {"dim": run.dim, "awake": packed(timings), "asleep": packed(rests)}


def all_awake(families: Families, sizes: Sequence[int], bar: Bar) -> Iterator[Timing]:
    for family in families:
        bar.describe(family)
        yield from time_awake(families, family, sizes, bar.advance)


def all_asleep(families: Families, sizes: Sequence[int], alone: float, bar: Bar) -> Iterator[Rest]:
    for family in RESTING:
        for n in sizes:
            bar.describe(f"{family} of {n}, sleeping")
            yield time_asleep(families, family, n, alone)
            bar.advance(10 * n)
