"""What BatchedVecEnv and AgentVecEnv give of each environment, against Stable-Baselines3's own DummyVecEnv."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecNormalize

from gsenv.adapters.sb3 import BatchedVecEnv
from gsenv.adapters.sb3_agents import AgentVecEnv
from gsenv.envs import tower_v0
from gsenv.envs.core.pixels import Observer
from tests.envs.registered import digest

COUNT = 3
SMALL: dict[str, Any] = {"width": 32, "height": 16}


def batched(count: int = COUNT, **arguments: Any) -> Any:
    cls: Any = BatchedVecEnv  # SB3 declares its own two classes alone
    return make_vec_env("gsenv:GStack-v0", count, 5, vec_env_cls=cls, env_kwargs=arguments)


def dummy(count: int = COUNT, **arguments: Any) -> Any:
    return make_vec_env("gsenv:GStack-v0", count, 5, env_kwargs=arguments)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The worlds of which pictures have been drawn."""
    worlds: list[int] = []
    original = Observer._render

    def counted(observer: Observer, task: Any, world: int) -> Any:
        worlds.append(world)
        return original(observer, task, world)

    monkeypatch.setattr(Observer, "_render", counted)
    return worlds


# ---------------------------------------------------------------- attributes and methods


def test_attributes_are_those_of_a_dummy_vec_env() -> None:
    envs, others = batched(randomize={"friction": (0.5, 1.5)}), dummy(randomize={"friction": (0.5, 1.5)})
    for vec_env in (envs, others):
        vec_env.reset()
    for name in ("half_width", "reward_weights", "physics", "np_random_seed", "observation_space", "spec", "split"):
        assert envs.get_attr(name) == others.get_attr(name), name
        assert envs.env_method("get_wrapper_attr", name) == envs.get_attr(name)
    assert envs.get_attr("spec")[0].max_episode_steps == 600
    assert len({physics["friction"] for physics in envs.get_attr("physics")}) == COUNT


@pytest.mark.parametrize("name", ["blocks", "half_width", "nothing"])
def test_wrapper_attributes_are_those_of_a_dummy_vec_env(name: str) -> None:
    for vec_env in (batched(), dummy()):
        known = name != "nothing"
        assert vec_env.env_method("has_wrapper_attr", name) == [known] * COUNT
        assert vec_env.env_method("has_wrapper_attr", name, indices=[1]) == [known]
        if not known:
            with pytest.raises(AttributeError):
                vec_env.env_method("get_wrapper_attr", name)
            assert vec_env.env_method("set_wrapper_attr", name, 2, force=False) == [False] * COUNT
            continue
        value: Any = {"blocks": 2, "half_width": (0.2, 0.25)}[name]
        assert vec_env.env_method("set_wrapper_attr", name, value) == [True] * COUNT
        assert vec_env.env_method("get_wrapper_attr", name, indices=[0, 2]) == [value] * 2
        assert vec_env.get_attr(name) == [value] * COUNT


@pytest.mark.parametrize("build", [batched, lambda: AgentVecEnv("tower_v0", 2)])
def test_looking_for_a_method_does_not_call_it(build: Any) -> None:
    envs = build()
    envs.reset()
    before = digest(envs.batch.save())
    for name in ("reset", "step", "close", "render", "has_wrapper_attr"):
        assert envs.has_attr(name)
    assert not envs.batch.closed
    assert digest(envs.batch.save()) == before
    assert envs.get_attr("has_wrapper_attr")[1]("blocks") is True
    assert callable(envs.get_attr("reset", -1)[0])


def test_what_belongs_to_all_worlds_or_stays_is_refused() -> None:
    envs = batched()
    envs.reset()
    before = digest(envs.batch.save())
    for name in ("spec", "observation_space", "render_mode"):
        envs.set_attr(name, envs.get_attr(name)[0])
        with pytest.raises(ValueError, match=f"set_attr: '{name}' is set when the environment is made, and stays"):
            envs.set_attr(name, "human")
    with pytest.raises(ValueError, match="call: worlds cannot be stepped one by one"):
        envs.env_method("step", np.zeros(4, np.float32))
    with pytest.raises(ValueError, match="'blocks' is shared by all worlds"):
        envs.env_method("set_wrapper_attr", "blocks", 2, indices=[0])
    with pytest.raises(ValueError, match="unknown option 'reset_mask'"):
        envs.env_method("reset", options={"reset_mask": np.array([True, False, False])}, indices=[1])
    assert envs.env_method("reset", indices=[]) == []
    assert digest(envs.batch.save()) == before


