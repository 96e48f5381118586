"""Errors of the chains against CPU time, one panel for each chain."""

from __future__ import annotations

from typing import Any

from benchmarks.common.plots import Figure, plain_axes, plt

from .engines import ENGINES, INTEGRATORS

COLORS = {
    "rows": "#d1701f", "joint coordinates": "#1f77b4", "Euler": "#b0b0b0", "implicitfast": "#7d7d7d", "RK4": "#444444"
}  # fmt: skip


def draw(chains: dict[str, Any]) -> Figure:
    figure, panels = plt.subplots(1, len(chains), figsize=(15, 5.0), sharey=True, layout="constrained")
    for axes, (name, engines) in zip(panels, chains.items(), strict=True):
        for engine in ENGINES:
            runs = [run for run in engines[engine].values() if 0.0 < run["error"] < 1.0]
            times, errors = [run["us"] for run in runs], [run["error"] for run in runs]
            label = engine if engine not in INTEGRATORS else f"MuJoCo, {engine}"
            dashed = (0, (4, 2)) if engine in INTEGRATORS else "-"
            axes.plot(times, errors, color=COLORS[engine], marker="o", markersize=4, linestyle=dashed, label=label)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("CPU time of a simulated second, us", loc="left")
        axes.set_title(name, fontsize=12, loc="left")
        plain_axes(axes)
    panels[0].set_ylabel("largest error of a link's end, m")
    panels[0].legend(frameon=False, fontsize=9)
    return figure
