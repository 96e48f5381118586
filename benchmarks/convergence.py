"""The observed order of convergence: errors against the timestep on scenes with known answers.

    python -m benchmarks.convergence [--quick] [--output docs]

Default options, two substeps, timesteps of 1/30 to 1/480 s. Each error is the largest over all steps against
a closed form or, for pendulums, a Runge-Kutta solution of their own equations of motion.  The order is the slope
of a least-squares line through log(error) over log(timestep), of errors above rounding.
Writes convergence.md, convergence.png and convergence.json; a minute, most of it compiling.
"""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.markdown import Markdown
from rich.progress import Progress

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from gsenv.scenes import (
    bouncing_balls,
    box_on_incline,
    chain,
    cradle,
    disk_on_incline,
    double_pendulum,
    pendulum,
    projectile,
    sliding_disk,
    spring_mass,
)
from gsenv.solver import Box, Circle, HalfPlane, Options, Scene, World
from gsenv.solver.jit import mute_compile_notice

Array = NDArray[np.float64]
G = 9.81
RATES = (30, 60, 120, 240, 480)  # steps in a second
QUICK_RATES = (60, 120, 240)
FINE = 3840  # Runge-Kutta steps in a second: its errors are below 1e-11
ROUNDING = 1e-12  # m, rad or part: errors below are "exact"
SPEEDS = np.linspace(1.7, 2.3, 8)  # m/s: sliding ends at different parts of a step


@dataclass(frozen=True)
class Case:
    """A scene, what is measured in it, and the order to be seen."""

    group: str
    scene: str
    quantity: str
    measure: Callable[[int], float]  # steps in a second -> error
    order: float | None  # expected; None: exact
    limit: str  # what limits it


@dataclass(frozen=True)
class Result:
    group: str
    scene: str
    quantity: str
    errors: tuple[float, ...]
    order: float | None  # observed; None: exact
    expected: float | None
    limit: str


def observed_order(rates: Iterable[int], errors: Iterable[float]) -> float | None:
    """Slope of log(error) over log(timestep) above rounding; None where fewer than three errors are."""
    points = [(-math.log(rate), math.log(error)) for rate, error in zip(rates, errors, strict=True) if error > ROUNDING]
    if len(points) < 3:
        return None
    log_timestep, log_error = zip(*points, strict=True)
    return float(np.polyfit(log_timestep, log_error, 1)[0])


# ---------------------------------------------------------------- measures


def world_at(scene: Scene, rate: int) -> World:
    return World(scene, options=Options(timestep=1.0 / rate, sleep=False))


def worst(world: World, seconds: float, error: Callable[[float], float]) -> float:
    """Largest of ``error(time)`` after each step."""
    largest = 0.0
    for _ in range(round(seconds / world.timestep)):
        world.step()
        largest = max(largest, abs(error(float(world.time[0]))))
    return largest


def free_flight(rate: int) -> float:
    world = world_at(projectile((5.0, 7.0), 3.0), rate)

    def error(t: float) -> float:
        x, y = world.position[0, 0]
        return max(abs(x - 5.0 * t), abs(y - 1.0 - 7.0 * t + 0.5 * G * t * t), abs(world.angle[0, 0] - 3.0 * t))

    return worst(world, 2.0, error)


def drag(rate: int) -> float:
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("ball", shapes=[Circle(radius=0.1)], linear_velocity=(1.0, 0.0), linear_damping=1.0)
    world = world_at(scene, rate)
    return worst(world, 2.0, lambda t: world.position[0, 0, 0] - (1.0 - math.exp(-t)))


def ellipse(rate: int) -> float:
    """x = cos(w t), y = (2/w) sin(w t) on a spring of no relaxed length, w = pi."""
    omega = math.pi
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("sun", "static")
    disk = Circle(radius=0.1)
    scene.add_body("ball", shapes=[disk], mass=1.0, position=(1.0, 0.0), linear_velocity=(0.0, 2.0))
    middle = (0.0, 0.0)
    scene.add_joint(
        "spring", "distance", "sun", "ball", anchor_a=middle, anchor_b=middle, length=0.0, stiffness=omega**2
    )
    world = world_at(scene, rate)

    def error(t: float) -> float:
        x, y = world.position[0, 1]
        return math.hypot(x - math.cos(omega * t), y - 2.0 / omega * math.sin(omega * t))

    return worst(world, 2.0, error)


