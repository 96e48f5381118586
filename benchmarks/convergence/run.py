"""Measures the errors of all cases and reports their orders."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Part, Picture, Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table

from .cases import CASES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RATES = (30, 60, 120, 240, 480)  # steps per s
QUICK_RATES = (60, 120, 240)
ROUNDING = 1e-12  # m, rad or relative: errors below are "exact"
WORDS = 3  # columns of group, scene and quantity


@dataclass(frozen=True)
class Result:
    """Errors of a case, one for each rate."""

    group: str
    scene: str
    quantity: str
    errors: Sequence[float]
    order: float | None  # observed; None: exact
    expected: float | None
    limit: str


def observed_order(rates: Iterable[int], errors: Iterable[float]) -> float | None:
    """Return the slope of log(error) over log(timestep) above rounding; None if fewer than three errors are."""
    points = [(-math.log(rate), math.log(error)) for rate, error in zip(rates, errors, strict=True) if error > ROUNDING]
    if len(points) < 3:
        return None
    log_timestep, log_error = zip(*points, strict=True)
    return float(np.polyfit(log_timestep, log_error, 1)[0])


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: this benchmark has no options of its own."""


def measure(run: Run) -> dict[str, Any]:
    rates = QUICK_RATES if run.quick else RATES
    results = []
    for case in track(CASES, "convergence", len(CASES)):
        errors = [case.measure(rate) for rate in rates]
        order = observed_order(rates, errors)
        results.append(Result(case.group, case.scene, case.quantity, errors, order, case.order, case.limit))
    return {"rates": rates, "results": packed(results)}


def order_text(order: float | None) -> str:
    return "exact" if order is None else f"{order:.2f}"


def report(results: Mapping[str, Any]) -> Report:
    rates, measured = results["rates"], unpacked(Result, results["results"])
    header = ["", "scene", "error of", *(f"1/{rate} s" for rate in rates), "order", "expected", "what limits it"]
    rows = []
    for r in measured:
        expected = "exact" if r.expected is None else f"{r.expected:g}"
        errors = (f"{error:.1e}" for error in r.errors)
        rows.append([r.group, r.scene, r.quantity, *errors, order_text(r.order), expected, r.limit])
    parts: list[Part] = [
        "All runs use default options, with two substeps of half a timestep each. The error is the largest over all "
        "steps, or over several speeds or heights where an event falls into a step. The reference is a closed form, "
        "or for pendulums a Runge-Kutta solution of their equations of motion.",
        "The order is the slope of log(error) over log(timestep), fitted to all errors above "
        f'{ROUNDING:g}; "exact" means an error of rounding size at every timestep.',
        Table(header, rows, WORDS),
        Picture("Error against timestep", partial(picture, measured, rates)),
    ]
    short = Table(header[1:-1], [row[1:-1] for row in rows], WORDS - 1)
    return Report("Observed order of convergence", parts, overview=[short])


def picture(results: Sequence[Result], rates: Sequence[int]) -> Figure:
    from .plot import draw

    return draw(results, rates)
