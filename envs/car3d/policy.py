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

    cruise: float = 12.5  # m/s
    crawl: float = 3.0  # m/s, the least that it asks for
    grip: float = 5.6  # m/s^2, sideways
    lift: float = 20.0  # m/s^2, the most that a crest may fall away from the car
    braking: float = 5.5  # m/s^2, what it counts on
    early: float = 2.0  # m before bends, where it has braked
    ramp: float = 5.0  # m/s, at the gate of a ramp
    bumps: float = 7.0  # m/s
    balls: float = 9.0  # m/s
    near: float = 2.0  # m from a gate, where that holds
    throttle: float = 1.0  # per m/s too slow
    brake: float = 0.5  # per m/s too fast
    most: float = 0.7  # throttle, at which the front wheels still steer
    straight: float = 0.08  # rad, up to which more is allowed


HABITS = Habits()


def pursue(observations: NDArray[np.float32], habits: Habits = HABITS) -> NDArray[np.float32]:
    """Return actions (..., 2) for observations (..., entry)."""
    observations = np.asarray(observations, np.float64)
    seen = {name: observations[..., k] for name, k in _INDEX.items()}
    angle = _steer(seen)
    square = np.full(angle.shape, habits.cruise**2)
    for k, ahead in enumerate(observe.BENDS_AHEAD):
        allowed = habits.grip / np.maximum(observe.BEND_UNIT * abs(seen[f"bend_{k}"]), 1e-3)
        square = np.minimum(square, allowed + 2.0 * habits.braking * max(ahead - habits.early, 0.0))
    gate = seen["gate_ramps"] * habits.ramp + seen["gate_bumps"] * habits.bumps + seen["gate_balls"] * habits.balls
    near = np.maximum(10.0 * abs(seen["to_gate"]) - habits.near, 0.0)
    square = np.where(gate > 0.0, np.minimum(square, gate**2 + 2.0 * habits.braking * near), square)
    square = np.minimum(square, _crest(observations[..., _PATCH], habits))
    missing = np.sqrt(np.maximum(square, habits.crawl**2)) - 10.0 * seen["vx"]
    most = np.where(abs(angle) > habits.straight, habits.most, 1.0)
    throttle = np.minimum(np.where(missing < 0.0, habits.brake, habits.throttle) * missing, most)
    actions = np.stack([throttle, angle / scene.STEERING], axis=-1)
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def hold_speed(observations: NDArray[np.float32], speed: float = 6.0) -> NDArray[np.float32]:
    """Return actions (..., 2) that steer as `pursue` does, and hold a speed in m/s."""
    actions = pursue(observations)
    missing = speed - 10.0 * np.asarray(observations, np.float64)[..., _INDEX["vx"]]
    actions[..., 0] = np.clip(np.where(missing < 0.0, 0.25, 0.6) * missing, -1.0, 1.0)
    return actions


def _steer(seen: dict[str, NDArray[Any]]) -> NDArray[Any]:
    """Return the angle in rad of the front wheels; the point that it aims at is the farther the faster the car is."""
    speed = 10.0 * seen["vx"]
    share = np.clip((speed - 4.0) / 5.0, 0.0, 1.0)
    x = observe.LOOK * (seen["waypoint_0_x"] + share * (seen["waypoint_1_x"] - seen["waypoint_0_x"])) + scene.AXLES
    y = observe.LOOK * (seen["waypoint_0_y"] + share * (seen["waypoint_1_y"] - seen["waypoint_0_y"]))
    angle: NDArray[Any] = np.arctan(2.0 * scene.AXLES * 2.0 * y / np.maximum(x * x + y * y, 1.0))
    return angle


def _crest(patch: NDArray[Any], habits: Habits) -> NDArray[Any]:
    """Return the square of the speed, m^2/s^2, at which no crest in the middle of the patch throws the car."""
    rows = patch.reshape(*patch.shape[:-1], observe.PATCH_ROWS, observe.PATCH_COLUMNS)
    heights = observe.HEIGHT_UNIT * rows[..., 1:4].mean(-1)
    bend = (2.0 * heights[..., 1:-1] - heights[..., :-2] - heights[..., 2:]) / observe.ROW_SPACING**2
    ahead = observe.FIRST_ROW + observe.ROW_SPACING * np.arange(1, observe.PATCH_ROWS - 1)
    allowed = habits.lift / np.maximum(bend, 1e-2) + 2.0 * habits.braking * np.maximum(ahead - 1.0, 0.0)
    least: NDArray[Any] = allowed.min(axis=-1)
    return least
