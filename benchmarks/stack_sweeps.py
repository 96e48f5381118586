"""Contact loads and height of a stack of ten boxes against the number of sweeps.

Plain projected Gauss-Seidel. "Cold" starts each step from zero impulses, "warm" from those of the last step.
There is no position pass, so what is seen is the work of the sweeps alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.progress import track
from benchmarks.common.report import Picture, Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.scenes import stack
from gsenv.solver import Options, World

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COUNT = 10
GRAVITY = 9.81
SWEEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
QUICK_SWEEPS = (1, 4, 16, 64, 256)
TICKS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
LABEL_COLOR = "#444444"


def options(sweeps: int, warm: bool) -> Options:
    return Options(
        solver="pgs", sweeps=sweeps, warm_start=warm, substeps=1, tolerance=0.0, position_sweeps=0, sleep=False
    )


def first_loads(world: World, sweeps: int) -> Array:
    """Load under each box, from the lowest, after one cold step from rest, in weights of a box."""
    world.reset()
    world.options = options(sweeps, warm=False)
    world.step()
    contacts = world.contacts()
    impulses = [contacts.impulse[contacts.body_b == b, 0].sum() for b in range(1, COUNT + 1)]
    return np.array(impulses) / (GRAVITY * world.timestep)  # boxes of 1 kg


def sunk(world: World, sweeps: int, warm: bool, seconds: float) -> float:
    """Return how far in m the top box is below its place after some time."""
    world.reset()
    world.options = options(sweeps, warm)
    world.step(round(seconds / world.timestep))
    return float(COUNT - 0.5 - world.position[0, COUNT, 1])


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time before the height is read")


def measure(run: Run) -> dict[str, Any]:
    world = World(stack(COUNT))
    world.step()  # compiles
    seconds, counts = run.options.seconds, QUICK_SWEEPS if run.quick else SWEEPS
    loads, cold, warm = [], [], []
    for sweeps in track(counts, "stacks", len(counts)):
        loads.append(first_loads(world, sweeps).tolist())
        cold.append(sunk(world, sweeps, False, seconds))
        warm.append(sunk(world, sweeps, True, seconds))
    return {"seconds": seconds, "sweeps": counts, "loads": loads, "cold": cold, "warm": warm}


def report(results: Mapping[str, Any]) -> Report:
    lines = zip(results["sweeps"], results["loads"], results["cold"], results["warm"], strict=True)
    rows = [[str(n), f"{load[0]:.3f}", f"{load[-1]:.3f}", f"{c:.2e}", f"{w:.2e}"] for n, load, c, w in lines]
    return Report(
        "A stack of ten boxes, plain projected Gauss-Seidel, 60 steps per second",
        [
            f"Loads are those of one cold step, in weights of one box. Sinking of the top box after "
            f"{results['seconds']:g} s, in m.",
            Table(["sweeps", "load under box 1", "under box 10", "sunk, cold start", "sunk, warm start"], rows),
            Picture("Load per contact and height of the top box against sweeps", partial(draw, results)),
        ],
    )


# ---------------------------------------------------------------- plot


def draw(results: Mapping[str, Any]) -> Figure:
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter

    from benchmarks.common.plots import plain_axes, plt

    sweeps = results["sweeps"]
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout=ConstrainedLayoutEngine(wspace=0.06))
    draw_loads(left, sweeps, np.array(results["loads"]))
    draw_sinking(right, sweeps, results["cold"], results["warm"], results["seconds"])
    for axes in (left, right):
        axes.set_xscale("log", base=2)
        axes.xaxis.set_major_locator(FixedLocator(TICKS))
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlabel("sweeps")
        plain_axes(axes, "x")
    left.set_xlim(0.9, sweeps[-1] * 1.9)
    right.set_xlim(0.9, sweeps[-1] * 1.15)
    figure.suptitle("A stack of ten boxes, plain projected Gauss-Seidel, 60 steps per second", fontsize=12.5)
    return figure


def draw_loads(axes: Axes, sweeps: Sequence[int], loads: Array) -> None:
    """Draw one line for each contact, in weights of one box, whose exact value is a whole number."""
    from benchmarks.common.plots import plt

    colors = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, COUNT))
    for k in range(COUNT):
        axes.hlines(COUNT - k, 0.9, sweeps[-1], color=colors[k], linewidth=0.8, linestyle=(0, (2, 3)), zorder=1)
        axes.plot(sweeps, loads[:, k], color=colors[k], marker="o", markersize=3, linewidth=1.6)
        axes.annotate(
            f"box {k + 1}", (sweeps[-1], loads[-1, k]), xytext=(8, 0), textcoords="offset points",
            color=colors[k], fontsize=8.5, va="center",
        )  # fmt: skip
    axes.set_ylabel("load under the box  [weights of one box]")
    axes.set_ylim(0.0, COUNT + 0.6)
    axes.set_yticks(range(0, COUNT + 1, 2))
    axes.set_title("Load per contact in one cold step (dotted: exact)", fontsize=11, loc="left")


def draw_sinking(
    axes: Axes, sweeps: Sequence[int], cold: Sequence[float], warm: Sequence[float], seconds: float
) -> None:
    for heights, label, color in ((cold, "cold start", "#c0392b"), (warm, "warm start", "#1f77b4")):
        drop = np.maximum(np.abs(heights), 1e-6)
        axes.plot(sweeps, drop, color=color, marker="o", markersize=3.5, linewidth=1.8, label=label)
    axes.set_yscale("log")
    axes.set_ylabel(f"top box out of place after {seconds:g} s  [m]")
    axes.axhline(1.0, color=LABEL_COLOR, linewidth=0.8, linestyle=(0, (2, 3)))
    axes.annotate("one box", (sweeps[-1], 1.0), xytext=(0, 3), textcoords="offset points", fontsize=8.5,
                  color=LABEL_COLOR, ha="right")  # fmt: skip
    axes.legend(frameon=False, loc="lower left")
    axes.set_title("Height of the top box", fontsize=11, loc="left")
