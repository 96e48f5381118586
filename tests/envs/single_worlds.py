"""A vector environment as Gymnasium defines it, made of single ones: what native ones must equal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.vector import TaskVectorEnv


class SingleWorlds:
    """`count` environments that `make` makes, world i seeded seed + i, truncated after `limit` steps."""

    def __init__(self, make: Callable[[], TaskEnv], count: int, mode: AutoresetMode, seed: int, limit: int) -> None:
        self.envs = [make() for _ in range(count)]
        self.mode = mode
        self.limit = limit
        self.resets = [env.reset(seed=seed + i) for i, env in enumerate(self.envs)]
        self.elapsed = [0] * count
        self.finished = [False] * count

    def step(self, i: int, action: Any) -> tuple[Any, ...]:
        """(observation, reward, terminated, truncated, info, final observation, final info)."""
        env = self.envs[i]
        if self.finished[i] and self.mode != AutoresetMode.SAME_STEP:
            observation, info = env.reset()
            self.elapsed[i], self.finished[i] = 0, False
            return observation, 0.0, False, False, info, None, None
        observation, reward, terminated, _, info = env.step(action)
        self.elapsed[i] += 1
        truncated = self.elapsed[i] >= self.limit
        final: tuple[Any, Any] = (None, None)
        if (terminated or truncated) and self.mode == AutoresetMode.SAME_STEP:
            final = (observation, info)
            observation, info = env.reset()
            self.elapsed[i] = 0
        else:
            self.finished[i] = terminated or truncated
        return observation, reward, terminated, truncated, info, *final

    def reset_finished(self, vector: TaskVectorEnv, observations: Any) -> None:
        """Partial reset of both; the others' observations stay."""
        mask = np.array(self.finished)
        if not mask.any():
            return
        begun, infos = vector.reset(options={"reset_mask": mask})
        for i, env in enumerate(self.envs):
            if mask[i]:
                observation, info = env.reset()
                np.testing.assert_array_equal(begun[i], observation)
                assert_info(infos, info, i)
                self.elapsed[i], self.finished[i] = 0, False
            else:
                np.testing.assert_array_equal(begun[i], observations[i])
        observations[:] = begun

    def compare_step(self, vector: TaskVectorEnv, observations: Any, actions: Any) -> tuple[Any, int, int]:
        """One step of both, all that they return equal: (observations, how many terminated, truncated)."""
        if self.mode == AutoresetMode.DISABLED:
            self.reset_finished(vector, observations)
        observations, rewards, terminated, truncated, infos = vector.step(actions)
        for i in range(len(self.envs)):
            one = self.step(i, actions[i])
            np.testing.assert_array_equal(observations[i], one[0])
            assert (rewards[i], terminated[i], truncated[i]) == one[1:4]
            assert_info(infos, one[4], i)
            if self.mode == AutoresetMode.SAME_STEP and (one[2] or one[3]):
                np.testing.assert_array_equal(infos["final_obs"][i], one[5])
                assert_info(infos["final_info"], one[6], i)
        return observations, int(terminated.sum()), int(truncated.sum())


def assert_info(infos: dict[str, Any], info: dict[str, Any], i: int) -> None:
    """World i of batched infos is the single environment's info."""
    for key, value in info.items():
        assert infos[f"_{key}"][i]
        if isinstance(value, dict):
            assert_info(infos[key], value, i)
        else:
            assert infos[key][i] == value
