"""GCar3D's car on a straight and level road."""

from __future__ import annotations

import numpy as np

from gsenv.envs.car3d import road, scene
from gsenv.envs.car3d.env import Car3DEnv

CAR = [scene.CHASSIS_BODY, *range(scene.FIRST_WHEEL, scene.FIRST_WHEEL + 4)]  # the bodies that move with it


def level_env(**randomize: tuple[float, float]) -> Car3DEnv:
    """The car on an empty, level and straight road."""
    env = Car3DEnv(difficulty=0.0, randomize=randomize)
    env.reset(seed=0)
    env.task.world.parameters.vertices["position"][0, : scene.ROWS * scene.COLUMNS, 2] = 0.0
    env.task.world.parameters.vertices["normal"][0, 0, :2] = -1.0, 1.0
    env.task.task_state["path"][0] = 0.0
    env.task.task_state["path"][0, :, road.X] = scene.FIRST_X + scene.STEP * np.arange(scene.NODES)
    return env


def drive_for(env: Car3DEnv, steps: int, action: tuple[float, float]) -> None:
    for _ in range(steps):
        env.task.step((action,))


def move_car(env: Car3DEnv, axis: int, by: float) -> None:
    """Move the car by so many m along an axis of the world."""
    env.task.world.state.bodies["position"][0, CAR, axis] += by
