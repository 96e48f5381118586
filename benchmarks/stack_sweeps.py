"""What sweeps do: load per contact and height of a stack of ten boxes against the number of sweeps.

python benchmarks/stack_sweeps.py [--seconds 2] [--output docs/stack_sweeps.png]

Plain projected Gauss-Seidel. "Cold" starts each step from zero impulses, "warm" from the last ones.
There is no position pass, so that what is seen is the sweeps' work alone.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter
from numpy.typing import NDArray

from gsenv.scenes import stack
from gsenv.solver import Options, World
from gsenv.solver.jit import mute_compile_notice

Array = NDArray[np.float64]

COUNT = 10
GRAVITY = 9.81
SWEEPS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
TICKS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
LABEL_COLOR = "#444444"


def options(sweeps: int, warm: bool) -> Options:
    return Options(
        solver="pgs", sweeps=sweeps, warm_start=warm, substeps=1, tolerance=0.0, position_sweeps=0, sleep=False
    )


def first_loads(world: World, sweeps: int) -> Array:
    """N s under each box, from below, after one cold step from rest."""
    world.reset()
    world.options = options(sweeps, warm=False)
    world.step()
    contacts = world.contacts()
    return np.array([contacts.impulse[contacts.body_b == b, 0].sum() for b in range(1, COUNT + 1)])


def sunk(world: World, sweeps: int, warm: bool, seconds: float) -> float:
    """m that the top box is below its place, after some time."""
    world.reset()
    world.options = options(sweeps, warm)
    world.step(round(seconds / world.timestep))
    return float(COUNT - 0.5 - world.position[0, COUNT, 1])


def draw_loads(axes: Axes, loads: Array, unit: float) -> None:
    """One line a contact, in units of a box's own impulse m g dt: its exact value is a whole number."""
    colors = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, COUNT))
    for k in range(COUNT):
        axes.hlines(COUNT - k, 0.9, SWEEPS[-1], color=colors[k], linewidth=0.8, linestyle=(0, (2, 3)), zorder=1)
        axes.plot(SWEEPS, loads[:, k] / unit, color=colors[k], marker="o", markersize=3, linewidth=1.6)
        axes.annotate(
            f"box {k + 1}", (SWEEPS[-1], loads[-1, k] / unit), xytext=(8, 0), textcoords="offset points",
            color=colors[k], fontsize=8.5, va="center",
        )  # fmt: skip
    axes.set_ylabel("load under the box  [weights of one box]")
    axes.set_ylim(0.0, COUNT + 0.6)
    axes.set_yticks(range(0, COUNT + 1, 2))
    axes.set_title("Load per contact in one cold step (dotted: exact)", fontsize=11, loc="left")


def draw_sinking(axes: Axes, cold: list[float], warm: list[float], seconds: float) -> None:
    for heights, label, color in ((cold, "cold start", "#c0392b"), (warm, "warm start", "#1f77b4")):
        drop = np.maximum(np.abs(heights), 1e-6)
        axes.plot(SWEEPS, drop, color=color, marker="o", markersize=3.5, linewidth=1.8, label=label)
    axes.set_yscale("log")
    axes.set_ylabel(f"top box out of place after {seconds:g} s  [m]")
    axes.axhline(1.0, color=LABEL_COLOR, linewidth=0.8, linestyle=(0, (2, 3)))
    axes.annotate("one box", (SWEEPS[-1], 1.0), xytext=(0, 3), textcoords="offset points", fontsize=8.5,
                  color=LABEL_COLOR, ha="right")  # fmt: skip
    axes.legend(frameon=False, loc="lower left")
    axes.set_title("Height of the top box", fontsize=11, loc="left")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time of the height plot")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "docs" / "stack_sweeps.png")
    arguments = parser.parse_args()
    mute_compile_notice()
    console = Console()
    world = World(stack(COUNT))
    with console.status("compiling kernels (once)"):
        world.step()
    loads, cold, warm = [], [], []
    for sweeps in track(SWEEPS, "stacks", console=console):
        loads.append(first_loads(world, sweeps))
        cold.append(sunk(world, sweeps, False, arguments.seconds))
        warm.append(sunk(world, sweeps, True, arguments.seconds))

    unit = GRAVITY * world.timestep  # boxes of 1 kg
    table = Table("sweeps", "load under box 1", "under box 10", "cold: sunk, m", "warm: sunk, m")
    for k, sweeps in enumerate(SWEEPS):
        table.add_row(
            str(sweeps), f"{loads[k][0] / unit:.3f}", f"{loads[k][-1] / unit:.3f}", f"{cold[k]:.2e}", f"{warm[k]:.2e}"
        )
    console.print(table)

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5), layout=ConstrainedLayoutEngine(wspace=0.06))
    draw_loads(left, np.array(loads), unit)
    draw_sinking(right, cold, warm, arguments.seconds)
    for axes in (left, right):
        axes.set_xscale("log", base=2)
        axes.xaxis.set_major_locator(FixedLocator(TICKS))
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlabel("sweeps")
        axes.grid(axis="x", color="#e5e5e5")
        axes.spines[["top", "right"]].set_visible(False)
    left.set_xlim(0.9, SWEEPS[-1] * 1.9)
    right.set_xlim(0.9, SWEEPS[-1] * 1.15)
    figure.suptitle("A stack of ten boxes, plain projected Gauss-Seidel, 60 steps a second", fontsize=12.5)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(arguments.output, dpi=110)
    console.print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
