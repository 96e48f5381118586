"""Log-log plots: one panel for each case, one front for each engine."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator

from benchmarks.common.plots import Axes, Figure, plain_axes, plt

from .cases import Case
from .fronts import OURS, Points, front
from .points import Point

COLORS = {
    "gsenv": "#0b6e99",
    "Box2D": "#d1702a",
    "Box2D v3": "#8e5aa8",
    "pymunk": "#7a8450",
    "MuJoCo": "#d1702a",
    "PyBullet": "#7a8450",
    "Rapier": "#c4568b",
    "Box3D": "#8e5aa8",
}
MARKS = {"fast": "^", "balanced": "o", "accurate": "s"}
INK = "#333333"
FLOOR, CEILING = 1e-9, 1.0  # of the error axis; smaller errors are drawn on the floor
COLUMNS = 5
PANEL = (3.05, 2.55)  # inches


def clipped(point: Point) -> float:
    return min(max(point.error or 0.0, FLOOR), CEILING)


def draw_engine(axes: Axes, points: list[Point], engine: str, right: float) -> None:
    color, ours = COLORS[engine], engine == OURS
    kept = [point for point in points if point.error is not None]
    axes.scatter([p.us for p in kept], [clipped(p) for p in kept], s=5, color=color, alpha=0.28, linewidths=0, zorder=2)
    best = front(kept)
    if best:
        xs, ys = [p.us for p in best], [clipped(p) for p in best]
        axes.step([xs[0], *xs, right], [CEILING, *ys, ys[-1]], where="post", color=color,
                  linewidth=2.0 if ours else 1.4, zorder=4 if ours else 3, solid_capstyle="round")  # fmt: skip
    for point in kept:
        if point.mark:
            axes.plot(point.us, clipped(point), MARKS[point.mark], color=color, markersize=5.5,
                      markeredgecolor="white", markeredgewidth=0.8, zorder=5, clip_on=False)  # fmt: skip


def draw_case(axes: Axes, case: Case, points: Points) -> None:
    times = [p.us for p in points.of(case.key) if p.error is not None]
    left, right = 10 ** math.floor(math.log10(min(times)) - 0.05), max(times) * 1.6
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(left, right)
    axes.set_ylim(FLOOR * 0.6, CEILING)
    for limit in (1e-2, 1e-3):
        axes.axhline(limit, color="#b5b5b5", linewidth=0.7, linestyle=(0, (3, 3)), zorder=1)
    for engine in reversed(points.engines):
        draw_engine(axes, points.of(case.key, engine), engine, right)
    axes.set_title(case.title, fontsize=8.8, loc="left", color=INK, pad=6)
    axes.yaxis.set_major_locator(FixedLocator([1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 1.0]))
    axes.yaxis.set_major_formatter(FuncFormatter(error_label))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_locator(LogLocator(numticks=6))
    axes.xaxis.set_major_formatter(FuncFormatter(time_label))
    axes.xaxis.set_minor_formatter(NullFormatter())
    plain_axes(axes, "x")
    axes.tick_params(labelsize=7.5, colors=INK, length=2.5)
    axes.tick_params(which="minor", length=0)
    axes.spines[["left", "bottom"]].set_color("#999999")


def error_label(value: float, _: int) -> str:
    exponent = round(math.log10(value))
    return "1" if exponent == 0 else f"$10^{{{exponent}}}$" if value > FLOOR else f"$\\leq 10^{{{exponent}}}$"


def time_label(value: float, _: int) -> str:
    """Return a time given in us as text in us, ms or s."""
    for unit, scale in (("s", 1e6), ("ms", 1e3)):
        if value >= scale:
            return f"{value / scale:g} {unit}"
    return f"{value:g} µs"


def legend_handles(engines: list[str]) -> list[Line2D]:
    fronts = [Line2D([], [], color=COLORS[engine], linewidth=2, label=engine) for engine in engines]
    marks = [
        Line2D([], [], color=COLORS[OURS], marker=mark, linestyle="", markersize=6, label=f"gsenv, {name}")
        for name, mark in MARKS.items()
    ]
    dot = Line2D([], [], color="#999999", marker=".", linestyle="", label="a setting; lines: the best so far")
    return [*fronts, *marks, dot]


def draw(cases: Sequence[Case], points: Points) -> Figure:
    """Draw all cases that have an error."""
    cases = [case for case in cases if any(p.error is not None for p in points.of(case.key))]
    columns = min(COLUMNS, len(cases))
    rows = -(-len(cases) // columns)
    width, height = max(columns * PANEL[0], 8.0), rows * PANEL[1] + 1.0
    layout = ConstrainedLayoutEngine(hspace=0.07, wspace=0.05)
    figure, grid = plt.subplots(rows, columns, figsize=(width, height), squeeze=False, sharey=True, layout=layout)
    for axes, case in zip(grid.flat, cases, strict=False):
        draw_case(axes, case, points)
    for axes in grid.flat[len(cases) :]:
        axes.set_visible(False)
    figure.supxlabel("CPU time per simulated second", fontsize=10.5, color=INK)
    figure.supylabel("error, relative or in m", fontsize=10.5, color=INK)
    handles = legend_handles(points.engines)
    figure.legend(handles=handles, loc="outside upper center", ncols=8, frameon=False, fontsize=9.5)
    return figure
