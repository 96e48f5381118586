"""Scripted policies for GRagdoll: one that balances on its ankles, and one that stands wide and steps where it falls.

They are functions of the observation alone and have no memory. Points are in m, in the heading frame (x forwards, y to
the left, z up) or in the frame of the pelvis; angles are in rad.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.ragdoll import figure, scene
from gsenv.envs.ragdoll.env import RagdollTask
from gsenv.envs.ragdoll2d import scene as lengths
from gsenv.envs.ragdoll2d.motion import Motion, follow, over_limits, reference_motion, select
from gsenv.envs.ragdoll2d.policy import FOLDED, LOW, UP, UPRIGHT

_INDEX = {entry.name: k for k, entry in enumerate(RagdollTask.observations)}
_AXES = {entry.name: k for k, entry in enumerate(RagdollTask.actions)}
_MOVERS = ("waist", "hip", "knee", "ankle")
_SPAN = {axis.name: axis.span for axis in figure.AXES}
_STAND = {axis.name: axis.stand for axis in figure.AXES}
FEATURES = {  # weights of what makes two moments of getting up alike
    "height": 0.6,
    **{f"down_{axis}": 1.2 for axis in "xyz"},
    **{f"v{axis}": 0.3 for axis in "xyz"},
    **{f"w{axis}": 0.5 for axis in "xyz"},
    **{f"{side}_foot_{axis}": 0.4 for side in ("left", "right") for axis in "xy"},
    "left_foot_z": 0.2, "right_foot_z": 0.2,
    **{f"{axis.name}_angle": 0.5 if any(part in axis.name for part in _MOVERS) else 0.15 for axis in figure.AXES},
}  # fmt: skip
_SIGN = {"left": 1.0, "right": -1.0}
_OTHER = {"left": "right", "right": "left"}
_HIP = 0.09  # m, of a hip from the middle
_THIGH, _SHIN, _ANKLE = lengths.THIGH, lengths.SHIN, scene.ANKLE
_SHORTEST, _LONGEST = 0.45, _THIGH + _SHIN - 0.004  # m, from hip to ankle

Array = NDArray[np.float64]
Point = tuple[Array, Array, Array]


class Habits(NamedTuple):
    """Numbers of `balance`, found by an evolution strategy with pushes of up to 0.9 m/s."""

    width: float = 0.207  # m, from the middle to a foot
    height: float = 0.871  # m, of the hips
    ankle: float = 2.7  # rad for each m of the capture point, forwards
    ankle_side: float = 1.5  # the same to the side
    spread: float = 0.946  # of the hips, for each m of the capture point to the side
    pelvis: float = 1.46  # of the hips, for the sine of the pelvis' tilt forwards
    pelvis_rate: float = 0.0245  # s, for its rate
    roll: float = 0.69  # of the hips' spread, for the sine of its tilt to the side
    roll_rate: float = 0.0348  # s
    waist: float = 0.6  # for the sine of the pelvis' tilt forwards
    step: float = 0.152  # m, of the capture point forwards, beyond which it steps
    side_step: float = 0.195  # m, to the side
    sideways: float = 1.03  # how much further to the side than forwards a step to the side is
    reach: float = 0.884  # of a step, over the way from the centre of mass to the capture point
    side_reach: float = 1.09  # the same to the side
    beyond: float = 0.0369  # m, added to the step forwards
    out: float = 0.0728  # m, of the foot from the middle, added to the step to the side
    lift: float = 0.0787  # m, of the swinging sole
    near: float = 0.138  # m from its goal, at which it comes down
    press: float = 0.0324  # m below the ground, where it then aims
    gather: float = 0.129  # m, of a foot from its place, beyond which it is brought back
    calm: float = 0.0426  # m/s, below which it is
    narrow: float = 0.141  # m, between the feet of a step, at least
    bias: float = 0.0164  # m, of the capture point


HABITS = Habits()


def squat_and_stand(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 21) that pull the legs in while the figure is low, and ask for the stand above that."""
    low = np.where(np.asarray(observations)[..., _INDEX["height"]] < LOW, 1.0, 0.0)
    actions = np.zeros((*low.shape, len(_AXES)), np.float32)
    for name, place in _AXES.items():
        actions[..., place] = FOLDED.get(name.removeprefix("left_").removeprefix("right_"), 0.0) * low
    return actions


