"""CPU times of calls on one core. Compilation and garbage collection are kept out; times are medians."""

from __future__ import annotations

import gc
import os
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from gsenv.solver import World

ROUNDS = 5


def usable_cores() -> list[int]:
    """Return the cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def pin(*cores: int) -> None:
    """Keep the calling thread, and those that it starts, on these cores, where the system can do it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, cores)


@contextmanager
def without_collector() -> Iterator[None]:
    """Switch garbage collection off in the block, after a collection of young objects."""
    was_on = gc.isenabled()
    gc.collect(1)
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def cpu_time(work: Callable[[], object]) -> float:
    """Return the CPU time in s of this process in one call: an engine may work in a thread of its own."""
    with without_collector():
        began = time.process_time()
        work()
        return time.process_time() - began


def step_time(world: World, steps: int, rounds: int = ROUNDS) -> float:
    """Return the CPU time in s of a step, the median of ``rounds`` calls of ``steps`` steps, with compiled kernels."""
    return statistics.median(cpu_time(lambda: world.step(steps)) for _ in range(rounds)) / steps


def call_time(function: Callable[[], object], seconds: float, rounds: int = ROUNDS) -> float:
    """Return the CPU time in s of a call, the median of ``rounds`` means over as many calls as fill ``seconds``.

    The first call, which may compile, is not counted.
    """
    function()
    means = []
    for _ in range(rounds):
        with without_collector():
            count, began = 0, time.thread_time()
            while (spent := time.thread_time() - began) < seconds or not count:
                function()
                count += 1
        means.append(spent / count)
    return statistics.median(means)


def median_ratio(times: Sequence[float], base: Sequence[float]) -> float:
    """Return the median ratio of times that were measured by turns, so that a slow minute hits both of a pair."""
    return statistics.median(a / b for a, b in zip(times, base, strict=True))
