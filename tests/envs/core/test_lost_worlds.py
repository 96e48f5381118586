"""A world whose numbers overflow ends its episode with finite numbers, and the others go on bit for bit."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gsenv.envs import tower_v0
from gsenv.envs.core.vector import TaskVectorEnv
from tests.envs.registered import EACH_TASK, make, make_vector, random_actions

COUNT, LOST = 4, 2


def spoil(world: Any, number: int) -> None:
    """Give all bodies of a world velocities that overflowed."""
    world.state.bodies["velocity"][number] = np.inf


def under_way(env_id: str, mode: AutoresetMode) -> TaskVectorEnv:
    vector = make_vector(env_id, COUNT, autoreset_mode=mode)
    vector.reset(seed=3)
    for action in random_actions(env_id, 3, 3, COUNT):
        vector.step(action)
    return vector


@pytest.mark.filterwarnings("ignore:World. by step:RuntimeWarning")
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_a_batch(env_id: str, mode: AutoresetMode) -> None:
    vector, whole = under_way(env_id, mode), under_way(env_id, mode)
    others = np.arange(COUNT) != LOST
    spoil(vector.task.world, LOST)
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
