"""The table of trained baselines."""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import baselines
from benchmarks.baselines import (
    SEEDS,
    Point,
    Trained,
    complete,
    interval,
    mark_shipped,
    measure,
    over_seeds,
    publish,
    published,
    report,
    settings_of,
    shipped,
)
from benchmarks.common.files import packed, unpacked
from benchmarks.common.files import write_json as write_results
from benchmarks.common.run import Run
from gsenv.envs.core.policies import trained_actions
from gsenv.train import ppo
from gsenv.train.checkpoint import COLUMNS, changed_settings
from gsenv.train.files import read_object, write_json, write_rows
from gsenv.train.run import Settings

ROOT = Path(__file__).parents[2]


def test_the_interquartile_mean_drops_a_quarter_of_the_seeds_at_each_end() -> None:
    mean, low, high = interval([0.0, 0.8, 0.9, 1.0])
    assert mean == pytest.approx(0.85)
    assert 0.0 <= low < mean < high <= 1.0


def test_an_interval_of_five_seeds_holds_the_mean_as_often_as_the_page_says() -> None:
    generator = np.random.default_rng(0)
    samples = generator.normal(3.0, 1.0, (400, SEEDS))
    inside = [low < 3.0 < high for _, low, high in map(interval, samples)]
    assert 0.86 < np.mean(inside) < 0.94  # "about 90 %"


def test_fewer_seeds_have_their_mean_and_range() -> None:
    assert over_seeds([0.0, 0.8, 0.4], "{:.1f}") == "0.4 (0.0 to 0.8 of 3)"
    assert " of " not in over_seeds([0.0, 0.8, 0.4, 0.5, 0.6], "{:.1f}")


def test_each_row_has_its_learning_curve_and_no_other_is_there() -> None:
    trained, _ = published(ROOT / "benchmarks/results/baselines.json")
    rows = {f"{one.env}-seed-{one.seed}.csv" for one in trained}
    assert {path.name for path in (ROOT / "docs/training").glob("*-seed-*.csv")} == rows


@pytest.mark.parametrize("env_id", list(ppo.SETTINGS))
def test_published_runs_learned_with_the_present_settings(env_id: str) -> None:
    """Where settings change, the environment must be trained anew, else the page tells of others."""
    of_runs = read_object(ROOT / f"docs/training/{env_id}-settings.json")
    settings = asdict(ppo.settings_for(env_id))
    assert changed_settings(of_runs, settings) == []
    assert of_runs["steps"] == settings["steps"]


def test_equal_seeds_have_no_interval() -> None:
    assert interval([0.7]) == (0.7, 0.7, 0.7)
    assert interval([1.0, 1.0, 1.0]) == (1.0, 1.0, 1.0)


def test_the_report_counts_the_seeds_that_solved_the_task() -> None:
    trained = [
        Trained(
            "GStack-v0", s, 2_000_000, ("abc", "abd", "abc, abd")[s], 100.0 + s, (-1.0, 40.0, 60.0)[s], 0.9, 12.0, "def"
        )
        for s in range(3)
    ]
    points = [Point("GStack-v0", s, 1000 * k, 0.1 * k) for s in range(3) for k in range(5)]
    made = report({"trained": packed(trained), "points": packed(points)})
    (row,) = made.parts[1].rows  # type: ignore[union-attr]
    assert row[:3] == ["GStack-v0", "3", "2.0"]
    assert row[-5:] == ["101", "not known", "40 to 60 (2 of 3)", "abc, abd", "def"]
    assert made.picture is not None
    figure = made.picture.draw()
    assert len(figure.axes[0].lines) == 3


def test_one_seed_has_no_interval() -> None:
    one = Trained("GStack-v0", 0, 2_000_000, "abc", 100.0, 40.0, 0.9, 12.0, "def")
    made = report({"trained": packed([one]), "points": packed([Point("GStack-v0", 0, 1000, 0.1)])})
    (row,) = made.parts[1].rows  # type: ignore[union-attr]
    assert row[3:5] == ["90%", "12.00"]
    assert row[7] == "40 (1 of 1)"


def test_each_seed_has_a_row_that_says_what_is_not_known() -> None:
    seeds = [
        Trained("GCar-v0", 0, 100, "abc", 50.0, -1.0, 0.5, 1.0, "def"),
        Trained("GCar-v0", 1, 100, "abc", 60.0, 40.0, 0.9, 2.0, "def", "", 61.0, 0.92, 0.94, 480.4, "best"),
    ]
    first, second = report({"trained": packed(seeds), "points": []}).parts[-1].rows  # type: ignore[union-attr]
    assert first == ["GCar-v0", "0", "50%", "not known", "not known", "not known", "not reached", "50", ""]
    assert second == ["GCar-v0", "1", "90%", "92%", "94%", "480", "40", "60", "`best.npz`"]


@pytest.mark.parametrize(("name", "other"), [("policy", "best"), ("best", "policy")])
def test_the_policy_of_the_package_is_found_among_those_of_a_run(tmp_path: Path, name: str, other: str) -> None:
    package = trained_actions("GCar-v0")
    package.save(tmp_path / f"{name}.npz")
    weight, bias = package.layers[-1]
    changed = replace(package, layers=(*package.layers[:-1], (weight, bias + np.float32(0.01))))
    changed.save(tmp_path / f"{other}.npz")
    assert shipped("GCar-v0", tmp_path) == name
    changed.save(tmp_path / f"{name}.npz")
    assert shipped("GCar-v0", tmp_path) == ""


