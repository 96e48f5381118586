"""Worlds shared out over threads: own pool, rebuilt in a forked child, each thread its own scratch."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from itertools import pairwise
from typing import Any

_pool: tuple[int, int, ThreadPoolExecutor | None] = (0, 0, None)  # pid, size; replaced as one


def _executor(size: int) -> ThreadPoolExecutor:
    """The process's pool. A child of a fork has no threads, so it makes its own.

    A pool that got too small is not shut down: another thread may be about to use it. Its idle
    threads end once nobody refers to it.
    """
    global _pool
    pid, room, pool = _pool
    if pool is None or pid != os.getpid() or room < size:
        pool = ThreadPoolExecutor(size, thread_name_prefix="gsenv")
        _pool = (os.getpid(), size, pool)
    return pool


def ranges(count: int, parts: int) -> list[tuple[int, int]]:
    """``count`` worlds in ``parts`` runs of nearly equal length."""
    edges = [count * k // parts for k in range(parts + 1)]
    return [(a, b) for a, b in pairwise(edges) if b > a]


def run(tasks: list[Callable[[], Any]]) -> list[Any]:
    """Results of the tasks, run side by side; the first one on the calling thread."""
    if len(tasks) == 1:
        return [tasks[0]()]
    pool = _executor(len(tasks) - 1)
    futures = [pool.submit(task) for task in tasks[1:]]
    try:
        first = tasks[0]()
    finally:  # an interrupt here must not leave others writing behind the caller's back
        wait(futures)
    return [first, *(future.result() for future in futures)]
