"""The report of learning on a CPU and on a GPU, and what is measured where."""

from __future__ import annotations

import os

import pytest

from benchmarks.common.files import packed
from benchmarks.common.tables import Table
from benchmarks.devices import LEARNERS, Learned, Place, Stepped, learn, named, places, report, step, thread_counts


def test_rates_and_reasons() -> None:
    learner = LEARNERS[0]
    fine = named("GStack-v0", learner, Place("cpu", 1), 0.25, 0.75)
    broken = named("GStack-v0", learner, Place("cuda", 1), 0.0, 0.0, "RuntimeError: no driver")
    assert fine.rate == learner.worlds * learner.steps
    results = {
        "gpu": "",
        "learned": packed([fine, broken]),
        "stepped": packed([Stepped("GStack-v0", 1, 100.0), Stepped("GStack-v0", 4, 250.0)]),
    }
    parts = report(results).parts
    learned, stepped = (part for part in parts if isinstance(part, Table))
    assert learned.rows[0][1:] == ["state, two layers of 64", "CPU, 1 thread", "3.05", "9.16", "8,192"]
    assert learned.rows[1][2:] == ["GPU", "-", "-", "-"]
    assert stepped.rows[1] == ["GStack-v0", "4", "250", "2.5"]
    assert "GStack-v0, state, two layers of 64, GPU: RuntimeError: no driver" in parts


def test_threads_and_places_of_this_machine() -> None:
    cores = len(os.sched_getaffinity(0))
    counts = thread_counts()
    assert counts[0] == 1
    assert cores / 2 < counts[-1] <= cores
    assert places()[0] == Place("cpu", 1)


def test_a_small_run(monkeypatch: pytest.MonkeyPatch) -> None:
    from benchmarks import devices

    monkeypatch.setattr(devices, "WORLDS", 8)
    small = devices.Learner("state", "MlpPolicy", "two layers of 64", 4, 8, 16, 1)
    done = learn("GStack-v0", small, Place("cpu", 1), 2)
    assert isinstance(done, Learned)
    assert done.steps == 32
    assert min(done.acting, done.learning) > 0.0
    assert step("GStack-v0", 1, 0.01).rate > 0.0
