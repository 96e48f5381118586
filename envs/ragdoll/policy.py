"""Scripted policies for GRagdoll: one that balances on its ankles, and one that also steps to the capture point.

They are functions of the observation alone and have no memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.ragdoll import figure
from gsenv.envs.ragdoll.env import RagdollTask

_INDEX = {entry.name: k for k, entry in enumerate(RagdollTask.observations)}
_AXES = {entry.name: k for k, entry in enumerate(RagdollTask.actions)}
_SPAN = {axis.name: axis.span for axis in figure.AXES}  # rad
_HIP = 0.09  # m, of a hip from the middle
_LEG = 0.83  # m, from hip to ankle in the stand


class Habits(NamedTuple):
    """Numbers of `balance`, by hand; most are those of the 2D figure."""

    ankle: float = 5.4  # action for each m of the capture point, forwards
    side: float = 4.0  # the same to the side
    pelvis: float = 2.1  # of the stance hips, for the sine of the pelvis' tilt
    rate: float = 0.14  # s/rad, for its rate
    roll: float = 1.5  # of the stance hips to the side
    roll_rate: float = 0.1  # s/rad
    waist: float = 0.8  # for the sine of the pelvis' tilt
    step: float = 0.142  # m, of the capture point forwards, beyond which it steps
    side_step: float = 0.11  # m, to the side
    reach: float = 0.94  # of the step, over the way to the capture point
    wide: float = 1.2  # the same to the side
    lift: float = 1.0  # of the swinging knee
    near: float = 0.1  # m from its place, at which the swinging foot comes down
    gather: float = 0.12  # m, of a foot from its place under the hip, beyond which it is brought back
    calm: float = 0.2  # m/s, below which it is
    bias: float = -0.007  # m, of the capture point


HABITS = Habits()


def lean(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 21) that press the edges of the soles against a fall, and nothing else."""
    seen = _named(observations)
    return _actions(seen, _press(seen, 4.0, 4.0))


def balance(observations: NDArray[np.float32], habits: Habits = HABITS) -> NDArray[np.float32]:
    """Return actions (..., 21) for observations (..., entry): ankles and hips, then steps to the capture point."""
    seen, h = _named(observations), habits
    x, y = 0.2 * seen["capture_x"] + h.bias, 0.2 * seen["capture_y"]  # m, from the middle of the support
    way_x, way_y = (0.2 * (seen[f"capture_{d}"] - seen[f"mass_{d}"]) for d in "xy")
    chosen = _press(seen, h.ankle, h.side, h.bias)
    chosen["waist"] = h.waist * seen["down_x"]
    falling = (np.abs(x) > h.step) | (np.abs(y) > h.side_step)
    calm = (np.hypot(seen["vx"], seen["vy"]) < h.calm) & ~falling
    for side, other, sign in (("left", "right", 1.0), ("right", "left", -1.0)):
        at_x, at_y = 0.5 * seen[f"{side}_foot_x"], 0.5 * seen[f"{side}_foot_y"]
        other_x, other_y = 0.5 * seen[f"{other}_foot_x"], 0.5 * seen[f"{other}_foot_y"]
        flies = (seen[f"{side}_load"] <= 0.0) & (seen[f"{other}_load"] > 0.0)
        light = seen[f"{side}_load"] < seen[f"{other}_load"]
        sideways = np.abs(y) * h.step > np.abs(x) * h.side_step
        trails = np.where(sideways, y * sign > 0.0, (at_x - other_x) * np.sign(x) < 0.0)
        away = np.hypot(at_x - other_x, at_y - other_y - 2.0 * sign * _HIP) > h.gather
        swings = flies | ((seen[f"{other}_load"] > 0.05) & ((falling & trails) | (calm & away & light)))
        goal_x = np.where(falling, h.reach * way_x, other_x)
        goal_y = np.where(falling, h.wide * way_y + sign * _HIP, other_y + 2.0 * sign * _HIP)
        goal_y = sign * np.maximum(sign * goal_y, 0.5 * _HIP)  # not across the other leg
        up = np.hypot(goal_x - at_x, goal_y - at_y) > h.near
        forwards = 1.2 * goal_x + seen["down_x"]
        chosen[f"{side}_hip"] = np.where(
            swings, forwards / _SPAN["left_hip"] + np.where(up, 0.5 * h.lift, 0.0),
            -h.pelvis * seen["down_x"] - h.rate * 5.0 * seen["wy"],
        )  # fmt: skip
        spread = (sign * goal_y - _HIP) / _LEG + sign * seen["down_y"]
        chosen[f"{side}_hip_spread"] = np.where(
            swings, spread / _SPAN["left_hip_spread"],
            sign * (-h.roll * seen["down_y"] + h.roll_rate * 5.0 * seen["wx"]),
        )  # fmt: skip
        chosen[f"{side}_knee"] = np.where(swings & up, -h.lift, 0.0)
        for joint in ("ankle", "ankle_side"):
            chosen[f"{side}_{joint}"] = np.where(swings, 0.0, chosen[f"{side}_{joint}"])
        chosen[f"{side}_hip_turn"] = np.zeros_like(x)
    return _actions(seen, chosen)


def _press(seen: dict[str, Any], ankle: float, side: float, bias: float = 0.0) -> dict[str, Any]:
    """Return the actions of the ankles against a fall."""
    x, y = 0.2 * seen["capture_x"] + bias, 0.2 * seen["capture_y"]
    return {
        "left_ankle": -ankle * x, "right_ankle": -ankle * x, "left_ankle_side": -side * y, "right_ankle_side": side * y
    }  # fmt: skip


def _named(observations: NDArray[Any]) -> dict[str, Any]:
    values = np.asarray(observations, np.float64)
    return {name: values[..., k] for name, k in _INDEX.items()}


def _actions(seen: dict[str, Any], chosen: dict[str, Any]) -> NDArray[np.float32]:
    """Return the actions of the named axes, 0 for the others, within [-1, 1]."""
    actions = np.zeros((*np.shape(seen["height"]), len(_AXES)))
    for name, value in chosen.items():
        actions[..., _AXES[name]] = value
    return np.clip(actions, -1.0, 1.0).astype(np.float32)
