"""Policies for demonstrations and comparisons: scripted ones, and trained ones where an asset exists.

A policy is a function of an environment; it returns the next action. All are functions of the
observation without memory, so one policy serves any number of environments.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.envs.core.mlp import MlpPolicy
from gsenv.envs.core.vector import TaskVectorEnv

Observations = NDArray[np.float32]
Actions = NDArray[np.float32]
Policy = Callable[[Any], Actions]
BatchPolicy = Callable[[Observations], Actions]


def scripted_policy(env_id: str) -> Policy:
    """Return the scripted policy of an environment, a function of the environment.

    Raises:
        LookupError: the environment has none.
    """
    return _on_env(scripted_actions(env_id))


def trained_policy(env_id: str) -> Policy:
    """Return the trained policy of an environment, a function of the environment that needs numpy alone.

    Raises:
        LookupError: the environment has none.
    """
    return _on_env(trained_actions(env_id))


def scripted_actions(env_id: str) -> BatchPolicy:
    """Return the scripted policy of an environment, a function of observations (..., entry).

    Raises:
        LookupError: the environment has none.
    """
    name = env_id.rpartition(":")[2]
    known = {entry.id: entry.scripted_policy for entry in ENVS}
    known |= {entry.name: entry.scripted_policy for entry in PARALLEL_ENVS}
    where = known.get(name)
    if where is None:
        raise LookupError(f"{name} has no scripted policy.")
    policy: BatchPolicy = _find(where)
    return policy


def named_task(env_id: str, arguments: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the id and the other arguments of an environment whose argument `task` makes it that of another id.

    That id has its time limit, its settings of training and its policies: GRagdoll-v0 with `task="get_up"` is
    GRagdoll-get-up-v0.
    """
    others = dict(arguments)
    stem, _, version = env_id.rpartition("-")
    other = f"{stem}-{str(others.pop('task', '')).replace('_', '-')}-{version}"
    known = other.rpartition(":")[2] in {entry.id for entry in ENVS}
    return (other, others) if known else (env_id, dict(arguments))


def trained_actions(env_id: str) -> MlpPolicy:
    """Return the trained policy of an environment, a function of observations (..., entry).

    Raises:
        LookupError: the environment has none.
    """
    name = env_id.rpartition(":")[2]
    asset = files("gsenv.assets") / f"{name}.npz"
    if not asset.is_file():
        raise LookupError(f"{name} has no trained policy; `gsenv train {name}` makes one.")
    with asset.open("rb") as file:
        return MlpPolicy.load(io.BytesIO(file.read()))


def make_batch(env_id: str, world_count: int, **arguments: Any) -> TaskVectorEnv:
    """Return the native vector environment of a registered environment, of one or of several agents.

    Raises:
        LookupError: there is no such environment.
        TypeError, ValueError: a bad argument.
    """
    name = env_id.rpartition(":")[2]
    known = {entry.id: entry.vector_env for entry in ENVS}
    known |= {entry.name: entry.vector_env for entry in PARALLEL_ENVS}
    if name not in known:
        raise LookupError(f"there is no environment {env_id!r}.")
    if "max_cycles" in arguments and name in {entry.name for entry in PARALLEL_ENVS}:  # as its parallel_env calls it
        arguments["max_episode_steps"] = arguments.pop("max_cycles")
    batch: TaskVectorEnv = _find(known[name])(world_count, **arguments)
    return batch


def _find(where: str) -> Any:
    """Return what an entry names as "module:name"."""
    module, _, name = where.partition(":")
    return getattr(import_module(f"gsenv.envs.{module}"), name)


def _on_env(policy: BatchPolicy) -> Policy:
    return lambda env: policy(env.unwrapped.observation)
