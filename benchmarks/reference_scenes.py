"""Error, CPU time and sweeps of the scenes with known answers, at default options.

Scenes and errors are those of the benchmark accuracy, which measures more settings, and other engines.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from benchmarks.accuracy.cases import Case
from benchmarks.accuracy.engines import Setting
from benchmarks.accuracy.points import finite_error, record, timed_run
from benchmarks.accuracy.run import chosen_cases
from benchmarks.accuracy.suites import Suite, suite_of
from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.solver import Options, World

ROUNDS, QUICK_ROUNDS = 5, 1
WORDS = 2  # columns of a case's key and title


@dataclass(frozen=True)
class Result:
    """One scene; ``error`` is None where it is infinite or not a number."""

    case: str
    title: str
    error: float | None
    us: float  # per simulated s
    sweeps: float  # per step


class Counted:
    """A simulation that counts the sweeps of its steps."""

    def __init__(self, simulation: Any) -> None:
        self.world: World = simulation.world
        self.read_states = simulation.read
        self.steps = self.sweeps = 0

    def step(self, count: int) -> None:
        for _ in range(count):
            self.world.step()
            self.steps += 1
            self.sweeps += int(self.world.diagnostics().sweeps[0])

    def read(self) -> NDArray[Any]:
        states: NDArray[Any] = self.read_states()
        return states


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--only", nargs="+", metavar="CASE", help="cases (tower:10) or families of cases (tower)")


def measure(run: Run) -> dict[str, Any]:
    suite = suite_of(run.dim)
    cases = chosen_cases(suite.cases, run.options.only, run.quick)
    rounds = QUICK_ROUNDS if run.quick else ROUNDS
    results = [measure_case(suite, case, rounds) for case in track(cases, "reference scenes", len(cases))]
    return {"dim": run.dim, "results": packed(results)}


def measure_case(suite: Suite, case: Case, rounds: int) -> Result:
    build, model = suite.build("gsenv"), case.scene().compile()
    setting = Setting("gsenv", "default", Options().timestep, {"sleep": case.sleep})
    counted = Counted(build(model, setting))
    error = finite_error(case.error, record(counted, case, model, setting.timestep))
    spent = statistics.median(timed_run(build, case, model, setting) for _ in range(rounds))
    return Result(case.key, case.title, error, 1e6 * spent / case.seconds, counted.sweeps / counted.steps)


def report(results: Mapping[str, Any]) -> Report:
    rows = []
    for r in unpacked(Result, results["results"]):
        error = "fails" if r.error is None else f"{r.error:.1e}"
        rows.append([r.case, r.title, error, f"{r.us:.0f}", f"{r.sweeps:.1f}"])
    table = Table(["case", "scene", "error", "us per simulated s", "sweeps per step"], rows, WORDS)
    return Report(f"{results['dim']}D scenes with known answers, default options", [table])
