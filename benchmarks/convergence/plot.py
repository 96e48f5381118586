"""Errors against the timestep, one panel for each group of scenes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from benchmarks.common.plots import Axes, Figure, plain_axes, plt

from .run import Result, order_text

GROUPS = ("smooth motion", "sliding", "impact", "joints", "joints by rows")
COLORS = ("#1f77b4", "#d1701f", "#7a4fbf", "#17a2a2")


def draw(results: Sequence[Result], rates: Sequence[int]) -> Figure:
    figure, panels = plt.subplots(1, len(GROUPS), figsize=(18, 5.4), sharey=True, layout="constrained")
    for axes, group in zip(panels, GROUPS, strict=True):
        draw_panel(axes, [r for r in results if r.group == group], rates)
        axes.set_title(group, fontsize=12, loc="left")
    panels[0].set_ylabel("error (m, rad or relative)")
    title = "Error against timestep, and the observed order of convergence (grey: slopes 1 and 2)"
    figure.suptitle(title, fontsize=13, x=0.01, ha="left")
    return figure


def draw_panel(axes: Axes, results: Sequence[Result], rates: Sequence[int]) -> None:
    steps = 1.0 / np.array(rates)
    for power, start in ((1, 3e-2), (2, 3e-2)):
        guide = start * (steps / steps[0]) ** power
        axes.plot(steps, guide, color="#c4c4c4", linewidth=1, linestyle=(0, (4, 3)))
        axes.annotate(f"{power}", (steps[-1], guide[-1]), (-5, 0), textcoords="offset points", color="#9a9a9a",
                      fontsize=9, ha="right", va="center")  # fmt: skip
    sloped = sorted((r for r in results if r.order is not None), key=lambda r: r.errors[0])
    height = -math.inf  # of the last label: they keep apart
    for result, color in zip(sloped, COLORS, strict=False):
        axes.plot(steps, result.errors, color=color, marker="o", markersize=4)
        height = max(math.log10(result.errors[0]), height + 0.4)
        axes.annotate(f"{result.scene}: {order_text(result.order)}", (steps[0], 10.0**height), (8, 0),
                      textcoords="offset points", color=color, fontsize=9, va="center", linespacing=1.05)  # fmt: skip
    exact = [r.scene for r in results if r.order is None]
    if exact:
        text = "\n".join(f"{name}: exact" for name in exact)
        axes.annotate(text, (0.04, 0.02), xycoords="axes fraction", color="#555555", fontsize=9)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(1e-12, 2.0)
    axes.set_xlim(0.7 * steps[-1], 16.0 * steps[0])  # room for the names
    axes.set_xticks(steps, [f"1/{rate}" for rate in rates], fontsize=8)
    axes.minorticks_off()
    axes.set_xlabel("timestep, s", loc="left")
    plain_axes(axes)
