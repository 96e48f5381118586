"""BatchedVecEnv against Stable-Baselines3's own DummyVecEnv."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from gsenv.adapters.sb3 import BatchedVecEnv
from gsenv.envs.stack.env import StackEnv
from tests.envs.registered import EACH_TASK


def make(env_id: str = "gsenv:GStack-v0", count: int = 3, seed: int | None = 5, **arguments: Any) -> Any:
    made = make_vec_env(env_id, count, seed, vec_env_cls=BatchedVecEnv, **arguments)  # type: ignore[arg-type]
    assert isinstance(made, BatchedVecEnv)
    return made


def assert_equal_infos(a: dict[str, Any], b: dict[str, Any]) -> None:
    assert a.keys() == b.keys()
    for key in a:
        if key == "episode":
            assert {**a[key], "t": 0} == {**b[key], "t": 0}
        else:
            np.testing.assert_array_equal(a[key], b[key], err_msg=key)


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_goes_through_the_same_states_as_dummy_vec_env(env_id: str) -> None:
    dummy = make_vec_env(f"gsenv:{env_id}", 3, 5)
    batched = make(f"gsenv:{env_id}", vec_env_kwargs={"infos": "all"})
    np.testing.assert_array_equal(dummy.reset(), batched.reset())
    for ours, theirs in zip(batched.reset_infos, dummy.reset_infos, strict=True):
        assert_equal_infos(ours, theirs)
    generator = np.random.default_rng(0)
    ended = 0
    for _ in range(80):
        actions = generator.uniform(-1.0, 1.0, (3, *batched.action_space.shape)).astype(np.float32)
        expected: tuple[Any, ...] = dummy.step(actions)
        results = batched.step(actions)
        for a, b in zip(results[:3], expected[:3], strict=True):
            np.testing.assert_array_equal(a, b)
            assert a.dtype == b.dtype
        for info, expected_info in zip(results[3], expected[3], strict=True):
            assert_equal_infos(info, expected_info)
        ended += int(results[2].sum())
    assert ended >= 2 or env_id != "GStack-v0"


def test_infos_of_worlds_that_go_on_are_empty_and_fresh() -> None:
    envs = make()
    envs.reset()
    idle = np.tile(np.array([0, 0, 0, -1], np.float32), (3, 1))
    infos = envs.step(idle)[3]
    assert infos == [{}, {}, {}]
    infos[0]["mine"] = 1
    assert envs.step(idle)[3] == [{}, {}, {}]


def test_end_by_the_time_limit() -> None:
    envs: Any = BatchedVecEnv([lambda: Monitor(gymnasium.make("GStack-v0", max_episode_steps=4))] * 2)
    envs.seed(0)
    first = envs.reset()
    idle = np.tile(np.array([0, 0, 0, -1], np.float32), (2, 1))
    for _ in range(3):
        observations, _, dones, infos = envs.step(idle)
        assert not dones.any()
    last = observations
    observations, rewards, dones, infos = envs.step(idle)
    assert rewards.dtype == np.float32
    assert dones.all()
    for w in range(2):
        assert infos[w]["TimeLimit.truncated"] is True
        assert infos[w]["episode"]["l"] == 4
        assert envs.observation_space.contains(infos[w]["terminal_observation"])
        assert not np.array_equal(infos[w]["terminal_observation"], observations[w])
        assert np.abs(infos[w]["terminal_observation"] - last[w]).max() < 1.0
    assert (observations != first).any()


def test_results_are_fresh() -> None:
    envs = make()
    kept = envs.reset()
    before = kept.copy()
    results = [envs.step(np.zeros((3, 4), np.float32)) for _ in range(2)]
    np.testing.assert_array_equal(kept, before)
    for a, b in zip(results[0][:3], results[1][:3], strict=True):
        assert a is not b
        assert not np.shares_memory(a, b)


def test_seeds_and_options_count_once() -> None:
    envs = make(seed=None)
    envs.seed(7)
    envs.set_options([{"blocks": 1}, {"blocks": 2}, {}])
    first = envs.reset()
    assert (8 * first[:, 28]).tolist() == [1.0, 2.0, 5.0]
    second = envs.reset()
    assert (8 * second[:, 28]).tolist() == [5.0, 5.0, 5.0]
    assert (first[:, :2] != second[:, :2]).any()
    envs.seed(7)
    np.testing.assert_array_equal(envs.reset()[:, :2], first[:, :2])


def test_attributes_are_shared_and_spaces_are_of_one_world() -> None:
    envs = make()
    assert envs.get_attr("blocks") == [5, 5, 5]
    envs.set_attr("blocks", 2)
    assert envs.get_attr("blocks", [0, 2]) == [2, 2]
    envs.reset()
    assert envs.get_attr("action_space", 1) == [envs.action_space]
    assert envs.get_attr("observation_space", 1) == [envs.observation_space]
    assert envs.get_attr("render_mode", 0) == ["rgb_array"]
    assert not envs.has_attr("nothing")
    with pytest.raises(ValueError, match="'blocks' is shared by all worlds"):
        envs.set_attr("blocks", 3, indices=[1])
    with pytest.raises(AttributeError):
        envs.set_attr("nothing", 3)


def test_methods() -> None:
    envs = make()
    before = envs.reset()
    frames = envs.env_method("render", indices=[2])
    assert frames[0].shape == (480, 640, 3)
    (pair,) = envs.env_method("reset", seed=99, options={"blocks": 1}, indices=[1])
    assert pair[1] == envs.reset_infos[1]
    single = StackEnv().reset(seed=99, options={"blocks": 1})
    np.testing.assert_array_equal(pair[0], single[0])
    np.testing.assert_array_equal(envs.batch.observe()[[0, 2]], before[[0, 2]])


def test_images_are_tiled() -> None:
    envs = make(count=2)
    envs.reset()
    picture = envs.render()
    assert picture is not None
    assert picture.shape[2] == 3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        silent = make(env_kwargs={"render_mode": None})
        silent.reset()
        assert silent.get_images() == [None, None, None]


def test_pixels() -> None:
    envs = make(count=2, env_kwargs={"observation": "pixels"})
    assert envs.reset().shape == (2, 84, 84, 3)
    release = np.tile(np.array([0, 0, 0, 1], np.float32), (2, 1))
    for _ in range(80):
        observations, _, dones, infos = envs.step(release)
        assert observations.dtype == np.uint8
        for w in np.flatnonzero(dones):
            assert infos[w]["terminal_observation"].shape == (84, 84, 3)
            return
    pytest.fail("no world ended")


def test_state_and_pixels_are_a_dict_as_in_a_dummy_vec_env() -> None:
    kwargs: dict[str, Any] = {"observation": "state+pixels", "width": 48, "height": 48, "blocks": 1}
    envs = make(count=2, env_kwargs=kwargs)
    dummy = make_vec_env("gsenv:GStack-v0", 2, env_kwargs=kwargs)
    starts: list[Any] = []
    for vec_env in (envs, dummy):
        vec_env.seed(5)
        starts.append(vec_env.reset())
    release = np.tile(np.array([0, 0, 0, 1], np.float32), (2, 1))
    ends = 0
    for _ in range(80):
        results: list[Any] = [vec_env.step(release) for vec_env in (envs, dummy)]
        for name in ("state", "pixels"):
            np.testing.assert_array_equal(starts[0][name], starts[1][name])
            np.testing.assert_array_equal(results[0][0][name], results[1][0][name])
            for w in np.flatnonzero(results[0][2]):
                last = [result[3][w]["terminal_observation"][name] for result in results]
                np.testing.assert_array_equal(last[0], last[1], strict=True)
                ends += 1
    assert ends > 0
    model = PPO("MultiInputPolicy", envs, n_steps=8, batch_size=16, n_epochs=1, device="cpu")
    assert model.learn(16).num_timesteps == 16


def test_monitor_is_known_and_its_file_holds_all_episodes(tmp_path: Path) -> None:
    envs = make(monitor_dir=str(tmp_path), monitor_kwargs={"info_keywords": ("placed",)})
    assert envs.env_is_wrapped(Monitor) == [True, True, True]
    assert envs.env_is_wrapped(Monitor, indices=[0]) == [True]
    assert envs.env_is_wrapped(gymnasium.wrappers.RescaleAction) == [False, False, False]
    envs.reset()
    count = 0
    for _ in range(80):
        _, _, dones, infos = envs.step(np.ones((3, 4), np.float32))
        for w in np.flatnonzero(dones):
            assert infos[w]["episode"]["placed"] == infos[w]["placed"]
            count += 1
    envs.close()
    (file,) = tmp_path.glob("*.monitor.csv")
    lines = file.read_text().splitlines()
    assert lines[1] == "r,l,t,placed"
    assert len(lines) == 2 + count
    assert count >= 3


def test_without_a_monitor_there_are_no_episodes() -> None:
    envs = BatchedVecEnv([lambda: gymnasium.make("GStack-v0")] * 2)
    assert envs.env_is_wrapped(Monitor) == [False, False]
    envs.reset()
    for _ in range(80):
        _, _, dones, infos = envs.step(np.ones((2, 4), np.float32))
        for w in np.flatnonzero(dones):
            assert "episode" not in infos[w]


@pytest.mark.parametrize(("make_one", "message"), [
    (lambda: gymnasium.wrappers.ClipAction(gymnasium.make("GStack-v0")), "wrapper ClipAction"),
    (lambda: gymnasium.make("CartPole-v1"), "an environment of gsenv made by its id"),
    (StackEnv, "an environment of gsenv made by its id"),
])  # fmt: skip
def test_what_cannot_be_batched_is_refused(make_one: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BatchedVecEnv([make_one])


def test_bad_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="at least one function"):
        BatchedVecEnv([])
    with pytest.raises(ValueError, match="infos must be 'ended' or 'all', got 'some'"):
        BatchedVecEnv([lambda: gymnasium.make("GStack-v0")], infos="some")


def test_arguments_of_the_environment_reach_the_batch() -> None:
    envs = make(env_kwargs={"blocks": 2, "success_time": 0.5}, vec_env_kwargs={"threads": 2})
    assert envs.get_attr("blocks") == [2, 2, 2]
    assert envs.batch.task.settings["success_time"] == 0.5
    assert envs.batch.max_episode_steps == 600
    assert envs.batch.task.threads == 2


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_single_environments_pass_the_checker(env_id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(env_id).unwrapped, warn=True)


def test_vec_normalize_is_saved_and_loaded(tmp_path: Path) -> None:
    normalize: Any = VecNormalize(make())
    normalize.reset()
    for _ in range(60):
        normalize.step(np.ones((3, 4), np.float32))
    normalize.save(str(tmp_path / "normalize.pkl"))
    loaded: Any = VecNormalize.load(str(tmp_path / "normalize.pkl"), make())
    np.testing.assert_array_equal(loaded.obs_rms.mean, normalize.obs_rms.mean)
    np.testing.assert_array_equal(loaded.reset(), loaded.normalize_obs(loaded.get_original_obs()))


def test_ppo_learns_the_same_from_it_as_from_dummy_vec_env() -> None:
    weights = []
    for cls in (DummyVecEnv, BatchedVecEnv):
        envs = make_vec_env("gsenv:GStack-v0", 4, seed=1, vec_env_cls=cls)  # type: ignore[arg-type]
        model = PPO("MlpPolicy", envs, n_steps=64, batch_size=64, n_epochs=1, seed=1, device="cpu")
        model.learn(512)
        assert len(model.ep_info_buffer or ()) > 2
        weights.append(model.policy.action_net.weight.detach().numpy())  # type: ignore[operator]
    np.testing.assert_array_equal(weights[0], weights[1])


@pytest.mark.parametrize("pair", [(0.2, 0.25), np.array([0.2, 0.25])])
def test_set_attr_takes_a_pair_as_one_value(pair: Any) -> None:
    envs = make(count=2)  # as many worlds as the pair has numbers
    envs.set_attr("half_width", pair)
    assert envs.batch.half_width == (0.2, 0.25)
