"""Step time per box against the number of boxes."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.common.plots import Axes, Figure, plain_axes, plt

from .report import TARGET, growth
from .run import BASE, SOLVERS, SWEEPS, Timing

COLORS = {"towers": "#1f77b4", "row": "#17a2a2", "tower": "#7a4fbf", "wall": "#d1701f", "pile": "#c0392b"}


def draw(timings: Sequence[Timing]) -> Figure:
    figure, panels = plt.subplots(1, len(SOLVERS), figsize=(13, 4.6), sharey=True, layout="constrained")
    for axes, solver in zip(panels, SOLVERS, strict=True):
        draw_panel(axes, [t for t in timings if t.solver == solver], timings)
        axes.set_title(f"{solver}, {SWEEPS} sweeps per substep", fontsize=11, loc="left")
    panels[0].set_ylabel("us per step and box")
    panels[-1].legend(frameon=False, fontsize=8.5, ncols=2)
    figure.suptitle(f"Step time per box: flat is linear (shaded: {TARGET:g} times that of {BASE} boxes)", fontsize=12)
    return figure


def draw_panel(axes: Axes, chosen: Sequence[Timing], timings: Sequence[Timing]) -> None:
    for family, color in COLORS.items():
        line = sorted((t for t in chosen if t.family == family), key=lambda t: t.bodies)
        axes.plot(
            [t.bodies for t in line], [t.per_body for t in line], color=color, marker="o", markersize=3.5, label=family
        )
        base = line[-1].per_body / growth(timings, line[-1])
        axes.fill_between([BASE, line[-1].bodies], base, TARGET * base, color=color, alpha=0.06, linewidth=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("boxes")
    plain_axes(axes)
