"""A scripted builder for GStack-v0: pure feedback from the observation, without memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.stack import scene
from gsenv.envs.stack.env import StackTask

_INDEX = {entry.name: k for k, entry in enumerate(StackTask.observations)}

_CARRY_GAP = 0.10  # m, above the support until the block is centred and level
_GAIN = 4.0  # 1/s: speed asked for, per m or rad of error
_LANDING_SPEED = 0.10  # m/s, of the last centimetres
_CENTRED = 0.012  # m
_LEVEL = 0.02  # rad
_CALM = 0.06  # m/s, for letting go
_STEADYING = 0.7  # of the deviation of the velocity, taken back near the support
_PARTING = 0.4  # m, above the finished tower
_LEAN_SHARE = 0.5  # how much of the tower's lean the next block takes back

DROP_GAP = 0.5  # m, of `drop_blocks`
LOWERED_GAP = 0.001  # m, of `lower_blocks`
_RISING_SPEED = 0.6  # m/s, of `lower_blocks` without a block

Seen = dict[str, NDArray[Any]]


def drop_blocks(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the actions of a naive builder, which centres and levels each block and drops it from 0.5 m."""
    return build_tower(observations, DROP_GAP)


def lower_blocks(observations: NDArray[np.float32], speed: float) -> NDArray[np.float32]:
    """Return the actions of a simple builder: it lowers each block at one speed, m/s, whatever else there is to do.

    Meanwhile it centres and levels it, and lets go 1 mm above the support; it waits for nothing.
    """
    seen = {name: np.asarray(observations)[..., k] for name, k in _INDEX.items()}
    holding = seen["holding"] > 0.5
    actions = np.stack(
        [
            np.where(holding, -_GAIN * seen["block_dx"], 0.0) / scene.SPEED,
            np.where(holding, -speed, _RISING_SPEED) / scene.SPEED,
            np.where(holding, -_GAIN * seen["block_angle"], 0.0) / scene.TURN_SPEED,
            np.where(holding & (seen["block_gap"] < LOWERED_GAP), 1.0, -1.0),
        ],
        axis=-1,
    )
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def build_tower(observations: NDArray[np.float32], drop_gap: float = 0.0) -> NDArray[np.float32]:
    """Return actions (..., 4) for observations (..., entry).

    With a block: level it and centre it over its support, come down, let go once it has landed.
    Without: go straight up until the next block arrives. With `drop_gap`, m, blocks are let go at this height.
    """
    seen = {name: np.asarray(observations)[..., k] for name, k in _INDEX.items()}
    holding = seen["holding"] > 0.5
    error_x = _target_x(seen) - seen["block_dx"]
    error_angle = seen["support_angle"] - seen["block_angle"]
    ready = (np.abs(error_x) < 2.0 * _CENTRED) & (np.abs(error_angle) < 2.0 * _LEVEL)
    speed_x = np.where(holding, _GAIN * error_x, 0.0)
    speed_y = np.where(holding, _descent(seen, ready, drop_gap), _ascent(seen))
    # The block turns about the magnet: what it swings to the side is taken back at once.
    turn = np.where(holding, _GAIN * error_angle, -2.0 * seen["gripper_angle"])
    landed = holding & (seen["block_gap"] - drop_gap < 0.004) & ready & (_slow(seen) | (drop_gap > 0.0))
    actions = np.stack(
        [
            speed_x / scene.SPEED,
            speed_y / scene.SPEED,
            turn / scene.TURN_SPEED,
            np.where(landed, 1.0, -1.0),
        ],
        axis=-1,
    )
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def _target_x(seen: Seen) -> NDArray[Any]:
    """Return where on its support the block belongs, in m: a little back towards the first block."""
    support_lean = seen["lean"] - seen["block_dx"]
    return -_LEAN_SHARE * support_lean


def _descent(seen: Seen, ready: NDArray[np.bool_], drop_gap: float) -> NDArray[Any]:
    """Return the vertical speed with a block: wait above the support until ready, then land softly."""
    gap = seen["block_gap"] - drop_gap
    high = _GAIN * (_CARRY_GAP - gap)
    low = np.minimum(-_GAIN * gap, -_LANDING_SPEED)
    # of a gantry that sways: what the block moves otherwise than it should, it moves by the sway
    return np.where(ready, low + _STEADYING * (low - seen["block_vy"]), high)


def _ascent(seen: Seen) -> NDArray[Any]:
    """Return the vertical speed without a block: up, gently at first, to where the next one comes."""
    clearance = np.maximum(seen["clearance"], 0.0)
    finished = (seen["rise"] == 0.0) & (clearance > _PARTING)
    return np.where(finished, 0.0, np.minimum(0.3 + 8.0 * clearance, 1.5))


def _slow(seen: Seen) -> NDArray[np.bool_]:
    return np.hypot(seen["block_vx"], seen["block_vy"]) < _CALM
