from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from gsenv.envs import ENVS
from gsenv.envs.core.mlp import MlpPolicy
from gsenv.envs.core.policies import named_task
from gsenv.train import evaluate as script
from gsenv.train.evaluate import PolicyError, evaluate, make_actor

GSTACK_OBSERVATIONS = 32


def still(observations: int = GSTACK_OBSERVATIONS) -> MlpPolicy:
    """Holds its block: zero but for a closed magnet."""
    layer = (np.zeros((4, observations), np.float32), np.array([0, 0, 0, -5], np.float32))
    return MlpPolicy(np.zeros(observations, np.float32), np.ones(observations, np.float32), (layer,))


def test_scripted_builds_and_random_does_not() -> None:
    three = {"blocks": 3}
    assert evaluate(make_actor("scripted", "GStack-v0"), "GStack-v0", 20, arguments=three).success_rate >= 0.9
    result = evaluate(make_actor("random", "GStack-v0"), "GStack-v0", 100, arguments=three)
    assert result.success_rate < 0.05
    assert result.episodes == 100


def test_equals_single_episodes() -> None:
    result = evaluate(make_actor("scripted", "GStack-v0"), "GStack-v0", 2, seed=7, arguments={"blocks": 1})
    lengths, returns = [], []
    for seed in (7, 8):
        env = gymnasium.make("GStack-v0", blocks=1, split="test")
        observation, _ = env.reset(seed=seed)
        done, length, total = False, 0, 0.0
        while not done:
            observation, reward, terminated, truncated, _ = env.step(make_actor("scripted", "GStack-v0")(observation))
            done, length, total = terminated or truncated, length + 1, total + float(reward)
        lengths.append(length)
        returns.append(total)
    assert result.mean_length == np.mean(lengths)
    assert result.mean_return == pytest.approx(np.mean(returns))


def test_evaluates_episodes_that_training_never_sees() -> None:
    """The same seeds of the split "train" are other episodes; `--set split=train` evaluates those."""
    actor = make_actor("scripted", "GStack-v0")
    results = [
        evaluate(actor, "GStack-v0", 5, arguments=given) for given in ({}, {"split": "test"}, {"split": "train"})
    ]
    assert results[0] == results[1] != results[2]


def test_time_limits_end_episodes() -> None:
    ended: list[int] = []
    result = evaluate(still(), "GStack-v0", 2, on_episodes=ended.append)
    assert ended == sorted(ended)
    assert ended[-1] == 2
    assert result.mean_length == 600
    assert result.success_rate == 0.0


def test_batches_give_what_one_batch_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    """So many episodes need no more memory than few."""
    actor = make_actor("scripted", "GStack-v0")
    ended: list[int] = []
    whole = evaluate(actor, "GStack-v0", 5, arguments={"blocks": 1})
    monkeypatch.setattr(script, "BATCH", 2)
    assert evaluate(actor, "GStack-v0", 5, arguments={"blocks": 1}, on_episodes=ended.append) == whole
    assert ended == sorted(ended)
    assert ended[-1] == 5


@pytest.mark.parametrize("observation", ["pixels", "state+pixels"])
def test_pixels_are_refused(observation: str) -> None:
    with pytest.raises(ValueError, match="an evaluation needs observation='state'"):
        evaluate(make_actor("scripted", "GStack-v0"), "GStack-v0", 1, arguments={"observation": observation})


def test_random_actions_are_not_what_the_episode_of_their_seed_is_drawn_from() -> None:
    drawn = np.random.default_rng(5).uniform(-1.0, 1.0, 12)
    for action in make_actor("random", "GStack-v0", 5)(np.zeros((3, 32), np.float32)).ravel():
        assert abs(drawn - action).min() > 1e-6


@pytest.mark.parametrize("entry", ENVS, ids=lambda entry: entry.id)
def test_random_policies_of_all_environments(entry: object) -> None:
    env_id: str = entry.id  # type: ignore[attr-defined]
    space = gymnasium.make(env_id).action_space
    actions = make_actor("random", env_id)(np.zeros((5, 3), np.float32))
    assert all(space.contains(action) for action in actions)