def travelled(scene: Scene, acceleration: float, rate: int) -> float:
    world = world_at(scene, rate)
    start = world.position[0, 1]
    return worst(world, 2.0, lambda t: math.hypot(*(world.position[0, 1] - start)) - 0.5 * acceleration * t * t)


def slide_down(rate: int) -> float:
    alpha = math.radians(35.0)
    return travelled(box_on_incline(35.0), G * (math.sin(alpha) - 0.5 * math.cos(alpha)), rate)


def roll_down(rate: int) -> float:
    return travelled(disk_on_incline(20.0), 2.0 / 3.0 * G * math.sin(math.radians(20.0)), rate)


def slide_to_rest(rate: int) -> float:
    """Worst of several speeds: v^2 / (2 mu g)."""
    errors = []
    for speed in SPEEDS:
        scene = Scene()
        scene.add_body("ground", "static", [HalfPlane(friction=0.3)])
        box = Box(half_extents=(0.25, 0.1), friction=0.3)
        scene.add_body("box", shapes=[box], position=(0.0, 0.1), linear_velocity=(speed, 0.0))
        world = world_at(scene, rate)
        world.step(rate)
        errors.append(abs(world.position[0, 1, 0] - speed**2 / (0.6 * G)))
    return max(errors)


def slide_to_roll(rate: int) -> float:
    """Worst of several speeds: sliding ends at v / (3 mu g), rolling has 2/3 v."""
    errors = []
    for speed in SPEEDS:
        world = world_at(sliding_disk(speed), rate)
        world.step(rate)
        t = speed / (0.9 * G)
        expected = speed * t - 0.15 * G * t * t + 2.0 / 3.0 * speed * (1.0 - t)
        errors.append(abs(world.position[0, 1, 0] - expected))
    return max(errors)


def bounces(rate: int) -> float:
    """Height of the lowest point over three apexes, e = .8, dropped from 1 m."""
    world = world_at(bouncing_balls([0.8]), rate)
    fall = math.sqrt(2.0 / G)

    def error(t: float) -> float:
        since, speed = t + fall, G * fall  # as if thrown up from the ground
        while since > 2.0 * speed / G:
            since -= 2.0 * speed / G
            speed *= 0.8
        return float(world.position[0, 1, 1] - 0.1 - speed * since + 0.5 * G * since * since)

    return worst(world, 2.2, error)


def oblique_bounce(rate: int) -> float:
    """Spin of a ball that slides all through its impact, over the closed form; worst of several heights.

    Friction takes mu (1 + e) of the normal speed u from the motion, which gives the spin 2 mu (1 + e) u / r.
    """
    mu, e, radius = 0.2, 0.7, 0.1
    errors = []
    for height in np.linspace(0.8, 1.2, 8):
        scene = Scene()
        scene.add_body("ground", "static", [HalfPlane(friction=mu)])
        ball = Circle(radius=radius, friction=mu, restitution=e)
        place = (0.0, height + radius)
        scene.add_body("ball", shapes=[ball], position=place, linear_velocity=(9.0, 0.0))
        world = world_at(scene, rate)
        world.step(round(0.6 * rate))
        spin = 2.0 * mu * (1.0 + e) * math.sqrt(2.0 * G * height) / radius
        errors.append(abs(-world.angular_velocity[0, 1] / spin - 1.0))
    return max(errors)


def cradle_heights(rate: int) -> float:
    """As many of five touching balls out as come in, to the same height, the others at rest; parts of that height."""
    errors = []
    for raised in (1, 2, 3, 4):
        world = world_at(cradle(raised), rate)
        world.step(round(0.9 * rate))
        angle, spin = world.angle[0, 1:], world.angular_velocity[0, 1:]
        inertia = 1.0 + world.parameters.inertia[0, 1:] / world.parameters.mass[0, 1:]  # about the hinge, over the mass
        heights = (1.0 - np.cos(angle) + inertia * spin**2 / (2.0 * G)) / (1.0 - math.cos(math.radians(30.0)))
        errors.append(np.abs(heights - (np.arange(5) >= 5 - raised)).max())
    return float(max(errors))


def swing(state: Array) -> Array:
    """A uniform rod of 1 m: (angle, rate)."""
    return np.array([state[1], -1.5 * G * math.sin(state[0])])


