"""Work in other processes: whole processes that are measured, and jobs that run side by side."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from benchmarks.common.progress import track
from benchmarks.common.stamp import ROOT

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Finished:
    """A process that has ended: user and system time, time on the clock, and what it printed."""

    cpu_seconds: float
    wall_seconds: float
    output: str


def run_python(code: str, cache: Path | str | None = None) -> Finished:
    """Run ``python -c code`` in the repository's root to its end.

    Args:
        cache: folder of numba's cache; the default one where it is None.

    Raises:
        subprocess.CalledProcessError: it failed.
    """
    environment = os.environ | ({} if cache is None else {"NUMBA_CACHE_DIR": str(cache)})
    before, began = os.times(), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, env=environment, cwd=ROOT, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    wall = time.perf_counter() - began
    after = os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    return Finished(cpu, wall, done.stdout)


def in_processes(work: Callable[[T], R], jobs: Sequence[T], processes: int, description: str) -> list[R]:
    """Return ``work`` of each job, in order, computed in this process or in several new ones."""
    if processes == 1:
        return [work(job) for job in track(jobs, description, len(jobs))]
    with get_context("spawn").Pool(processes) as pool:
        return list(track(pool.imap(work, jobs, chunksize=10), description, len(jobs)))
