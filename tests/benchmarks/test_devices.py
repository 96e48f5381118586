"""The report of learning on a CPU and on a GPU, and what is measured where."""

from __future__ import annotations

import os

import pytest

from benchmarks.common.files import packed
from benchmarks.common.tables import Table
from benchmarks.devices import (
    LEARNERS,
    Learned,
    Learner,
    Place,
    Stepped,
    learn,
    named,
    places,
    report,
    step,
    thread_counts,
)


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
    assert "Cores:" not in str(parts[0])  # these results do not tell
    learned, stepped = (part for part in parts if isinstance(part, Table))
    assert learned.rows[0][1:] == ["state, two layers of 64", "CPU, 1 thread", "3.05", "9.16", "8,192"]
    assert learned.rows[1][2:] == ["GPU", "-", "-", "-"]
    assert stepped.rows[1] == ["GStack-v0", "4", "250", "2.5"]
    assert "GStack-v0, state, two layers of 64, GPU: RuntimeError: no driver" in parts


def test_page_says_how_it_was_measured() -> None:
    learned = named("GStack-v0", LEARNERS[0], Place("cpu", 1), 0.25, 0.75)
    results = {"gpu": "", "cores": 12, "rollouts": 7, "learners": packed([Learner("state", "P", "N", 6, 5, 10, 4)])}
    results |= {"learned": packed([learned]), "stepped": packed([Stepped("GStack-v0", 1, 100.0)])}
    text, table = report(results).parts[:2]
    assert isinstance(text, str)
    assert "Cores: 12." in text
    assert "the median of 7 rollouts after a first" in text
    assert "6 worlds take 5 steps each, and PPO learns from them in batches of 10 for 4 epochs" in text
    assert "of one rollout" in str(report(results | {"rollouts": 1}).parts[0])
    assert isinstance(table, Table)
    assert list(table.header[3:5]) == ["acting, s / 100,000 steps", "learning, s / 100,000 steps"]


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
