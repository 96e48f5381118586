"""The pool that worlds are shared out over."""

from __future__ import annotations

import os
import threading
import time
from functools import partial

import pytest

from gsenv.solver.api import threads


def test_results_come_in_order_and_from_several_threads() -> None:
    barrier = threading.Barrier(4, timeout=30)  # only passed by four at once

    def task(k: int) -> tuple[int, str]:
        barrier.wait()
        return k, threading.current_thread().name

    results = threads.run([partial(task, k) for k in range(4)])
    assert [k for k, _ in results] == [0, 1, 2, 3]
    assert len({name for _, name in results}) == 4
    assert results[0][1] == threading.current_thread().name


def test_callers_with_pools_of_different_sizes_do_not_disturb_one_another() -> None:
    errors: list[BaseException] = []

    def call(size: int) -> None:
        try:
            for _ in range(200):
                assert threads.run([partial(pow, k, 2) for k in range(size)]) == [k * k for k in range(size)]
        except BaseException as error:
            errors.append(error)

    for first in (2, 5):
        callers = [threading.Thread(target=call, args=(first + k,)) for k in range(8)]
        for caller in callers:
            caller.start()
        for caller in callers:
            caller.join(60)
    assert not errors


def test_an_error_waits_for_the_others() -> None:
    done = []

    def slow() -> None:
        time.sleep(0.1)
        done.append(1)

    with pytest.raises(ZeroDivisionError):
        threads.run([lambda: 1 // 0, slow])
    assert done
    with pytest.raises(ZeroDivisionError):
        threads.run([slow, lambda: 1 // 0])
    assert len(done) == 2


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_child_makes_its_own_pool() -> None:
    threads.run([os.getpid] * 3)
    child = os.fork()
    if child == 0:
        try:
            same = threads.run([os.getpid] * 3) == [os.getpid()] * 3
        except BaseException:
            os._exit(2)
        os._exit(0 if same else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert threads.run([os.getpid] * 3) == [os.getpid()] * 3


@pytest.mark.parametrize(("count", "parts"), [(1, 1), (7, 3), (2, 5), (1024, 2)])
def test_ranges_cover_all_worlds_once(count: int, parts: int) -> None:
    runs = threads.ranges(count, parts)
    assert [w for a, b in runs for w in range(a, b)] == list(range(count))
    sizes = [b - a for a, b in runs]
    assert max(sizes) - min(sizes) <= 1
