"""Error of each fidelity as scenes get harder.

What grows: mass ratio, height, length, timestep, stiffness, overlap, distance from the origin, spin. A run
is called broken where its error exceeds 10 % or a number is not finite. --random adds random jointed scenes.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.files import packed, unpacked
from benchmarks.common.processes import in_processes
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Part, Picture, Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.scenes import chain, jelly, mass_ratio_stack, stack
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Revolute
from gsenv.train.arguments import not_negative, positive
from tests.stress.jointed import CATEGORIES, random_jointed_case
from tests.stress.measure import LIMIT, Outcome, problems, run_case

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

FIDELITIES = ("fast", "balanced", "accurate")
SECONDS = 5.0
BROKEN = 0.1
STEPS = 300  # of a random scene


def overlap_or_height(world: World, start: Array) -> float:
    """Return the deepest overlap or change of height, divided by the height of a box."""
    moved = np.abs(world.position[0] - start)[1:, 1].max()
    return float(max(world.diagnostics().penetration[0], moved))


def stacked(world: World) -> float:
    start = world.position[0].copy()
    world.step(round(SECONDS / world.timestep))
    return overlap_or_height(world, start)


def swinging(world: World, link: float = 0.25) -> float:
    """Return the largest, at any time, of the joint error over a link's length and the energy drift over its scale."""
    mass = np.where(world.model.bodies["kind"] == 2, world.parameters.mass[0], 0.0)
    height = max(float(np.ptp(world.center_of_mass[0, :, 1])), link)
    kinetic = float(world.diagnostics().kinetic_energy[0])
    scale = float(mass.sum()) * 9.81 * height + kinetic
    start = float(world.diagnostics().energy[0])
    worst = 0.0
    for _ in range(round(SECONDS / world.timestep / 5)):
        world.step(5)
        d = world.diagnostics()
        error = max(float(d.joint_error[0]) / link, abs(float(d.energy[0]) - start) / scale)
        if not math.isfinite(error):
            return math.inf
        worst = max(worst, error)
    return worst


def springy(world: World) -> float:
    """Return the larger of the relative energy gain and the final deviation from the block's shape over its width."""
    start = float(world.diagnostics().energy[0])
    width = float(np.ptp(world.position[0, 1:, 0]))
    most = -math.inf
    for _ in range(round(SECONDS / world.timestep / 5)):
        world.step(5)
        most = max(most, float(world.diagnostics().energy[0]) - start)
    if not world.diagnostics().finite[0]:
        return math.inf
    mass = float(world.parameters.mass[0, 1:].sum())
    shape = abs(float(np.ptp(world.position[0, 1:, 0])) / width - 1.0)
    return max(most / (mass * 9.81 * 2.5), 0.1 * shape, 1e-9)


def deep(part: float) -> Scene:
    """Return ten boxes, each of which starts inside the one below by the fraction ``part`` of a box."""
    scene = stack(10)
    for k in range(10):
        scene.bodies[f"box_{k}"].position[1] = 0.5 + k * (1.0 - part)
    return scene


def pushed_apart(world: World) -> float:
    """Return the overlap that is left, or how far above its own height the tower was thrown."""
    highest = 0.0
    for _ in range(round(SECONDS / world.timestep / 5)):
        world.step(5)
        highest = max(highest, float(world.position[0, :, 1].max()) - 9.5)
    return max(float(world.diagnostics().penetration[0]), highest)


def far_away(distance: float) -> Scene:
    scene = stack(10)
    for k in range(10):
        scene.bodies[f"box_{k}"].position[0] += distance
    return scene


def spinning(speed: float) -> Scene:
    """Return three bars pinned end to end that rotate freely as one."""
    scene = Scene(gravity=(0.0, 0.0))
    for k in range(3):
        bar = Box(half_extents=(0.125, 0.02))
        place = (0.25 * k - 0.25, 0.0)
        scene.add_body(
            f"bar_{k}", shapes=[bar], position=place, linear_velocity=(0.0, speed * place[0]), angular_velocity=speed
        )
        if k:
            scene.add_joint(f"pin_{k}", Revolute(f"bar_{k - 1}", f"bar_{k}", anchor=(0.25 * k - 0.375, 0.0)))
    return scene


