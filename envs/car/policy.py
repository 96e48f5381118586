"""A scripted driver for GCar-v0: brakes before crests and drops, and keeps its nose level in the air.

The policy is a function of the observation alone and has no memory.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.car import rules
from gsenv.envs.car.env import CarTask

_INDEX = {entry.name: k for k, entry in enumerate(CarTask.observations)}
_HEIGHTS = slice(_INDEX["height_0"], _INDEX["height_0"] + rules.HEIGHTS)
_DX = rules.HEIGHT_SPACING
_AHEAD = rules.FIRST_HEIGHT + _DX * np.arange(rules.HEIGHTS)

# The driver's habits.
CRUISE = 7.0  # m/s
CRAWL = 2.5  # m/s, over the sharpest crest
LIFT = 5.0  # m/s^2, the most that a crest may fall away from the car
BRAKING = 3.0  # m/s^2, what it counts on
THROTTLE = 0.5  # per m/s too slow


def drive(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 2) for observations (..., entry)."""
    observations = np.asarray(observations, np.float64)
    seen = {name: observations[..., k] for name, k in _INDEX.items()}
    speed = 10.0 * (seen["vx"] * seen["cosine"] + seen["vy"] * seen["sine"])
    throttle = THROTTLE * (_safe_speed(observations[..., _HEIGHTS]) - speed)
    throttle = np.where(throttle < 0.0, 0.5 * throttle, throttle)
    slope = (observations[..., _HEIGHTS.start + 2] - observations[..., _HEIGHTS.start]) / (2.0 * _DX)
    # Off the ground, speeding wheels up lifts the nose and braking them drops it.
    tilt = seen["sine"] - np.clip(0.7 * slope, -0.5, 0.5) + 0.3 * seen["w"]
    flying = (seen["rear_touches"] + seen["front_touches"]) == 0.0
    rearing = (seen["front_touches"] == 0.0) & (seen["rear_touches"] > 0.0) & (tilt > 0.5)
    throttle = np.where(flying, -2.0 * tilt, np.where(rearing, 0.5 - tilt, throttle))
    both = np.stack([throttle, throttle], axis=-1)
    return np.clip(both, -1.0, 1.0).astype(np.float32)


def _safe_speed(heights: NDArray[Any]) -> NDArray[Any]:
    """Return the speed in m/s from which the car can brake in time for every crest ahead, so that none throws it."""
    bend = (2.0 * heights[..., 1:-1] - heights[..., :-2] - heights[..., 2:]) / _DX**2
    bend = 0.5 * (bend[..., :-1] + bend[..., 1:])
    crest = np.clip(LIFT / np.maximum(bend, 1e-3), CRAWL**2, CRUISE**2)
    square = crest + 2.0 * BRAKING * np.maximum(_AHEAD[1:-2] - 1.0, 0.0)
    return np.minimum(np.sqrt(square.min(axis=-1)), CRUISE)
