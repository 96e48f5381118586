from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from gsenv import cli
from gsenv.envs.core.mlp import MlpPolicy
from gsenv.train import checkpoint, curve, experiment, export, ppo, watcher
from gsenv.train.evaluate import Evaluation, evaluate
from gsenv.train.experiment import with_arguments
from gsenv.train.export import load_zip
from gsenv.train.files import read_object, read_rows, write_json
from gsenv.train.run import Run, Settings, save
from tests.train.small import EXPERIMENTS, PPO

POLICY_FILES = {"policy.npz", "policy.zip", "normalize.npz"}
BOTH = pytest.mark.parametrize(("kind", "settings"), EXPERIMENTS, ids=["ppo", "sac"])


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.is_file()}


def mean_observation(run: Run) -> Any:
    statistics: Any = run.normalize.obs_rms
    return statistics.mean


@BOTH
def test_a_run_leaves_policies_logs_and_a_result(kind: Any, settings: Any, tmp_path: Path) -> None:
    assert experiment.run_seed(kind, settings, tmp_path / "seed-0") == experiment.OK
    folder = tmp_path / "seed-0"
    assert names(folder) == POLICY_FILES | {"best.npz", "settings.json", "origin.json", "progress.csv", "result.json"}
    rows = read_rows(folder / "progress.csv")
    steps = [row["steps"] for row in rows]
    assert steps == sorted(set(steps))
    assert steps[-1] >= 256 - 64
    assert any(row["evaluated_success"] >= 0.0 for row in rows)
    assert json.loads((folder / "settings.json").read_text())["arguments"] == settings.arguments
    result = json.loads((folder / "result.json").read_text())
    tests = {f"blocks 1: {policy}" for policy in ("trained", "best", "scripted", "random")}
    assert set(result) == tests | {"as trained: scripted", "as trained: random"}
    assert result["blocks 1: scripted"]["success_rate"] == 1.0
    curve.plot(tmp_path)
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_the_best_policy_is_that_of_the_best_evaluation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, settings = EXPERIMENTS[0]
    scores = [0.2, 0.8, 0.4, 0.8, 0.1]  # of equals the larger return

    def evaluation(*_: object) -> Evaluation:
        success = scores.pop(0)
        return Evaluation(2, success, -len(scores), 1.0)

    monkeypatch.setattr(watcher, "evaluate", evaluation)
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


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """A short run, whose files are in tmp_path / "seed-0"."""
    kind, settings = EXPERIMENTS[0]
    run = experiment.prepare(kind, replace(settings, steps=128), tmp_path / "seed-0")
    assert experiment.train(run)
    return run


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def refusal(run: Run, resume: bool, **changes: Any) -> str:
    """The sentence with which a run in the same folder is refused; no file has changed then."""
    before = contents(run.folder)
    with pytest.raises(ValueError, match=r"^[^\n]*$") as error:
        experiment.prepare(EXPERIMENTS[0][0], replace(run.settings, **changes), run.folder, resume=resume)
    assert contents(run.folder) == before
    return str(error.value)