# ---------------------------------------------------------------- resets


@pytest.mark.parametrize(("options", "message"), [
    ([{"blocks": 3}, {"blocks": 99}, {}], "blocks must be"),
    ([{}, {}, {"bloks": 3}], "unknown option 'bloks'"),
    ([{}, {}, {"reset_mask": np.ones(3, bool)}], "unknown option 'reset_mask'"),
    ([{"blocks": 3}], "3 dicts of options are needed, got 1"),
    ([{}, 5, {}], "options must be a dict"),
])  # fmt: skip
def test_bad_options_of_one_world_change_none(options: Any, message: str) -> None:
    envs = batched()
    envs.reset()
    envs.step(np.ones((3, 4), np.float32))
    before = digest([envs.batch.save(), envs._lengths, envs._returns])
    envs.set_options(options)
    with pytest.raises(ValueError, match=message):
        envs.reset()
    assert digest([envs.batch.save(), envs._lengths, envs._returns]) == before
    envs.set_options()
    envs.reset()


def test_options_of_each_world_reach_it() -> None:
    options = [{"blocks": 2, "half_width": (0.2, 0.2)}, {"reward_weights": {"placed": 3.0}}, {"half_width": [0.2, 0.2]}]
    starts = []
    for vec_env in (batched(), dummy()):
        vec_env.set_options(options)
        starts.append(vec_env.reset())
    np.testing.assert_array_equal(*starts)


def test_pictures_are_drawn_once(drawn: list[int]) -> None:
    envs = batched(16, observation="pixels", blocks=1, **SMALL)
    envs.set_options([{"blocks": 1 + i % 2} for i in range(16)])
    envs.reset()
    assert sorted(drawn) == list(range(16))
    for _ in range(200):
        drawn.clear()
        actions = np.zeros((16, 4), np.float32)
        actions[3, 3] = 1.0  # world 3 drops its block, which cracks
        dones = envs.step(actions)[2]
        assert len(drawn) == 16 + dones.sum()
        if dones.any():
            break
    assert np.flatnonzero(dones).tolist() == [3]
    drawn.clear()
    envs.env_method("reset", indices=[2, 5])
    assert drawn == [2, 5]


# ---------------------------------------------------------------- agents


def test_attributes_of_an_agent() -> None:
    envs, parallel = AgentVecEnv("tower_v0", 2), tower_v0.parallel_env()
    for name in ("observation_space", "action_space"):
        expected = getattr(parallel, name)("gripper_0")
        assert envs.get_attr(name) == envs.env_method("get_wrapper_attr", name) == [expected] * 4
        assert getattr(envs, name) == expected
        with pytest.raises(ValueError, match=f"'{name}' is set when the environment is made"):
            envs.set_attr(name, gymnasium.spaces.Discrete(2))
    envs.set_attr("half_width", (0.2, 0.25))
    assert envs.get_attr("half_width") == [(0.2, 0.25)] * 4
    assert envs.env_method("has_wrapper_attr", "blocks", indices=[3]) == [True]


def test_methods_of_an_agent() -> None:
    envs = AgentVecEnv("tower_v0", 3, blocks=2)
    envs.seed(0)
    before = envs.reset()
    results = envs.env_method("reset", seed=8, options={"blocks": 4}, indices=[2, 3])
    observations, infos = tower_v0.parallel_env(blocks=2).reset(seed=8, options={"blocks": 4})
    for (observation, info), agent in zip(results, observations, strict=True):
        np.testing.assert_array_equal(observation, observations[agent])
        assert info == infos[agent]
    assert [result[1] for result in results] == envs.reset_infos[2:4]
    after = envs.batch.observe().reshape(6, -1)
    np.testing.assert_array_equal(after[[0, 1, 4, 5]], before[[0, 1, 4, 5]])
    assert len(envs.env_method("reset")) == 6
    saved = digest(envs.batch.save())
    with pytest.raises(ValueError, match=r"the agents of a world begin together, but indices \[2, 3, 4\] lack some"):
        envs.env_method("reset", indices=[2, 3, 4])
    with pytest.raises(ValueError, match="call: worlds cannot be stepped one by one"):
        envs.env_method("step", np.zeros(4))
    assert digest(envs.batch.save()) == saved


