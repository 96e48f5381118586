"""A world whose numbers overflow ends its episode with finite numbers, and the others go on bit for bit."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gsenv.envs import tower_v0
from gsenv.envs.core.vector import TaskVectorEnv
from tests.envs.registered import EACH_TASK, make, make_vector, random_actions

COUNT, LOST = 4, 2


WAYS = {"velocity": np.inf, "fast": 1e200, "position": np.nan}  # what spoils a world


def spoil(world: Any, number: int, way: str = "velocity") -> None:
    """Give all bodies of a world velocities or positions that overflowed, or do so in the next step."""
    field = "position" if way == "position" else "velocity"
    world.state.bodies[field][number] = WAYS[way]


def under_way(env_id: str, mode: AutoresetMode) -> TaskVectorEnv:
    vector = make_vector(env_id, COUNT, autoreset_mode=mode)
    vector.reset(seed=3)
    for action in random_actions(env_id, 3, 3, COUNT):
        vector.step(action)
    return vector


@pytest.mark.filterwarnings("ignore:World. by step:RuntimeWarning")
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_a_batch(env_id: str, mode: AutoresetMode, way: str) -> None:
    vector, whole = under_way(env_id, mode), under_way(env_id, mode)
    others = np.arange(COUNT) != LOST
    spoil(vector.task.world, LOST, way)
    actions = random_actions(env_id, 4, 4, COUNT)
    observation, reward, terminated, truncated, infos = vector.step(actions[0])
    expected = whole.step(actions[0])
    if mode == AutoresetMode.SAME_STEP:
        observation = observation.copy()
        assert np.isfinite(infos["final_obs"][LOST]).all()
    assert terminated[LOST]
    assert not truncated[LOST]
    assert reward[LOST] == 0.0
    assert vector.single_observation_space.contains(observation[LOST])
    np.testing.assert_array_equal(observation[others], expected[0][others])
    np.testing.assert_array_equal(reward[others], expected[1][others])
    for values in infos.values():
        if np.asarray(values).dtype.kind == "f":
            assert np.isfinite(values).all()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the episode that begins anew is as any other
        for action in actions[1:]:
            observation, reward, terminated, _, _ = vector.step(action)
            expected = whole.step(action)
            np.testing.assert_array_equal(observation[others], expected[0][others])
    assert vector.task.world.lost is None
    assert np.isfinite(observation).all()
    assert np.isfinite(reward).all()


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_a_single_environment(env_id: str) -> None:
    env = make(env_id, diagnostics=True)
    env.reset(seed=3)
    base: Any = env.unwrapped
    spoil(base.task.world, 0)
    with pytest.warns(RuntimeWarning, match="Reset the world"):
        observation, reward, terminated, _, info = env.step(random_actions(env_id, 3, 1)[0])
    assert terminated
    assert reward == 0.0
    assert env.observation_space.contains(observation)
    assert np.isnan(info["diagnostic_penetration"])  # what is not known is not 0
    env.reset(seed=4)
    observation, reward, terminated, _, info = env.step(random_actions(env_id, 3, 1)[0])
    assert not terminated
    assert np.isfinite(info["diagnostic_penetration"])


@pytest.mark.filterwarnings("ignore:World. by step:RuntimeWarning")
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_pixels_and_frames(mode: AutoresetMode, way: str) -> None:
    arguments: dict[str, Any] = {"observation": "pixels", "render_mode": "rgb_array", "autoreset_mode": mode}
    vector, whole = (make_vector("GStack-v0", COUNT, **arguments) for _ in range(2))
    others = np.arange(COUNT) != LOST
    for one in (vector, whole):
        one.reset(seed=3)
    spoil(vector.task.world, LOST, way)
    action = random_actions("GStack-v0", 4, 1, COUNT)[0]
    observation, _, terminated, _, infos = vector.step(action)
    np.testing.assert_array_equal(terminated, ~others)
    last = infos["final_obs"][LOST] if mode == AutoresetMode.SAME_STEP else observation[LOST]
    assert not last.any()
    np.testing.assert_array_equal(observation[others], whole.step(action)[0][others])
    frames, expected = vector.render(), whole.render()
    assert frames is not None
    assert expected is not None
    for k in np.flatnonzero(others):
        np.testing.assert_array_equal(frames[k], expected[k])
    assert vector.step(action)[0][LOST].any()
    if mode == AutoresetMode.NEXT_STEP:
        assert (frames[LOST][-1] == 64).all()  # plain, with a line of text
        assert (frames[LOST] != 64).any()


@pytest.mark.filterwarnings("ignore:World. by step:RuntimeWarning")
@pytest.mark.parametrize("way", ["deepcopy", "pickle", "save"])
def test_copies_know_that_they_are_lost(way: str) -> None:
    env = make("GStack-v0", render_mode="rgb_array")
    env.reset(seed=3)
    base: Any = env.unwrapped
    spoil(base.task.world, 0)
    env.step(random_actions("GStack-v0", 3, 1)[0])
    if way == "save":
        saved = base.save()
        base.reset(seed=4)
        assert base.task.world.lost is None
        base.restore(saved)
    other = {"deepcopy": copy.deepcopy, "pickle": lambda one: pickle.loads(pickle.dumps(one)), "save": lambda one: one}
    copied: Any = other[way](env)
    np.testing.assert_array_equal(copied.unwrapped.task.world.lost, [True])
    assert copied.render().shape == (480, 640, 3)


def test_agents() -> None:
    env = tower_v0.parallel_env()
    env.reset(seed=3)
    spoil(env.task.world, 0)
    actions = {agent: env.action_space(agent).sample() for agent in env.agents}
    with pytest.warns(RuntimeWarning, match="Reset the world"):
        observations, rewards, terminations, _, _ = env.step(actions)
    assert all(terminations.values())
    assert list(rewards.values()) == [0.0] * len(rewards)
    assert all(env.observation_space(agent).contains(value) for agent, value in observations.items())
