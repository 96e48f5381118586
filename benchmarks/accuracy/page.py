"""The report: the cheapest setting of each engine at a given error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from benchmarks.common.report import Part, Picture, Report
from benchmarks.common.tables import Table
from gsenv.solver.api.options import FIDELITIES

from .cases import Case
from .fronts import OURS, Judge, Points, best_peer, cheapest, lenient, ratio_to_best_peer, strict
from .method import LENIENT, method
from .points import Point, points_in
from .suites import suite_of

LIMITS = (1e-2, 1e-3, 1e-4)
LOOSE = 3e-2  # m: for the heap of balls
WORDS = 2  # columns of a case's key and title


def time_cell(point: Point | None) -> str:
    return "-" if point is None else f"{point.us:.0f}"


def overview(cases: Sequence[Case], points: Points) -> list[Part]:
    """Return the tables for the terminal: times and ratios at the first two limits."""
    parts: list[Part] = ["CPU us per simulated second of the cheapest setting, and gsenv's time over the best peer's:"]
    for limit in LIMITS[:2]:
        rows = []
        for case in cases:
            best = [cheapest(points.of(case.key, engine), limit) for engine in points.engines]
            rows.append([case.key, *map(time_cell, best), ratio_to_best_peer(points, case.key, limit)])
        parts.append(Table([f"error <= {limit:.0e}", *points.engines, "ratio"], rows))
    return parts


def limit_table(cases: Sequence[Case], points: Points, limit: float, judge: Judge = strict) -> Table:
    """Return the times and settings of the cheapest points whose error is at most ``limit``."""
    rows = []
    for case in cases:
        best = [cheapest(points.of(case.key, engine), limit, judge) for engine in points.engines]
        peer = best_peer(points, case.key, limit, judge)
        labels = [point.label if point else "-" for point in (best[0], peer)]
        ratio = ratio_to_best_peer(points, case.key, limit, judge)
        rows.append([case.key, case.title, *map(time_cell, best), ratio, *labels])
    header = ["case", "scene", *points.engines, "gsenv / best peer", "gsenv's setting", "best peer's setting"]
    return Table(header, rows, WORDS)


def fidelity_table(cases: Sequence[Case], points: Points) -> Table:
    """Return the errors and times of gsenv's fidelities."""
    rows = []
    for case in cases:
        row = [case.key, case.title]
        marked = {point.mark: point for point in points.of(case.key, OURS)}
        for mark in FIDELITIES:
            point = marked.get(mark)
            error = "-" if point is None else "fails" if point.error is None else f"{point.error:.1e}"
            row += [error, time_cell(point)]
        rows.append(row)
    return Table(["case", "scene", *(f"{m}: {w}" for m in FIDELITIES for w in ("error", "us"))], rows, WORDS)


def outdated_cases(points: Points, sources: Mapping[str, str]) -> list[str]:
    """Return the keys of the cases with points from before the last change of a source file."""
    return sorted({point.case for point in points.all if point.sources != sources[point.engine]})


def report(results: Mapping[str, Any]) -> Report:
    """Return the page, and for the terminal the overview."""
    dim = results["dim"]
    points = Points(points_in(results))
    cases = [case for case in suite_of(dim).cases if points.of(case.key)]
    standing = [case for case in cases if case.kind == "standing"]
    balls = [case for case in cases if case.kind == "balls"]
    parts: list[Part] = [Picture("Error against CPU time, one panel for each case", partial(picture, cases, points))]
    parts.append(method(dim, points.engines))
    outdated = outdated_cases(points, results["sources"])
    if outdated:
        parts.append(f"These cases were measured before the last change of a source file: {', '.join(outdated)}.")
    for limit in LIMITS:
        parts += [f"## Cheapest setting with an error of at most {limit:.0e}", limit_table(cases, points, limit)]
    if balls:
        parts += [f"## Balls that fall apart, error at most {LOOSE:.0e} m", limit_table(balls, points, LOOSE)]
    parts += [
        "## Fidelities of gsenv",
        "The columns give the error, and the CPU time in us per simulated second.",
        fidelity_table(cases, points),
    ]
    parts += ["## Standing scenes, heights and overlaps alone", LENIENT]
    for limit in LIMITS[:2]:
        parts += [f"Error at most {limit:.0e}:", limit_table(standing, points, limit, lenient)]
    title = "Run time against error" + (" in 3D" if dim == 3 else "")
    return Report(title, parts, overview=overview(cases, points))


def picture(cases: Sequence[Case], points: Points) -> Any:
    from .plot import draw

    return draw(cases, points)
