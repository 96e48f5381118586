"""How wrong a trajectory is. Each function sees a Trajectory only, so all engines are judged alike.

Relative errors are over the closed form's value, others say their unit. Where the measured thing never
happens the error is infinite.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.records.model import JointKind

from .geometry import deepest_overlap
from .geometry3d import conjugate, deepest_box_overlap, rotated
from .trajectory import Trajectory, ball_joints

Array = NDArray[np.float64]

G = 9.81
BALL_RADIUS, ARM = 0.1, 1.0  # m, of the bouncing ball and of the cradle
STILL = 1e-2  # m and m/s: what stands may drift sideways and move at the end by less


def distance_error(trajectory: Trajectory, law: Callable[[Array], Array]) -> float:
    """How far body 1 is from where it should be, at worst, over its distance at the end; m if that is 0.

    The worst of all times and not the last alone: at one time errors may cancel by luck.

    Args:
        law: m travelled from the start by time s.
    """
    moved = np.linalg.norm(trajectory.position[:, 1] - trajectory.position[0, 1], axis=-1)
    expected = law(trajectory.times)
    return float(np.abs(moved - expected).max()) / (float(expected[-1]) or 1.0)


def slide_to_roll_error(trajectory: Trajectory, speed: float, friction: float, inertia: float = 0.5) -> float:
    """Worst of the distance's error and the final speed's relative error, of a disk that slides, then rolls.

    It slows down at mu g until it rolls at v0 / (1 + k), k the ``inertia`` over m r^2: a disk's and cylinder's at
    v0 / (3 mu g), 2/3 v0; a sphere's (k = 2/5) at 2 v0 / (7 mu g), 5/7 v0.
    """
    final = speed / (1.0 + inertia)
    grip = (speed - final) / (friction * G)

    def law(t: Array) -> Array:
        slid = np.minimum(t, grip)
        return speed * slid - 0.5 * friction * G * slid**2 + final * (t - slid)

    return max(distance_error(trajectory, law), abs(speed_at_end(trajectory) - final) / final)


def speed_at_end(trajectory: Trajectory) -> float:
    """m/s of body 1."""
    return float(np.linalg.norm(trajectory.linear_velocity[-1, 1]))


def peaks(heights: Array) -> Array:
    """Heights of the local maxima, each the top of the parabola through its three highest samples."""
    left, middle, right = heights[:-2], heights[1:-1], heights[2:]
    at = (middle > left) & (middle >= right)
    a, b, c = left[at], middle[at], right[at]
    return b + (c - a) ** 2 / (8.0 * (2.0 * b - a - c))


def apex_error(trajectory: Trajectory, restitution: float, count: int = 3) -> float:
    """Largest relative error of the first apexes after a drop from 1 m: e^2k m, by samples of positions.

    All of them and not the last alone: at some timesteps one is met by luck.
    """
    tops = peaks(trajectory.height[:, 1] - BALL_RADIUS)[:count]
    expected = restitution ** (2.0 * np.arange(1, count + 1))
    return float((np.abs(tops - expected) / expected).max()) if len(tops) == count else math.inf


def layer_error(start: Array, end: Array) -> float:
    """m: largest error of a layer's mean height, per layer from the ground up to it: gaps add up."""
    levels = np.round(start, 6)
    return max(float(abs((end - start)[levels == level].mean())) / (1 + k) for k, level in enumerate(np.unique(levels)))


def lenient_standing_error(trajectory: Trajectory) -> float:
    """m: deepest overlap at any sample, or the layers' mean height error at the end, whichever is larger."""
    boxes = trajectory.dynamic
    states = trajectory.states[:, boxes]
    half = trajectory.model.nominal_shapes["size"][trajectory.model.bodies["shape_first"][boxes]]
    if trajectory.dim == 2:
        overlap = max(deepest_overlap(sample[:, 0:2], sample[:, 2], half) for sample in states)
    else:
        overlap = max(deepest_box_overlap(sample[:, 0:3], sample[:, 3:7], half) for sample in states)
    height = trajectory.height[:, boxes]
    return max(overlap, layer_error(height[0], height[-1]))


def standing_error(trajectory: Trajectory) -> float:
    """The same; infinite for what drifted sideways by 1 cm or still moves at 1 cm/s at the end."""
    boxes = trajectory.dynamic
    drift = np.abs((trajectory.position[-1, boxes] - trajectory.position[0, boxes])[:, :-1]).max()
    speed = np.linalg.norm(trajectory.linear_velocity[-1, boxes], axis=-1).max()
    return lenient_standing_error(trajectory) if drift < STILL and speed < STILL else math.inf


def crossings(times: Array, values: Array, upward_only: bool = False) -> Array:
    """s: when the values pass 0, by a cubic of time over value through four samples."""
    left, right = values[1:-2], values[2:-1]
    passed = (left < 0.0) & (right >= 0.0) if upward_only else left * right < 0.0
    at = np.flatnonzero(passed) + 1
    found = np.zeros(len(at))
    for k, i in enumerate(at):
        t, v = times[i - 1 : i + 3], values[i - 1 : i + 3]
        for j in range(4):
            others = np.delete(v, j)
            found[k] += t[j] * np.prod(others / (others - v[j]))
    return found


def hinges(trajectory: Trajectory) -> NDArray[np.intp]:
    """Indices of the joints that are hinges, or ball joints in 3D."""
    if trajectory.dim == 3:
        return ball_joints(trajectory.model)
    return np.flatnonzero(trajectory.model.joints["kind"] == JointKind.REVOLUTE)


