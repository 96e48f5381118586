"""CPU time of a step of named scenes that never sleep, also as a ratio to another checkout's.

    python -m benchmarks step_time --against ../other-checkout

Each checkout runs in a process of its own on the same core. The two take turns, so a slow minute of the machine hits
both; the ratio is the median over the rounds of the paired ratios. Kernels are compiled before.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import progress_bar
from benchmarks.common.report import Part, Report
from benchmarks.common.run import Run, UsageError
from benchmarks.common.stamp import ROOT
from benchmarks.common.tables import Table
from benchmarks.common.timing import median_ratio

SCENES = {2: ("stack", "pyramid", "heavy_chain", "cubes", "car"), 3: ("cube_stack", "ball_rain", "ball_chain")}
ROUNDS, QUICK_ROUNDS = 21, 5
STEPS = 60  # before the timed part, and in each timed call

# Runs inside the measured checkout, old ones too, so it imports very little. It prints a line for each line that it
# reads: the CPU s of a step, in a call that starts from the same state each time.
WORKER = """
import gc, json, sys, time
from gsenv.scenes import make_world
from gsenv.solver import Options
name, steps = sys.argv[1], int(sys.argv[2])
world = make_world(name, options=Options(sleep=False))
world.step(steps)
snapshot = world.save()
world.step(steps)
gc.disable()
print(json.dumps(len(world.model.bodies)), flush=True)
for line in sys.stdin:
    world.restore(snapshot)
    world.step(1)
    began = time.thread_time()
    world.step(steps)
    print(json.dumps((time.thread_time() - began) / steps), flush=True)
"""


@dataclass(frozen=True)
class Timing:
    """A scene: us per step, and the ratio to the other checkout; None: there is none."""

    scene: str
    bodies: int
    us: float
    other_us: float | None
    ratio: float | None


class Worker:
    """A process that steps one scene with the gsenv of one checkout."""

    def __init__(self, checkout: Path, scene: str) -> None:
        command = [sys.executable, "-c", WORKER, scene, str(STEPS)]
        environment = os.environ | {"PYTHONPATH": str(checkout)}
        self.checkout = checkout
        self.process = subprocess.Popen(
            command, cwd=checkout, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> Worker:
        self.bodies = int(self._answer())
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def seconds(self) -> float:
        """Return the CPU time in s of a step."""
        assert self.process.stdin is not None
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return self._answer()

    def _answer(self) -> float:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"step_time: the process of {self.checkout} ended with an error, see above.")
        number: float = json.loads(line)
        return number


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--against", type=Path, metavar="DIR", help="another checkout of gsenv")
    parser.add_argument("--scenes", nargs="+", metavar="NAME", help="names of gsenv.scenes.SCENES")


def measure(run: Run) -> dict[str, Any]:
    from gsenv.scenes import SCENES as KNOWN

    other: Path | None = run.options.against
    if other is not None and not (other / "gsenv" / "__init__.py").exists():
        raise UsageError(f"--against {other}: this folder has no gsenv.")
    names = run.options.scenes or (SCENES[run.dim][:1] if run.quick else SCENES[run.dim])
    for name in names:
        if name not in KNOWN:
            raise UsageError(f"--scenes {name}: no such scene; `gsenv list` has them all.")
    rounds = QUICK_ROUNDS if run.quick else ROUNDS
    timings = []
    with progress_bar("compiling", len(names)) as bar:
        for name in names:
            bar.describe(name)
            timings.append(time_scene(name, other, rounds))
            bar.advance()
    return {"dim": run.dim, "rounds": rounds, "timings": packed(timings)}


def time_scene(name: str, other: Path | None, rounds: int) -> Timing:
    """Return this checkout's time and, measured by turns, the other's."""
    checkouts = [ROOT] if other is None else [ROOT, other.resolve()]
    with ExitStack() as stack:
        workers = [stack.enter_context(Worker(checkout, name)) for checkout in checkouts]
        times: list[list[float]] = [[] for _ in workers]
        for _ in range(rounds):
            for worker, seconds in zip(workers, times, strict=True):
                seconds.append(worker.seconds())
    us = [1e6 * statistics.median(seconds) for seconds in times]
    if other is None:
        return Timing(name, workers[0].bodies, us[0], None, None)
    return Timing(name, workers[0].bodies, us[0], us[1], median_ratio(*times))


def report(results: Mapping[str, Any]) -> Report:
    timings = unpacked(Timing, results["timings"])
    parts: list[Part] = [f"CPU us per step, median of {results['rounds']} calls of {STEPS} steps.", table(timings)]
    return Report(f"Step time in {results['dim']}D", parts)


def table(timings: Sequence[Timing]) -> Table:
    rows = []
    for t in timings:
        row = [t.scene, str(t.bodies), f"{t.us:.2f}"]
        if t.other_us is not None and t.ratio is not None:
            row += [f"{t.other_us:.2f}", f"{t.ratio:.3f}"]
        rows.append(row)
    header = ["scene", "bodies", "this checkout"]
    return Table(header + ["the other", "ratio"] * (timings[0].ratio is not None), rows)
