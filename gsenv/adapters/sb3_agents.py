"""Stable-Baselines3 with parameter sharing: each agent of each world as one environment of a VecEnv.

from stable_baselines3 import PPO
from gsenv.adapters.sb3_agents import AgentVecEnv

envs = AgentVecEnv("tower_v0", world_count=64)  # 128 environments
PPO("MlpPolicy", envs, n_steps=64).learn(1_000_000)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from time import time
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from gsenv.envs.core.policies import make_batch
from gsenv.envs.core.spec_tables import box_of

Array = NDArray[Any]
Indices = int | Iterable[int] | None


class AgentVecEnv(VecEnv):
    """A batch of worlds with several agents; environment `w * A + a` is agent a, of A, of world w.

    All agents of a world end at once. Settings are those of the batch: `set_attr` sets them for all worlds.

    Args:
        name: of an environment of several agents, such as "tower_v0".
        world_count: number of worlds.
        threads: number of threads that the worlds are distributed over.
        arguments: of the environment, such as `blocks=2`.

    Raises:
        LookupError: there is no such environment of several agents.
        TypeError, ValueError: a bad argument.
    """

    def __init__(self, name: str, world_count: int, threads: int = 1, **arguments: Any) -> None:
        self.batch = make_batch(name, world_count, threads=threads, autoreset_mode=AutoresetMode.DISABLED, **arguments)
        task = self.batch.task
        if not task.agents:
            raise LookupError(f"{name} has one agent; BatchedVecEnv is for those.")
        self.agents = task.agents
        self._actions: Array | None = None
        self._began = time()
        self._returns = np.zeros((world_count, len(self.agents)))
        self._lengths = np.zeros(world_count, np.int64)
        super().__init__(world_count * len(self.agents), box_of(task.observations), box_of(task.actions))
        self.metadata = dict(self.batch.metadata)

    def reset(self) -> Array:
        """Begin new episodes in all worlds, with the seeds set for the next reset; return observations."""
        everywhere = np.ones(self.batch.num_envs, np.bool_)
        self._reset(everywhere, list(self._seeds[: self.batch.num_envs]), dict(self._options[0]))
        self._reset_seeds()
        self._reset_options()
        return self._observe()

    def step_async(self, actions: Array) -> None:
        """Set the actions of the next `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Array, Array, Array, list[dict[str, Any]]]:
        """Step all worlds; return observations, rewards, dones and infos. Ended worlds are reset, as SB3 expects."""
        assert self._actions is not None, "step_wait: call step_async first"
        count = len(self.agents)
        actions = self._actions.reshape(self.batch.num_envs, count, -1)
        observations, rewards, terminated, truncated, _ = self.batch.step(actions)
        dones = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = list(map(dict, ((),) * self.num_envs))
        for w in np.flatnonzero(dones).tolist():
            for a in range(count):
                info = self.batch.task.info(w, a)
                info["terminal_observation"] = observations[w, a].copy()
                info["TimeLimit.truncated"] = bool(truncated[w] and not terminated[w])
                info["episode"] = self._episode(w, a)
                infos[w * count + a] = info
        if dones.any():
            self._reset(dones, None, {})
        return self._observe(), rewards.astype(np.float32).ravel(), np.repeat(dones, count), infos

    def close(self) -> None:
        self.batch.close()

    def get_images(self) -> Sequence[Array | None]:
        """Return a frame of each environment: that of its world."""
        frames = self.batch.render()
        count = len(self.agents)
        return [None] * self.num_envs if frames is None else [frame for frame in frames for _ in range(count)]

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        values = self.batch.get_attr(attr_name)
        return [values[i // len(self.agents)] for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute, which all worlds share; raises ValueError where `indices` are only some."""
        if set(self._get_indices(indices)) != set(range(self.num_envs)):
            raise ValueError(f"set_attr: {attr_name!r} is shared by all worlds; it cannot be set in {indices!r} only.")
        self.batch.set_attr(attr_name, [value] * self.batch.num_envs)  # a value may itself be a pair

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the batch once, and return the part of its result for each chosen environment."""
        results = self.batch.call(method_name, *method_args, **method_kwargs)
        return [results[i // len(self.agents)] for i in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]

    # ------------------------------------------------- internal

    def _reset(self, mask: NDArray[np.bool_], seeds: list[int | None] | None, options: dict[str, Any]) -> None:
        self.batch.reset(seed=seeds, options={**options, "reset_mask": mask})
        self._returns[mask] = 0.0
        self._lengths[mask] = 0
        count = len(self.agents)
        for w in np.flatnonzero(mask).tolist():
            for a in range(count):
                self.reset_infos[w * count + a] = self.batch.task.info(w, a)

    def _observe(self) -> Array:
        observations: Array = self.batch.observe()
        return observations.reshape(self.num_envs, -1)

    def _episode(self, w: int, a: int) -> dict[str, Any]:
        """Return what Monitor records of an episode that has ended."""
        spent = round(time() - self._began, 6)
        return {"r": round(float(self._returns[w, a]), 6), "l": int(self._lengths[w]), "t": spent}
