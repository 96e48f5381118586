"""Scripted drivers for GCar: one that holds a speed, and one that brakes before crests, hollows and gates.

They are functions of the observation alone and have no memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.car import rules
from gsenv.envs.car.env import CarTask

_INDEX = {entry.name: k for k, entry in enumerate(CarTask.observations)}
_HEIGHTS = slice(_INDEX["height_0"], _INDEX["height_0"] + rules.HEIGHTS)
_DX = rules.HEIGHT_SPACING
_AHEAD = rules.FIRST_HEIGHT + _DX * np.arange(rules.HEIGHTS)


class Habits(NamedTuple):
    """Numbers of a driver, found by random search; the defaults are for GCar-v0."""

    cruise: float = 6.5  # m/s
    crawl: float = 2.54  # m/s, over the sharpest crest
    lift: float = 7.6  # m/s^2, the most that a crest may fall away from the car
    press: float = 10.0  # m/s^2, the most that a hollow may press it upwards
    braking: float = 6.4  # m/s^2, what it counts on
    throttle: float = 0.5  # per m/s too slow
    brake: float = 0.1  # per m/s too fast
    gate: float = 5.8  # m/s, below a gate
    near: float = 1.2  # m from its middle, where that holds
    level: float = 2.3  # per unit of tilt in the air
    damp: float = 0.29  # s/rad, of the rate in that tilt


HABITS = Habits()
STEEP = Habits(
    cruise=9.0, crawl=2.5, lift=6.5, press=13.0, braking=5.0, brake=0.12, gate=6.2, near=2.0, level=2.1, damp=0.3
)


def hold_speed(observations: NDArray[np.float32], speed: float = 5.0) -> NDArray[np.float32]:
    """Return actions (..., 2) that hold a speed in m/s and heed nothing else."""
    seen = _seen(observations)
    throttle = 0.5 * (speed - _speed(seen))
    return _both(np.where(throttle < 0.0, 0.5 * throttle, throttle))


def drive(observations: NDArray[np.float32], habits: Habits = HABITS) -> NDArray[np.float32]:
    """Return actions (..., 2) for observations (..., entry)."""
    observations = np.asarray(observations, np.float64)
    seen, heights = _seen(observations), rules.HEIGHT_UNIT * observations[..., _HEIGHTS]
    missing = _safe_speed(heights, 10.0 * seen["to_gate"], habits) - _speed(seen)
    throttle = np.where(missing < 0.0, habits.brake, habits.throttle) * missing
    slope = (heights[..., 2] - heights[..., 0]) / (2.0 * _DX)
    # Off the ground, speeding wheels up lifts the nose and braking them drops it.
    tilt = seen["sine"] - np.clip(0.7 * slope, -0.5, 0.5) + habits.damp * rules.RATE_UNIT * seen["w"]
    flying = (seen["rear_touches"] + seen["front_touches"]) == 0.0
    rearing = (seen["front_touches"] == 0.0) & (seen["rear_touches"] > 0.0) & (tilt > 0.5)
    return _both(np.where(flying, -habits.level * tilt, np.where(rearing, 0.5 - tilt, throttle)))


def drive_steep(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 2) of the driver for GCar-hardcore-v0."""
    return drive(observations, STEEP)


def _seen(observations: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return {name: observations[..., k] for name, k in _INDEX.items()}


def _both(throttle: NDArray[Any]) -> NDArray[np.float32]:
    return np.clip(np.stack([throttle, throttle], axis=-1), -1.0, 1.0).astype(np.float32)


def _speed(seen: dict[str, NDArray[Any]]) -> NDArray[Any]:
    """Return the speed in m/s along the car's axis."""
    speed: NDArray[Any] = 10.0 * (seen["vx"] * seen["cosine"] + seen["vy"] * seen["sine"])
    return speed


def _safe_speed(heights: NDArray[Any], gate: NDArray[Any], habits: Habits) -> NDArray[Any]:
    """Return the speed in m/s from which the car can brake in time for all that it sees ahead.

    Over a crest or through a hollow of the curvature k, v^2 k stays below a bound; `gate` is the distance of the next.
    """
    bend = (2.0 * heights[..., 1:-1] - heights[..., :-2] - heights[..., 2:]) / _DX**2
    bend = 0.5 * (bend[..., :-1] + bend[..., 1:])
    bound = np.where(bend > 0.0, habits.lift, habits.press) / np.maximum(abs(bend), 1e-3)
    square = np.clip(bound, habits.crawl**2, habits.cruise**2)
    square = square + 2.0 * habits.braking * np.maximum(_AHEAD[1:-2] - 1.0, 0.0)
    square = square + 2.0 * rules.G * np.minimum(heights[..., 1:-2], 0.0)  # what the car gains downhill
    at_gate = habits.gate**2 + 2.0 * habits.braking * np.maximum(abs(gate) - habits.near, 0.0)
    least = np.minimum(square.min(axis=-1), at_gate)
    return np.clip(np.sqrt(np.maximum(least, 0.0)), habits.crawl, habits.cruise)