def swings(trajectory: Trajectory) -> Array:
    """(sample, hinge) rad: angle of each hinge's second body from hanging straight below it."""
    index = hinges(trajectory)
    if trajectory.dim == 3:  # in the plane of x and z, where all scenes swing
        body = trajectory.model.joints["body_b"][index]
        arm = rotated(trajectory.rotation[:, body], -trajectory.model.nominal_joints["anchor_b"][index])
        return np.arctan2(arm[..., 0], -arm[..., 2])
    arms = -trajectory.model.nominal_joints["anchor_b"][index]  # from the hinge to the centre of mass
    angles = trajectory.angle[:, trajectory.model.joints["body_b"][index]] + np.arctan2(arms[:, 0], -arms[:, 1])
    return angles - 2.0 * np.pi * np.round(angles[0] / (2.0 * np.pi))


def period_error(trajectory: Trajectory, expected: float) -> float:
    """Relative error of the mean period (s) of the last hinge's swing."""
    starts = crossings(trajectory.times, swings(trajectory)[:, -1], upward_only=True)
    if len(starts) < 2:
        return math.inf
    return abs(float(np.diff(starts).mean()) - expected) / expected


def highest(values: Array) -> float:
    """Top of the parabola through the highest sample and its neighbours."""
    i = int(np.argmax(values))
    return float(values[i] if i in (0, len(values) - 1) else peaks(values[i - 1 : i + 2])[0])


def cradle_error(trajectory: Trajectory, raised: int, degrees: float = 30.0) -> float:
    """After the first impact the last ``raised`` balls swing to the angle the first came from.

    Returns the worst error of their highest angles, or angle of another ball, over that angle, from 0.3 to
    0.7 of the balls' period (impacts are at a quarter and three quarters of it).
    """
    start = math.radians(degrees)
    round_up = 0.5 if trajectory.dim == 2 else 0.4  # inertia of a disk or ball over m r^2
    small = 2.0 * math.pi * math.sqrt((ARM**2 + round_up * BALL_RADIUS**2) / (G * ARM))
    period = small * (1.0 + start**2 / 16.0)
    window = (trajectory.times > 0.3 * period) & (trajectory.times < 0.7 * period)
    angles = swings(trajectory)[window]
    out = [abs(highest(column) - start) for column in angles[:, -raised:].T]
    return max(*out, float(np.abs(angles[:, :-raised]).max())) / start


def energies(trajectory: Trajectory) -> Array:
    """(sample,) J: kinetic and potential energy of the bodies."""
    bodies = trajectory.dynamic
    v, w = trajectory.linear_velocity[:, bodies], trajectory.angular_velocity[:, bodies]
    if trajectory.dim == 3:
        w = rotated(conjugate(trajectory.rotation[:, bodies]), w)
        turning = (trajectory.inertia * w**2).sum(-1)
    else:
        turning = trajectory.inertia * w**2
    kinetic = 0.5 * (trajectory.mass * (v**2).sum(-1) + turning).sum(-1)
    gravity = -float(trajectory.model.nominal_world["gravity"][-1])
    return kinetic + gravity * trajectory.height[:, bodies] @ trajectory.mass


def energy_error(trajectory: Trajectory, link: float) -> float:
    """Largest change of a chain's energy at any time, over m g L: all mass, and the length of links of ``link`` m."""
    energy = energies(trajectory)
    length = link * len(trajectory.dynamic)
    return float(np.abs(energy - energy[0]).max() / (trajectory.mass.sum() * G * length))


def joint_gaps(trajectory: Trajectory) -> Array:
    """(sample, joint) m: distance of the two anchors of each hinge."""
    model = trajectory.model
    index = hinges(trajectory)
    ends = []
    for side in ("a", "b"):
        body, anchor = model.joints[f"body_{side}"][index], model.nominal_joints[f"anchor_{side}"][index]
        if trajectory.dim == 3:
            ends.append(trajectory.position[:, body] + rotated(trajectory.rotation[:, body], anchor))
            continue
        c, s = np.cos(trajectory.angle[:, body]), np.sin(trajectory.angle[:, body])
        x, y = anchor.T
        ends.append(trajectory.position[:, body] + np.stack([c * x - s * y, s * x + c * y], -1))
    return np.linalg.norm(ends[1] - ends[0], axis=-1)


def chain_error(trajectory: Trajectory, link: float) -> float:
    """Worst of hinge gap over link length and energy error, at any time."""
    return max(float(joint_gaps(trajectory).max()) / link, energy_error(trajectory, link))


def spring_error(trajectory: Trajectory, frequency: float, damping_ratio: float, length: float = 1.0) -> float:
    """Largest distance from the damped oscillator's closed form at any time, over the starting amplitude.

    The mass hangs still g / w^2 below the end of the relaxed spring.
    """
    w, z, t = 2.0 * math.pi * frequency, damping_ratio, trajectory.times
    if z < 1.0:
        d = math.sqrt(1.0 - z * z)
        left = np.exp(-z * w * t) * (np.cos(d * w * t) + z / d * np.sin(d * w * t))
    else:
        left = np.exp(-w * t) * (1.0 + w * t)
    away = trajectory.position[:, 1, 1] + length + G / w**2
    return float(np.abs(away - away[0] * left).max() / abs(away[0]))
