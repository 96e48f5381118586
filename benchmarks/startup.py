"""Seconds from process start to the end of the first step, with a cold and a warm kernel cache.

    python -m benchmarks.startup

CPU seconds (user and system) and wall seconds of whole processes; warm is the median of five.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

from rich.console import Console
from rich.progress import track
from rich.table import Table

TARGETS = {
    "import gsenv": "import gsenv",
    "stack of ten, one step": "from gsenv.scenes import make_world; make_world('stack').step()",
    "terrain scene, one step": "from gsenv.scenes import make_world; make_world('terrain').step()",
    "GStack-v0, reset and one step": (
        "import gymnasium, gsenv; env = gymnasium.make('GStack-v0'); env.reset(seed=0); "
        "env.step(env.action_space.sample())"
    ),
}


def run(code: str, cache: str) -> tuple[float, float]:
    """(CPU s, wall s) of one process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        env=os.environ | {"NUMBA_CACHE_DIR": cache},
        stderr=subprocess.DEVNULL,
    )
    wall = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def main() -> None:
    table = Table("what", "cold CPU s", "cold wall s", "warm CPU s", "warm wall s")
    for name, code in track(TARGETS.items(), "starting processes"):
        with tempfile.TemporaryDirectory() as cache:
            cold = run(code, cache)
            warm = [run(code, cache) for _ in range(5)]
        cpu, wall = (statistics.median(values) for values in zip(*warm, strict=True))
        table.add_row(name, f"{cold[0]:.1f}", f"{cold[1]:.1f}", f"{cpu:.2f}", f"{wall:.2f}")
    Console().print(table)


if __name__ == "__main__":
    main()
