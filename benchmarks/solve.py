"""Run time against error of the methods of `solve`: mass ratios, towers, piles with friction, P-matrices, ties.

Each problem is solved to several tolerances. The error is that of the impulses where they are known in closed form
(towers: the weight above), else the residual of the natural map.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from benchmarks.common.timing import cpu_time
from gsenv.solver.problem.problem import Problem, Solution, solve
from tests.solver.problem.problems import (
    degenerate_problem,
    murty_problem,
    p_problem,
    pyramid,
    spatial_tower,
    tower,
)

Array = NDArray[np.float64]
Known = Callable[[Solution], float]  # the relative error of a solution

TOLERANCES = (1e-2, 1e-5, 1e-8)
SWEEPS = ("pgs", "nncg", "apgd")
SEEDS = 5
ROUNDS = 3
LEMKE_ROWS = 500  # beyond these a run takes minutes


@dataclass(frozen=True)
class Case:
    """One problem of a family.

    Attributes:
        family: what is varied.
        name: its value.
        make: the problem for a seed, and the error of its impulses if they are known.
        methods: that can solve it.
        seeds: how many problems it stands for.
    """

    family: str
    name: str
    make: Callable[[int], tuple[Problem, Known | None]]
    methods: Sequence[str]
    seeds: int = 1


@dataclass(frozen=True)
class Line:
    """Medians over the seeds of a case."""

    family: str
    name: str
    rows: int
    method: str
    solved: int  # at the last tolerance
    seeds: int
    milliseconds: Sequence[float]  # one for each tolerance
    errors: Sequence[float]


def relative_error(impulse: Array, expected: Array) -> float:
    """Largest relative error."""
    return float(np.abs(impulse / expected - 1.0).max())


def standing(count: int, ratio: float, seed: int) -> tuple[Problem, Known | None]:
    problem, weight = tower(count, ratio)
    return problem, lambda solution: relative_error(solution.impulse, weight)


def standing_in_space(count: int, ratio: float, seed: int) -> tuple[Problem, Known | None]:
    problem, weight = spatial_tower(count, 0.5, ratio)

    def error(solution: Solution) -> float:
        return relative_error(solution.impulse.reshape(count, 4, 3)[:, :, 0].sum(axis=1), weight)

    return problem, error


def pushed_in_space(count: int, ratio: float, seed: int) -> tuple[Problem, Known | None]:
    return spatial_tower(count, 0.5, ratio, 0.6)[0], None


def piled(layers: int, ratio: float, seed: int) -> tuple[Problem, Known | None]:
    return pyramid(layers, 0.3, ratio), None


def without_symmetry(count: int, seed: int) -> tuple[Problem, Known | None]:
    return p_problem(np.random.default_rng(seed), count), None


def degenerate(count: int, symmetric: bool, seed: int) -> tuple[Problem, Known | None]:
    return degenerate_problem(np.random.default_rng(seed), count, symmetric), None


def exponential(count: int, seed: int) -> tuple[Problem, Known | None]:
    return murty_problem(count), None


def all_cases() -> list[Case]:
    every = ("auto", "direct", "lemke", *SWEEPS)
    spatial = ("auto", "direct", *SWEEPS)
    general = ("auto", "direct", "lemke")
    ratios = (1.0, 1e2, 1e3, 1e5, 1e7, 1e9)
    piles = ((4, 1.0), (4, 1e3), (8, 1.0), (8, 1e3), (8, 1e6), (15, 1.0), (15, 1e3))
    towers = ((5, 1.0), (5, 1e3), (20, 1.0), (20, 1e3), (20, 1e9))
    pushed = ((5, 1.0), (20, 1.0), (20, 1e3))
    cases = [Case("mass ratio, 10 boxes", f"{r:g}", partial(standing, 10, r), every) for r in ratios]
    for n in (10, 30, 100, 300, 1000):
        cases.append(Case("boxes in a tower", f"{n}", partial(standing, n, 1.0), every))
    for n, r in piles:
        cases.append(Case("2D pyramid, mu 0.3: layers, mass ratio", f"{n}, {r:g}", partial(piled, n, r), every))
    for n, r in towers:
        name = f"{n}, {r:g}"
        cases.append(Case("3D tower, mu 0.5: boxes, mass ratio", name, partial(standing_in_space, n, r), spatial))
    for n, r in pushed:
        name = f"{n}, {r:g}"
        cases.append(Case("3D tower pushed sideways: boxes, mass ratio", name, partial(pushed_in_space, n, r), spatial))
    for n in (10, 30, 100, 300):
        cases.append(Case("P-matrix without symmetry: rows", f"{n}", partial(without_symmetry, n), general, SEEDS))
    for n in (10, 30, 100, 200):
        cases.append(Case("degenerate, semidefinite: rows", f"{n}", partial(degenerate, n, True), every, SEEDS))
    for n in (10, 30, 100):
        methods = general if n < 100 else ("auto", "lemke")  # "direct" takes minutes there, and fails
        cases.append(Case("degenerate linear program: rows", f"{n}", partial(degenerate, n, False), methods, SEEDS))
    for n in (5, 10, 20):
        cases.append(Case("Murty's example: rows", f"{n}", partial(exponential, n), general))
    return cases


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--family", default="", metavar="TEXT", help="only families whose name contains this")


def measure(run: Run) -> dict[str, Any]:
    cases = [case for case in all_cases() if run.options.family in case.family]
    if run.quick:
        cases = [case for case in cases if case.make(0)[0].row_count <= 150]
    lines = []
    with progress_bar("solve", sum(len(case.methods) for case in cases)) as bar:
        for case in cases:
            problems = [case.make(seed) for seed in range(1 if run.quick else case.seeds)]
            for method in case.methods:
                bar.describe(f"{case.family} {case.name}, {method}")
                if method != "lemke" or problems[0][0].row_count <= LEMKE_ROWS:
                    lines.append(line_of(case, method, problems))
                bar.advance()
    return {"tolerances": TOLERANCES, "lines": packed(lines)}


def line_of(case: Case, method: str, problems: Sequence[tuple[Problem, Known | None]]) -> Line:
    """Measure one method on the problems of a case."""
    milliseconds, errors, solved = [], [], 0
    for tolerance in TOLERANCES:
        measured = [measure_one(problem, known, method, tolerance) for problem, known in problems]
        # rounded as they are stored, so that the page is the same from stored results
        milliseconds.append(float(f"{statistics.median(m[0] for m in measured):.4g}"))
        errors.append(float(f"{statistics.median(m[1] for m in measured):.3g}"))
        solved = sum(m[2] for m in measured)
    rows = problems[0][0].row_count
    return Line(case.family, case.name, rows, method, solved, len(problems), milliseconds, errors)


def measure_one(problem: Problem, known: Known | None, method: str, tolerance: float) -> tuple[float, float, bool]:
    """Return CPU ms, the error, and whether the problem was solved."""
    solution = solve(problem, method, tolerance)  # compiles
    times = [1e3 * cpu_time(lambda: solve(problem, method, tolerance))]
    while len(times) < ROUNDS and times[0] < 300.0:
        times.append(1e3 * cpu_time(lambda: solve(problem, method, tolerance)))
    error = solution.residual if known is None else known(solution)
    return statistics.median(times), error, solution.converged


def report(results: Mapping[str, Any]) -> Report:
    lines = unpacked(Line, results["lines"])
    tolerances = results["tolerances"]
    parts: list[Part] = [
        "CPU time and error of `solve(problem, method, tolerance)` for three tolerances on the residual, with the "
        "default limit of 10,000 sweeps. The error is the largest relative error of the impulses in towers, where they "
        "equal the weight above, and the residual of the natural map elsewhere. "
        "[Solve rows without bodies](problems.md) describes the methods.",
        '"Not solved" marks results whose residual exceeds 1e-8; their errors are those of the best impulses found. '
        f"Random problems: medians over {SEEDS}. Lemke's method is dense and is run up to {LEMKE_ROWS} rows.",
    ]
    for family in dict.fromkeys(line.family for line in lines):
        chosen = [line for line in lines if line.family == family]
        parts += [f"## {family[0].upper()}{family[1:]}", family_table(chosen, tolerances)]
    return Report("Run time against error of `solve`", parts)


def family_table(lines: Sequence[Line], tolerances: Sequence[float]) -> Table:
    header = ["case", "method", "rows", "solved to 1e-8"]
    for tolerance in tolerances:
        header += [f"ms at {tolerance:.0e}", "error"]
    rows, last = [], ""
    for line in lines:
        done = "yes" if line.solved == line.seeds else f"{line.solved} of {line.seeds}" if line.solved else "not solved"
        cells = [f"**{line.name}**" if line.name != last else "", line.method, str(line.rows), done]
        for milliseconds, error in zip(line.milliseconds, line.errors, strict=True):
            cells += [f"{milliseconds:.3g}", f"{error:.0e}"]
        rows.append(cells)
        last = line.name
    return Table(header, rows, words=2)