def test_options_of_each_world_of_agents() -> None:
    envs = AgentVecEnv("tower_v0", 2)
    envs.seed(3)
    envs.set_options([{"blocks": 2}, {"blocks": 2}, {"blocks": 4}, {"blocks": 4}])
    observations = envs.reset()
    for w, blocks in enumerate((2, 4)):
        expected, _ = tower_v0.parallel_env(blocks=blocks).reset(seed=3 + w)
        np.testing.assert_array_equal(observations[2 * w : 2 * w + 2], list(expected.values()))
    saved = digest(envs.batch.save())
    for options, message in (
        ([{"blocks": 2}, {}, {}, {}], "the agents of a world need equal options, those of world 0 differ"),
        ([{}, {}, {"blocks": 2}, {"blocks": 4}], "those of world 1 differ"),
        ([{"blocks": 2}, {"blocks": 2}, {"blocks": 99}, {"blocks": 99}], "blocks must be"),
        ([{"blocks": 2}, {"blocks": 2}], "4 dicts of options are needed, got 2"),
    ):
        envs.set_options(options)
        with pytest.raises(ValueError, match=message):
            envs.reset()
    assert digest(envs.batch.save()) == saved


@pytest.mark.parametrize("observation", ["pixels", "state+pixels"])
def test_agents_see_pictures(observation: str, drawn: list[int]) -> None:
    arguments: dict[str, Any] = {"blocks": 2, "observation": observation, **SMALL}
    envs, parallel = AgentVecEnv("tower_v0", 2, **arguments), tower_v0.parallel_env(**arguments)
    assert envs.observation_space == parallel.observation_space("gripper_0")
    envs.seed(3)
    seen = envs.reset()
    assert sorted(drawn) == [0, 1]
    assert_seen(envs, seen, 2, parallel.reset(seed=4)[0])
    act = np.zeros((4, 4), np.float32)
    act[2:, 3] = 1.0  # world 1 drops its blocks
    for _ in range(200):
        drawn.clear()
        seen, _, dones, infos = envs.step(act)
        results = parallel.step(dict(zip(parallel.agents, act[2:], strict=True)))
        assert len(drawn) == 2 + dones[::2].sum() + 1  # one is the parallel environment's
        if dones.any():
            break
        assert_seen(envs, seen, 2, results[0])
    assert dones.tolist() == [False, False, True, True]
    for i, agent in enumerate(("gripper_0", "gripper_1"), 2):
        last = infos[i]["terminal_observation"]
        assert envs.observation_space.contains(last)
        assert digest(last) == digest(results[0][agent])
    assert_seen(envs, seen, 2, parallel.reset()[0])


def assert_seen(envs: Any, seen: Any, first: int, expected: dict[str, Any]) -> None:
    """That the environments from `first` on see what the agents see."""
    for i, observation in enumerate(expected.values(), first):
        own = {name: array[i] for name, array in seen.items()} if isinstance(seen, dict) else seen[i]
        assert envs.observation_space.contains(own)
        assert digest(own) == digest(observation)


def test_agents_learn_from_pictures_and_state() -> None:
    envs = AgentVecEnv("tower_v0", 1, observation="state+pixels", width=36, height=36)
    policy = {"net_arch": [8], "features_extractor_kwargs": {"cnn_output_dim": 8}}
    normalized = VecNormalize(envs, norm_obs_keys=["state"])
    model = PPO("MultiInputPolicy", normalized, n_steps=8, batch_size=16, n_epochs=1, policy_kwargs=policy)
    assert model.learn(16).num_timesteps == 16
