"""A scripted builder for tower_v0: each gripper by its own observation, without memory or messages."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.stack import scene
from gsenv.envs.tower.env import TowerTask

_INDEX = {entry.name: k for k, entry in enumerate(TowerTask.observations)}

_CARRY_GAP = 0.10  # m, above the support until the block is centred and level
_GAIN = 4.0  # 1/s: speed asked for, per m or rad of error
_LANDING_SPEED = 0.10  # m/s, of the last centimetres
_CENTRED = 0.012  # m
_LEVEL = 0.02  # rad
_CALM = 0.06  # m/s, for letting go
_LEAN_SHARE = 0.5  # how much of the tower's lean the next block takes back
_WAITING = -1.15  # m, of the block from its support, while the other builds
_BUSY = 0.8  # m: nearer to the tower than this, an empty gripper is still in the way
_PARTING = 0.12  # m, above the tower, before the empty gripper leaves

DROP_GAP = 0.5  # m, of `drop_together`

Seen = dict[str, NDArray[Any]]


def drop_together(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the actions of naive builders, which centre and level each block and drop it from 0.5 m."""
    return build_together(observations, DROP_GAP)


def build_together(observations: NDArray[np.float32], drop_gap: float = 0.0) -> NDArray[np.float32]:
    """Return actions (..., 4) for observations (..., entry) of one or many grippers.

    Of two that hold a block the one with the turn builds, the other waits on its side, and so it does until the
    empty gripper has left. An empty gripper rises off the tower and goes out to its next block. With `drop_gap`,
    m, blocks are let go at this height.
    """
    seen = {name: np.asarray(observations, np.float64)[..., k] for name, k in _INDEX.items()}
    holding = seen["holding"] > 0.5
    mine = _my_turn(seen)
    error_x = np.where(mine, -_LEAN_SHARE * seen["lean"], _WAITING) - seen["block_dx"]
    error_angle = seen["support_angle"] - seen["block_angle"]
    ready = mine & (np.abs(error_x) < 2.0 * _CENTRED) & (np.abs(error_angle) < 2.0 * _LEVEL)
    calm = (np.hypot(seen["block_vx"], seen["block_vy"]) < _CALM) | (drop_gap > 0.0)
    landed = holding & (seen["block_gap"] - drop_gap < 0.004) & ready & calm
    actions = np.stack(
        [
            np.where(holding, _inwards(seen, error_x), _outwards(seen)) / scene.SPEED,
            np.where(holding, _descent(seen, ready, drop_gap), _ascent(seen)) / scene.SPEED,
            np.where(holding, _GAIN * error_angle, -2.0 * seen["gripper_angle"]) / scene.TURN_SPEED,
            np.where(landed, 1.0, -1.0),
        ],
        axis=-1,
    )
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def _my_turn(seen: Seen) -> NDArray[np.bool_]:
    """Whether to go to the tower: the way is free, or both hold a block and this gripper has the turn."""
    other_x = seen["other_dx"] + seen["grasp_dx"] + seen["block_dx"]  # of the other gripper from the support
    away = other_x > _BUSY
    return np.where(seen["other_holding"] > 0.5, seen["turn"] > 0.5, away)


def _inwards(seen: Seen, error_x: NDArray[Any]) -> NDArray[Any]:
    """Return the speed inwards with a block, which must rise beside the tower before it comes near."""
    low = (seen["block_gap"] < 0.5 * _CARRY_GAP) & (seen["block_dx"] < -_BUSY) & (error_x > 0.0)
    return np.where(low, 0.0, _GAIN * error_x)


def _outwards(seen: Seen) -> NDArray[Any]:
    """Return the speed inwards without a block: out to the depot, once clear of the tower."""
    return np.where(seen["clearance"] > _PARTING, -_GAIN * (seen["to_depot"] + 0.05), 0.0)


def _descent(seen: Seen, ready: NDArray[np.bool_], drop_gap: float) -> NDArray[Any]:
    """Return the vertical speed with a block: wait above the support until ready, then land softly."""
    gap = seen["block_gap"] - drop_gap
    return np.where(ready, np.minimum(-_GAIN * gap, -_LANDING_SPEED), _GAIN * (_CARRY_GAP - gap))


def _ascent(seen: Seen) -> NDArray[Any]:
    """Return the vertical speed without a block: up off the tower, gently at first, and high enough on the way out."""
    clearance = seen["clearance"]
    off = np.minimum(0.3 + 8.0 * np.maximum(clearance, 0.0), _GAIN * (2.0 * _PARTING - clearance))
    return np.where(seen["to_depot"] > 0.0, off, np.minimum(_GAIN * seen["rise"] + 0.1 * (seen["rise"] > 0), 1.5))
