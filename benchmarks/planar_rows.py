"""Error and run time of the planar reference scenes at default options.

    taskset -c 0 python -m benchmarks.planar_rows [--json FILE]

Errors are measured in one run, times in others (step calls only, compiled before, median of five).
Bodies are kept awake unless the row says otherwise. Peers' figures: cheapest setting of the best of
Box2D 2.4 and pymunk 7 that reaches the error in brackets, from the design's measurements on one core
of another run; compare orders of magnitude, not digits.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

from gsenv.scenes import (
    bouncing_balls,
    box_on_incline,
    disk_on_incline,
    mass_ratio_stack,
    pyramid,
    sliding_disk,
    stack,
)
from gsenv.solver import Options, Scene, World

G = 9.81
AWAKE = Options(sleep=False)


@dataclass(frozen=True)
class Row:
    number: str
    name: str
    scene: Callable[[], Scene]
    seconds: float
    error: Callable[[World, np.ndarray], float]
    tolerance: float
    peer: str
    options: Options = AWAKE


@dataclass(frozen=True)
class Result:
    number: str
    name: str
    error: float
    tolerance: float
    us_per_second: float
    sweeps_per_step: float
    peer: str


def slid(degrees: float, acceleration: float, seconds: float) -> Callable[..., float]:
    """Relative error of a distance down a slope; absolute where nothing should move."""

    def error(world: World, start: np.ndarray) -> float:
        moved = float(np.hypot(*(world.position[0, 1] - start[1])))
        expected = 0.5 * acceleration * seconds**2
        return abs(moved - expected) / expected if expected > 0.0 else moved

    return error


def layers(world: World, start: np.ndarray) -> float:
    """Deepest penetration or mean height error of a layer, whichever is larger (m)."""
    nominal = np.round(start[1:, 1], 6)
    height = world.position[0, 1:, 1]
    means = [
        abs((height - nominal)[nominal == level].mean()) / (1 + i)
        for i, level in enumerate(np.unique(nominal))
    ]
    return max(float(world.diagnostics().penetration[0]), *means)


def loads(world: World, start: np.ndarray) -> float:
    count = len(start) - 1
    contacts = world.contacts(0)
    worst = 0.0
    for k in range(count):
        below = (contacts.body_b == k + 1) & (contacts.body_a == k)
        load = contacts.impulse[below, 0].sum()
        expected = (count - k) * G * world.timestep
        worst = max(worst, abs(load - expected) / expected)
    return worst


def rolled(world: World, start: np.ndarray) -> float:
    t, mu, v0 = float(world.time[0]), 0.3, 3.0
    t1 = v0 / (3 * mu * G)
    distance = v0 * t1 - 0.5 * mu * G * t1**2 + 2 / 3 * v0 * (t - t1)
    return abs(float(world.position[0, 1, 0]) - distance) / distance


def third_apex(world: World, start: np.ndarray) -> float:
    """World stands just after the third apex: the parabola through it gives the apex."""
    y, v = world.position[0, 1, 1] - 0.1, world.linear_velocity[0, 1, 1]
    return abs(float(y + v * v / (2 * G)) - 0.8**6) / 0.8**6


def rows() -> list[Row]:
    a35, a20 = math.radians(35.0), math.radians(20.0)
    fall = math.sqrt(2.0 / G)
    apex3 = fall * (1 + 2 * (0.8 + 0.64) + 0.512)
    slide = G * (math.sin(a35) - 0.5 * math.cos(a35))
    return [
        Row("1", "loads in a stack of 10", lambda: stack(10), 5.0, loads, 1e-2, "-"),
        Row("6", "sliding disk rolls", sliding_disk, 2.0, rolled, 1e-2, "-"),
        Row("7", "disk rolls down 20 deg", lambda: disk_on_incline(20.0), 2.0,
            slid(20.0, 2 / 3 * G * math.sin(a20), 2.0), 1e-2, "65 (1e-2), 368 (1e-3)"),
        Row("8", "block slides at 35 deg", lambda: box_on_incline(35.0), 2.0,
            slid(35.0, slide, 2.0), 1e-2, "83 (1e-2), 1242 (1e-3)"),
        Row("8", "block stays at 20 deg (m)", lambda: box_on_incline(20.0), 5.0,
            slid(20.0, 0.0, 5.0), 1e-4, "78 (1e-3 m)"),
        Row("10", "third apex, e = .8", lambda: bouncing_balls([0.8]), apex3,
            third_apex, 1e-3, "44 (1e-2), nobody (1e-3)"),
        Row("14", "tower of 10 (m)", lambda: stack(10), 10.0, layers, 5e-3,
            "530 (1e-2), 2024 (1e-3)"),
        Row("14", "tower of 20 (m)", lambda: stack(20), 10.0, layers, 5e-3,
            "1973 (1e-2), 4181 (1e-3)"),
        Row("14", "tower of 50 (m)", lambda: stack(50), 10.0, layers, 5e-3,
            "5129 (1e-2), 40034 (1e-3)"),
        Row("15", "10 kg on 1 kg (m)", lambda: mass_ratio_stack(10.0), 5.0, layers, 5e-3, "-"),
        Row("15", "100 kg on 1 kg (m)", lambda: mass_ratio_stack(100.0), 5.0, layers, 5e-3,
            "299 (1e-2), 1841 (1e-3)"),
        Row("15", "1000 kg on 1 kg (m)", lambda: mass_ratio_stack(1000.0), 5.0, layers, 3e-2,
            "2253 (1e-2), 9569 (1e-3)"),
        Row("16", "pyramid, base 10 (m)", lambda: pyramid(10), 10.0, layers, 5e-3,
            "3828 (1e-2), 7571 (1e-3)"),
        Row("16", "pyramid, base 20 (m)", lambda: pyramid(20), 10.0, layers, 5e-3,
            "16052 (1e-2), 61668 (1e-3)"),
        Row("14", "tower of 10, sleeping (m)", lambda: stack(10), 10.0, layers, 5e-3,
            "150 (1e-2)", Options()),
        Row("16", "pyramid, base 20, sleeping (m)", lambda: pyramid(20), 10.0, layers, 5e-3,
            "2467 (1e-2)", Options()),
    ]  # fmt: skip


def measure(row: Row) -> Result:
    scene = row.scene()
    world = World(scene, options=row.options)
    start = world.position[0].copy()
    steps = math.ceil(row.seconds / world.timestep - 1e-9)
    sweeps = 0
    for _ in range(steps):
        world.step()
        sweeps += int(world.diagnostics().sweeps[0])
    error = row.error(world, start)
    times = []
    for _ in range(5):
        world.reset()
        began = time.thread_time()
        world.step(steps)
        times.append((time.thread_time() - began) / (steps * world.timestep))
    return Result(
        row.number, row.name, error, row.tolerance, 1e6 * statistics.median(times),
        sweeps / steps, row.peer,
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="also write the results to this file")
    arguments = parser.parse_args()
    results = [measure(row) for row in track(rows(), "measuring")]
    table = Table("row", "scene", "error", "tolerance", "us / sim. s", "sweeps / step",
                  "best 2D peer, us / sim. s (error)")  # fmt: skip
    for r in results:
        table.add_row(r.number, r.name, f"{r.error:.1e}", f"{r.tolerance:.0e}",
                      f"{r.us_per_second:.0f}", f"{r.sweeps_per_step:.1f}", r.peer)  # fmt: skip
    Console().print(table)
    if arguments.json is not None:
        arguments.json.write_text(json.dumps([asdict(r) for r in results], indent=1))


if __name__ == "__main__":
    main()
