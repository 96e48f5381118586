"""BatchedVecEnv against Stable-Baselines3's own DummyVecEnv."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from tests.envs.registered import EACH_TASK, IDS, SETTINGS, make, random_actions

pytest.importorskip("stable_baselines3")  # of the extra "train"

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecMonitor, VecNormalize, VecVideoRecorder

from gsenv.adapters.sb3 import BatchedVecEnv

LIMIT = 7
COUNT = 3


def makers(env_id: str, monitored: bool = True, **arguments: Any) -> list[Any]:
    def one() -> gymnasium.Env[Any, Any]:
        env = make(env_id, **{"max_episode_steps": LIMIT, **arguments})
        return Monitor(env) if monitored else env

    return [one] * COUNT


def timeless(infos: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Infos without the seconds that an episode took."""
    return [{**info, "episode": {**info["episode"], "t": 0.0}} if "episode" in info else info for info in infos]


def assert_same_infos(infos: list[dict[str, Any]], expected: list[dict[str, Any]]) -> None:
    for one, other in zip(timeless(infos), timeless(expected), strict=True):
        last = [info.pop("terminal_observation", None) for info in (one, other)]
        np.testing.assert_array_equal(last[0], last[1], strict=True)
        assert one == other
        assert {type(value) for value in one.values()} == {type(value) for value in other.values()}


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("monitored", [False, True], ids=["bare", "monitored"])
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_equals_dummy_vec_env(env_id: str, monitored: bool, threads: int) -> None:
    envs = BatchedVecEnv(makers(env_id, monitored), threads=threads, infos="all")
    dummy = DummyVecEnv(makers(env_id, monitored))
    for vec_env in (envs, dummy):
        vec_env.seed(4)
    np.testing.assert_array_equal(envs.reset(), dummy.reset(), strict=True)
    assert envs.reset_infos == dummy.reset_infos
    ends = 0
    for k, actions in enumerate(random_actions(env_id, 1, 4 * LIMIT, COUNT)):
        result, expected = envs.step(actions), dummy.step(actions)
        for one, other in zip(result[:3], expected[:3], strict=True):
            np.testing.assert_array_equal(one, other, strict=True)
        assert_same_infos(result[3], expected[3])
        assert_same_infos(envs.reset_infos, dummy.reset_infos)
        ends += int(result[2].sum())
        if k == 2 * LIMIT:
            for vec_env in (envs, dummy):
                vec_env.seed(77)
            np.testing.assert_array_equal(envs.reset(), dummy.reset(), strict=True)
    assert ends >= 2 * COUNT


def test_infos_of_ended_worlds_alone() -> None:
    env_id = IDS[0]
    envs, full = BatchedVecEnv(makers(env_id)), BatchedVecEnv(makers(env_id), infos="all")
    for vec_env in (envs, full):
        vec_env.seed(0)
        vec_env.reset()
    for actions in random_actions(env_id, 1, 2 * LIMIT, COUNT):
        _, _, dones, infos = envs.step(actions)
        expected = full.step(actions)[3]
        assert_same_infos([infos[i] for i in np.flatnonzero(dones)], [expected[i] for i in np.flatnonzero(dones)])
        assert all(infos[i] == {} for i in np.flatnonzero(~dones))


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_options_and_methods_equal_dummy_vec_env(env_id: str) -> None:
    name, value = next(iter(SETTINGS[env_id].items())) if env_id in SETTINGS else (None, None)
    both: list[Any] = [BatchedVecEnv(makers(env_id)), DummyVecEnv(makers(env_id))]
    starts = []
    for vec_env in both:
        vec_env.seed(1)
        options = [{}, {name: value}, {}] if name else {}
        vec_env.set_options(options)
        starts.append([vec_env.reset(), vec_env.reset()])
        starts[-1].append(vec_env.env_method("reset", seed=8, indices=[1])[0][0])
        starts[-1].append(vec_env.step(random_actions(env_id, 0, 1, COUNT)[0])[0])
        assert vec_env.env_is_wrapped(Monitor) == [True] * COUNT
        assert vec_env.get_attr("render_mode") == [None] * COUNT
        assert vec_env.get_attr("spec", indices=0)[0].id == env_id
        if name:
            vec_env.set_attr(name, value)
            assert vec_env.get_attr(name) == [value] * COUNT
        for key, item in (("render_fps", 30), ("render_modes", ["human", "rgb_array"])):
            assert vec_env.metadata[key] == item
        with pytest.raises(AttributeError):
            vec_env.get_attr("nothing_of_this_name")
        vec_env.close()
    for one, other in zip(*starts, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_make_vec_env_needs_no_other_change(env_id: str, tmp_path: Path) -> None:
    batched: Any = BatchedVecEnv  # SB3 declares its own two classes alone
    envs = make_vec_env(f"gsenv:{env_id}", COUNT, seed=3, monitor_dir=str(tmp_path), vec_env_cls=batched)
    dummy = make_vec_env(f"gsenv:{env_id}", COUNT, seed=3)
    np.testing.assert_array_equal(envs.reset(), dummy.reset())
    envs.env_method("reset", seed=0)
    limit = gymnasium.spec(env_id).max_episode_steps
    assert limit is not None
    envs.batch.max_episode_steps = LIMIT  # type: ignore[attr-defined]
    for actions in random_actions(env_id, 1, LIMIT, COUNT):
        envs.step(actions)
    envs.close()
    (path,) = tmp_path.glob("*.monitor.csv")  # one for all worlds
    header, names, *episodes = path.read_text().splitlines()
    assert json.loads(header[1:])["env_id"] == env_id
    assert names == "r,l,t"
    assert len(episodes) >= COUNT
    assert all(1 <= int(episode.split(",")[1]) <= LIMIT for episode in episodes)


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_wrappers_and_training_run(env_id: str, tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    size: dict[str, Any] = {"render_mode": "rgb_array", "width": 64, "height": 48}
    inner = BatchedVecEnv(makers(env_id, **size))
    recorder = VecVideoRecorder(inner, str(tmp_path), lambda step: step == 0, video_length=5)
    envs = VecNormalize(VecFrameStack(VecMonitor(recorder), 2))
    model = PPO("MlpPolicy", envs, n_steps=16, batch_size=16, n_epochs=1, policy_kwargs={"net_arch": [8]}, seed=0)
    model.learn(2 * 16 * COUNT)
    assert len(model.ep_info_buffer) > 0  # type: ignore[arg-type]
    envs.close()
    assert list(tmp_path.glob("*.mp4"))


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_what_cannot_be_batched_is_refused(env_id: str) -> None:
    scaled = partial(gymnasium.wrappers.RescaleAction, min_action=np.float32(-2), max_action=np.float32(2))
    with pytest.raises(ValueError, match="RescaleAction"):
        BatchedVecEnv([lambda: scaled(make(env_id))])
    with pytest.raises(ValueError, match="gsenv"):
        BatchedVecEnv([partial(gymnasium.make, "CartPole-v1")])
    with pytest.raises(ValueError, match="env_fns"):
        BatchedVecEnv([])
    with pytest.raises(ValueError, match="infos"):
        BatchedVecEnv(makers(env_id), infos="none")
    envs = BatchedVecEnv(makers(env_id))
    with pytest.raises(ValueError, match="shared"):
        envs.set_attr("render_mode", None, indices=[0])
