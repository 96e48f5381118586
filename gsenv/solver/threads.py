"""Worlds shared out over threads: own pool, rebuilt in a forked child, each thread its own scratch."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from itertools import pairwise
from typing import Any

_pool: ThreadPoolExecutor | None = None
_pool_pid = 0
_pool_size = 0


def _executor(size: int) -> ThreadPoolExecutor:
    """The process's pool. A child of a fork has no threads, so it makes its own."""
    global _pool, _pool_pid, _pool_size
    if _pool is None or _pool_pid != os.getpid() or _pool_size < size:
        if _pool is not None and _pool_pid == os.getpid():
            _pool.shutdown(wait=False)
        _pool = ThreadPoolExecutor(size, thread_name_prefix="gsenv")
        _pool_pid = os.getpid()
        _pool_size = size
    return _pool


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
