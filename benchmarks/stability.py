"""Where each fidelity holds: error over mass ratio, height, length, timestep, stiffness, overlap, distance, spin.

python -m benchmarks.stability              the map, docs/stability.png and .md
python -m benchmarks.stability --random 10000 --processes 2     random jointed scenes as well

A run is called broken where its error exceeds 10 % or a number is not finite.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from rich.console import Console
from rich.progress import track

from gsenv.scenes import chain, jelly, mass_ratio_stack, stack
from gsenv.solver import Box, Options, Scene, World
from tests.stress.jointed import CATEGORIES, random_jointed_case
from tests.stress.measure import LIMIT, Outcome, problems, run_case

FIDELITIES = ("fast", "balanced", "accurate")
SECONDS = 5.0
BROKEN = 0.1
STEPS = 300  # of a random scene


def overlap_or_height(world: World, start: np.ndarray) -> float:
    """Deepest overlap or change of height over a box."""
    moved = np.abs(world.position[0] - start)[1:, 1].max()
    return float(max(world.diagnostics().penetration[0], moved))


def stacked(world: World) -> float:
    start = world.position[0].copy()
    world.step(round(SECONDS / world.timestep))
    return overlap_or_height(world, start)


def swinging(world: World, link: float = 0.25) -> float:
    """Joint error over a link, or drift of the energy over its scale, whichever is worst at any time."""
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
    """Energy gained over the start, and how far from its shape the block ends, over its width."""
    start = float(world.diagnostics().energy[0])
    width = float(np.ptp(world.position[0, 1:, 0]))
    most = -math.inf
    for _ in range(round(SECONDS / world.timestep / 5)):
        world.step(5)
        most = max(most, float(world.diagnostics().energy[0]) - start)
    mass = float(world.parameters.mass[0, 1:].sum())
    shape = abs(float(np.ptp(world.position[0, 1:, 0])) / width - 1.0)
    return max(most / (mass * 9.81 * 2.5), 0.1 * shape, 1e-9)


def deep(part: float) -> Scene:
    """Ten boxes, each ``part`` of a box inside the one below."""
    scene = stack(10)
    for k in range(10):
        scene.bodies[f"box_{k}"].position[1] = 0.5 + k * (1.0 - part)
    return scene


def pushed_apart(world: World) -> float:
    """Overlap left, or how far above its own height the tower was thrown."""
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
    """Three bars pinned end to end that turn as one in space."""
    scene = Scene(gravity=(0.0, 0.0))
    for k in range(3):
        bar = Box(half_extents=(0.125, 0.02))
        place = (0.25 * k - 0.25, 0.0)
        scene.add_body(
            f"bar_{k}", shapes=[bar], position=place, linear_velocity=(0.0, speed * place[0]), angular_velocity=speed
        )
        if k:
            scene.add_joint(f"pin_{k}", "revolute", f"bar_{k - 1}", f"bar_{k}", anchor=(0.25 * k - 0.375, 0.0))
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


def measure() -> dict[str, np.ndarray]:
    """Errors (axis, value) of each fidelity."""
    errors = {name: np.zeros((len(AXES), len(AXES[0].values))) for name in FIDELITIES}
    jobs = [(i, k, name) for i, axis in enumerate(AXES) for k in range(len(axis.values)) for name in FIDELITIES]
    for i, k, name in track(jobs, "runs"):
        axis, value = AXES[i], AXES[i].values[k]
        options = Options.preset(name, timestep=axis.timestep(value), sleep=False)
        error = axis.error(World(axis.scene(value), options=options))
        errors[name][i, k] = error if math.isfinite(error) else math.inf
    return errors


def draw(errors: dict[str, np.ndarray], path: Path) -> None:
    colors = ListedColormap(["#1a7f5a", "#58b06d", "#b5d56a", "#f3d35b", "#ee8e4a", "#c8434a"])
    edges = [-5.0, -4.0, -3.0, -2.0, -1.0]
    figure, panels = plt.subplots(1, len(FIDELITIES), figsize=(15, 6.4), sharey=True, layout="constrained")
    for panel, name in zip(panels, FIDELITIES, strict=True):
        with np.errstate(divide="ignore"):
            level = np.digitize(np.log10(np.maximum(errors[name], 1e-12)), edges)
        panel.imshow(level, cmap=colors, vmin=-0.5, vmax=5.5, aspect="auto")
        for i, axis in enumerate(AXES):
            for k, value in enumerate(axis.values):
                panel.text(k, i, f"{value:g}", ha="center", va="center", fontsize=9, color="#222222")
        panel.set_title(name, fontsize=13)
        panel.set_xticks([])
        panel.set_yticks(range(len(AXES)), [axis.title for axis in AXES])
        for side in panel.spines.values():
            side.set_visible(False)
    handles = [plt.Rectangle((0, 0), 1, 1, color=colors(i)) for i in range(6)]
    labels = ["< 1e-5", "< 1e-4", "< 1e-3", "< 1e-2", "< 0.1", "broken"]
    figure.legend(handles, labels, ncols=6, loc="outside lower center", frameon=False, title="error")
    figure.suptitle("Where each fidelity holds: the number is the value of the axis, the colour its error", fontsize=14)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".part.png")
    figure.savefig(temporary, dpi=130)
    temporary.replace(path)
    plt.close(figure)


def table(errors: dict[str, np.ndarray]) -> str:
    lines = ["| axis | fidelity | " + " | ".join(f"{k + 1}" for k in range(len(AXES[0].values))) + " |"]
    lines.append("|---" * (2 + len(AXES[0].values)) + "|")
    for i, axis in enumerate(AXES):
        lines.append(f"| **{axis.title}** | | " + " | ".join(f"**{value:g}**" for value in axis.values) + " |")
        for name in FIDELITIES:
            cells = ["broken" if e > BROKEN else f"{e:.0e}" for e in errors[name][i]]
            lines.append(f"| | {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def run_random(seed: int) -> Outcome:
    return run_case(random_jointed_case(seed), STEPS)


def random_scenes(count: int, processes: int) -> tuple[str, list[str]]:
    """A table by category, and what was broken."""
    with get_context("spawn").Pool(processes) as pool:
        results = list(track(pool.imap(run_random, range(count), chunksize=10), "random scenes", total=count))
    lines = ["| category | scenes | broken | most energy excess | most speed over its drive |", "|---|---|---|---|---|"]
    for category in CATEGORIES:
        group = [outcome for outcome in results if outcome.category == category]
        if group:
            excess = max((o.excess for o in group if not math.isnan(o.excess)), default=math.nan)
            driven = [o.speed for o in group if math.isnan(o.excess)]
            cells = (
                category, str(len(group)), str(sum(bool(problems(o)) for o in group)),
                "driven" if driven else f"{excess:.1e}", f"{max(driven):.2f}" if driven else "-",
            )  # fmt: skip
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n", [line for line in map(problems, results) if line]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=0, metavar="N", help="random jointed scenes on top")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path("docs"))
    arguments = parser.parse_args()
    console = Console()
    start = perf_counter()
    errors = measure()
    text = "# Where each fidelity holds\n\n`python -m benchmarks.stability`; errors of 5 s, see the script.\n\n"
    text += "![map](stability.png)\n\n" + table(errors)
    draw(errors, arguments.output / "stability.png")
    if arguments.random:
        made, broken = random_scenes(arguments.random, arguments.processes)
        text += f"\n## {arguments.random} random jointed scenes of {STEPS} steps\n\n"
        text += f"Broken: not finite, energy above the start by {LIMIT:g} of its scale, or too fast for its drive.\n\n"
        text += made
        for line in broken:
            console.print(f"[red]{line}")
    part = arguments.output / "stability.part.md"
    part.write_text(text)
    part.replace(arguments.output / "stability.md")
    console.print(text)
    console.print(f"{perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
