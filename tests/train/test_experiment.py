from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from gsenv.envs.core.mlp import MlpPolicy
from gsenv.train import curve, experiment
from gsenv.train.evaluate import Evaluation, evaluate
from gsenv.train.export import load_zip
from gsenv.train.files import read_rows
from tests.train.small import EXPERIMENTS, PPO

POLICY_FILES = {"policy.npz", "policy.zip", "normalize.npz"}
BOTH = pytest.mark.parametrize(("kind", "settings"), EXPERIMENTS, ids=["ppo", "sac"])


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.is_file()}


def mean_observation(run: experiment.Run) -> Any:
    statistics: Any = run.normalize.obs_rms
    return statistics.mean


@BOTH
def test_a_run_leaves_policies_logs_and_a_result(kind: Any, settings: Any, tmp_path: Path) -> None:
    assert experiment.run_seed(kind, settings, tmp_path / "seed-0") == experiment.OK
    folder = tmp_path / "seed-0"
    assert names(folder) == POLICY_FILES | {"best.npz", "settings.json", "progress.csv", "result.json"}
    rows = read_rows(folder / "progress.csv")
    steps = [row["steps"] for row in rows]
    assert steps == sorted(set(steps))
    assert steps[-1] >= 256 - 64
    assert any(row["evaluated_success"] >= 0.0 for row in rows)
    assert json.loads((folder / "settings.json").read_text())["arguments"] == settings.arguments
    result = json.loads((folder / "result.json").read_text())
    assert set(result) == {f"blocks 1: {policy}" for policy in ("trained", "best", "scripted", "random")}
    assert result["blocks 1: scripted"]["success_rate"] == 1.0
    curve.plot(tmp_path)
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_the_best_policy_is_that_of_the_best_evaluation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, settings = EXPERIMENTS[0]
    scores = [0.2, 0.8, 0.4, 0.8, 0.1]  # of equals the larger return

    def evaluation(*_: object) -> Evaluation:
        success = scores.pop(0)
        return Evaluation(2, success, -len(scores), 1.0)

    monkeypatch.setattr(experiment, "evaluate", evaluation)
    run = experiment.prepare(kind, replace(settings, steps=64 * 2 * 5), tmp_path)
    assert experiment.train(run)
    assert not scores
    evaluated = [row["steps"] for row in run.rows if row["evaluated_success"] != ""]
    assert MlpPolicy.load(tmp_path / "best.npz").notes["steps"] == evaluated[3]


@BOTH
def test_exported_policies_act_as_the_model_does(kind: Any, settings: Any, tmp_path: Path) -> None:
    run = experiment.prepare(kind, settings, tmp_path)
    experiment.train(run)
    run.normalize.training = False  # or a reset would count
    observations = run.normalize.reset()
    originals = run.normalize.get_original_obs()
    expected, _ = run.model.predict(observations, deterministic=True)
    for policy in (MlpPolicy.load(tmp_path / "policy.npz"), load_zip(tmp_path / "policy.zip")):
        np.testing.assert_allclose(policy(originals), expected, atol=2e-5)  # type: ignore[arg-type]
    assert MlpPolicy.load(tmp_path / "policy.npz").notes["steps"] == run.steps


@BOTH
def test_resume_goes_on(kind: Any, settings: Any, tmp_path: Path) -> None:
    first = experiment.prepare(kind, replace(settings, steps=128), tmp_path)
    assert experiment.train(first)
    again = experiment.prepare(kind, settings, tmp_path, resume=True)
    assert again.steps == first.steps == 128
    assert len(again.rows) == len(first.rows) > 0
    np.testing.assert_array_equal(mean_observation(again), mean_observation(first))
    assert experiment.train(again)
    assert again.steps == 256
    assert [row["steps"] for row in read_rows(tmp_path / "progress.csv")][: len(first.rows)] == [
        row["steps"] for row in first.rows
    ]
    done = experiment.prepare(kind, settings, tmp_path, resume=True)
    assert experiment.train(done)
    assert done.steps == 256