def test_a_new_run_does_not_replace_an_old_one(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert "already holds a run (policy.npz" in refusal(run, resume=False)
    before = contents(run.folder)
    command = ["train", "GStack-v0", "--steps", "128", "--out", str(run.folder.parent)]
    assert cli.main([*command, "--seeds", "7", "0"]) == 1
    assert capsys.readouterr().err.startswith(f"gsenv train: {run.folder} already holds a run")
    assert contents(run.folder) == before
    assert not (run.folder.parent / "seed-7").exists()  # refused before any seed is trained


def test_resume_needs_the_whole_checkpoint(run: Run) -> None:
    for name in ("policy.zip", "normalize.npz"):
        (run.folder / name).unlink()
        assert "has policy.npz but not" in refusal(run, resume=True)
        assert name in refusal(run, resume=True)


def test_resume_keeps_the_arguments(run: Run) -> None:
    assert "holds a run with arguments {" in refusal(run, resume=True, arguments={"blocks": 2})
    assert "holds a run with lessons [" in refusal(run, resume=True, lessons=({"blocks": 2},))


def test_resume_keeps_how_it_learns_but_not_how_far(run: Run) -> None:
    for name in ("learning_rate", "discount", "pass_mark", "world_count", "clip"):
        other = 2 * getattr(run.settings, name)
        assert f"holds a run with {name} " in refusal(run, resume=True, **{name: other})
    longer = replace(run.settings, steps=256, tests=(), log_every=7, evaluate_every=9)
    assert experiment.prepare(EXPERIMENTS[0][0], longer, run.folder, resume=True).steps == 128


def test_a_run_that_continues_draws_other_exploration(tmp_path: Path) -> None:
    import torch

    kind, settings = EXPERIMENTS[0]
    run = experiment.prepare(kind, replace(settings, steps=128), tmp_path)
    drawn = torch.randn(4)
    experiment.train(run)
    experiment.prepare(kind, settings, tmp_path, resume=True)
    assert not torch.equal(torch.randn(4), drawn)


def test_resume_refuses_files_of_two_checkpoints(run: Run) -> None:
    old = (run.folder / "policy.zip").read_bytes()
    longer = replace(run.settings, steps=256)
    experiment.train(experiment.prepare(EXPERIMENTS[0][0], longer, run.folder, resume=True))
    (run.folder / "policy.zip").write_bytes(old)
    assert "is of 128 steps and normalize.npz beside it of 256" in refusal(run, resume=True)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "steps,seconds,return,evaluated_return,evaluated_success\n1,2,x,,\n",
            "progress.csv: line 2 must hold numbers",
        ),
        ("steps,seconds,return,evaluated_return,evaluated_success\n1\n", "not as many cells"),
        ("steps,seconds\n1,2\n", "progress.csv lacks the column return"),
        ("", "progress.csv lacks the column steps"),
    ],
)
def test_a_broken_table_is_named(text: str, message: str, run: Run) -> None:
    (run.folder / "progress.csv").write_text(text)
    assert message in refusal(run, resume=True)
    with pytest.raises(ValueError, match=r"progress\.csv"):
        curve.plot(run.folder.parent)


def test_broken_settings_are_named(run: Run) -> None:
    (run.folder / "settings.json").write_text("{")
    assert "settings.json is no JSON file" in refusal(run, resume=True)