def features(observations: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return what `get_up` compares of observations (..., entry)."""
    return select(observations, _INDEX, FEATURES)


def get_up(observations: NDArray[np.float32], motion: Motion | None = None) -> NDArray[np.float32]:
    """Return actions (..., 21) that follow a reference motion, or its mirror image, to the stand, and balance there.

    motion: another one than that of the package, which begins on the back or on the front.
    """
    seen = np.asarray(observations)
    stands = (seen[..., _INDEX["height"]] > UP) & (seen[..., _INDEX["down_z"]] < -UPRIGHT)
    rising = follow(motion or reference_motion("GRagdoll-get-up-v0"), features(seen))
    standing = over_limits(balance(seen), figure.AXES)
    return np.where(stands[..., None], standing, rising).clip(-1.0, 1.0).astype(np.float32)


def lean(observations: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return actions (..., 21) that press the edges of the soles against a fall, and nothing else."""
    seen = _named(observations)
    x, y = -0.8 * seen["capture_x"], 0.8 * seen["capture_y"]
    return _actions(seen, {"left_ankle": x, "right_ankle": x, "left_ankle_side": -y, "right_ankle_side": y})


def balance(observations: NDArray[np.float32], habits: Habits = HABITS) -> NDArray[np.float32]:
    """Return actions (..., 21) for observations (..., entry): ankles, hips, then a step to the capture point."""
    seen, h = _named(observations), habits
    capture = 0.2 * seen["capture_x"] + h.bias, 0.2 * seen["capture_y"]  # from the middle of the support
    chosen = {"waist": h.waist * seen["down_x"] / _SPAN["waist"]}
    for side in _SIGN:
        swings, goal = _step(seen, side, capture, h)
        swing = _swing(seen, side, goal, h)
        stance = _stance(seen, side, capture, h)
        for joint, angle in stance.items():
            name = f"{side}_{joint}"
            chosen[name] = (np.where(swings, swing[joint], angle) - _STAND[name]) / _SPAN[name]
    return _actions(seen, chosen)


def _step(seen: dict[str, Any], side: str, capture: tuple[Array, Array], h: Habits) -> tuple[Any, tuple[Array, Array]]:
    """Return whether a foot swings, and where to: (x, y) from the centre of mass."""
    sign, other = _SIGN[side], _OTHER[side]
    x, y = capture
    foot_x, foot_y, _ = _foot(seen, side)
    other_x, other_y, _ = _foot(seen, other)
    load, support = seen[f"{side}_load"], seen[f"{other}_load"]
    falling = (x / h.step) ** 2 + (y / h.side_step) ** 2 > 1.0
    sideways = np.abs(y) / h.side_step > h.sideways * np.abs(x) / h.step
    fitting = np.where(sideways, y * sign > 0.0, (foot_x - other_x) * np.sign(x) < 0.0)  # leads, or trails forwards
    home_x, home_y = other_x, other_y + 2.0 * sign * h.width
    away = np.hypot(foot_x - home_x, foot_y - home_y) > h.gather
    calm = np.hypot(seen["vx"], seen["vy"]) < h.calm
    flies = (load <= 0.0) & (support > 0.0)
    swings = flies | ((support > 0.05) & np.where(falling, fitting, calm & away & (load < support)))
    way_x, way_y = x - h.bias - 0.2 * seen["mass_x"], y - 0.2 * seen["mass_y"]  # from the centre of mass
    ahead = h.beyond * np.sign(x) * np.minimum(np.abs(x) / h.step, 1.0)
    goal_x = np.where(falling, h.reach * way_x + ahead, home_x)
    goal_y = np.where(falling, h.side_reach * way_y + sign * h.out, home_y)
    return swings, (goal_x, other_y + sign * np.maximum(sign * (goal_y - other_y), h.narrow))


def _swing(seen: dict[str, Any], side: str, goal: tuple[Array, Array], h: Habits) -> dict[str, Array]:
    """Return the angles of a leg whose sole is level and on its way to a goal (x, y) from the centre of mass."""
    sign = _SIGN[side]
    foot = _foot(seen, side)
    spread, hip, knee = (seen[f"{side}_{joint}_angle"] + _STAND[f"{side}_{joint}"] for joint in _LEG)
    forwards, outwards, up = leg_point(spread, hip, knee)
    below = _level(seen, (forwards, sign * outwards, up))  # the ankle, from the hip
    far = np.hypot(goal[0] - foot[0], goal[1] - foot[1]) > h.near
    lift = np.where(far, h.lift, -h.press)
    wanted = goal[0] - foot[0] + below[0], goal[1] - foot[1] + below[1], lift - foot[2] + below[2]
    x, y, z = _in_pelvis(seen, wanted)
    spread, hip, knee = leg_angles((x, sign * y, z))
    pitch, roll = _tilt(seen)
    return {
        "hip_spread": spread, "hip": hip, "knee": knee, "ankle": pitch - hip - knee, "ankle_side": sign * roll - spread
    }  # fmt: skip


def _stance(seen: dict[str, Any], side: str, capture: tuple[Array, Array], h: Habits) -> dict[str, Array]:
    """Return the angles of a standing leg, which presses the edge of its sole against a fall and levels the pelvis."""
    sign = _SIGN[side]
    x, y = capture
    spread, hip, knee = leg_angles((0.0 * x, 0.0 * x + h.width - _HIP, 0.0 * x + _ANKLE - h.height))
    level = -scene.STAND_TILT - hip - knee
    rolling = -h.roll * seen["down_y"] + h.roll_rate * 5.0 * seen["wx"] + h.spread * y
    return {
        "hip_spread": spread + sign * rolling,
        "hip": hip - h.pelvis * seen["down_x"] - h.pelvis_rate * 5.0 * seen["wy"],
        "knee": knee,
        "ankle": level - h.ankle * x,
        "ankle_side": -spread - sign * h.ankle_side * y,
    }


# ---------------------------------------------------------------- the leg


_LEG = ("hip_spread", "hip", "knee")


def leg_point(spread: Any, hip: Any, knee: Any) -> Point:
    """Return where the ankle is from the hip in the pelvis' frame: forwards, outwards, up; feet point forwards."""
    along = _THIGH * np.cos(hip) + _SHIN * np.cos(hip + knee)
    return _THIGH * np.sin(hip) + _SHIN * np.sin(hip + knee), along * np.sin(spread), -along * np.cos(spread)


def leg_angles(point: Point) -> Point:
    """Return spread, hip and knee that bring the ankle to a point from the hip, or as near as the leg reaches."""
    forwards, outwards, up = point
    along = np.hypot(outwards, up)
    length = np.clip(np.hypot(forwards, along), _SHORTEST, _LONGEST)
    bend = np.arccos(np.clip((length**2 - _THIGH**2 - _SHIN**2) / (2.0 * _THIGH * _SHIN), -1.0, 1.0))
    hip = np.arctan2(forwards, along) + np.arctan2(_SHIN * np.sin(bend), _THIGH + _SHIN * np.cos(bend))
    return np.arctan2(outwards, -up), hip, -bend


def _foot(seen: dict[str, Any], side: str) -> Point:
    """Return the sole below the ankle: x and y from the centre of mass, z from the ground."""
    return 0.5 * seen[f"{side}_foot_x"], 0.5 * seen[f"{side}_foot_y"], 0.2 * seen[f"{side}_foot_z"]


# ---------------------------------------------------------------- the pelvis


def _tilt(seen: dict[str, Any]) -> tuple[Array, Array]:
    """Return the angles by which the pelvis leans forwards, and then to the left."""
    pitch = np.arcsin(np.clip(seen["down_x"], -1.0, 1.0))
    return pitch, np.arcsin(np.clip(seen["down_y"] / np.maximum(np.cos(pitch), 0.3), -1.0, 1.0))


def _level(seen: dict[str, Any], vector: Point) -> Point:
    """Rotate a vector from the frame of the pelvis to the heading frame."""
    pitch, roll = _tilt(seen)
    x, y, z = vector
    y, z = y * np.cos(roll) + z * np.sin(roll), z * np.cos(roll) - y * np.sin(roll)
    return x * np.cos(pitch) + z * np.sin(pitch), y, z * np.cos(pitch) - x * np.sin(pitch)


def _in_pelvis(seen: dict[str, Any], vector: Point) -> Point:
    """Rotate a vector from the heading frame to that of the pelvis."""
    pitch, roll = _tilt(seen)
    x, y, z = vector
    x, z = x * np.cos(pitch) - z * np.sin(pitch), z * np.cos(pitch) + x * np.sin(pitch)
    return x, y * np.cos(roll) - z * np.sin(roll), z * np.cos(roll) + y * np.sin(roll)


# ---------------------------------------------------------------- observations and actions


def _named(observations: NDArray[Any]) -> dict[str, Any]:
    values = np.asarray(observations, np.float64)
    return {name: values[..., k] for name, k in _INDEX.items()}


def _actions(seen: dict[str, Any], chosen: dict[str, Any]) -> NDArray[np.float32]:
    """Return the actions of the named axes, 0 for the others, within [-1, 1]."""
    actions = np.zeros((*np.shape(seen["height"]), len(_AXES)))
    for name, value in chosen.items():
        actions[..., _AXES[name]] = value
    return np.clip(actions, -1.0, 1.0).astype(np.float32)