@dataclass(frozen=True)
class Axis:
    """One thing that is made ever harder: its values, the scene, the error, and options that depend on it."""

    title: str
    values: tuple[float, ...]
    scene: Callable[[float], Scene]
    error: Callable[[World], float]
    timestep: Callable[[float], float] = lambda value: 1.0 / 60.0


AXES = (
    Axis("mass ratio of two boxes", (1, 10, 100, 1e3, 1e4, 1e5, 1e6), mass_ratio_stack, stacked),
    Axis("boxes in a tower", (2, 5, 10, 20, 50, 100, 200), lambda n: stack(int(n)), stacked),
    Axis(
        "links of a chain, 100x end", (2, 5, 10, 20, 50, 100, 200),
        lambda n: chain(int(n), 0.25, 30.0, last_mass=100.0), swinging,
    ),
    Axis(
        "mass ratio of a chain's end", (1, 10, 100, 1e3, 1e4, 1e5, 1e6),
        lambda r: chain(20, 0.25, 30.0, last_mass=r), swinging,
    ),
    Axis(
        "timestep, tower of 10, ms", (1, 2, 5, 10, 20, 50, 100), lambda ms: stack(10), stacked, lambda ms: 1e-3 * ms
    ),
    Axis(
        "timestep, chain of 20, ms", (1, 2, 5, 10, 20, 50, 100), lambda ms: chain(20, 0.25, 30.0), swinging,
        lambda ms: 1e-3 * ms,
    ),
    Axis("stiffness of a jelly, Hz", (1, 3, 10, 30, 100, 300, 1000), lambda f: jelly(4, 3, frequency=f), springy),
    Axis("overlap of ten boxes, part", (0.001, 0.01, 0.05, 0.1, 0.2, 0.5, 0.9), deep, pushed_apart),
    Axis("distance from the origin, m", (1, 1e2, 1e4, 1e5, 1e6, 1e7, 1e8), far_away, stacked),
    Axis("spin of three bars, rad/s", (1, 3, 10, 30, 100, 300, 1000), spinning, swinging),
)  # fmt: skip


@dataclass(frozen=True)
class Line:
    """Errors of one fidelity along one axis; None: not finite."""

    axis: str
    values: Sequence[float]
    fidelity: str
    errors: Sequence[float | None]


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--random", type=not_negative, default=0, metavar="N", help="measure random jointed scenes as well"
    )
    parser.add_argument("--processes", type=positive, default=1, help="for the random scenes")


def measure(run: Run) -> dict[str, Any]:
    chosen = slice(0, 5, 2) if run.quick else slice(None)
    lines = []
    with progress_bar("compiling", len(AXES) * len(FIDELITIES)) as bar:
        for axis in AXES:
            bar.describe(axis.title)
            for fidelity in FIDELITIES:
                values = axis.values[chosen]
                lines.append(Line(axis.title, values, fidelity, [error_of(axis, value, fidelity) for value in values]))
                bar.advance()
    scenes = random_scenes(run.options.random, run.options.processes) if run.options.random else {}
    return {"lines": packed(lines), "random": scenes}


def error_of(axis: Axis, value: float, fidelity: str) -> float | None:
    options = Options.preset(fidelity, timestep=axis.timestep(value), sleep=False)
    error = axis.error(World(axis.scene(value), options=options))
    return error if math.isfinite(error) else None


# ---------------------------------------------------------------- random scenes


@dataclass(frozen=True)
class Summary:
    """Outcomes of a category of random scenes.

    ``excess`` is None where something drives all of them, ``speed`` where nothing drives any.
    """

    category: str
    scenes: int
    broken: int
    excess: float | None
    speed: float | None


def run_random(seed: int) -> Outcome:
    return run_case(random_jointed_case(seed), STEPS)


def random_scenes(count: int, processes: int) -> dict[str, Any]:
    """Run random scenes; return summaries by category, and descriptions of what was broken."""
    outcomes = in_processes(run_random, range(count), processes, "random jointed scenes")
    groups = {category: [o for o in outcomes if o.category == category] for category in CATEGORIES}
    return {
        "count": count,
        "summaries": packed(summary(category, group) for category, group in groups.items() if group),
        "broken": [line for line in map(problems, outcomes) if line],
    }


