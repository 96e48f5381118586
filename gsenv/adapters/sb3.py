"""Stable-Baselines3: all worlds of an environment as one VecEnv, in one process.

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from gsenv.adapters.sb3 import BatchedVecEnv

envs = make_vec_env("gsenv:GStack-v0", n_envs=64, vec_env_cls=BatchedVecEnv)
PPO("MlpPolicy", envs, n_steps=64).learn(1_000_000)
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from time import time
from typing import Any

import gymnasium
import numpy as np
from gymnasium import wrappers
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.pixels import put, take
from gsenv.envs.core.vector import NEVER, TaskVectorEnv

Array = NDArray[Any]
Indices = int | Iterable[int] | None

# Wrappers that a batch replaces: Monitor and TimeLimit below, the checks by the vector environment.
_KNOWN_WRAPPERS: tuple[type[Any], ...] = (
    Monitor,
    wrappers.TimeLimit,
    wrappers.OrderEnforcing,
    wrappers.PassiveEnvChecker,
)


class BatchedVecEnv(VecEnv):
    """A batch of worlds with the interface of SB3's `DummyVecEnv` and the same results.

    With the same seeds, world i passes through the same states as environment i of a DummyVecEnv. The batch writes
    the episode records of `Monitor` itself. All worlds share their settings, so `set_attr` sets them for all.

    Args:
        env_fns: functions as `make_vec_env` passes them. Only the first is called; the batch has `len(env_fns)`
            worlds of the environment that it returns. That environment may be wrapped in a Monitor and in the
            wrappers that `gymnasium.make` adds, nothing else. A Monitor's file gets the episodes of all worlds.
        threads: number of threads that the worlds are distributed over.
        infos: "ended" fills the info dicts of worlds whose episode has just ended, which is all that SB3 reads;
            "all" fills those of all worlds at each step, as a DummyVecEnv does, which takes time for each world.

    Raises:
        ValueError: the environment cannot be batched, or an argument is bad.
    """

    def __init__(
        self, env_fns: Sequence[Callable[[], gymnasium.Env[Any, Any]]], threads: int = 1, infos: str = "ended"
    ) -> None:
        if not env_fns:
            raise ValueError("env_fns must hold at least one function, got none.")
        if infos not in ("ended", "all"):
            raise ValueError(f"infos must be 'ended' or 'all', got {infos!r}.")
        probe = env_fns[0]()
        layers = _layers(probe)
        self.batch = _make_batch(layers, len(env_fns), threads)
        self._wrapper_classes = tuple(type(layer) for layer in layers[:-1])
        self._monitor = next((layer for layer in layers if isinstance(layer, Monitor)), None)
        self._all_infos = infos == "all"
        self._actions: Array | None = None
        self._returns = np.zeros(len(env_fns))
        self._lengths = np.zeros(len(env_fns), np.int64)
        super().__init__(len(env_fns), probe.observation_space, probe.action_space)
        self.metadata = dict(probe.metadata)
        layers[-1].close()  # closing the Monitor would close its file, which this batch goes on writing

    # ------------------------------------------------- VecEnv

    def reset(self) -> Any:
        """Begin new episodes in all worlds, with the seeds and options set for the next reset; return observations."""
        everywhere = np.arange(self.num_envs)
        groups: dict[str, list[int]] = {}  # worlds with equal options are reset together
        for i, options in enumerate(self._options):
            groups.setdefault(json.dumps(options, sort_keys=True, default=repr), []).append(i)
        for worlds in groups.values():
            self._reset(np.array(worlds), self._seeds, self._options[worlds[0]])
        self._fill_reset_infos(everywhere)
        self._reset_seeds()
        self._reset_options()
        return self.batch.observe()

    def step_async(self, actions: Array) -> None:
        """Set the actions of the next `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, Array, Array, list[dict[str, Any]]]:
        """Step all worlds; return observations, rewards, dones and infos. Ended worlds are reset, as SB3 expects."""
        assert self._actions is not None, "step_wait: call step_async first"
        observations, rewards, terminated, truncated, _ = self.batch.step(self._actions)
        dones = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = list(map(dict, ((),) * self.num_envs))
        if self._all_infos:
            for w, info in enumerate(infos):
                info.update(self.batch.task.info(w))
                info["TimeLimit.truncated"] = False
        if dones.any():
            ended = np.flatnonzero(dones)
            for w in ended.tolist():
                info = self.batch.task.info(w)
                info["terminal_observation"] = take(observations, w)
                info["TimeLimit.truncated"] = bool(truncated[w] and not terminated[w])
                if self._monitor is not None:
                    info["episode"] = self._episode(self._monitor, w, info)
                infos[w] = info
            self._reset(ended, None, {})
            self._fill_reset_infos(ended)
            for w in ended.tolist():
                put(observations, w, self.batch.observe_world(w))
        return observations, rewards.astype(np.float32), dones, infos

    def close(self) -> None:
        if self._monitor is not None and self._monitor.results_writer is not None:
            self._monitor.results_writer.close()
        self.batch.close()

    def get_images(self) -> Sequence[Array | None]:
        frames = self.batch.render()
        return [None] * self.num_envs if frames is None else list(frames)

    # ------------------------------------------------- attributes and methods of the worlds

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute of each chosen world; an array over worlds is split, other values are shared."""
        if attr_name in ("observation_space", "action_space"):  # the spaces of one environment
            attr_name = f"single_{attr_name}"
        values = self.batch.get_attr(attr_name)
        return [values[i] for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute, which all worlds share.

        Raises:
            AttributeError: there is no such attribute.
            ValueError: `indices` are only some of the worlds.
        """
        if set(self._get_indices(indices)) != set(range(self.num_envs)):
            raise ValueError(f"set_attr: {attr_name!r} is shared by all worlds; it cannot be set in {indices!r} only.")
        self.batch.set_attr(attr_name, [value] * self.batch.num_envs)  # a value may itself be a pair

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the vector environment once, and return the part of its result for each chosen world.

        `reset` begins new episodes in the chosen worlds only: `env_method("reset", seed=3, indices=[0])`.
        """
        chosen = list(self._get_indices(indices))
        if method_name == "reset":
            return self._reset_chosen(chosen, *method_args, **method_kwargs)
        results = self.batch.call(method_name, *method_args, **method_kwargs)
        return [results[i] for i in chosen]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        wrapped = any(issubclass(known, wrapper_class) for known in self._wrapper_classes)
        return [wrapped for _ in self._get_indices(indices)]

    # ------------------------------------------------- internal

    def _reset(self, worlds: Array, seeds: Sequence[int | None] | None, options: dict[str, Any]) -> None:
        mask = np.zeros(self.num_envs, np.bool_)
        mask[worlds] = True
        self.batch.reset(seed=seeds, options={**options, "reset_mask": mask})
        self._returns[worlds] = 0.0
        self._lengths[worlds] = 0

    def _reset_chosen(
        self, chosen: list[int], *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> list[Any]:
        worlds = np.array(chosen)
        self._reset(worlds, None if seed is None else [seed] * self.num_envs, options or {})
        self._fill_reset_infos(worlds)
        return [(self.batch.observe_world(w), self.reset_infos[w]) for w in chosen]

    def _fill_reset_infos(self, worlds: Array) -> None:
        for w in worlds.tolist():
            self.reset_infos[w] = self.batch.task.info(w)

    def _episode(self, monitor: Monitor, w: int, info: dict[str, Any]) -> dict[str, Any]:
        """Return Monitor's record of an episode that has ended, and write it to the Monitor's file if there is one."""
        episode = {
            "r": round(float(self._returns[w]), 6),
            "l": int(self._lengths[w]),
            "t": round(time() - monitor.t_start, 6),
        }
        episode |= {key: info[key] for key in monitor.info_keywords}
        if monitor.results_writer is not None:
            monitor.results_writer.write_row(episode)
        return episode


def _layers(env: gymnasium.Env[Any, Any]) -> list[gymnasium.Env[Any, Any]]:
    """Return the environment's wrappers, outermost first, and the environment itself last."""
    layers = [env]
    while isinstance(layers[-1], gymnasium.Wrapper):
        layers.append(layers[-1].env)
    return layers


def _make_batch(layers: list[gymnasium.Env[Any, Any]], world_count: int, threads: int) -> TaskVectorEnv:
    env = layers[-1]
    for layer in layers[:-1]:
        if not isinstance(layer, _KNOWN_WRAPPERS):
            raise ValueError(f"BatchedVecEnv cannot batch the wrapper {type(layer).__name__}; wrap the batch instead.")
    if not isinstance(env, TaskEnv) or env.spec is None:
        raise ValueError(f"BatchedVecEnv needs an environment of gsenv made by its id, got {env!r}.")
    limits = [layer._max_episode_steps for layer in layers if isinstance(layer, wrappers.TimeLimit)]
    batch = gymnasium.make_vec(
        env.spec,
        num_envs=world_count,
        vectorization_mode="vector_entry_point",
        threads=threads,
        autoreset_mode=AutoresetMode.DISABLED,
        max_episode_steps=min(limits, default=NEVER),
    )
    assert isinstance(batch, TaskVectorEnv)
    return batch