def test_curves_have_the_scripted_and_the_random_policy_beside_them(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib.axes import Axes

    write_json(run.folder / "result.json", experiment.test(run))
    drawn: list[tuple[float, str]] = []
    monkeypatch.setattr(Axes, "axhline", lambda _, y, **style: drawn.append((y, style["label"])))
    curve.plot(run.folder.parent)
    result = read_object(run.folder / "result.json")
    wanted = [(result[f"as trained: {kind}"], kind) for kind in ("scripted", "random")]
    assert drawn == [pair for r, k in wanted for pair in ((100 * r["success_rate"], k), (r["mean_return"], k))]


def test_curves_leave_out_other_folders(run: Run) -> None:
    for name in ("seed-foo", "seed-", "seed-1-old"):
        (run.folder.parent / name).mkdir()
        (run.folder.parent / name / "progress.csv").write_text("nothing")
    curve.plot(run.folder.parent)
    assert (run.folder.parent / "curve.png").is_file()


@pytest.mark.parametrize("name", ["policy.npz", "policy.zip", "normalize.npz", "progress.csv"])
def test_a_failed_checkpoint_leaves_the_old_one_whole(name: str, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    before = contents(run.folder)
    run.model.num_timesteps += 1

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    targets: dict[str, tuple[Any, str]] = {
        "policy.npz": (MlpPolicy, "save"),
        "policy.zip": (run.model, "save"),
        "normalize.npz": (export, "save_normalize"),
        "progress.csv": (checkpoint, "write_rows"),
    }
    monkeypatch.setattr(*targets[name], fail)
    with pytest.raises(OSError, match="No space left"):
        save(run)
    assert contents(run.folder) == before


def test_errors_of_the_system_name_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    assert cli.main(["train", "GStack-v0", "--steps", "128", "--out", str(tmp_path / "file")]) == 1
    assert capsys.readouterr().err == f"gsenv train: {tmp_path / 'file' / 'seed-0'}: Not a directory\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seeds", "1", "2", "1"], "the seed 1 is given twice"),
        (["--seeds", str(2**32)], "must be at most 4294967295"),
        (["--set", "observation=pixels"], "training needs observation='state'"),
        (["--set", "split=test"], "training takes the split 'train'"),
        (["--set", "colour=9"], "unexpected keyword argument 'colour'; its own are"),
    ],
)
def test_bad_commands_are_refused_in_one_sentence(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["train", "GStack-v0", "--out", str(tmp_path / "new"), *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    with pytest.raises(SystemExit) as stop:
        ppo.main(["--out", str(tmp_path / "new"), *arguments])
    assert stop.value.code == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "new").exists()


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
    save(run)
    old = (tmp_path / "policy.zip").read_bytes()

    def fail(path: Path) -> None:
        path.write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(run.model, "save", fail)
    with pytest.raises(OSError, match="disk full"):
        save(run)
    assert names(tmp_path) == POLICY_FILES | {"settings.json", "origin.json"}
    assert (tmp_path / "policy.zip").read_bytes() == old


def test_tensorboard_gets_events_where_it_is_installed(tmp_path: Path) -> None:
    pytest.importorskip("tensorboard")
    kind, settings = EXPERIMENTS[0]
    experiment.train(experiment.prepare(kind, settings, tmp_path))
    assert list((tmp_path / "tensorboard").glob("events.*"))


def test_a_lesson_begins_when_the_one_before_is_passed() -> None:
    settings = Settings(
        arguments={"blocks": 5, "crack_speed": 0.4}, pass_mark=0.5, lessons=({"blocks": 2}, {"blocks": 3})
    )
    course = settings.curriculum(0)
    assert course.current() == {"blocks": 2}
    assert not course.advance(1.0, 4)  # of episodes of before
    course.ended = 8
    assert not course.advance(1.0, 8)
    assert not course.advance(0.49, 4)
    assert not course.advance(float("nan"), 4)
    assert course.advance(0.5, 4)
    assert course.current() == {"blocks": 3}
    assert not course.advance(1.0, 4)
    course.ended = 8
    assert course.advance(1.0, 4)
    assert course.current() == {"blocks": 5}
    course.ended = 8
    assert not course.advance(1.0, 4)
    assert Settings(arguments={"blocks": 5}).curriculum(0).current() == {}


def test_runs_play_episodes_of_their_own(tmp_path: Path) -> None:
    """Other seeds, runs that continue, and runs whose agents share a policy begin with other seeds of their worlds."""
    kind, settings = EXPERIMENTS[0]
    towers = replace(settings, env="tower_v0", arguments={}, lessons=())
    seen: list[int] = []
    for each in (settings, replace(settings, seed=1), replace(towers, seed=2), replace(towers, seed=3)):
        run = experiment.prepare(kind, each, tmp_path / str(each.seed))
        run.normalize.reset()
        seen += sorted(set(run.normalize.get_attr("np_random_seed")))
    experiment.train(experiment.prepare(kind, replace(settings, steps=128), tmp_path / "0", resume=True))
    run = experiment.prepare(kind, settings, tmp_path / "0", resume=True)
    run.normalize.reset()
    seen += run.normalize.get_attr("np_random_seed")
    assert len(set(seen)) == len(seen) == 5 * settings.world_count


def test_the_first_episodes_are_of_the_first_lesson(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, settings = EXPERIMENTS[0]
    run = experiment.prepare(kind, replace(settings, lessons=({"blocks": 2},), arguments={"blocks": 4}), tmp_path)
    seen: list[Any] = []
    reset = run.normalize.reset

    def begin() -> Any:
        seen.append(run.normalize.get_attr("blocks"))
        return reset()

    monkeypatch.setattr(run.normalize, "reset", begin)
    experiment.train(run)
    assert seen == [[2, 2]]


def test_an_interrupted_run_continues_in_its_lesson(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Although no row of progress.csv was due since that lesson began, and no evaluation has been made."""
    kind, settings = EXPERIMENTS[0]
    lessons = ({"blocks": 2}, {"blocks": 3})
    easy = replace(
        settings, lessons=lessons, pass_mark=0.0, arguments={"blocks": 1}, steps=10_000, log_every=9_000,
        evaluate_every=2_000,
    )  # fmt: skip
    run = experiment.prepare(kind, easy, tmp_path)
    algorithm: Any = type(run.model)
    learn = algorithm.train

    def train(model: Any) -> None:
        learn(model)
        if model.env.get_attr("blocks")[0] == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(algorithm, "train", train)
        assert not experiment.train(run)
    assert [row["lesson"] for row in run.rows] == [1]
    again = experiment.prepare(kind, replace(easy, steps=run.steps + 2_048), tmp_path, resume=True)
    assert experiment.train(again)
    assert again.rows[0]["lesson"] == 1
    assert again.rows[-1]["evaluated_success"] != ""
    assert (tmp_path / "best.npz").is_file()


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


def test_what_the_user_sets_holds_in_lessons_and_tests() -> None:
    settings = Settings(
        arguments={"blocks": 5},
        lessons=({"blocks": 2, "crack_speed": 2.0}, {"blocks": 3, "crack_speed": 2.0}, {"blocks": 5}),
        tests=({}, {"crack_speed": 0.3}),
    )
    own = with_arguments(settings, {"blocks": 4, "split": "train"})
    assert own.arguments == {"blocks": 4}
    assert own.lessons == ({"crack_speed": 2.0},)
    assert own.tests == ({"blocks": 4}, {"blocks": 4, "crack_speed": 0.3})
    assert with_arguments(settings, {}) == settings
    assert with_arguments(settings, {"crack_speed": 1.0}).tests == ({"crack_speed": 1.0},)


def test_a_task_that_the_user_sets_is_that_of_its_own_id(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`task="get_up"` makes GRagdoll2D-v0 another task, with lessons and a time limit of its own."""
    started: list[Settings] = []

    def run_seed(_kind: Any, settings: Settings, *_: object) -> int:
        started.append(settings)
        return experiment.INTERRUPTED

    monkeypatch.setattr(experiment, "run_seed", run_seed)
    for env_id, given in (("GRagdoll2D-v0", ["task=get_up"]), ("GRagdoll2D-get-up-v0", [])):
        sets = [word for text in (*given, "randomize=None") for word in ("--set", text)]
        experiment.main(ppo.EXPERIMENT, ["--env", env_id, *sets, "--out", str(tmp_path)])
    named, own = started
    assert named == own
    assert own.env == "GRagdoll2D-get-up-v0"
    assert own.arguments["randomize"] is None


def test_a_short_run_has_a_row_of_its_end(tmp_path: Path) -> None:
    short = replace(PPO, log_every=100_000, evaluate_every=100_000, tests=())
    assert experiment.run_seed(ppo.EXPERIMENT, short, tmp_path / "seed-0") == experiment.OK
    (row,) = read_rows(tmp_path / "seed-0" / "progress.csv")
    assert row["steps"] >= short.steps


def test_staggered_worlds_begin_their_episodes_apart(tmp_path: Path) -> None:
    lengths = {}
    for staggered in (False, True):
        settings = replace(
            PPO, staggered=staggered, world_count=4, env="GRagdoll2D-get-up-v0", arguments={}, lessons=()
        )
        run = experiment.prepare(ppo.EXPERIMENT, replace(settings, steps=4 * 320), tmp_path / str(staggered))
        experiment.train(run)
        lengths[staggered] = [episode["l"] for episode in run.model.ep_info_buffer or ()]
    assert lengths[False] == [300] * 4
    assert len(set(lengths[True][:4])) == 4
