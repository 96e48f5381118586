"""A scripted builder for GStack3D-v0: pure feedback from the observation, without memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.stack3d import scene
from gsenv.envs.stack3d.env import Stack3DTask

_INDEX = {entry.name: k for k, entry in enumerate(Stack3DTask.observations)}

_CARRY_GAP = 0.10  # m, above the support until the block is centred and straight
_GAIN = 4.0  # 1/s: speed asked for, per m or rad of error
_LANDING_SPEED = 0.10  # m/s, of the last centimetres
_CENTRED = 0.012  # m
_STRAIGHT = 0.03  # rad
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

    Meanwhile it centres and turns it, and lets go 1 mm above the support; it waits for nothing.
    """
    seen = {name: np.asarray(observations, np.float64)[..., k] for name, k in _INDEX.items()}
    holding = seen["holding"] > 0.5
    actions = np.stack(
        [
            np.where(holding, -_GAIN * seen["block_dx"], 0.0) / scene.SPEED,
            np.where(holding, -_GAIN * seen["block_dy"], 0.0) / scene.SPEED,
            np.where(holding, -speed, _RISING_SPEED) / scene.SPEED,
            np.where(holding, -_GAIN * seen["block_twist"], 0.0) / scene.TURN_SPEED,
            np.where(holding & (seen["block_gap"] < LOWERED_GAP), 1.0, -1.0),
        ],
        axis=-1,
    )
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def build_tower(observations: NDArray[np.float32], drop_gap: float = 0.0) -> NDArray[np.float32]:
    """Return actions (..., 5) for observations (..., entry).

    With a block: turn it in line and centre it over its support, come down, let go once it has landed.
    Without: go straight up until the next block arrives. With `drop_gap`, m, blocks are let go at this height.
    """
    seen = {name: np.asarray(observations, np.float64)[..., k] for name, k in _INDEX.items()}
    holding = seen["holding"] > 0.5
    # of the tower's lean, the support's part: the block's own is still to come
    error_x = -_LEAN_SHARE * (seen["lean_x"] - seen["block_dx"]) - seen["block_dx"]
    error_y = -_LEAN_SHARE * (seen["lean_y"] - seen["block_dy"]) - seen["block_dy"]
    centred = np.hypot(error_x, error_y) < 2.0 * _CENTRED
    ready = centred & (np.abs(seen["block_twist"]) < _STRAIGHT)
    turn = np.where(holding, -_GAIN * seen["block_twist"], -2.0 * seen["gripper_heading"])
    speed = np.sqrt(seen["block_vx"] ** 2 + seen["block_vy"] ** 2 + seen["block_vz"] ** 2)
    landed = holding & (seen["block_gap"] - drop_gap < 0.004) & ready & ((speed < _CALM) | (drop_gap > 0.0))
    actions = np.stack(
        [
            np.where(holding, _GAIN * error_x, 0.0) / scene.SPEED,
            np.where(holding, _GAIN * error_y, 0.0) / scene.SPEED,
            np.where(holding, _descent(seen, ready, drop_gap), _ascent(seen)) / scene.SPEED,
            turn / scene.TURN_SPEED,
            np.where(landed, 1.0, -1.0),
        ],
        axis=-1,
    )
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def _descent(seen: Seen, ready: NDArray[np.bool_], drop_gap: float) -> NDArray[Any]:
    """Return the vertical speed with a block: wait above the support until ready, then land softly."""
    gap = seen["block_gap"] - drop_gap
    low = np.minimum(-_GAIN * gap, -_LANDING_SPEED)
    # of a gantry that sways: what the block moves otherwise than it should, it moves by the sway
    return np.where(ready, low + _STEADYING * (low - seen["block_vz"]), _GAIN * (_CARRY_GAP - gap))


def _ascent(seen: Seen) -> NDArray[Any]:
    """Return the vertical speed without a block: up, gently at first, to where the next one comes."""
    clearance = np.maximum(seen["clearance"], 0.0)
    finished = (seen["rise"] == 0.0) & (clearance > _PARTING)
    return np.where(finished, 0.0, np.minimum(0.3 + 8.0 * clearance, 1.5))
