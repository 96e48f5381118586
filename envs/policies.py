"""Policies to look at and to compare with: scripted ones, and trained ones where an asset exists.

A policy is a function of an environment; it returns the next action. The scripted ones are pure
feedback from the observation, without memory, so one policy serves any number of environments; the
trained ones are too.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs import stack_scene
from gsenv.envs.car_driver import drive
from gsenv.envs.mlp import MlpPolicy
from gsenv.envs.stack import StackTask
from gsenv.envs.stack3d_policy import build_tower as build_tower_in_space

Observations = NDArray[np.float32]
Actions = NDArray[np.float32]
Policy = Callable[[Any], Actions]
BatchPolicy = Callable[[Observations], Actions]

_INDEX = {entry.name: k for k, entry in enumerate(StackTask.observations)}

# The builder's habits.
_CARRY_GAP = 0.10  # m, above the support until the block is centred and level
_GAIN = 4.0  # 1/s: speed asked for, per m or rad of error
_LANDING_SPEED = 0.10  # m/s, of the last centimetres
_CENTRED = 0.012  # m
_LEVEL = 0.02  # rad
_CALM = 0.06  # m/s, for letting go
_PARTING = 0.4  # m, above the finished tower
_LEAN_SHARE = 0.5  # how much of the tower's lean the next block takes back


def scripted_policy(env_id: str) -> Policy:
    """The scripted policy of an environment.

    Raises:
        LookupError: there is none.
    """
    return _on_env(scripted_actions(env_id))


def trained_policy(env_id: str) -> Policy:
    """The trained policy of an environment, which needs numpy alone.

    Raises:
        LookupError: there is none.
    """
    return _on_env(trained_actions(env_id))


def scripted_actions(env_id: str) -> BatchPolicy:
    """The scripted policy of an environment, of (..., entry) observations.

    Raises:
        LookupError: there is none.
    """
    name = env_id.rpartition(":")[2]
    if name not in _SCRIPTED:
        raise LookupError(f"{name} has no scripted policy.")
    return _SCRIPTED[name]


def trained_actions(env_id: str) -> MlpPolicy:
    """The trained policy of an environment, of (..., entry) observations.

    Raises:
        LookupError: there is none.
    """
    name = env_id.rpartition(":")[2]
    asset = files("gsenv.assets") / f"{name}.npz"
    if not asset.is_file():
        raise LookupError(f"{name} has no trained policy; `gsenv train {name}` makes one.")
    with asset.open("rb") as file:
        return MlpPolicy.load(io.BytesIO(file.read()))


def _on_env(policy: BatchPolicy) -> Policy:
    return lambda env: policy(env.unwrapped.observation)


def build_tower(observations: Observations) -> Actions:
    """GStack's builder: (..., entry) observations to (..., 4) actions.

    With a block: level it and centre it over its support, come down, let go once it has landed.
    Without: go straight up until the next block arrives.
    """
    seen = {name: np.asarray(observations)[..., k] for name, k in _INDEX.items()}
    holding = seen["holding"] > 0.5
    error_x = _target_x(seen) - seen["block_dx"]
    error_angle = seen["support_angle"] - seen["block_angle"]
    ready = (np.abs(error_x) < 2.0 * _CENTRED) & (np.abs(error_angle) < 2.0 * _LEVEL)
    speed_x = np.where(holding, _GAIN * error_x, 0.0)
    speed_y = np.where(holding, _descent(seen, error_x, ready), _ascent(seen))
    # The block turns about the magnet: what it swings to the side is taken back at once.
    turn = np.where(holding, _GAIN * error_angle, -2.0 * seen["gripper_angle"])
    landed = holding & (seen["block_gap"] < 0.004) & ready & _slow(seen)
    actions = np.stack(
        [
            speed_x / stack_scene.SPEED,
            speed_y / stack_scene.SPEED,
            turn / stack_scene.TURN_SPEED,
            np.where(landed, 1.0, -1.0),
        ],
        axis=-1,
    )
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def _target_x(seen: dict[str, NDArray[np.float32]]) -> NDArray[Any]:
    """Where on its support the block belongs: a little back towards the first block."""
    support_lean = seen["lean"] - seen["block_dx"]
    return -_LEAN_SHARE * support_lean


def _descent(
    seen: dict[str, NDArray[np.float32]], error_x: NDArray[Any], ready: NDArray[np.bool_]
) -> NDArray[Any]:
    """Vertical speed with a block: wait above the support until ready, then land softly."""
    gap = seen["block_gap"]
    high = _GAIN * (_CARRY_GAP - gap)
    low = np.minimum(-_GAIN * gap, -_LANDING_SPEED)
    return np.where(ready, low, high)


def _ascent(seen: dict[str, NDArray[np.float32]]) -> NDArray[Any]:
    """Vertical speed without a block: up, gently at first, to where the next one comes."""
    clearance = np.maximum(seen["clearance"], 0.0)
    finished = (seen["rise"] == 0.0) & (clearance > _PARTING)
    return np.where(finished, 0.0, np.minimum(0.3 + 8.0 * clearance, 1.5))


def _slow(seen: dict[str, NDArray[np.float32]]) -> NDArray[np.bool_]:
    return np.hypot(seen["block_vx"], seen["block_vy"]) < _CALM


_SCRIPTED: dict[str, BatchPolicy] = {
    "GStack-v0": build_tower,
    "GStack3D-v0": build_tower_in_space,
    "GCar-v0": drive,
}