def test_resume_without_files_begins_anew(tmp_path: Path) -> None:
    kind, settings = EXPERIMENTS[0]
    assert experiment.prepare(kind, settings, tmp_path / "new", resume=True).steps == 0


def test_equal_seeds_train_equal_policies(tmp_path: Path) -> None:
    kind, settings = EXPERIMENTS[0]
    weights = []
    for k, seed in enumerate((0, 0, 1)):
        run = experiment.prepare(kind, replace(settings, seed=seed), tmp_path / str(k))
        experiment.train(run)
        weights.append(MlpPolicy.load(tmp_path / str(k) / "policy.npz").layers[-1][0])
    np.testing.assert_array_equal(weights[0], weights[1])
    assert (weights[0] != weights[2]).any()


def test_interrupt_keeps_a_usable_policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, _ = EXPERIMENTS[0]
    run = experiment.prepare(kind, PPO, tmp_path)

    def interrupt() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(run.model, "train", interrupt)
    assert not experiment.train(run)
    policy = MlpPolicy.load(tmp_path / "policy.npz")
    assert evaluate(policy, "GStack-v0", 2, arguments={"blocks": 1}).episodes == 2
    assert experiment.prepare(kind, PPO, tmp_path, resume=True).steps == run.steps > 0


def test_a_failed_save_leaves_the_old_policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, settings = EXPERIMENTS[0]
    run = experiment.prepare(kind, settings, tmp_path)
    experiment.save(run)
    old = (tmp_path / "policy.zip").read_bytes()

    def fail(path: Path) -> None:
        path.write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(run.model, "save", fail)
    with pytest.raises(OSError, match="disk full"):
        experiment.save(run)
    assert names(tmp_path) == POLICY_FILES | {"settings.json"}
    assert (tmp_path / "policy.zip").read_bytes() == old


def test_tensorboard_gets_events_where_it_is_installed(tmp_path: Path) -> None:
    pytest.importorskip("tensorboard")
    kind, settings = EXPERIMENTS[0]
    experiment.train(experiment.prepare(kind, settings, tmp_path))
    assert list((tmp_path / "tensorboard").glob("events.*"))


def test_a_lesson_begins_when_the_one_before_is_passed() -> None:
    settings = experiment.Settings(
        arguments={"blocks": 5, "crack_speed": 0.4},
        world_count=4,
        pass_mark=0.5,
        lessons=({"blocks": 2}, {"blocks": 3}),
    )
    course = settings.curriculum(0)
    assert course.current() == {"blocks": 2}
    assert not course.advance(1.0)  # of episodes of before
    course.ended = 8
    assert not course.advance(0.49)
    assert not course.advance(float("nan"))
    assert course.advance(0.5)
    assert course.current() == {"blocks": 3}
    assert not course.advance(1.0)
    course.ended = 8
    assert course.advance(1.0)
    assert course.current() == {"blocks": 5}
    course.ended = 8
    assert not course.advance(1.0)
    assert experiment.Settings(arguments={"blocks": 5}).curriculum(0).current() == {}


@pytest.mark.parametrize(("kind", "settings"), EXPERIMENTS)
def test_training_goes_through_the_lessons_and_resumes_in_the_last(kind: Any, settings: Any, tmp_path: Path) -> None:
    lessons = ({"blocks": 2}, {"blocks": 3})
    easy = replace(settings, lessons=lessons, pass_mark=0.0, arguments={"blocks": 1, "crack_speed": 2.0}, steps=2048)
    run = experiment.prepare(kind, easy, tmp_path)
    assert experiment.train(run)
    seen = [row["lesson"] for row in run.rows]
    assert seen == sorted(seen)
    assert seen[-1] == 2
    again = experiment.prepare(kind, replace(easy, steps=2048 + 256), tmp_path, resume=True)
    assert experiment.train(again)
    assert {row["lesson"] for row in again.rows[len(run.rows) :]} == {2}
    assert again.normalize.get_attr("blocks") == [1] * easy.world_count
