"""Seconds from process start to the end of the first step, with an empty and with a full kernel cache.

CPU seconds (user and system) and wall seconds of whole processes. Cold: the cache is empty and kernels are compiled.
Warm: the median of five processes after that. --quick uses your own cache and measures warm processes only.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from benchmarks.common.files import packed, unpacked
from benchmarks.common.processes import Finished, run_python
from benchmarks.common.progress import track
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table

PROGRAMS = {
    "import gsenv": "import gsenv",
    "stack of ten, one step": "from gsenv.scenes import make_world; make_world('stack').step()",
    "terrain scene, one step": "from gsenv.scenes import make_world; make_world('terrain').step()",
    "GStack-v0, reset and one step": (
        "import gymnasium, gsenv; env = gymnasium.make('GStack-v0'); env.reset(seed=0); "
        "env.step(env.action_space.sample())"
    ),
}
QUICK_PROGRAMS = ("import gsenv", "stack of ten, one step")
ROUNDS, QUICK_ROUNDS = 5, 2


@dataclass(frozen=True)
class Startup:
    """s of whole processes; None: not measured."""

    program: str
    cold_cpu: float | None
    cold_wall: float | None
    warm_cpu: float
    warm_wall: float


def startup(program: str, warm: list[Finished], cold: Finished | None) -> Startup:
    cpu = statistics.median(process.cpu_seconds for process in warm)
    wall = statistics.median(process.wall_seconds for process in warm)
    if cold is None:
        return Startup(program, None, None, cpu, wall)
    return Startup(program, cold.cpu_seconds, cold.wall_seconds, cpu, wall)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: this benchmark has no options of its own."""


def measure(run: Run) -> dict[str, Any]:
    programs = QUICK_PROGRAMS if run.quick else tuple(PROGRAMS)
    return {"programs": packed(track(map(quick if run.quick else full, programs), "processes", len(programs)))}


def quick(program: str) -> Startup:
    run_python(PROGRAMS[program])  # fills the cache
    return startup(program, [run_python(PROGRAMS[program]) for _ in range(QUICK_ROUNDS)], None)


def full(program: str) -> Startup:
    with tempfile.TemporaryDirectory() as cache:
        cold = run_python(PROGRAMS[program], cache)
        warm = [run_python(PROGRAMS[program], cache) for _ in range(ROUNDS)]
    return startup(program, warm, cold)


def report(results: Mapping[str, Any]) -> Report:
    rows = []
    for s in unpacked(Startup, results["programs"]):
        cold = ["-" if value is None else f"{value:.1f}" for value in (s.cold_cpu, s.cold_wall)]
        rows.append([s.program, *cold, f"{s.warm_cpu:.2f}", f"{s.warm_wall:.2f}"])
    header = ["process start to the end of", "cold CPU s", "cold wall s", "warm CPU s", "warm wall s"]
    return Report("Start-up", [Table(header, rows)])
