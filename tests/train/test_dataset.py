"""Minari datasets of policies."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from gsenv import cli
from gsenv.train import dataset
from gsenv.train.evaluate import PolicyError, evaluate, make_actor

minari = pytest.importorskip("minari")  # of the extra "test"
pytest.importorskip("h5py")  # its storage
BLOCKS = {"blocks": 1}  # short episodes
NAME = "gsenv/GStack-v0/test-v0"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr(dataset, "SCORED_EPISODES", 3)
    monkeypatch.setattr(dataset, "BATCH", 2)  # so that three episodes are two batches
    return tmp_path


@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_the_recovered_environment_repeats_each_episode_bit_for_bit(noise: float) -> None:
    made = dataset.make_dataset("scripted", "GStack-v0", NAME, 3, seed=5, noise=noise, arguments=BLOCKS)
    loaded = minari.load_dataset(made.spec.dataset_id)
    env = loaded.recover_environment()
    seeds = [data["seed"] for data in loaded.storage.get_episode_metadata(range(3))]
    assert seeds == [5, 6, 7]
    assert loaded.total_steps == sum(len(episode.actions) for episode in loaded.iterate_episodes())
    for seed, episode in zip(seeds, loaded.iterate_episodes(), strict=True):
        observation, info = env.reset(seed=seed)
        np.testing.assert_array_equal(observation, episode.observations[0])
        assert np.abs(episode.actions).max() <= 1.0
        for t, action in enumerate(episode.actions):
            observation, reward, terminated, truncated, info = env.step(action)
            np.testing.assert_array_equal(observation, episode.observations[t + 1])
            assert (reward, terminated, truncated) == (
                episode.rewards[t],
                episode.terminations[t],
                episode.truncations[t],
            )
            assert info["success"] == episode.infos["success"][t + 1]
            assert info["reward_placed"] == episode.infos["reward_placed"][t + 1]
        assert terminated or truncated
        assert not (episode.terminations | episode.truncations)[:-1].any()


def test_noise_widens_the_actions_around_the_same_policy() -> None:
    act = make_actor("scripted", "GStack-v0")
    plain, noisy = (
        next(dataset.run_episodes(act, "GStack-v0", 1, noise=noise, arguments=BLOCKS)) for noise in (0, 0.1)
    )
    np.testing.assert_array_equal(plain.actions[0], act(plain.observations[:1])[0])
    changes = noisy.actions - act(noisy.observations[:-1])
    inside = np.abs(noisy.actions) < 1.0
    assert 0.05 < changes[inside].std() < 0.12


def test_the_evaluation_environment_and_the_scores_are_of_the_split_test() -> None:
    made = dataset.make_dataset("random", "GStack-v0", NAME, 1, arguments=BLOCKS)
    assert made.recover_environment(eval_env=True).unwrapped.split == "test"
    assert made.recover_environment().unwrapped.split == "train"
    random = evaluate(make_actor("random", "GStack-v0"), "GStack-v0", 3, arguments=BLOCKS).mean_return
    scripted = evaluate(make_actor("scripted", "GStack-v0"), "GStack-v0", 3, arguments=BLOCKS).mean_return
    assert minari.get_normalized_score(made, np.array([random])) == pytest.approx(0.0)
    assert minari.get_normalized_score(made, np.array([scripted])) <= 1.0


def test_bad_input_is_refused_before_any_episode(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    def run(*arguments: Any) -> Any:
        raise AssertionError("episodes were run")

    monkeypatch.setattr(dataset, "run_episodes", run)
    with pytest.raises(ValueError, match="several agents"):
        dataset.make_dataset("scripted", "tower_v0", NAME)
    with pytest.raises(ValueError, match="named like gsenv/GStack-v0/own-v0, not 'no version!'"):
        dataset.make_dataset("scripted", "GStack-v0", "no version!")
    with pytest.raises(ValueError, match="named like gsenv/GStack-v0/own-v0, not 'own'"):
        dataset.make_dataset("scripted", "GStack-v0", "own")
    with pytest.raises(ValueError, match="observe the state"):
        dataset.make_dataset("scripted", "GStack-v0", NAME, arguments={"observation": "pixels"})
    with pytest.raises(PolicyError, match="cannot read"):
        dataset.make_dataset("missing.npz", "GStack-v0", NAME)
    (folder / NAME).mkdir(parents=True)
    with pytest.raises(ValueError, match=f"`minari delete {NAME}`"):
        dataset.make_dataset("scripted", "GStack-v0", NAME)


@pytest.mark.skipif(os.name != "posix", reason="limits of a process")
@pytest.mark.parametrize("name", [NAME, "ab-v0", "here/new/ab-v0"])
def test_a_failed_write_leaves_nothing(
    name: str, monkeypatch: pytest.MonkeyPatch, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Not the namespaces either; h5py crashes where it frees what it could not write."""
    import resource

    start = subprocess.Popen

    def start_with_small_files(command: list[str], **arguments: Any) -> Any:
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))  # noqa: E731
        return start(command, preexec_fn=limit, **arguments)

    monkeypatch.setattr(subprocess, "Popen", start_with_small_files)
    (folder / "here").mkdir()
    command = ["dataset", "GStack-v0", "--policy", "scripted", "--episodes", "5", "--set", "blocks=1", "--name", name]
    assert cli.main(command) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"gsenv: cannot write the dataset: {folder}: ")
    assert error.count("\n") == 1
    assert [path.name for path in folder.rglob("*")] == ["here"]
    monkeypatch.undo()
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    assert cli.main(command) == 0