def summary(category: str, group: Sequence[Outcome]) -> Summary:
    excess = max((o.excess for o in group if not math.isnan(o.excess)), default=None)
    speed = max((o.speed for o in group if math.isnan(o.excess)), default=None)
    return Summary(category, len(group), sum(bool(problems(o)) for o in group), excess, speed)


# ---------------------------------------------------------------- report


def report(results: Mapping[str, Any]) -> Report:
    lines = unpacked(Line, results["lines"])
    parts: list[Part] = [
        f"Each cell has the error of a run of {SECONDS:g} s, relative or in heights of a box. A run whose error is "
        f"above {BROKEN:g} or not finite is called broken.",
        Picture("Error of each fidelity along each axis", partial(draw, lines)),
        axes_table(lines),
    ]
    scenes = results["random"]
    if scenes:
        parts += [
            f"## {scenes['count']} random jointed scenes of {STEPS} steps",
            f"A scene is called broken if a number is not finite, if the energy rises above its start by {LIMIT:g} of"
            " its scale, or if a body is faster than its drive allows.",
            random_table(unpacked(Summary, scenes["summaries"])),
            *(f"**{line}**" for line in scenes["broken"]),
        ]
    return Report("Where each fidelity holds", parts)


def axes_table(lines: Sequence[Line]) -> Table:
    rows = []
    for k, line in enumerate(lines):
        if k % len(FIDELITIES) == 0:
            rows.append([f"**{line.axis}**", "", *(f"**{value:g}**" for value in line.values)])
        rows.append(["", line.fidelity, *map(error_cell, line.errors)])
    return Table(["axis", "fidelity", *(str(k + 1) for k in range(len(lines[0].values)))], rows, words=2)


def error_cell(error: float | None) -> str:
    return "broken" if error is None or error > BROKEN else f"{error:.0e}"


def random_table(summaries: Sequence[Summary]) -> Table:
    rows = []
    for s in summaries:
        excess = "driven" if s.excess is None or s.speed is not None else f"{s.excess:.1e}"
        rows.append([s.category, str(s.scenes), str(s.broken), excess, "-" if s.speed is None else f"{s.speed:.2f}"])
    return Table(["category", "scenes", "broken", "largest energy excess", "largest speed over the drive's"], rows)


def draw(lines: Sequence[Line]) -> Figure:
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Rectangle

    from benchmarks.common.plots import plt

    colors = ListedColormap(["#1a7f5a", "#58b06d", "#b5d56a", "#f3d35b", "#ee8e4a", "#c8434a"])
    edges = [-5.0, -4.0, -3.0, -2.0, -1.0]
    figure, panels = plt.subplots(1, len(FIDELITIES), figsize=(15, 6.4), sharey=True, layout="constrained")
    for panel, name in zip(panels, FIDELITIES, strict=True):
        chosen = [line for line in lines if line.fidelity == name]
        errors = np.array([[math.inf if error is None else error for error in line.errors] for line in chosen])
        panel.imshow(np.digitize(np.log10(np.maximum(errors, 1e-12)), edges), cmap=colors, vmin=-0.5, vmax=5.5,
                     aspect="auto")  # fmt: skip
        for i, line in enumerate(chosen):
            for k, value in enumerate(line.values):
                panel.text(k, i, f"{value:g}", ha="center", va="center", fontsize=9, color="#222222")
        panel.set_title(name, fontsize=13)
        panel.set_xticks([])
        panel.set_yticks(range(len(chosen)), [line.axis for line in chosen])
        for side in panel.spines.values():
            side.set_visible(False)
    handles = [Rectangle((0, 0), 1, 1, color=colors(i)) for i in range(6)]
    labels = ["< 1e-5", "< 1e-4", "< 1e-3", "< 1e-2", "< 0.1", "broken"]
    figure.legend(handles, labels, ncols=6, loc="outside lower center", frameon=False, title="error")
    figure.suptitle("Where each fidelity holds: the number is the value of the axis, the colour its error", fontsize=14)
    return figure
