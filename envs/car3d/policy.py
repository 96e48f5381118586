"""Scripted drivers for GCar3D-v0, functions of the observation alone: pure pursuit at a speed that the road allows.

Source of the method: R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm" (1992): steer onto the
circle through the rear axle that meets the road some way ahead.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.car3d import observe, scene
from gsenv.envs.car3d.env import Car3DTask

_INDEX = {entry.name: k for k, entry in enumerate(Car3DTask.observations)}
_PATCH = slice(_INDEX["height_0_0"], _INDEX["height_0_0"] + observe.PATCH_ROWS * observe.PATCH_COLUMNS)


class Habits(NamedTuple):
    """Numbers of `pursue`."""

    cruise: float = 9.0  # m/s
    crawl: float = 3.0  # m/s, the least that it asks for
    grip: float = 5.0  # m/s^2, sideways
    lift: float = 6.0  # m/s^2, the most that a crest may fall away from the car
    braking: float = 4.0  # m/s^2, what it counts on
    gate: float = 5.0  # m/s, below a gate
    throttle: float = 0.6  # per m/s too slow
    brake: float = 0.25  # per m/s too fast


HABITS = Habits()


def pursue(observations: NDArray[np.float32], habits: Habits = HABITS) -> NDArray[np.float32]:
    """Return actions (..., 2) for observations (..., entry)."""
    observations = np.asarray(observations, np.float64)
    seen = {name: observations[..., k] for name, k in _INDEX.items()}
    bends = [_curvature(seen, k) for k in range(len(observe.AHEAD))]
    angle = np.arctan(2.0 * scene.AXLES * np.where(seen["vx"] > 0.6, bends[1], bends[0]))
    square = np.full(angle.shape, habits.cruise**2)
    for k, ahead in enumerate(observe.AHEAD[1:], 1):
        allowed = habits.grip / np.maximum(abs(bends[k]), 1e-3) + habits.braking * (ahead - observe.AHEAD[1])
        square = np.minimum(square, allowed)
    near = np.maximum(10.0 * abs(seen["to_gate"]) - 3.0, 0.0)
    square = np.minimum(square, habits.gate**2 + 2.0 * habits.braking * near)
    square = np.minimum(square, _crest(observations[..., _PATCH], habits))
    missing = np.sqrt(np.maximum(square, habits.crawl**2)) - 10.0 * seen["vx"]
    throttle = np.where(missing < 0.0, habits.brake, habits.throttle) * missing
    actions = np.stack([throttle, angle / scene.STEERING], axis=-1)
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def hold_speed(observations: NDArray[np.float32], speed: float = 6.0) -> NDArray[np.float32]:
    """Return actions (..., 2) that steer as `pursue` does, and hold a speed in m/s."""
    actions = pursue(observations)
    missing = speed - 10.0 * np.asarray(observations, np.float64)[..., _INDEX["vx"]]
    actions[..., 0] = np.clip(np.where(missing < 0.0, 0.25, 0.6) * missing, -1.0, 1.0)
    return actions


def _curvature(seen: dict[str, NDArray[Any]], k: int) -> NDArray[Any]:
    """Return the curvature in 1/m of the circle from the rear axle through waypoint k."""
    x = observe.LOOK * seen[f"waypoint_{k}_x"] + scene.AXLES
    y = observe.LOOK * seen[f"waypoint_{k}_y"]
    curvature: NDArray[Any] = 2.0 * y / np.maximum(x * x + y * y, 1.0)
    return curvature


def _crest(patch: NDArray[Any], habits: Habits) -> NDArray[Any]:
    """Return the square of the speed, m^2/s^2, at which no crest in the middle of the patch throws the car."""
    rows = patch.reshape(*patch.shape[:-1], observe.PATCH_ROWS, observe.PATCH_COLUMNS)
    heights = observe.HEIGHT_UNIT * rows[..., 1:4].mean(-1)
    bend = (2.0 * heights[..., 1:-1] - heights[..., :-2] - heights[..., 2:]) / observe.ROW_SPACING**2
    ahead = observe.FIRST_ROW + observe.ROW_SPACING * np.arange(1, observe.PATCH_ROWS - 1)
    allowed = habits.lift / np.maximum(bend, 1e-2) + 2.0 * habits.braking * np.maximum(ahead - 1.0, 0.0)
    least: NDArray[Any] = allowed.min(axis=-1)
    return least
