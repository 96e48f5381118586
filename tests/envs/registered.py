"""Every registered environment, for tests that hold for each of them."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from dataclasses import fields, is_dataclass
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import load_env_creator
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import NDArray

from gsenv.envs import ENVS
from gsenv.envs.core.vector import TaskVectorEnv

IDS = [entry.id for entry in ENVS]
TIERS = ("-hardcore-", "-get-up-")
TASK_IDS = [i for i in IDS if not any(tier in i for tier in TIERS)]  # one of each task: tiers share its kernels
COSTLY = ("GCar3D-v0", "GRagdoll-v0")  # in tests of what all tasks share, the 3D robots run at night only
EACH_TASK = [pytest.param(i, marks=pytest.mark.slow) if i in COSTLY else i for i in TASK_IDS]
MODES = list(AutoresetMode)
SETTINGS: dict[str, dict[str, Any]] = {  # of lively episodes that end early
    "GStack-v0": {"blocks": 2, "crack_speed": 100.0},
    "GStack-hardcore-v0": {"blocks": 2, "crack_speed": 100.0},
    "GCar-v0": {"difficulty": 1.0},
    "GCar-hardcore-v0": {"difficulty": 1.0},
    "GCar3D-v0": {"difficulty": 1.0},
    "GStack3D-v0": {"blocks": 2, "crack_speed": 100.0},
    "GStack3D-hardcore-v0": {"blocks": 2, "crack_speed": 100.0},
    "GRagdoll2D-v0": {"push": 1.0},
    "GRagdoll2D-hardcore-v0": {"push": 1.0},
    "GRagdoll-v0": {"push": 1.0},
    "GRagdoll-hardcore-v0": {"push": 1.0},
}


def terms_of(info: dict[str, Any]) -> dict[str, Any]:
    """The reward terms of an info, by name."""
    return {key.removeprefix("reward_"): value for key, value in info.items() if key.startswith("reward_")}


def make(env_id: str, **arguments: Any) -> gymnasium.Env[Any, Any]:
    """A single environment as `gymnasium.make` wraps it."""
    return gymnasium.make(f"gsenv:{env_id}", **SETTINGS.get(env_id, {}) | arguments)


def make_vector(env_id: str, count: int, **arguments: Any) -> TaskVectorEnv:
    """The native vector environment, with no wrapper."""
    entry_point: Any = gymnasium.spec(env_id).vector_entry_point
    vector_class: Any = load_env_creator(entry_point)
    vector: TaskVectorEnv = vector_class(count, **SETTINGS.get(env_id, {}) | arguments)
    return vector


def make_sync(env_id: str, count: int, mode: AutoresetMode, **arguments: Any) -> SyncVectorEnv:
    """The same made of single environments by gymnasium, which defines what is right."""
    makers: list[Callable[[], gymnasium.Env[Any, Any]]] = [partial(make, env_id, **arguments)] * count
    return SyncVectorEnv(makers, autoreset_mode=mode)


def random_actions(env_id: str, seed: int, *shape: int) -> NDArray[np.float32]:
    """Uniform ones, each held for a few steps: bodies move and touch."""
    size = make(env_id).action_space.shape
    assert size is not None
    rng = np.random.default_rng(seed)
    held = rng.uniform(-1.0, 1.0, (-(-shape[0] // 4), *shape[1:], *size))
    return np.repeat(held, 4, axis=0)[: shape[0]].astype(np.float32)


def touching(env_id: str) -> gymnasium.Env[Any, Any]:
    """An environment in the middle of an episode, bodies in contact."""
    env = make(env_id)
    worlds = env.unwrapped.task.world.state.worlds  # type: ignore[attr-defined]
    env.reset(seed=11)
    for n, action in enumerate(random_actions(env_id, 2, 300)):
        _, _, terminated, truncated, _ = env.step(action)
        assert not terminated
        assert not truncated
        if n >= 5 and worlds["contact_count"][0]:
            return env
    raise AssertionError("nothing touched")


def play(env: Any, actions: Iterable[Any]) -> list[Any]:
    """All that steps and resets return; a reset wherever an episode ends."""
    log: list[Any] = []
    for action in actions:
        log.append(env.step(action))
        if not isinstance(env, gymnasium.vector.VectorEnv):
            if log[-1][2] or log[-1][3]:
                log.append(env.reset())
        elif env.metadata["autoreset_mode"] == AutoresetMode.DISABLED:
            ended = log[-1][2] | log[-1][3]
            if ended.any():
                log.append(env.reset(options={"reset_mask": ended}))
    return log


def digest(value: Any) -> str:
    """Of the bits and types of nested results, wherever they are in memory."""
    state = hashlib.sha256()
    _feed(state, value)
    return state.hexdigest()


def _feed(state: Any, value: Any) -> None:
    if isinstance(value, np.ndarray) and value.dtype.names:
        for name in value.dtype.names:
            _feed(state, value[name])
    elif isinstance(value, np.ndarray) and value.dtype != object:
        state.update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, np.ndarray | list | tuple):
        state.update(b"[%d" % len(value))
        for item in value:
            _feed(state, item)
    elif isinstance(value, dict):
        for key in sorted(value):
            state.update(key.encode())
            _feed(state, value[key])
    elif is_dataclass(value):
        for field in fields(value):
            _feed(state, getattr(value, field.name))
    else:
        state.update(repr(value).encode())


def assert_same_infos(infos: dict[str, Any], expected: dict[str, Any]) -> None:
    """Equal keys, masks, types and, where the mask is True, bits."""
    assert infos.keys() == expected.keys()
    for key, value in infos.items():
        other = expected[key]
        if isinstance(value, dict):
            assert_same_infos(value, other)
        elif key.startswith("_"):
            np.testing.assert_array_equal(value, other, err_msg=key)
        else:
            there = expected[f"_{key}"]
            assert isinstance(value, np.ndarray), key
            assert value.dtype == other.dtype, key
            assert len(value) == len(there), key
            for one, two in zip(value[there], other[there], strict=True):
                if isinstance(two, dict):  # the last observation of an ended world
                    assert data_equivalence(one, two, exact=True)
                    continue
                np.testing.assert_array_equal(one, two, err_msg=key, strict=True)
            if value.dtype == object:
                assert all(one is None for one in value[~there])
