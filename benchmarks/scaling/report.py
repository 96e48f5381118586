"""Tables and plot of the growth of a step's time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from benchmarks.common.files import unpacked
from benchmarks.common.report import Part, Picture, Report
from benchmarks.common.tables import Table

from .run import BASE, SOLVERS, SWEEPS, Rest, Timing
from .scenes import FAMILIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TARGET = 1.5  # of the growth


def growth(timings: Sequence[Timing], one: Timing, per_row: bool = False) -> float:
    """Return the time per body (or row) divided by that of BASE boxes."""
    (base,) = (t for t in timings if (t.family, t.solver, t.bodies) == (one.family, one.solver, BASE))
    return one.per_row / base.per_row if per_row else one.per_body / base.per_body


def awake_table(timings: Sequence[Timing], solver: str) -> Table:
    """Return the table of us per step and box, and in brackets the ratio to BASE boxes."""
    chosen = [t for t in timings if t.solver == solver]
    sizes = sorted({t.bodies for t in chosen})
    rows = []
    for family in FAMILIES[2]:
        line = sorted((t for t in chosen if t.family == family), key=lambda t: t.bodies)
        cells = [f"{t.per_body:.2f} ({growth(timings, t):.2f})" for t in line]
        last = line[-1]
        rows.append([family, *cells, f"{last.rows / last.bodies:.1f}", f"{growth(timings, last, per_row=True):.2f}"])
    return Table([solver, *map(str, sizes), "rows per box", "ratio per row"], rows)


def rest_table(rests: Sequence[Rest]) -> Table:
    header = ["family", "boxes", "awake", "all asleep", "share", "ten awake beside", "ten alone", "share"]
    rows = [
        [
            r.family, str(r.bodies), f"{r.awake:.0f}", f"{r.asleep:.1f}", f"{r.asleep_share:.2%}",
            f"{r.beside:.0f}", f"{r.tower:.0f}", f"{r.beside_share:.1%}",
        ]
        for r in rests
    ]  # fmt: skip
    return Table(header, rows)


def report(results: Mapping[str, Any]) -> Report:
    timings, rests = unpacked(Timing, results["awake"]), unpacked(Rest, results["asleep"])
    worst = max((growth(timings, t), t.family, t.solver, t.bodies) for t in timings if t.bodies >= BASE)
    parts: list[Part] = [
        "Times are CPU times of step calls on one core of a shared machine with kernels compiled beforehand, as "
        "medians; repeated runs differ by 20 %.",
        f"## Awake, {SWEEPS} sweeps in each of two substeps",
        f"Each cell has the microseconds per step and box, and in brackets their ratio to those of {BASE} boxes. The "
        f"last two columns are those of the largest scene. The target is a ratio below {TARGET:g}. The largest ratio "
        f"is {worst[0]:.2f} ({worst[1]} of {worst[3]}, {worst[2]}).",
        "The families are towers of ten that do not touch (towers), the same towers side by side and touching (row),"
        " one tower (tower), bricks in running bond, at most 50 side by side (wall), and boxes of random sizes "
        "between walls (pile). Direct solutions by the subspace solver are not counted as sweeps. Where an overlap of "
        "any two boxes has grown by much in a step, the whole world takes it again in parts ([method](method.md)): the "
        "more boxes of a pile fall, the more steps are divided.",
        *(awake_table(timings, solver) for solver in SOLVERS),
        Picture("Time per step and box against the number of boxes", partial(picture, timings)),
        "## Asleep, default options",
        "Times are in microseconds per step. The first share is the time with all boxes asleep divided by that with "
        "all awake; its target is below 2 %. The second is the time that the sleeping boxes add to a step in which a"
        " tower of ten beside them is awake, divided by the time with all awake.",
        rest_table(rests),
    ]
    return Report("Growth with the number of bodies" + (" in 3D" if results["dim"] == 3 else ""), parts)


def picture(timings: Sequence[Timing]) -> Figure:
    from .plot import draw

    return draw(timings)
