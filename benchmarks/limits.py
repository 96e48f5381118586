"""What the solver takes: resting boxes and flying balls at extreme sizes, masses, speeds, timesteps and forces.

Each scene is run in 2D and 3D with the default options. The ranges in which a World stays silent, warns or refuses are
read from the code.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.api.options import MOST
from gsenv.solver.api.ranges import HALF_WIDTH, MASS_RATIO, TIMESTEP
from gsenv.solver.specification.check import LARGEST, SMALLEST

SECONDS = 2.0  # simulated
BROKEN = 0.1  # half-widths
PASSED = 1.0


@dataclass(frozen=True)
class Outcome:
    """One run: ``error`` in half-widths of the boxes, or PASSED where a ball has passed a wall; -1 is not finite."""

    quantity: str
    dim: int
    value: float
    error: float


@dataclass(frozen=True)
class Axis:
    """A quantity with its values and the run that measures the error at each."""

    values: tuple[float, ...]
    run: Callable[[int, float], float]


def up(dim: int, height: float, x: float = 0.0) -> tuple[float, ...]:
    return (x, height) if dim == 2 else (x, 0.0, height)


def grounded(dim: int, gravity: float = 9.81) -> Scene:
    scene = Scene(dim=dim, gravity=up(dim, -gravity))
    scene.add_body("ground", "static", [planar.HalfPlane() if dim == 2 else spatial.Plane()])
    return scene


def box(dim: int, half: float) -> Any:
    return planar.Box(half_extents=(half,) * 2) if dim == 2 else spatial.Box(half_extents=(half,) * 3)


def resting(
    dim: int, half: float = 0.5, ratio: float = 1.0, timestep: float = 1 / 60, gravity: float = 9.81, x: float = 0.0
) -> float:
    """Return the error of two boxes on each other: the largest overlap or displacement, in half-widths."""
    scene = grounded(dim, gravity)
    for k, mass in enumerate((1.0, ratio)):
        scene.add_body(f"box_{k}", shapes=[box(dim, half)], mass=mass, position=up(dim, half * (1 + 2 * k), x))
    world = World(scene, options=Options(timestep=timestep))
    start = world.position
    world.step(min(round(SECONDS / timestep) + 1, 2000))
    moved = float(np.abs(world.position - start).max())
    return max(float(world.diagnostics().penetration.max()), moved) / half


def thrown(dim: int, speed: float, continuous: bool) -> float:
    """Return PASSED if a ball of 0.1 m passes a wall that is 0.2 m thick, and 0 if it does not."""
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    wall = (0.1, 50.0) if dim == 2 else (0.1, 50.0, 50.0)
    shape = planar.Box(half_extents=wall) if dim == 2 else spatial.Box(half_extents=wall)
    ball = planar.Circle(radius=0.1) if dim == 2 else spatial.Sphere(radius=0.1)
    scene.add_body("wall", "static", [shape])
    velocity = up(dim, 0.0, speed)
    scene.add_body("ball", shapes=[ball], position=up(dim, 0.0, -1.3), linear_velocity=velocity, continuous=continuous)
    world = World(scene)
    world.step(int(3.0 / (speed * world.timestep)) + 5)
    place = float(world.position[0, 1, 0])
    return PASSED if place > 0.0 else 0.0 if np.isfinite(place) else float("nan")


def flung(dim: int, speed: float) -> float:
    """Return the largest gain of energy of a chain whose last body is thrown, over that body's energy.

    A box hangs on a hinge, the next on a sprung weld, the next on a pivot, the last on a rope of 0.2 m.
    """
    scene = Scene(dim=dim)
    scene.add_body("hook", "static", position=up(dim, 0.0))
    names = [f"link_{k}" for k in range(4)]
    for k, name in enumerate(names):
        velocity = up(dim, -0.6 * speed, 0.8 * speed) if name == names[-1] else up(dim, 0.0)
        scene.add_body(name, shapes=[box(dim, 0.05)], position=up(dim, -0.2 * (k + 1)), linear_velocity=velocity)
    if dim == 2:
        scene.add_joint("hinge", planar.Revolute("hook", names[0], anchor=(0.0, -0.1)))
        scene.add_joint("pivot", planar.Revolute(names[1], names[2], anchor=(0.0, -0.5)))
    else:
        scene.add_joint("hinge", spatial.Hinge("hook", names[0], anchor=up(3, -0.1), axis=(0.0, 1.0, 0.0)))
        scene.add_joint("pivot", spatial.Ball(names[1], names[2], anchor=up(3, -0.5)))
    joints = planar if dim == 2 else spatial
    scene.add_joint("weld", joints.Weld(names[0], names[1], frequency=4.0, damping_ratio=0.3))
    scene.add_joint("rope", joints.Distance(names[2], names[3], limits=(0.0, 0.2)))
    world = World(scene)
    start = world.diagnostics()
    gain = 0.0
    for _ in range(round(SECONDS / world.timestep)):
        world.step()
        gain = max(gain, float((world.diagnostics().energy - start.energy)[0]))
    finite = world.diagnostics().finite[0]
    return gain / float(start.kinetic_energy[0]) if finite else float("nan")


def pushed(dim: int, force: float) -> float:
    """Return 0 if a box of 1 kg has a finite state 2 s after a force has acted on it for one step, else NaN."""
    scene = grounded(dim)
    scene.add_body("box", shapes=[box(dim, 0.5)], mass=1.0, position=up(dim, 0.5))
    world = World(scene)
    world.apply_force("box", force=(force,) * dim)
    world.step(120)
    return 0.0 if np.isfinite(world.position).all() and np.isfinite(world.linear_velocity).all() else float("nan")


AXES = {
    "half-width of two boxes, m": Axis(
        (1e-6, 1e-5, 1e-4, 5e-4, 1e-2, 1.0, 1e2, 1e4, 1e6), lambda dim, x: resting(dim, half=x)
    ),
    "mass of the upper box over that of the lower": Axis(
        (1e-6, 1e-3, 1.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8), lambda dim, x: resting(dim, ratio=x)
    ),
    "timestep, s": Axis(
        (1e-5, 1e-4, 1e-3, 1e-2, 1 / 50, 1 / 20, 0.1, 0.5, 1.0), lambda dim, x: resting(dim, timestep=x)
    ),
    "gravity, m/s^2": Axis((1e-6, 1e-3, 0.1, 9.81, 1e2, 1e3, 1e4, 1e5, 1e6), lambda dim, x: resting(dim, gravity=x)),
    "distance from the origin, m": Axis(
        (1.0, 1e3, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e12), lambda dim, x: resting(dim, x=x)
    ),
    "speed of a ball of 0.1 m at a wall of 0.2 m, m/s": Axis(
        (1.0, 5.0, 10.0, 20.0, 50.0, 1e2, 1e3, 1e4, 1e6), lambda dim, x: thrown(dim, x, False)
    ),
    "the same with continuous=True": Axis(
        (1.0, 5.0, 10.0, 20.0, 50.0, 1e2, 1e3, 1e4, 1e6), lambda dim, x: thrown(dim, x, True)
    ),
    "speed of the last of four linked boxes, m/s": Axis((1.0, 10.0, 30.0, 1e2, 3e2, 1e3, 1e4, 1e6, 1e9), flung),
    "force on a box of 1 kg, N": Axis((1.0, 1e3, 1e6, 1e9, 1e12, 1e18, 1e24, 1e30, 1e36), pushed),
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """No options of its own."""


def measure(run: Run) -> dict[str, Any]:
    outcomes = []
    cases = [(name, axis, dim, value) for name, axis in AXES.items() for dim in (2, 3) for value in axis.values]
    if run.quick:
        cases = cases[::4]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the ranges that are left here on purpose
        for name, axis, dim, value in track(cases, "limits", len(cases)):
            error = axis.run(dim, value)
            outcomes.append(Outcome(name, dim, value, error if np.isfinite(error) else -1.0))
    return {"outcomes": packed(outcomes)}


def report(results: Mapping[str, Any]) -> Report:
    outcomes = unpacked(Outcome, results["outcomes"])
    rows = []
    for name in dict.fromkeys(outcome.quantity for outcome in outcomes):
        chosen = [outcome for outcome in outcomes if outcome.quantity == name]
        values = list(dict.fromkeys(outcome.value for outcome in chosen))
        width = max(len(axis.values) for axis in AXES.values())
        rows.append([f"**{name}**", *(f"**{value:.3g}**" for value in values), *[""] * (width - len(values))])
        for dim in (2, 3):
            cells = {outcome.value: _cell(outcome) for outcome in chosen if outcome.dim == dim}
            rows.append([f"{dim}D", *(cells.get(value, "") for value in values), *[""] * (width - len(values))])
    table = Table(["quantity", *map(str, range(1, len(rows[0])))], rows)
    return Report("Limits", [_MEASURED, table, *_RANGES])


def _cell(outcome: Outcome) -> str:
    if outcome.error < 0.0:
        return "not finite"
    if "wall" in outcome.quantity or "continuous" in outcome.quantity:
        return "passes" if outcome.error == PASSED else "held"
    if "force" in outcome.quantity:
        return "finite"
    return "broken" if outcome.error > BROKEN else f"{outcome.error:.0e}"


_MEASURED = (
    f"What the solver takes, in 2D and 3D with the default options. Two boxes lie on each other and on the ground for "
    f"{SECONDS:g} s or 2000 steps; a cell has the largest overlap or displacement in half-widths, and above {BROKEN:g} "
    "of them the run is called broken. A ball that is thrown at a wall is held by it or passes. A hinge, a sprung "
    "weld, a pivot and a rope make a chain of four boxes of 0.1 m, of which the last is thrown; a cell has the largest "
    f"gain of energy, divided by that of the throw, above {BROKEN:g} broken. No run ended with an error. "
    "`World.diagnostics()` reports overlaps and sweeps that ran out with `penetration` and `unconverged`; boxes "
    "that move where they should rest, as the smallest ones and those under the largest gravity do, are not reported. "
    "[Where each fidelity holds](stability.md) has towers, chains and stiffnesses at "
    "each fidelity, [How a step works](method.md) the known limits of the method."
)
_RANGES = (
    "## Silent, warned, refused",
    f"- A World warns once of a mass ratio above {MASS_RATIO:g}, of a half-width below {HALF_WIDTH:g} m and of a "
    f"timestep above 1/{1 / TIMESTEP:.0f} s, and goes on. It warns of a world in which a position or velocity has "
    'become NaN or infinite ("not finite" above); the bodies of such a world stay as they are until it is reset or '
    "restored, the others go on bit for bit, and `diagnostics().finite` tells which it is.\n"
    f"- Numbers beyond {LARGEST:g} in magnitude, and positive ones below {SMALLEST:g}, are refused in one sentence "
    "wherever a number is given: their squares or products could overflow. So are NaN, infinity (but as a bound of a "
    "force or of a limit), texts and truth values in place of numbers. Nothing has changed then.\n"
    f"- Options: at most {MOST['substeps']} `substeps` and `max_substeps`, {MOST['sweeps']} `sweeps` and "
    f"`position_sweeps`, {MOST['halvings']} `halvings`.\n"
    "- Pictures and observed pixels: 16 to 8192 px a side in environments, 1 to 8192 px in scenes; MP4 needs even "
    "sides.\n"
    "- A 2D polygon has 3 to 64 corners, a 3D hull up to 64, a heightfield up to a million heights; a user constraint "
    "has up to 3 rows in 2D and 6 in 3D.",
    "## Threads, Ctrl-C and files",
    "- One thread at a time may use a World, a renderer or an environment; a second one gets a RuntimeError, and "
    "nothing is changed. `World(threads=...)` shares the worlds out over threads itself.\n"
    "- Ctrl-C ends `World.step(10**7)` within 0.2 s, or after the present step if that takes longer. All worlds have "
    "then taken the same number of steps and continue bit for bit.\n"
    "- Files are written beside the old ones, which are replaced once the new ones are complete on the disk. After a "
    "full disk, an error, SIGTERM or SIGHUP (a closed terminal) the old file is as it was, nothing else is left, and "
    "commands end with exit code 1 and one sentence (SIGTERM: 143, SIGHUP: 129). Other signals that end a process at "
    "once, such as SIGKILL and SIGQUIT, may leave a hidden file or folder beside the target.",
)
