"""States of GStack3D-v0 that tests start from."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.task import Task
from gsenv.envs.stack3d.scene import DRIVE_JOINT, FIRST_BLOCK, FIRST_BLOCK_SHAPE, FIRST_WELD

IDLE = np.array([0, 0, 0, 0, -1], np.float32)
RELEASE = np.array([0, 0, 0, 0, 1], np.float32)
DOWN = np.array([0, 0, -1, 0, -1], np.float32)


def turn_z(angle: float) -> tuple[float, float, float, float]:
    return float(np.cos(0.5 * angle)), 0.0, 0.0, float(np.sin(0.5 * angle))


def mixed_actions(seed: int, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Random actions that hold their block for a while."""
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (*shape, 5)).astype(np.float32)
    actions[..., 4] -= 0.9
    return actions


def place_gripper(task: Task, height: float) -> None:
    """Above the middle, at rest, its target with it."""
    task.world.set_pose("gripper", position=(0.0, 0.0, height), orientation=turn_z(0.0))
    task.world.set_velocity("gripper", linear=(0.0, 0.0, 0.0), angular=(0.0, 0.0, 0.0))
    task.world.state.joints["target_position"][0, DRIVE_JOINT] = (0.0, 0.0, height)
    task.world.state.joints["target_rotation"][0, DRIVE_JOINT] = turn_z(0.0)


def set_up_tower(task: Task, count: int) -> list[float]:
    """`count` released blocks, one on the other, the gripper 1 m above; returns their heights."""
    physics = task.world
    top = 0.0
    heights = []
    for k in range(count):
        name = f"block_{k}"
        physics.parameters.set(name, enabled=1)
        half = float(physics.parameters.shapes["size"][0, FIRST_BLOCK_SHAPE + k, 2])
        physics.set_pose(name, position=(0.0, 0.0, top + half), orientation=turn_z(0.0))
        physics.set_velocity(name, linear=(0.0, 0.0, 0.0), angular=(0.0, 0.0, 0.0))
        heights.append(top + half)
        top += 2.0 * half
    physics.parameters.joints["enabled"][0, FIRST_WELD:] = 0
    place_gripper(task, top + 1.0)
    state = task.task_state[:1]
    state["arrived"] = count
    state["held"] = -1
    state["placed"] = count - 1
    state["stand"] = 0
    return heights


def block_position(task: Task, k: int) -> Any:
    return np.array(task.world.position[0, FIRST_BLOCK + k])
