"""Worlds distributed over threads: one pool for each process, made again in a forked child."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from itertools import pairwise
from typing import Any

_pool: tuple[int, int, ThreadPoolExecutor | None] = (0, 0, None)  # pid, size, pool; replaced together


def _executor(size: int) -> ThreadPoolExecutor:
    """Return the pool of the process. A forked child has no threads, so it makes its own.

    A pool that is too small is not shut down: another thread may be about to use it. Its idle
    threads end once nothing refers to it.
    """
    global _pool
    pid, room, pool = _pool
    if pool is None or pid != os.getpid() or room < size:
        pool = ThreadPoolExecutor(size, thread_name_prefix="gsenv")
        _pool = (os.getpid(), size, pool)
    return pool


def ranges(count: int, parts: int) -> list[tuple[int, int]]:
    """Return ``parts`` ranges (first, last + 1) of nearly equal length that cover ``count`` worlds."""
    edges = [count * k // parts for k in range(parts + 1)]
    return [(a, b) for a, b in pairwise(edges) if b > a]


def run(tasks: list[Callable[[], Any]]) -> list[Any]:
    """Run tasks concurrently, the first on the calling thread; returns their results."""
    if len(tasks) == 1:
        return [tasks[0]()]
    pool = _executor(len(tasks) - 1)
    futures = [pool.submit(task) for task in tasks[1:]]
    try:
        first = tasks[0]()
    finally:  # after an interrupt here no thread may continue to write
        wait(futures)
    return [first, *(future.result() for future in futures)]
