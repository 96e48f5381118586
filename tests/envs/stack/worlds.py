"""States of GStack-v0 that tests start from."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.task import Task
from gsenv.envs.stack.scene import FIRST_BLOCK, FIRST_BLOCK_SHAPE

IDLE = np.array([0, 0, 0, -1], np.float32)
RELEASE = np.array([0, 0, 0, 1], np.float32)


def mixed_actions(seed: int, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Random actions that hold their block for a while."""
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (*shape, 4)).astype(np.float32)
    actions[..., 3] -= 0.9
    return actions


def set_up_tower(task: Task, count: int, world: int = 0) -> list[float]:
    """`count` released blocks, one on the other, the gripper 1 m above; returns their heights."""
    physics = task.world
    top = 0.0
    heights = []
    for k in range(count):
        name = f"block_{k}"
        physics.parameters.set(name, worlds=world, enabled=1)
        half = float(physics.parameters.shapes["size"][world, FIRST_BLOCK_SHAPE + k, 1])
        physics.set_pose(name, position=(0.0, top + half), angle=0.0, worlds=world)
        physics.set_velocity(name, linear=(0.0, 0.0), angular=0.0, worlds=world)
        heights.append(top + half)
        top += 2.0 * half
    physics.parameters.joints["enabled"][world, 1:] = 0
    physics.set_pose("gripper", position=(0.0, top + 1.0), angle=0.0, worlds=world)
    physics.set_target("drive", position=(0.0, top + 1.0), angle=0.0, worlds=world)
    state = task.task_state[world : world + 1]
    state["arrived"] = count
    state["held"] = -1
    state["placed"] = count - 1
    state["stand"] = 0
    return heights


def block_position(task: Task, k: int, world: int = 0) -> Any:
    return np.array(task.world.position[world, FIRST_BLOCK + k])


def assert_equal(a: Any, b: Any) -> None:
    """Equal bit for bit but for the padding of records: arrays, snapshots, results of steps."""
    if is_dataclass(a):
        for field in fields(a):
            assert_equal(getattr(a, field.name), getattr(b, field.name))
    elif isinstance(a, dict):
        assert a.keys() == b.keys()
        for key in a:
            assert_equal(a[key], b[key])
    elif isinstance(a, (list, tuple)):
        assert len(a) == len(b)
        for one, other in zip(a, b, strict=True):
            assert_equal(one, other)
    elif isinstance(a, np.ndarray) and a.dtype.names:
        for name in a.dtype.names:
            assert_equal(a[name], b[name])
    elif isinstance(a, np.ndarray) and a.dtype != object:
        assert a.dtype == b.dtype
        assert np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()
    elif isinstance(a, np.ndarray):
        assert_equal(a.tolist(), b.tolist())
    else:
        assert a == b
