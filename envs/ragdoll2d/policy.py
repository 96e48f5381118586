"""Scripted policies for GRagdoll2D: balance on the ankles, steps to the capture point too, and getting up.

They are functions of the observation alone and have no memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.ragdoll2d import scene
from gsenv.envs.ragdoll2d.env import RagdollGetUpTask, RagdollTask
from gsenv.envs.ragdoll2d.motion import Motion, follow, over_limits, reference_motion, select

_INDEX = {entry.name: k for k, entry in enumerate(RagdollTask.observations)}
_GET_UP_INDEX = {entry.name: k for k, entry in enumerate(RagdollGetUpTask.observations)}
_AXES = {entry.name: k for k, entry in enumerate(RagdollTask.actions)}


UP = -0.15  # of the observation `height`: the crown 3 % below that in the stand
UPRIGHT = 0.6  # cosine of the chest's tilt
LOW = -2.5  # of the observation `height`: half the height of the stand
_JOINTS = ("waist", "near_hip", "near_knee", "near_ankle", "far_hip", "far_knee", "far_ankle")
FEATURES = {  # weights of what makes two moments of getting up alike
    "height": 0.6, "pelvis_rate": 0.7, "vx": 0.3, "vy": 0.3, "near_foot_x": 0.5, "far_foot_x": 0.5,
    **{f"{part}_{wave}": 1.0 for part in ("pelvis", "chest") for wave in ("sine", "cosine")},
    **{f"{joint}_angle": 0.6 for joint in _JOINTS},
}  # fmt: skip
FOLDED = {"hip": 1.0, "knee": -1.0, "ankle": 1.0}  # signs of the actions that fold a leg


class Habits(NamedTuple):
    """Numbers of `balance`, found by random search."""

    ankle: float = 5.4  # action for each m of the capture point
    pelvis: float = 2.1  # of the stance hip, for the sine of the pelvis' tilt
    pelvis_rate: float = 0.14  # s/rad
    waist: float = 0.83  # for the sine of the chest's tilt
    step: float = 0.142  # m, of the capture point, beyond which it steps
    reach: float = 0.94  # of the step, over the way to the capture point
    beyond: float = -0.013  # m, added to it
    lift: float = 1.04  # of the swinging knee
    near: float = 0.126  # m from its place, at which the swinging foot comes down
    gather: float = 0.14  # m between the feet, beyond which it gathers them
    calm: float = 0.23  # m/s, below which it gathers them
    bias: float = -0.007  # m, of the capture point


HABITS = Habits()


def lean(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 7) that press the toes or the heels against a fall, and nothing else."""
    observations = np.asarray(observations, np.float64)
    press = -0.8 * observations[..., _INDEX["capture_x"]]
    return _actions(observations, {"near_ankle": press, "far_ankle": press})


def squat_and_stand(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 7) that pull the legs in while the figure is low, and ask for the stand above that."""
    observations = np.asarray(observations, np.float64)
    low = np.where(observations[..., _INDEX["height"]] < LOW, 1.0, 0.0)
    legs = {f"{side}_{joint}": sign * low for side in ("near", "far") for joint, sign in FOLDED.items()}
    return _actions(observations, {"waist": -low} | legs)


def features(observations: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return what `get_up` compares of observations (..., entry) of getting up."""
    return select(observations, _GET_UP_INDEX, FEATURES)


def get_up(observations: NDArray[np.float32], motion: Motion | None = None) -> NDArray[np.float32]:
    """Return actions (..., 7) that follow a reference motion to the stand, and balance there.

    motion: another one than that of the package, which begins on the back or on the front.
    """
    seen = np.asarray(observations)
    stands = (seen[..., _INDEX["height"]] > UP) & (seen[..., _GET_UP_INDEX["chest_cosine"]] > UPRIGHT)
    rising = follow(motion or reference_motion("GRagdoll2D-get-up-v0"), features(seen))
    standing = over_limits(balance(seen), scene.AXES)
    return np.where(stands[..., None], standing, rising).clip(-1.0, 1.0).astype(np.float32)


def balance(observations: NDArray[np.float32], habits: Habits = HABITS) -> NDArray[np.float32]:
    """Return actions (..., 7) for observations (..., entry) of either task: ankles, then steps to the capture point."""
    observations = np.asarray(observations, np.float64)
    index = _GET_UP_INDEX if observations.shape[-1] == len(_GET_UP_INDEX) else _INDEX
    seen = {name: observations[..., k] for name, k in index.items()}
    h = habits
    capture = 0.2 * seen["capture_x"] + h.bias
    way = 0.2 * (seen["capture_x"] - seen["mass_x"])  # from the centre of mass to the capture point
    chosen: dict[str, Any] = {"waist": -h.waist * seen["chest_sine"]}
    feet = {side: 0.5 * seen[f"{side}_foot_x"] for side in ("near", "far")}
    falling = np.abs(capture) > h.step
    apart = np.abs(feet["near"] - feet["far"]) > h.gather
    gathers = apart & (np.abs(seen["vx"]) < h.calm) & ~falling
    for side, other in (("near", "far"), ("far", "near")):
        trails = (feet[side] - feet[other]) * np.sign(capture) < 0.0
        trails |= (feet[side] == feet[other]) & (side == "near")
        flies = (seen[f"{side}_load"] <= 0.0) & (seen[f"{other}_load"] > 0.0)
        grounded = seen[f"{other}_load"] > 0.05
        light = seen[f"{side}_load"] < seen[f"{other}_load"]
        swings = grounded & ((falling & trails & (seen[f"{other}_load"] > 0.0)) | flies | (gathers & light))
        place = np.where(falling, h.reach * way + np.sign(capture) * h.beyond, feet[other])
        off = place - feet[side]
        thigh = 1.2 * place - seen["pelvis_sine"]
        up = np.abs(off) > h.near
        chosen[f"{side}_hip"] = np.where(
            swings, thigh / 0.78 + np.where(up, 0.5 * h.lift, 0.0),
            h.pelvis * seen["pelvis_sine"] + h.pelvis_rate * 5.0 * seen["pelvis_rate"],
        )  # fmt: skip
        chosen[f"{side}_knee"] = np.where(swings & up, -h.lift, 0.0)
        level = -2.0 * seen[f"{side}_foot_sine"]
        chosen[f"{side}_ankle"] = np.where(swings, level, -h.ankle * capture)
    return _actions(observations, chosen)


def _actions(observations: NDArray[Any], chosen: dict[str, Any]) -> NDArray[np.float32]:
    """Return the actions of the named axes, 0 for the others, within [-1, 1]."""
    actions = np.zeros((*observations.shape[:-1], len(_AXES)))
    for name, value in chosen.items():
        actions[..., _AXES[name]] = value
    return np.clip(actions, -1.0, 1.0).astype(np.float32)