def test_a_new_policy_in_the_package_takes_the_mark_of_the_one_before(tmp_path: Path) -> None:
    seeds = [Trained("GCar-v0", seed, 100, "abc", 50.0, -1.0, 0.5, 1.0, "def") for seed in range(3)]
    before = [replace(seeds[0], shipped="policy"), *seeds[1:], replace(seeds[0], env="GStack-v0", shipped="best")]
    assert mark_shipped(before, tmp_path) == before  # no run is there
    folder = tmp_path / "GCar-v0" / "seed-2"
    folder.mkdir(parents=True)
    for name in ("policy", "best"):
        trained_actions("GCar-v0").save(folder / f"{name}.npz")
    marks = [(one.env, one.shipped) for one in mark_shipped(before, tmp_path)]
    assert marks == [("GCar-v0", ""), ("GCar-v0", ""), ("GCar-v0", "policy"), ("GStack-v0", "best")]


def test_settings_and_curves_of_the_runs_are_written_beside_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = tmp_path / "runs" / "GCar-v0" / "seed-3"
    run.mkdir(parents=True)
    row = dict.fromkeys(COLUMNS, 1.0)
    write_rows(run / "progress.csv", [row, row | {"steps": 2.0}])
    write_json(run / "settings.json", {"env": "GCar-v0", "seed": 3})
    docs = tmp_path / "docs"
    docs.mkdir()
    for seed in (1, 2):  # of which the rows have seed 1 still
        write_rows(docs / f"GCar-v0-seed-{seed}.csv", [row])
    old, new = (Trained("GCar-v0", seed, 2, "", 1.0, -1.0, 0.5, 1.0, "") for seed in (1, 3))
    drawn: list[int] = []
    monkeypatch.setattr(baselines, "draw_curves", lambda curves, run, picture: drawn.extend(curves))
    publish([new], [old, new], tmp_path / "runs", docs)
    assert drawn == [1, 3]
    monkeypatch.undo()
    publish([new], [old, new], tmp_path / "runs", docs)
    assert {path.name for path in docs.iterdir()} == {
        "GCar-v0-seed-1.csv", "GCar-v0-seed-3.csv", "GCar-v0-settings.json", "GCar-v0.png"
    }  # fmt: skip
    assert (tmp_path / "docs" / "GCar-v0-seed-3.csv").read_bytes() == (run / "progress.csv").read_bytes()


def test_a_run_is_complete_after_its_last_step_and_its_result(tmp_path: Path) -> None:
    settings = settings_of("GStack-v0", 1, False)
    assert not complete(tmp_path, settings)
    write_rows(tmp_path / "progress.csv", [{"steps": settings.steps // 2}])
    write_json(tmp_path / "result.json", {})
    assert not complete(tmp_path, settings)
    write_rows(tmp_path / "progress.csv", [{"steps": settings.steps // 2}, {"steps": settings.steps}])
    write_json(tmp_path / "settings.json", asdict(settings))
    assert complete(tmp_path, settings)
    assert not complete(tmp_path, replace(settings, discount=0.5))
    assert not complete(tmp_path, replace(settings, steps=settings.steps // 2))  # a longer run


def test_published_seeds_stay_and_are_not_trained_again(tmp_path: Path) -> None:
    seeds = [Trained("GCar-v0", s, 100, "abc", 1.0, -1.0, 0.5, 1.0, "def") for s in range(2)]
    points = [Point("GCar-v0", s, 100, 0.5) for s in range(2)]
    file = tmp_path / "baselines.json"
    write_results(file, {"trained": packed(seeds), "points": packed(points)})
    options = argparse.Namespace(env=["GCar-v0"], seeds=2, runs=tmp_path, trained=False, add=True, renew=False)
    kept = measure(Run(options, quick=False, dim=2, stamp={}, results_file=file))
    assert kept == {"trained": packed(seeds), "points": packed(points)}
    assert published(None) == ([], [])


def test_renewing_replaces_an_environment_that_was_trained_anew_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = [Trained(env, 0, 100, "old", 1.0, -1.0, 0.5, 1.0, "old") for env in ("GStack-v0", "GCar-v0", "GCar3D-v0")]
    points = [Point(one.env, 0, 100, 0.5) for one in old]
    file = tmp_path / "baselines.json"
    write_results(file, {"trained": packed(old), "points": packed(points)})
    options = argparse.Namespace(
        env=["GCar-v0", "GCar3D-v0"], seeds=2, runs=tmp_path, trained=True, add=False, renew=True
    )

    def fake_test(settings: Settings, folder: Path, quick: bool) -> tuple[Trained, list[Point]]:
        one = Trained(settings.env, settings.seed, 200, "new", 2.0, -1.0, 0.9, 2.0, "new")
        return one, [Point(settings.env, settings.seed, 200, 0.9)]

    monkeypatch.setattr(baselines, "complete", lambda folder, settings: settings.env == "GCar-v0")
    monkeypatch.setattr(baselines, "test", fake_test)
    made = measure(Run(options, quick=False, dim=2, stamp={}, results_file=file))
    trained = [(one.env, one.seed, one.commit) for one in unpacked(Trained, made["trained"])]
    assert trained == [("GStack-v0", 0, "old"), ("GCar-v0", 0, "new"), ("GCar-v0", 1, "new"), ("GCar3D-v0", 0, "old")]
    assert [(p.env, p.success) for p in unpacked(Point, made["points"])] == [
        ("GStack-v0", 0.5), ("GCar-v0", 0.9), ("GCar-v0", 0.9), ("GCar3D-v0", 0.5)
    ]  # fmt: skip
