"""How the time of a step grows with the number of bodies, and what sleeping bodies cost.

    taskset -c 0 python -m benchmarks.scaling [--dim 3] [--quick] [--output docs]

Awake: scenes of 10 to 5,000 boxes at a fixed number of sweeps (tolerance 0, sleeping off), from the
same settled and slightly shaken state for each solver.  Asleep: the same scenes at default options,
all awake, all asleep, and asleep beside a tower of ten that a moving plate keeps awake.
CPU time of step calls, compiled before, median; writes scaling.md, scaling.png and scaling.json.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from rich.console import Console
from rich.markdown import Markdown
from rich.progress import Progress

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from gsenv.solver import Options, Scene, World
from gsenv.solver.jit import mute_compile_notice

from .scaling_scenes import FAMILIES, Families, with_awake_tower

SIZES = (10, 30, 100, 300, 1000, 3000, 5000)
QUICK_SIZES = (10, 100, 1000)
BASE = 100  # boxes: what ratios refer to
SWEEPS = 10  # of each of the two substeps
FIXED = Options(sweeps=SWEEPS, tolerance=0.0, sleep=False)
SETTLING = Options(sleep=False)
SOLVERS = ("pgs", "nncg", "subspace")
SHAKE = 1e-3  # m/s: without it a tower reaches the exact answer, where sweeps end early
STEPS = 10  # of a timed call
ROUNDS = 5
BUDGET = 0.02  # CPU s of a round: small scenes are timed more than once in it
SLEEPING = 5000  # bodies
NAMES = {2: "scaling", 3: "scaling3d"}
IN_SPACE = {2: "", 3: ", in space"}
COMMAND = {2: "", 3: " --dim 3"}
COLORS = {"towers": "#1f77b4", "row": "#17a2a2", "tower": "#7a4fbf", "wall": "#d1701f", "pile": "#c0392b"}


@dataclass(frozen=True)
class Timing:
    """A scene at a fixed number of sweeps."""

    family: str
    solver: str
    bodies: int
    rows: int
    islands: int
    sweeps: float  # per island and substep
    microseconds: float  # a step

    @property
    def per_body(self) -> float:
        return self.microseconds / self.bodies

    @property
    def per_row(self) -> float:
        return self.microseconds / self.rows


@dataclass(frozen=True)
class Rest:
    """A settled scene at default options, us a step."""

    family: str
    bodies: int
    awake: float
    asleep: float
    tower: float  # the tower on the moving plate alone
    beside: float  # the same with the sleeping scene beside it

    @property
    def asleep_part(self) -> float:
        return self.asleep / self.awake

    @property
    def beside_part(self) -> float:
        """What the sleepers cost beside an awake island, over what they cost awake."""
        return (self.beside - self.tower) / self.awake


# ---------------------------------------------------------------- measuring


def cpu_time(world: World, steps: int) -> float:
    """s a step, in one call."""
    began = time.thread_time()
    world.step(steps)
    return (time.thread_time() - began) / steps


def microseconds(world: World, steps: int) -> float:
    """Median CPU time of a step in calls of so many."""
    return 1e6 * statistics.median(cpu_time(world, steps) for _ in range(ROUNDS))


def boxes_of(world: World) -> np.ndarray[Any, np.dtype[np.intp]]:
    return np.flatnonzero(world.model.bodies["kind"] == 2)


class Settled:
    """A scene of a family, and the state that each timing starts from."""

    def __init__(self, families: Families, family: str, count: int) -> None:
        build, settle = families[family]
        self.world = World(build(count), options=SETTLING)
        self.world.step(settle)
        self.count = count
        self.snapshot = self.world.save()
        self.boxes = boxes_of(self.world)
        ndof = self.world.state.bodies["velocity"].shape[-1]
        self.shake = SHAKE * np.random.default_rng(0).uniform(-1.0, 1.0, (count, ndof))

    def time(self, solver: str) -> float:
        """CPU s a step: the median of more than one call where a scene is small."""
        self.world.options = replace(FIXED, solver=solver)
        times: list[float] = []
        while not times or (sum(times) < BUDGET and len(times) < 20):
            self.world.restore(self.snapshot)
            self.world.state.bodies["velocity"][0, self.boxes] += self.shake
            self.world.step(1)  # buffers grow here
            times.append(cpu_time(self.world, STEPS))
        return statistics.median(times)


def time_awake(
    families: Families, family: str, sizes: tuple[int, ...], advance: Callable[[int], object]
) -> Iterator[Timing]:
    """All sizes in turn, several times: a machine that is slow for a while is slow for all of them."""
    scenes = [Settled(families, family, n) for n in sizes]
    for solver in SOLVERS:
        times: dict[int, list[float]] = {n: [] for n in sizes}
        for _ in range(ROUNDS):
            for scene in scenes:
                times[scene.count].append(scene.time(solver))
                advance(scene.count)
        for scene in scenes:
            scene.time(solver)
            n, d = scene.count, scene.world.diagnostics()
            assert d.awake[0] == n, f"{family} of {n}: {d.awake[0]} are awake"
            sweeps = float(d.sweeps[0] / (d.islands[0] * FIXED.substeps))
            spent = 1e6 * statistics.median(times[n])
            yield Timing(family, solver, n, int(d.rows[0]), int(d.islands[0]), sweeps, spent)


def put_to_sleep(world: World) -> None:
    """All but the last ten boxes, if these stand on the plate. By hand: a wall of thousands takes long."""
    boxes = boxes_of(world)
    if "plate" in world.model.body_names:
        boxes = boxes[:-10]
    world.state.bodies["asleep"][0, boxes] = 1
    world.state.bodies["velocity"][0, boxes] = 0.0


def time_asleep(families: Families, family: str, count: int, alone: float) -> Rest:
    """The scene awake, asleep, and asleep beside a tower that is awake."""
    build, settle = families[family]
    world = World(build(count), options=SETTLING)
    world.step(settle)
    awake = microseconds(world, STEPS)
    world.options = Options()
    put_to_sleep(world)
    asleep = microseconds(world, 100 * STEPS)
    assert world.diagnostics().awake[0] == 0, family
    beside = World(with_awake_tower(build(count)), options=SETTLING)
    beside.step(settle)
    beside.options = Options()
    put_to_sleep(beside)
    both = microseconds(beside, 10 * STEPS)
    assert beside.diagnostics().awake[0] == 10, family
    return Rest(family, count, awake, asleep, alone, both)


def awake_tower_alone(dim: int) -> float:
    world = World(with_awake_tower(Scene(dim)))
    world.step(20)
    return microseconds(world, 10 * STEPS)


def measure(dim: int, sizes: tuple[int, ...], console: Console) -> tuple[list[Timing], list[Rest]]:
    timings: list[Timing] = []
    rests: list[Rest] = []
    sleeping = [n for n in (BASE, 1000, SLEEPING) if n <= max(sizes)]
    all_families = FAMILIES[dim]
    resting = ("towers", "wall", "pile")
    with Progress(console=console) as progress:
        total = sum(sizes) * len(all_families) * len(SOLVERS) * ROUNDS + sum(sleeping) * len(resting) * 10
        task = progress.add_task("compiling", total=total)
        World(all_families["tower"][0](2), options=FIXED).step()
        World(all_families["towers"][0](200), options=FIXED).step()
        for family in all_families:
            progress.update(task, description=family)
            timings += time_awake(all_families, family, sizes, partial(progress.advance, task))
        alone = awake_tower_alone(dim)
        for family in resting:
            for n in sleeping:
                progress.update(task, description=f"{family} of {n}, sleeping")
                rests.append(time_asleep(all_families, family, n, alone))
                progress.advance(task, 10 * n)
    return timings, rests


# ---------------------------------------------------------------- reporting


def table(header: list[str], rows: list[list[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def growth(timings: list[Timing], one: Timing, per_row: bool = False) -> float:
    """Time per body (or row) over that of BASE boxes."""
    (base,) = (t for t in timings if (t.family, t.solver, t.bodies) == (one.family, one.solver, BASE))
    return one.per_row / base.per_row if per_row else one.per_body / base.per_body


def awake_table(timings: list[Timing], solver: str) -> str:
    """us per step and body, and in brackets the ratio to BASE boxes."""
    chosen = [t for t in timings if t.solver == solver]
    sizes = sorted({t.bodies for t in chosen})
    rows = []
    for family in FAMILIES[2]:
        line = sorted((t for t in chosen if t.family == family), key=lambda t: t.bodies)
        cells = [f"{t.per_body:.2f} ({growth(timings, t):.2f})" for t in line]
        last = line[-1]
        rows.append([family, *cells, f"{last.rows / last.bodies:.1f}", f"{growth(timings, last, per_row=True):.2f}"])
    return table([solver, *map(str, sizes), "rows a box", "ratio a row"], rows)


def rest_table(rests: list[Rest]) -> str:
    header = ["family", "boxes", "awake", "all asleep", "part", "ten awake beside", "ten alone", "part"]
    rows = [
        [
            r.family, str(r.bodies), f"{r.awake:.0f}", f"{r.asleep:.1f}", f"{r.asleep_part:.2%}",
            f"{r.beside:.0f}", f"{r.tower:.0f}", f"{r.beside_part:.1%}",
        ]
        for r in rests
    ]  # fmt: skip
    return table(header, rows)


def report(dim: int, timings: list[Timing], rests: list[Rest]) -> str:
    worst = max((growth(timings, t), t.family, t.solver, t.bodies) for t in timings if t.bodies >= BASE)
    parts = [
        f"# Growth with the number of bodies{IN_SPACE[dim]}",
        f"`python -m benchmarks.scaling{COMMAND[dim]}`: CPU time of step calls on one core of a shared machine, "
        "compiled before, median; repeated runs differ by 20 %.",
        f"## Awake, {SWEEPS} sweeps in each of two substeps",
        f"Microseconds per step and box, in brackets over those of {BASE} boxes; \"rows a box\" and \"ratio a row\" "
        "are those of the largest scene. The target is a ratio below 1.5. "
        f"Largest ratio: {worst[0]:.2f} ({worst[1]} of {worst[3]}, {worst[2]}).",
        "towers: of ten, apart. row: the same, side by side and touching. tower: one on the other. wall: running "
        "bond, at most 50 wide. pile: random boxes between two walls. A step of the subspace solver counts no sweep.",
        *(awake_table(timings, solver) for solver in SOLVERS),
        f"![time per step and box against the number of boxes]({NAMES[dim]}.png)",
        "## Asleep, default options",
        "Microseconds per step. \"Part\": all asleep over all awake, target below 2 %; and what the sleepers add to a "
        "step in which a tower of ten beside them is awake, over what they cost awake.",
        rest_table(rests),
    ]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def plot(timings: list[Timing], path: Path) -> None:
    figure, panels = plt.subplots(1, len(SOLVERS), figsize=(13, 4.6), sharey=True, layout="constrained")
    for axes, solver in zip(panels, SOLVERS, strict=True):
        draw_panel(axes, [t for t in timings if t.solver == solver], timings)
        axes.set_title(f"{solver}, {SWEEPS} sweeps a substep", fontsize=11, loc="left")
    panels[0].set_ylabel("us per step and box")
    panels[-1].legend(frameon=False, fontsize=8.5, ncols=2)
    figure.suptitle("Time of a step per box: flat is linear (shaded: 1.5 times that of 100 boxes)", fontsize=12)
    figure.savefig(path.with_suffix(".tmp.png"), dpi=110)
    os.replace(path.with_suffix(".tmp.png"), path)


def draw_panel(axes: Axes, chosen: list[Timing], timings: list[Timing]) -> None:
    for family, color in COLORS.items():
        line = sorted((t for t in chosen if t.family == family), key=lambda t: t.bodies)
        axes.plot(
            [t.bodies for t in line], [t.per_body for t in line], color=color, marker="o", markersize=3.5, label=family
        )
        base = line[-1].per_body / growth(timings, line[-1])
        axes.fill_between([BASE, line[-1].bodies], base, 1.5 * base, color=color, alpha=0.06, linewidth=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("boxes")
    axes.grid(which="both", color="#ececec")
    axes.spines[["top", "right"]].set_visible(False)


def write(path: Path, text: str) -> None:
    """The whole file or none of it."""
    draft = path.with_name(path.name + ".tmp")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=f"sizes {QUICK_SIZES} only")
    parser.add_argument("--dim", type=int, choices=(2, 3), default=2)
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "docs")
    arguments = parser.parse_args()
    mute_compile_notice()
    console = Console()
    timings, rests = measure(arguments.dim, QUICK_SIZES if arguments.quick else SIZES, console)
    text = report(arguments.dim, timings, rests)
    console.print(Markdown(text))
    folder, name = arguments.output, NAMES[arguments.dim]
    folder.mkdir(parents=True, exist_ok=True)
    figures = {"awake": [asdict(t) for t in timings], "asleep": [asdict(r) for r in rests]}
    write(folder / f"{name}.json", json.dumps(figures, indent=1) + "\n")
    write(folder / f"{name}.md", text)
    plot(timings, folder / f"{name}.png")
    console.print(f"wrote {folder}/{name}.md, .png and .json")


if __name__ == "__main__":
    main()
