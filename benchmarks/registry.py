"""All benchmarks by name. A module is imported only when its benchmark runs, so the list needs no optional library."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:
    from benchmarks.common.report import Report
    from benchmarks.common.run import Run


class Implementation(Protocol):
    """What the module of a benchmark defines."""

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the benchmark's own command line options."""

    def measure(self, run: Run) -> dict[str, Any]:
        """Run the benchmark; everything that its report shows, as JSON data."""

    def report(self, results: Mapping[str, Any]) -> Report:
        """Return tables, text and picture of what ``measure`` returned."""


@dataclass(frozen=True)
class Benchmark:
    """One entry of the list.

    Attributes:
        name: on the command line; also of its module or package in benchmarks/.
        summary: one line.
        dims: dimensions that it has; with more than one it gets the option --dim.
        single_core: whether its process stays on one core, as timing needs; it gets the option --core.
        page: whether a full run writes a page to docs/.
    """

    name: str
    summary: str
    dims: tuple[int, ...] = (2,)
    single_core: bool = False
    page: bool = False

    def load(self) -> Implementation:
        """Import the module."""
        return cast(Implementation, import_module(f"benchmarks.{self.name}"))

    def stem(self, dim: int) -> str:
        """Return the name of its files, without the ending."""
        return self.name if dim == self.dims[0] else f"{self.name}{dim}d"


BENCHMARKS: dict[str, Benchmark] = {
    benchmark.name: benchmark
    for benchmark in (
        Benchmark(
            "accuracy", "run time against error on scenes with known answers, beside other engines", (2, 3), True, True
        ),
        Benchmark("articulation", "bodies on joints: rows, joint coordinates, MuJoCo", (3,), True, True),
        Benchmark("baselines", "PPO at each tier, five seeds: success, return, time of training", page=True),
        Benchmark("convergence", "order of convergence in the timestep, against closed forms", page=True),
        Benchmark("devices", "PPO's time on the CPU and on a GPU, and threads of worlds", page=True),
        Benchmark(
            "heaps", "CPU time per box of heaps, moving and at rest, beside Box2D v3 and Box3D", (2, 3), True, True
        ),
        Benchmark("limits", "resting boxes and flying balls at extreme sizes, masses, speeds and timesteps", page=True),
        Benchmark("reference_scenes", "error, CPU time and sweeps of the scenes with known answers", (2, 3), True),
        Benchmark("render", "CPU time of a rendered frame", (2, 3), True),
        Benchmark("scaling", "step time against the number of bodies, awake and asleep", (2, 3), True, True),
        Benchmark("solve", "run time against error of the methods that solve rows without bodies", (2,), True, True),
        Benchmark("stability", "error of each fidelity as scenes get harder, and random jointed scenes", page=True),
        Benchmark("stages", "CPU time of each stage of a step, of heaps", (2, 3), True, True),
        Benchmark("stack_sweeps", "contact loads and height of a stack against the number of sweeps"),
        Benchmark("startup", "process start to the end of the first step, with an empty and a full kernel cache"),
        Benchmark("step_time", "CPU time of a step, also as a ratio to another checkout's", (2, 3), True),
        Benchmark("stress", "energy gained and speeds reached in random scenes", (2, 3)),
        Benchmark("tiers", "success of zero, random, naive, scripted and trained policies at each tier", page=True),
        Benchmark("throughput", "environment steps per second, beside Gymnasium's Box2D and EnvPool's", page=True),
    )
}
