"""Attributes and methods of the worlds, as gymnasium's own vector environments give them."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode

from gsenv.envs import tower_v0
from gsenv.envs.core.policies import make_batch
from tests.envs.registered import EACH_TASK, IDS, MODES, digest, make, make_sync, make_vector, random_actions

each_task = pytest.mark.parametrize("env_id", EACH_TASK)


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("env_id", IDS)
def test_settings_are_shared_whatever_their_length(env_id: str, count: int) -> None:
    vector, single = make_vector(env_id, count), make(env_id)
    for name in vector.task.settings:
        expected = (single.get_wrapper_attr(name),) * count
        assert vector.get_attr(name) == vector.call(name) == expected
        vector.set_attr(name, vector.get_attr(name))
        assert vector.get_attr(name) == expected


@each_task
def test_what_each_world_has_is_that_of_its_single_environment(env_id: str) -> None:
    name = next(iter(make_vector(env_id, 1).physics))
    value = make_vector(env_id, 1).physics[name][0]
    arguments: dict[str, Any] = {"randomize": {name: (value, 1.01 * value)}, "render_mode": "rgb_array"}
    arguments |= {"width": 32, "height": 16}
    vector = make_vector(env_id, 3, **arguments)
    sync = make_sync(env_id, 3, AutoresetMode.NEXT_STEP, **arguments)
    for envs in (vector, sync):
        envs.reset(seed=5)
    for attribute in ("physics", "np_random_seed", "observation_space", "action_space", "render_mode", "split"):
        assert vector.get_attr(attribute) == sync.get_attr(attribute), attribute
    assert len({physics[name] for physics in vector.get_attr("physics")}) == 3
    assert all(type(value) is float for physics in vector.get_attr("physics") for value in physics.values())
    for one, other in zip(vector.get_attr("np_random"), sync.get_attr("np_random"), strict=True):
        assert one.bit_generator.state == other.bit_generator.state
    for frame, expected in zip(vector.call("render"), sync.call("render"), strict=True):
        np.testing.assert_array_equal(frame, expected)
    assert vector.get_attr("finished") == (False, False, False)
    assert vector.call("metadata") == (vector.metadata,) * 3  # as many entries as there are worlds


def test_observations_of_each_world_and_no_frames_without_a_mode() -> None:
    vector = make_vector("GStack-v0", 2, observation="state+pixels", width=32, height=16)
    batch, _ = vector.reset(seed=0)
    for world, observation in enumerate(vector.call("observe")):
        assert vector.single_observation_space.contains(observation)
        np.testing.assert_array_equal(observation["pixels"], batch["pixels"][world])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert vector.call("render") == (None, None)


@pytest.mark.parametrize("mode", MODES)
@each_task
def test_call_resets_each_world_as_a_single_environment(env_id: str, mode: AutoresetMode) -> None:
    vector, sync = make_vector(env_id, 3, autoreset_mode=mode), make_sync(env_id, 3, mode)
    for arguments in ({"seed": 4}, {}, {"seed": 9, "options": {}}):
        for envs in (vector, sync):
            envs.reset(seed=1)
        assert data_equivalence(vector.call("reset", **arguments), sync.call("reset", **arguments), exact=True)
        assert vector.get_attr("np_random_seed") == sync.get_attr("np_random_seed")
    for actions in random_actions(env_id, 0, 5, 3):
        np.testing.assert_array_equal(vector.step(actions)[0], sync.step(actions)[0])


def test_call_resets_worlds_of_several_agents() -> None:
    vector = make_batch("tower_v0", 3)
    results = vector.call("reset", seed=4, options={"blocks": 2})
    observations, infos = tower_v0.parallel_env().reset(seed=4, options={"blocks": 2})
    for observation, info in results:
        np.testing.assert_array_equal(observation, list(observations.values()))
        assert info.keys() == infos["gripper_0"].keys()
        assert info["reward_placed"].shape == (2,)
    assert vector.get_attr("observation_space") == (vector.single_observation_space,) * 3


def test_what_call_refuses_it_refuses_before_anything_runs() -> None:
    vector = make_vector("GStack-v0", 2)
    vector.reset(seed=0)
    before = digest(vector.save())
    with pytest.raises(ValueError, match="call: worlds cannot be stepped one by one"):
        vector.call("step", np.zeros((2, 4), np.float32))
    with pytest.raises(ValueError, match="unknown option 'reset_mask'"):
        vector.call("reset", options={"reset_mask": np.array([True, False])})
    with pytest.raises(ValueError, match="blocks must be"):
        vector.call("reset", seed=3, options={"blocks": 99})
    with pytest.raises(ValueError, match="a seed must be a whole number"):
        vector.call("reset", seed="3")
    for name in ("physics", "np_random", "np_random_seed", "finished"):
        for value in (vector.get_attr(name), vector.get_attr(name)[0]):
            with pytest.raises(ValueError, match=f"set_attr: '{name}' cannot be set, as each world has its own"):
                vector.set_attr(name, value)
    assert digest(vector.save()) == before


def test_spaces_of_a_batch_stay() -> None:
    vector = make_vector("GStack-v0", 2)
    for name in ("observation_space", "action_space"):
        before = getattr(vector, name)
        vector.set_attr(name, vector.get_attr(name))
        with pytest.raises(ValueError, match=f"set_attr: '{name}' is set when the environment is made"):
            vector.set_attr(name, gymnasium.spaces.Discrete(3))
        assert getattr(vector, name) is before


@pytest.mark.parametrize("build", [
    lambda: make("GStack-v0").unwrapped,
    lambda: make_vector("GStack-v0", 2),
    lambda: make_batch("tower_v0", 2),
    tower_v0.parallel_env,
])  # fmt: skip
def test_the_render_mode_stays(build: Callable[[], Any]) -> None:
    env = build()
    env.render_mode = None
    for mode in ("rgb_array", "human", "x"):
        with pytest.raises(ValueError, match=r"^render_mode is set when the environment is made, and stays\.$"):
            env.render_mode = mode
        assert env.render_mode is None


def test_the_render_mode_stays_behind_wrappers() -> None:
    env = make("GStack-v0", render_mode="rgb_array")
    with pytest.raises(ValueError, match="render_mode is set when"):
        env.unwrapped.set_wrapper_attr("render_mode", None)
    assert env.render_mode == "rgb_array"


def test_pictures_are_drawn_once_for_each_observation(monkeypatch: pytest.MonkeyPatch) -> None:
    vector = make_vector("GStack-v0", 4, observation="pixels", width=16, height=16, autoreset_mode="Disabled")
    drawn: list[int] = []
    original = type(vector._observer)._render

    def counted(observer: Any, task: Any, world: int) -> Any:
        drawn.append(world)
        return original(observer, task, world)

    monkeypatch.setattr(type(vector._observer), "_render", counted)
    mask = vector.begin_episodes(3)
    assert mask.all()
    assert drawn == []
    expected = vector.observe()
    np.testing.assert_array_equal(vector.reset(seed=3)[0], expected)
    assert drawn == [0, 1, 2, 3] * 2
    before = digest(vector.save())
    cases: list[tuple[Any, Any, str]] = [
        (None, {"blocks": 99}, "blocks must be"),
        ([1], None, "4 seeds are needed"),
        (None, {"reset_mask": np.zeros(4, bool)}, "at least one True"),
    ]
    for seed, options, message in cases:
        with pytest.raises(ValueError, match=message):
            vector.begin_episodes(seed, options)
    assert digest(vector.save()) == before
