"""One point: the error of a setting on a case, and the CPU time of its step calls."""

from __future__ import annotations

import gc
import json
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsenv.solver.model import Model

from .cases import Case
from .engines import Setting, Simulation
from .errors import lenient_standing_error
from .trajectory import Trajectory

Build = Callable[[Model, Setting], Simulation]

ENOUGH_SECONDS = 0.1  # of timed runs
FEWEST_RUNS, MOST_RUNS = 3, 9
LONG_SECONDS = 0.7  # a run of this length is timed once more only
HOPELESS = 2.0  # times slower than a better setting: not timed again


@dataclass(frozen=True)
class Point:
    """A measured setting.

    Attributes:
        case, engine, label, timestep, mark: which; see Case and Setting.
        error: see the case; None is infinite (fell, or never happened).
        lenient: of standing cases, the error without the demand on drift and final speed.
        us: CPU us of step calls per simulated second, median of the runs.
        fastest: us of the fastest run.
        runs: how many were timed.
        stamp: versions of all that the figure depends on.
    """

    case: str
    engine: str
    label: str
    timestep: float
    mark: str
    error: float | None
    lenient: float | None
    us: float
    fastest: float
    runs: int
    stamp: str

    @property
    def key(self) -> str:
        return f"{self.case}|{self.engine}|{self.label}"


def step_count(seconds: float, timestep: float) -> int:
    return round(seconds / timestep)


def record(simulation: Simulation, case: Case, model: Model, timestep: float) -> Trajectory:
    """The trajectory, sampled at the case's rate, or at each step where steps are longer."""
    total = step_count(case.seconds, timestep)
    stride = max(1, round(1.0 / (case.rate * timestep)))
    states, steps = [simulation.read()], [0]
    while steps[-1] < total:
        count = min(stride, total - steps[-1])
        simulation.step(count)
        states.append(simulation.read())
        steps.append(steps[-1] + count)
    return Trajectory(np.array(steps) * timestep, np.array(states), model)


def judged(error: Callable[[Trajectory], float], trajectory: Trajectory) -> float | None:
    """The error, None where it is infinite or not a number."""
    value = error(trajectory) if np.isfinite(trajectory.states).all() else np.inf
    return value if np.isfinite(value) else None


def timed_run(build: Build, case: Case, model: Model, setting: Setting) -> float:
    """CPU s of all step calls of a run, building and garbage collection kept out."""
    simulation = build(model, setting)
    steps = step_count(case.seconds, setting.timestep)
    gc.collect(1)  # the rest is older than the benchmark
    gc.disable()
    try:
        began = time.thread_time()
        simulation.step(steps)
        return time.thread_time() - began
    finally:
        gc.enable()


def measure(build: Build, case: Case, setting: Setting, stamp: str, rivals: list[Point]) -> Point:
    """Error and time of one setting.

    Args:
        rivals: points of the same case and engine; what they beat by far is timed once only.
    """
    model = case.scene().compile()
    trajectory = record(build(model, setting), case, model, setting.timestep)
    error = judged(case.error, trajectory)
    lenient = judged(lenient_standing_error, trajectory) if case.kind == "standing" else error
    times: list[float] = []
    while True:
        times.append(timed_run(build, case, model, setting))
        us = 1e6 * statistics.median(times) / case.seconds
        hopeless = lenient is None or any(
            r.error is not None and r.error <= lenient and HOPELESS * r.us < us for r in rivals
        )
        fewest = 1 if hopeless else 2 if times[0] > LONG_SECONDS else FEWEST_RUNS
        most = fewest if hopeless or times[0] > LONG_SECONDS else MOST_RUNS
        if len(times) >= most or (len(times) >= fewest and sum(times) >= ENOUGH_SECONDS):
            break
    return Point(
        case.key, setting.engine, setting.label, setting.timestep, setting.mark, error,
        lenient, us, 1e6 * min(times) / case.seconds, len(times), stamp,
    )  # fmt: skip


class Results:
    """Measured points in a JSON file, written anew after each: what was measured stays measured.

    A point whose stamp differs from the present one is measured again.
    """

    def __init__(self, path: Path, about: dict[str, Any], fresh: bool = False) -> None:
        self.path = path
        self.about = about
        self.points: dict[str, Point] = {}
        if path.exists() and not fresh:
            for entry in json.loads(path.read_text())["points"]:
                point = Point(**entry)
                self.points[point.key] = point

    def known(self, case: Case, setting: Setting, stamp: str) -> bool:
        point = self.points.get(f"{case.key}|{setting.engine}|{setting.label}")
        return point is not None and point.stamp == stamp

    def of(self, case: str, engine: str | None = None) -> list[Point]:
        return [p for p in self.points.values() if p.case == case and engine in (p.engine, None)]

    def add(self, point: Point) -> None:
        self.points[point.key] = point
        self.write()

    def write(self) -> None:
        """Atomically: a reader sees the old file or the new one. One line a point."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        part = self.path.with_suffix(".part")
        lines = ",\n".join(json.dumps(vars(point)) for point in self.points.values())
        part.write_text(f'{{"about": {json.dumps(self.about)},\n"points": [\n{lines}\n]}}\n')
        os.replace(part, self.path)
