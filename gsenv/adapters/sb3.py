"""Stable-Baselines3: all worlds of an environment as one VecEnv, in one process.

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from gsenv.adapters.sb3 import BatchedVecEnv

envs = make_vec_env("gsenv:GStack-v0", n_envs=64, vec_env_cls=BatchedVecEnv)
PPO("MlpPolicy", envs, n_steps=64).learn(1_000_000)
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from inspect import isfunction
from time import time
from typing import Any

import gymnasium
import numpy as np
from gymnasium import wrappers
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from gsenv.envs.core.arguments import mapping_of
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.fixed import check_fixed
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

_WRAPPER_METHODS = ("get_wrapper_attr", "has_wrapper_attr", "set_wrapper_attr")  # of gymnasium.Env, by which others go


class SharedVecEnv(VecEnv):
    """What the VecEnvs over one batch of worlds share: the environments of a world lie side by side.

    Environment i is of world i // A, where each world has A of them, one for each agent; without agents A is 1.
    Settings belong to all worlds.

    Args:
        batch: the worlds, without autoreset.
        attributes: those of one environment that the batch does not have, or that differ from its own; among them
            `observation_space` and `action_space`.
    """

    def __init__(self, batch: TaskVectorEnv, attributes: dict[str, Any]) -> None:
        self.batch = batch
        self._attributes = attributes
        self._per_world = max(len(batch.task.agents), 1)
        self._actions: Array | None = None
        self._returns = np.zeros_like(batch.task.reward)
        self._lengths = np.zeros(batch.num_envs, np.int64)
        count = batch.num_envs * self._per_world
        super().__init__(count, attributes["observation_space"], attributes["action_space"])

    # ------------------------------------------------- VecEnv

    def reset(self) -> Any:
        """Begin new episodes in all worlds, with the seeds and options set for the next reset; return observations.

        Raises:
            ValueError: bad options, not one dict for each environment, or different ones for the agents of a world;
                nothing has changed then.
        """
        seeds = self._seeds[: self.batch.num_envs]
        for options, worlds in self._groups():
            self._begin(np.array(worlds), seeds, options)
        self._reset_seeds()
        self._reset_options()
        return self._flat(self.batch.observe())

    def step_async(self, actions: Array) -> None:
        """Set the actions of the next `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, Array, Array, list[dict[str, Any]]]:
        """Step all worlds; return observations, rewards, dones and infos. Ended worlds are reset, as SB3 expects."""
        assert self._actions is not None, "step_wait: call step_async first"
        actions = self._actions
        if self.batch.task.agents:
            actions = actions.reshape(self.batch.num_envs, self._per_world, -1)
        observations, rewards, terminated, truncated, _ = self.batch.step(actions)
        dones = terminated | truncated
        self._returns += rewards
        self._lengths += 1
        infos = self._infos()
        if dones.any():
            ended = np.flatnonzero(dones)
            last = self._flat(observations)
            for i in self._environments(ended):
                w = i // self._per_world
                info = self._info(i)
                info["terminal_observation"] = take(last, i)
                info["TimeLimit.truncated"] = bool(truncated[w] and not terminated[w])
                self._record(i, info)
                infos[i] = info
            self._begin(ended, None, {})
            for w in ended.tolist():
                put(observations, w, self.batch.observe_world(w))
        gains = rewards.astype(np.float32).ravel()
        return self._flat(observations), gains, np.repeat(dones, self._per_world), infos

    def close(self) -> None:
        self.batch.close()

    def get_images(self) -> Sequence[Array | None]:
        """Return a frame of each environment: that of its world."""
        frames = self.batch.render()
        return [None if frames is None else frames[i // self._per_world] for i in range(self.num_envs)]

    # ------------------------------------------------- attributes and methods of the environments

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute of each chosen environment, see `TaskVectorEnv.call`; methods are not called."""
        chosen = self._chosen(indices)
        if attr_name in self._attributes:
            return [self._attributes[attr_name] for _ in chosen]
        if attr_name in _WRAPPER_METHODS or isfunction(getattr(type(self.batch), attr_name, None)):
            return [partial(self._call_one, attr_name, i) for i in chosen]
        values = self.batch.get_attr(attr_name)
        return [values[i // self._per_world] for i in chosen]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute, which all worlds share.

        Raises:
            AttributeError: there is no such attribute.
            ValueError: `indices` are only some of the environments, or a bad value, or what cannot be set.
        """
        if set(self._chosen(indices)) != set(range(self.num_envs)):
            raise ValueError(f"set_attr: {attr_name!r} is shared by all worlds; it cannot be set in {indices!r} only.")
        if attr_name in self._attributes:
            check_fixed(f"set_attr: {attr_name!r}", value, self._attributes[attr_name])
            return
        self.batch.set_attr(attr_name, [value] * self.batch.num_envs)  # a value may itself be a pair

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the vector environment once, and return its result for each chosen environment.

        `reset` begins new episodes in the chosen worlds only: `env_method("reset", seed=3, indices=[0])`.

        Raises:
            AttributeError: there is no such method.
            ValueError: the method is `step`, or a reset is of some agents of a world only; nothing has changed then.
        """
        chosen = self._chosen(indices)
        if method_name == "reset":
            return self._reset_chosen(chosen, *method_args, **method_kwargs)
        if method_name in _WRAPPER_METHODS:
            return getattr(self, f"_{method_name}")(chosen, *method_args, **method_kwargs)
        results = self.batch.call(method_name, *method_args, **method_kwargs)
        return [results[i // self._per_world] for i in chosen]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        return [False for _ in self._chosen(indices)]

    def _get_wrapper_attr(self, chosen: list[int], name: str) -> list[Any]:
        return self.get_attr(name, chosen)

    def _has_wrapper_attr(self, chosen: list[int], name: str) -> list[bool]:
        return [self.has_attr(name)] * len(chosen)

    def _set_wrapper_attr(self, chosen: list[int], name: str, value: Any, *, force: bool = True) -> list[bool]:
        """Set an attribute as `set_attr` does; without `force`, return False where there is none."""
        if not force and not self.has_attr(name):
            return [False] * len(chosen)
        self.set_attr(name, value, chosen)
        return [True] * len(chosen)

    def _reset_chosen(
        self, chosen: list[int], *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> list[Any]:
        worlds = sorted({i // self._per_world for i in chosen})
        if set(self._environments(worlds)) != set(chosen):
            raise ValueError(f"reset: the agents of a world begin together, but indices {chosen} lack some of them.")
        given = mapping_of(options)
        self.batch.task.check_options(given)
        if not worlds:
            return []
        self._begin(np.array(worlds), None if seed is None else [seed] * self.batch.num_envs, given)
        seen = {w: self.batch.observe_world(w) for w in worlds}
        return [(self._of_environment(seen[i // self._per_world], i), self.reset_infos[i]) for i in chosen]

    # ------------------------------------------------- internal

    def _chosen(self, indices: Indices) -> list[int]:
        """Return the indices of environments from 0 on; raises IndexError for one that does not exist."""
        return [range(self.num_envs)[i] for i in self._get_indices(indices)]

    def _call_one(self, name: str, i: int, *args: Any, **kwargs: Any) -> Any:
        return self.env_method(name, *args, indices=[i], **kwargs)[0]

    def _environments(self, worlds: Iterable[int]) -> list[int]:
        """Return the environments of worlds."""
        return [int(w) * self._per_world + a for w in worlds for a in range(self._per_world)]

    def _groups(self) -> list[tuple[dict[str, Any], list[int]]]:
        """Return the options for the next reset, each with the worlds that have them.

        Raises:
            ValueError: options that `reset` refuses.
        """
        if len(self._options) != self.num_envs:
            raise ValueError(f"reset: {self.num_envs} dicts of options are needed, got {len(self._options)}.")
        groups: dict[str, tuple[dict[str, Any], list[int]]] = {}
        keys = []
        for given in self._options:
            options = mapping_of(given)
            keys.append(repr(self.batch.task.check_options(options)) if options else "")
            groups.setdefault(keys[-1], (options, []))
        for w in range(self.batch.num_envs):
            own = keys[w * self._per_world : (w + 1) * self._per_world]
            if len(set(own)) > 1:
                raise ValueError(f"reset: the agents of a world need equal options, those of world {w} differ.")
            groups[own[0]][1].append(w)
        return list(groups.values())

    def _begin(self, worlds: Array, seeds: Sequence[int | None] | None, options: dict[str, Any]) -> None:
        mask = np.zeros(self.batch.num_envs, np.bool_)
        mask[worlds] = True
        self.batch.begin_episodes(seeds, {**options, "reset_mask": mask})
        self._returns[worlds] = 0.0
        self._lengths[worlds] = 0
        for i in self._environments(worlds):
            self.reset_infos[i] = self._info(i)

    def _info(self, i: int) -> dict[str, Any]:
        w, a = divmod(i, self._per_world)
        return self.batch.task.info(w, a if self.batch.task.agents else None)

    def _infos(self) -> list[dict[str, Any]]:
        """Return the infos of a step in which no episode ends."""
        return list(map(dict, ((),) * self.num_envs))

    def _of_environment(self, observation: Any, i: int) -> Any:
        """Return an environment's part of the observation of its world."""
        return take(observation, i % self._per_world) if self.batch.task.agents else observation

    def _flat(self, observations: Any) -> Any:
        """Return observations (world, ...), or a dict of such, as (environment, ...); they share their memory."""
        if isinstance(observations, dict):
            return {name: self._flat(array) for name, array in observations.items()}
        if not self.batch.task.agents:
            return observations
        return observations.reshape(self.num_envs, *observations.shape[2:])

    @abstractmethod
    def _record(self, i: int, info: dict[str, Any]) -> None:
        """Add the record of environment i's episode, which has ended, to its info."""

    def _episode(self, i: int, began: float) -> dict[str, Any]:
        """Return what Monitor records of an episode that has ended."""
        spent = round(time() - began, 6)
        return {"r": round(float(self._returns.flat[i]), 6), "l": int(self._lengths[i // self._per_world]), "t": spent}


class BatchedVecEnv(SharedVecEnv):
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
        batch = _make_batch(layers, len(env_fns), threads)
        self._wrapper_classes = tuple(type(layer) for layer in layers[:-1])
        self._monitor = next((layer for layer in layers if isinstance(layer, Monitor)), None)
        self._all_infos = infos == "all"
        own = {"observation_space": probe.observation_space, "action_space": probe.action_space, "spec": probe.spec}
        super().__init__(batch, own)
        self.metadata = dict(probe.metadata)
        layers[-1].close()  # closing the Monitor would close its file, which this batch goes on writing

    def close(self) -> None:
        if self._monitor is not None and self._monitor.results_writer is not None:
            self._monitor.results_writer.close()
        super().close()

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Indices = None) -> list[bool]:
        wrapped = any(issubclass(known, wrapper_class) for known in self._wrapper_classes)
        return [wrapped for _ in self._chosen(indices)]

    def _infos(self) -> list[dict[str, Any]]:
        infos = super()._infos()
        if self._all_infos:
            for i, info in enumerate(infos):
                info.update(self._info(i))
                info["TimeLimit.truncated"] = False
        return infos

    def _record(self, i: int, info: dict[str, Any]) -> None:
        """Add Monitor's record to the info, and write it to the Monitor's file if there is one."""
        monitor = self._monitor
        if monitor is None:
            return
        episode = self._episode(i, monitor.t_start)
        episode |= {key: info[key] for key in monitor.info_keywords}
        if monitor.results_writer is not None:
            monitor.results_writer.write_row(episode)
        info["episode"] = episode


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