def test_policy_files(tmp_path: Path) -> None:
    still().save(tmp_path / "policy.npz")
    actor = make_actor(str(tmp_path / "policy.npz"), "GStack-v0")
    np.testing.assert_array_equal(actor(np.zeros((1, GSTACK_OBSERVATIONS), np.float32)), [[0, 0, 0, -1]])
    still(7).save(tmp_path / "other.npz")
    (tmp_path / "broken.npz").write_text("no archive")
    for policy, message in (
        ("other.npz", "is for 7 observations"),
        ("broken.npz", "is not a policy"),
        ("missing.npz", "cannot read"),
        ("policy.txt", "an .npz or a .zip file, not"),
    ):
        with pytest.raises(PolicyError, match=message):
            make_actor(str(tmp_path / policy), "GStack-v0")


def test_policies_of_other_tasks_are_refused_and_those_of_other_tiers_are_not(tmp_path: Path) -> None:
    files = {}
    for env_id in ("GStack-hardcore-v0", "GCar-v0", "mine/GCar-v1"):
        files[env_id] = tmp_path / f"{env_id.replace('/', '-')}.npz"
        replace(still(), notes={"env": env_id}).save(files[env_id])
    for env_id in ("GStack-hardcore-v0", "mine/GCar-v1"):
        make_actor(str(files[env_id]), "gsenv:GStack-v0")
    with pytest.raises(PolicyError, match="was trained in GCar-v0: what it sees and does means other things in GStack"):
        make_actor(str(files["GCar-v0"]), "GStack-v0")


def test_policies_of_stable_baselines_files(tmp_path: Path) -> None:
    pytest.importorskip("stable_baselines3")
    (tmp_path / "broken.zip").write_text("no archive")
    with pytest.raises(PolicyError, match="zip is not an MlpPolicy"):
        make_actor(str(tmp_path / "broken.zip"), "GStack-v0")
    with pytest.raises(PolicyError, match="cannot read"):
        make_actor(str(tmp_path / "missing.zip"), "GStack-v0")


def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert script.main(["GStack-v0", "--policy", "scripted", "--episodes", "3", "--set", "blocks=1"]) == 0
    assert "success 100% of 3 episodes" in capsys.readouterr().out
    assert script.main(["GStack-v0", "--policy", "scripted", "--set", "blocks=9"]) == 1
    assert "blocks must be" in capsys.readouterr().err
    for wrong in (["GNothing-v0"], ["GStack-v0", "--episodes", "0"], ["GStack-v0", "--set", "blocks"]):
        with pytest.raises(SystemExit) as error:
            script.main(wrong)
        assert error.value.code == 2


def test_needs_no_torch() -> None:
    code = (
        "import sys; sys.modules['torch'] = sys.modules['stable_baselines3'] = None\n"
        "from gsenv.train import evaluate\n"
        "sys.exit(evaluate.main(['GStack-v0', '--policy', 'scripted', '--episodes', '1', '--set', 'blocks=1']))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    assert "success 100% of 1 episodes" in result.stdout


def test_an_argument_that_makes_another_task_means_the_id_of_that_task() -> None:
    get_up = {"task": "get_up"}
    assert named_task("GRagdoll-v0", get_up | {"push": 0.1}) == ("GRagdoll-get-up-v0", {"push": 0.1})
    assert named_task("gsenv:GRagdoll2D-v0", get_up) == ("gsenv:GRagdoll2D-get-up-v0", {})
    for env_id, arguments in (("GRagdoll-v0", {}), ("GRagdoll-v0", {"task": "balance"}), ("GStack-v0", {"blocks": 2})):
        assert named_task(env_id, arguments) == (env_id, arguments)
    one, other = (make_actor("trained", name, 0, get_up) for name in ("GRagdoll2D-v0", "GRagdoll2D-get-up-v0"))
    observations = np.random.default_rng(0).normal(size=(5, 43)).astype(np.float32)
    np.testing.assert_array_equal(one(observations), other(observations))
    one, other = make_actor("scripted", "GRagdoll2D-v0", 0, get_up), make_actor("scripted", "GRagdoll2D-get-up-v0")
    np.testing.assert_array_equal(one(observations), other(observations))
    with pytest.raises(PolicyError, match="GNone-v0 has no scripted policy"):
        make_actor("scripted", "GNone-v0")


def test_episodes_that_never_end_are_refused() -> None:
    with pytest.raises(ValueError, match="needs episodes that end"):
        evaluate(make_actor("random", "GCar-v0"), "GCar-v0", 2, arguments={"max_episode_steps": -1})
