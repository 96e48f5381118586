"""SuperSuit's concat_vec_envs over native vector environments.

It was made for PettingZoo: what it concatenates must name the space of one agent `observation_space`, give infos as
a list and reset in the same step. Its own view of a single gymnasium environment fails for all of them.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import DictInfoToList

from tests.envs.registered import EACH_TASK, TASK_IDS, make, make_vector, random_actions, terms_of

supersuit = pytest.importorskip("supersuit")  # of the extra "test"
COPIES, WORLDS = 3, 2
LIMIT = 5


class View(DictInfoToList):
    """A native vector environment as SuperSuit wants one."""

    def __init__(self, env_id: str) -> None:
        super().__init__(make_vector(env_id, WORLDS, autoreset_mode=AutoresetMode.SAME_STEP, max_episode_steps=LIMIT))
        self.observation_space = self.env.single_observation_space
        self.action_space = self.env.single_action_space

    def env_is_wrapped(self, wrapper_class: type[Any]) -> list[bool]:
        return [False] * WORLDS


def alone(env_id: str, actions: Any, seeds: list[int]) -> list[Any]:
    """What the copies do by themselves."""
    copies = [View(env_id) for _ in range(COPIES)]
    log: list[Any] = [np.concatenate([copy.reset(seed=seed)[0] for copy, seed in zip(copies, seeds, strict=True)])]
    for step in actions:
        results = [copy.step(step[k * WORLDS : (k + 1) * WORLDS]) for k, copy in enumerate(copies)]
        log.append([np.concatenate(parts) for parts in list(zip(*results, strict=True))[:4]])
    return log


@pytest.mark.parametrize(("processes", "seeds"), [(0, [6, 7, 8]), (2, [6, 7, 7])])  # it counts from s in each
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_copies_do_what_they_do_alone(env_id: str, processes: int, seeds: list[int]) -> None:
    actions = random_actions(env_id, 0, 2 * LIMIT + 1, COPIES * WORLDS)
    expected = alone(env_id, actions, seeds)
    envs = supersuit.concat_vec_envs_v1(View(env_id), COPIES, num_cpus=processes)
    try:
        assert envs.num_envs == COPIES * WORLDS
        np.testing.assert_array_equal(envs.reset(seed=6)[0], expected[0])
        for step, (observations, rewards, terminated, truncated) in zip(actions, expected[1:], strict=True):
            result = envs.step(step)
            np.testing.assert_array_equal(result[0], observations)
            np.testing.assert_array_equal(np.float32(result[1]), np.float32(rewards))  # between processes float32
            np.testing.assert_array_equal(result[2], terminated)
            np.testing.assert_array_equal(result[3], truncated)
            assert all(terms_of(info) for info in result[4])
    finally:
        envs.close()


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_behind_the_interface_of_stable_baselines(env_id: str) -> None:
    pytest.importorskip("stable_baselines3")
    envs = supersuit.concat_vec_envs_v1(View(env_id), COPIES, base_class="stable_baselines3")
    observations = envs.reset()
    assert observations.shape == (COPIES * WORLDS, *envs.observation_space.shape)
    for step in random_actions(env_id, 0, LIMIT, COPIES * WORLDS):
        observations, rewards, dones, infos = envs.step(step)
    assert rewards.shape == dones.shape == (COPIES * WORLDS,)
    assert len(infos) == COPIES * WORLDS


@pytest.mark.parametrize("env_id", ["CartPole-v1", *EACH_TASK])
def test_its_view_of_single_environments_is_broken(env_id: str) -> None:
    """It takes what reset returns, a pair, for the observation. Once this fails, test single ones above."""
    env = make(env_id) if env_id in TASK_IDS else gymnasium.make(env_id)
    with pytest.raises(ValueError, match="inhomogeneous"):
        supersuit.concat_vec_envs_v1(env, 2).reset(seed=0)
