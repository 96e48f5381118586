"""One point: the error of a setting on a case, and the CPU time of its step calls."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.common.files import packed, read_json, unpacked, write_json
from benchmarks.common.timing import cpu_time
from gsenv.solver import Model

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
        error: see the case; None: infinite (it fell, or what is measured never happened).
        lenient: for standing cases, the error without the limits on drift and final speed.
        us: CPU us of step calls per simulated second, median of the runs.
        fastest: us of the fastest run.
        runs: how many were timed.
        sources: versions and digests of all that the numbers depend on.
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
    sources: str

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


def finite_error(error: Callable[[Trajectory], float], trajectory: Trajectory) -> float | None:
    """The error, None where it is infinite or not a number."""
    value = error(trajectory) if np.isfinite(trajectory.states).all() else np.inf
    return value if np.isfinite(value) else None


def timed_run(build: Build, case: Case, model: Model, setting: Setting) -> float:
    """CPU s of all step calls of a run; building the simulation is not counted."""
    simulation = build(model, setting)
    steps = step_count(case.seconds, setting.timestep)
    return cpu_time(lambda: simulation.step(steps))


def measure_point(build: Build, case: Case, setting: Setting, sources: str, others: Sequence[Point]) -> Point:
    """Error and time of one setting.

    Args:
        others: points of the same case and engine; a setting that they beat by far is timed once only.
    """
    model = case.scene().compile()
    trajectory = record(build(model, setting), case, model, setting.timestep)
    error = finite_error(case.error, trajectory)
    lenient = finite_error(lenient_standing_error, trajectory) if case.kind == "standing" else error
    times: list[float] = []
    while True:
        times.append(timed_run(build, case, model, setting))
        us = 1e6 * statistics.median(times) / case.seconds
        hopeless = lenient is None or any(
            other.error is not None and other.error <= lenient and HOPELESS * other.us < us for other in others
        )
        fewest = 1 if hopeless else 2 if times[0] > LONG_SECONDS else FEWEST_RUNS
        most = fewest if hopeless or times[0] > LONG_SECONDS else MOST_RUNS
        if len(times) >= most or (len(times) >= fewest and sum(times) >= ENOUGH_SECONDS):
            break
    return Point(
        case.key, setting.engine, setting.label, setting.timestep, setting.mark, error,
        lenient, us, 1e6 * min(times) / case.seconds, len(times), sources,
    )  # fmt: skip


class Results:
    """Measured points. A file of them, if there is one, is written anew after each: what was measured is kept.

    Attributes:
        dim: 2 or 3.
        stamp: of the present run.
        sources: of each engine in the present run; a point with others is out of date and is measured again.
        versions: of the stored run, by name.
        points: by key.
    """

    def __init__(
        self, dim: int, stamp: Mapping[str, Any], sources: Mapping[str, str], path: Path | None, fresh: bool = False
    ) -> None:
        self.dim, self.stamp, self.path = dim, stamp, path
        self.sources = dict(sources)
        self.points: dict[str, Point] = {}
        self.versions: dict[str, str] = {}
        if path is not None and path.exists() and not fresh:
            stored = read_json(path)
            self.points = {point.key: point for point in points_in(stored)}
            self.sources = stored["sources"] | self.sources
            self.versions = stored["stamp"]["versions"]

    def known(self, case: Case, setting: Setting) -> bool:
        point = self.points.get(f"{case.key}|{setting.engine}|{setting.label}")
        return point is not None and point.sources == self.sources[setting.engine]

    def of(self, case: str, engine: str) -> list[Point]:
        return [point for point in self.points.values() if (point.case, point.engine) == (case, engine)]

    def add(self, point: Point) -> None:
        self.points[point.key] = point
        if self.path is not None:
            write_json(self.path, {"stamp": self.stamp, **self.data()})

    def data(self) -> dict[str, Any]:
        """As JSON data. Few points differ in their sources, so each has the index of its own in a list."""
        texts = sorted({point.sources for point in self.points.values()})
        rows = packed(replace(point, sources=str(texts.index(point.sources))) for point in self.points.values())
        return {"dim": self.dim, "sources": self.sources, "sources_of_points": texts, "points": rows}


def points_in(data: Mapping[str, Any]) -> list[Point]:
    """The reverse of ``Results.data``."""
    texts = data["sources_of_points"]
    return [replace(point, sources=texts[int(point.sources)]) for point in unpacked(Point, data["points"])]