def test_an_unusable_folder_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "file"))
    assert cli.main(["dataset", "GStack-v0", "--policy", "random", "--name", NAME]) == 1
    assert capsys.readouterr().err == f"gsenv: cannot write the dataset: {tmp_path / 'file'}: File exists\n"


def test_bars_of_episodes_and_of_reference_scores() -> None:
    episodes: list[int] = []
    scores: list[tuple[int, int]] = []
    dataset.make_dataset(
        "random", "GStack-v0", NAME, 3, arguments=BLOCKS,
        on_episodes=episodes.append, on_scores=lambda done, count: scores.append((done, count)),
    )  # fmt: skip
    assert episodes == sorted(episodes)
    assert episodes[-1] == 3
    assert scores == sorted(scores)
    assert scores[-1] == (9, 9)  # of random, scripted and trained


def test_the_command_writes_a_dataset(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["dataset", "GStack-v0", "--policy", "random", "--episodes", "2", "--set", "blocks=1"]
    assert cli.main(command) == 0
    assert capsys.readouterr().out.startswith("gsenv/GStack-v0/random-v0: 2 episodes, ")
    env = minari.load_dataset("gsenv/GStack-v0/random-v0").recover_environment()
    assert isinstance(env, gymnasium.Env)
    assert cli.main(command) == 2
    assert "there already is a dataset" in capsys.readouterr().err
    assert cli.main([*command, "--noise", "-1"]) == 2
    assert "is not a number of at least 0" in capsys.readouterr().err
    assert cli.main([*command, "--noise", "1e300"]) == 2
    assert "noise must be 0 to 100" in capsys.readouterr().err
    assert cli.main([*command, "--name", "gsenv/GStack-v0/endless-v0", "--set", "max_episode_steps=-1"]) == 2
    assert "a dataset needs episodes that end, so max_episode_steps must not be -1" in capsys.readouterr().err
    assert cli.main([*command, "--name", ""]) == 2
    assert "a dataset is named like" in capsys.readouterr().err
    assert cli.main(["dataset", "GRagdoll2D-v0", "--set", "task=get_up", *command[2:-2]]) == 0
    assert capsys.readouterr().out.startswith("gsenv/GRagdoll2D-get-up-v0/random-v0: 2 episodes, ")