def double_swing(state: Array) -> Array:
    """Two uniform rods of 1 m and equal masses: angles a, b from hanging and their rates, from Lagrange's equations."""
    a, b, p, q = state
    c, s = math.cos(a - b), math.sin(a - b)
    mass = np.array([[4.0 / 3.0, 0.5 * c], [0.5 * c, 1.0 / 3.0]])
    force = (-0.5 * q * q * s - 1.5 * G * math.sin(a), 0.5 * p * p * s - 0.5 * G * math.sin(b))
    return np.array([p, q, *np.linalg.solve(mass, force)])


@cache
def runge_kutta(derivative: Callable[[Array], Array], start: tuple[float, ...], seconds: float) -> Array:
    """States at FINE per second, from the start on."""
    h, states = 1.0 / FINE, [np.array(start)]
    for _ in range(round(seconds * FINE)):
        x = states[-1]
        k1 = derivative(x)
        k2 = derivative(x + 0.5 * h * k1)
        k3 = derivative(x + 0.5 * h * k2)
        k4 = derivative(x + h * k3)
        states.append(x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    return np.array(states)


def pendulum_angle(rate: int) -> float:
    world = world_at(pendulum(90.0), rate)
    exact = runge_kutta(swing, (0.5 * math.pi, 0.0), 2.0)

    def error(t: float) -> float:
        x, y = world.center_of_mass[0, 1]
        return math.atan2(x, -y) - exact[round(t * FINE), 0]

    return worst(world, 2.0, error)


def double_pendulum_place(rate: int) -> float:
    """Of the lower rod's middle."""
    world = world_at(double_pendulum(90.0), rate)
    exact = runge_kutta(double_swing, (0.5 * math.pi, 0.5 * math.pi, 0.0, 0.0), 1.0)

    def error(t: float) -> float:
        a, b = exact[round(t * FINE), :2]
        x, y = world.center_of_mass[0, 2]
        return math.hypot(x - math.sin(a) - 0.5 * math.sin(b), y + math.cos(a) + 0.5 * math.cos(b))

    return worst(world, 1.0, error)


def chain_energy(rate: int) -> float:
    world = world_at(chain(20, 0.25, 30.0), rate)
    start = world.diagnostics().energy[0]
    scale = 20.0 * G * 20 * 0.25  # m g L
    return worst(world, 2.0, lambda t: float(world.diagnostics().energy[0] - start) / scale)


def oscillation(ratio: float, rate: int) -> float:
    """Of 2 Hz, over the amplitude."""
    world = world_at(spring_mass(2.0, ratio), rate)
    omega = 4.0 * math.pi
    damped = omega * math.sqrt(1.0 - ratio**2)
    sag = G / omega**2
    amplitude = 0.1 - sag

    def error(t: float) -> float:
        shape = math.cos(damped * t) + ratio * omega / damped * math.sin(damped * t)
        return (-1.0 - sag - world.position[0, 1, 1]) / amplitude - math.exp(-ratio * omega * t) * shape

    return worst(world, 2.5, error)


TURNING = "joint rows of one direction for each substep, that of its middle"
EVENT = "one friction impulse for the substep in which sliding ends"
EXACT = "nothing: velocity is linear in time"
ITS_TIME = "nothing: impacts come at their own times"
CASES = (
    Case("smooth motion", "spinning flight", "place m, angle rad", free_flight, None, EXACT),
    Case("smooth motion", "drag of 1/s", "place m", drag, 1.0, "damping is one implicit Euler factor"),
    Case("smooth motion", "ellipse on a spring", "place m", ellipse, 2.0, "the spring turns within a substep"),
    Case("smooth motion", "oscillator", "height, part", lambda rate: oscillation(0.0, rate), None,
         "nothing: discrete map of the closed form"),
    Case("smooth motion", "oscillator, damped", "height, part", lambda rate: oscillation(0.2, rate), 2.0,
         "frequency and decay are exact, amplitude and phase are not"),
    Case("sliding", "block down 35 deg", "distance m", slide_down, 2.0, "settling: nanometres"),
    Case("sliding", "disk rolls down 20 deg", "distance m", roll_down, None, EXACT),
    Case("sliding", "block slides to rest", "place m", slide_to_rest, 2.0, EVENT),
    Case("sliding", "disk slides, then rolls", "place m", slide_to_roll, 2.0, EVENT),
    Case("impact", "ball, e = .8", "height m", bounces, None, ITS_TIME),
    Case("impact", "oblique ball", "spin, part", oblique_bounce, None, ITS_TIME),
    Case("impact", "cradle of five", "heights, part", cradle_heights, 2.0, "joints; contacts are found once a step"),
    Case("joints", "pendulum, 90 deg", "angle rad", pendulum_angle, 2.0, TURNING),
    Case("joints", "double pendulum", "place m", double_pendulum_place, 2.0, TURNING),
    Case("joints", "chain of 20", "energy, part of m g L", chain_energy, 2.0, TURNING),
)  # fmt: skip
GROUPS = ("smooth motion", "sliding", "impact", "joints")
COLORS = ("#1f77b4", "#d1701f", "#7a4fbf", "#17a2a2")


def measure(cases: Iterable[Case], rates: tuple[int, ...]) -> list[Result]:
    results = []
    for case in cases:
        errors = tuple(case.measure(rate) for rate in rates)
        order = observed_order(rates, errors)
        results.append(Result(case.group, case.scene, case.quantity, errors, order, case.order, case.limit))
    return results


# ---------------------------------------------------------------- reporting


def order_text(order: float | None) -> str:
    return "exact" if order is None else f"{order:.2f}"


def report(results: list[Result], rates: tuple[int, ...]) -> str:
    header = ["", "scene", "error of", *(f"1/{rate} s" for rate in rates), "order", "expected", "what limits it"]
    lines = [header, ["---"] * len(header)]
    for r in results:
        expected = "exact" if r.expected is None else f"{r.expected:g}"
        errors = (f"{e:.1e}" for e in r.errors)
        lines.append([r.group, r.scene, r.quantity, *errors, order_text(r.order), expected, r.limit])
    parts = [
        "# Observed order of convergence",
        "`python -m benchmarks.convergence`: default options, two substeps of half a timestep each. Errors are the "
        "largest over all steps, or over several speeds or heights where an event falls into a step; against closed "
        "forms, and for pendulums against a Runge-Kutta solution of their equations of motion.",
        "The order is the slope of log(error) over log(timestep), fitted to all errors above "
        f"{ROUNDING:g}; \"exact\" is rounding at every timestep.",
        "\n".join("| " + " | ".join(line) + " |" for line in lines),
        "![error against timestep](convergence.png)",
    ]
    return "\n\n".join(parts) + "\n"


def plot(results: list[Result], rates: tuple[int, ...], path: Path) -> None:
    figure, panels = plt.subplots(1, len(GROUPS), figsize=(15, 5.4), sharey=True, layout="constrained")
    for axes, group in zip(panels, GROUPS, strict=True):
        draw_panel(axes, [r for r in results if r.group == group], rates)
        axes.set_title(group, fontsize=12, loc="left")
    panels[0].set_ylabel("error (m, rad or part of the whole)")
    title = "Error against timestep, and the observed order of convergence (grey: slopes 1 and 2)"
    figure.suptitle(title, fontsize=13, x=0.01, ha="left")
    figure.savefig(path.with_suffix(".tmp.png"), dpi=110)
    os.replace(path.with_suffix(".tmp.png"), path)


def draw_panel(axes: Axes, results: list[Result], rates: tuple[int, ...]) -> None:
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
    axes.grid(color="#efefef")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def write(path: Path, text: str) -> None:
    """The whole file or none of it."""
    draft = path.with_name(path.name + ".tmp")
    draft.write_text(text, encoding="utf-8")
    os.replace(draft, path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=f"timesteps of 1 / {QUICK_RATES} s only")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "docs")
    arguments = parser.parse_args()
    mute_compile_notice()
    console = Console()
    rates = QUICK_RATES if arguments.quick else RATES
    with Progress(console=console) as progress:
        results = measure(progress.track(CASES, description="measuring"), rates)
    text = report(results, rates)
    console.print(Markdown(text))
    folder = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    figures: dict[str, Any] = {"rates": rates, "results": [asdict(r) for r in results]}
    write(folder / "convergence.json", json.dumps(figures, indent=1) + "\n")
    write(folder / "convergence.md", text)
    plot(results, rates, folder / "convergence.png")
    console.print(f"wrote {folder}/convergence.md, .png and .json")


if __name__ == "__main__":
    main()
