"""Readings of 2D joints: coordinates, rates, errors and spring energies, as arrays over the worlds."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.springs import beyond_limit, distance_reading, limit_energy, stored_energy
from ..core.trig import atan2, sin_cos
from ..jit import njit
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.state import State
from .initial_state import turn_about
from .joints.point import arm
from .joints.reference import anchor_give, turn_give
from .math import cross, rotate

SLIDING = (JointKind.PRISMATIC, JointKind.WHEEL)
WITHOUT_COORDINATE = (JointKind.WELD, JointKind.ROWS, JointKind.TARGET)
_WELD = int(JointKind.WELD)
_REVOLUTE = int(JointKind.REVOLUTE)
_PRISMATIC = int(JointKind.PRISMATIC)
_DISTANCE = int(JointKind.DISTANCE)
_WHEEL = int(JointKind.WHEEL)


class _Ends(NamedTuple):
    """The ends of one joint in all worlds: arms from the centres of mass, difference of the anchors, axis."""

    arm_a: Array  # m (world, 2)
    arm_b: Array
    apart: Array  # m (world, 2), anchor_b - anchor_a
    rate: Array  # m/s (world, 2)
    axis: Array  # (world, 2), unit, of sliding joints


def rotated(rotation: Array, vector: Array) -> Array:
    c, s = rotation[..., 0], rotation[..., 1]
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], -1)


def _left(vector: Array) -> Array:
    return np.stack([-vector[..., 1], vector[..., 0]], -1)


def _ends(model: Model, parameters: ParameterArrays, state: State, j: int) -> _Ends:
    arms, points, speeds = [], [], []
    for side in ("a", "b"):
        i = model.joints[f"body_{side}"][j]
        body = state.bodies[:, i]
        arm = rotated(body["rotation"], parameters.joints[f"anchor_{side}"][:, j] - parameters.bodies["center"][:, i])
        arms.append(arm)
        points.append(body["position"] + arm)
        speeds.append(body["velocity"][:, :2] + body["velocity"][:, 2:] * _left(arm))
    axis = rotated(state.bodies["rotation"][:, model.joints["body_a"][j]], parameters.joints["axis"][:, j])
    return _Ends(arms[0], arms[1], points[1] - points[0], speeds[1] - speeds[0], axis)


def beside(model: Model, j: int) -> list[int]:
    """Return the coordinates of a joint whose rates stay where one of them, j, is set; with j."""
    return [j]


def unit_motion(model: Model, parameters: ParameterArrays, state: State, j: int) -> tuple[Array, Array]:
    """Return the angular (world, 1) and linear (world, 2) velocity of body b at its anchor for a rate of 1."""
    if _with_coordinate(model, j) in SLIDING:
        return np.zeros((len(state.worlds), 1)), _ends(model, parameters, state, j).axis
    return np.ones((len(state.worlds), 1)), np.zeros((len(state.worlds), 2))


def displacement(
    model: Model, parameters: ParameterArrays, state: State, j: int, shift: Array, sign: float
) -> tuple[Array, Array, Array]:
    """Return how one body moves for a change of the coordinate: (pivot, turn, translation), each for all worlds.

    ``sign``: 1 moves body b, -1 body a.
    """
    spin, slide = unit_motion(model, parameters, state, j)
    ends = _ends(model, parameters, state, j)
    pivot = state.bodies["position"][:, model.joints["body_b"][j]] + ends.arm_b
    return pivot, turn_about(slide, sign * shift * spin[:, 0]), sign * shift[:, None] * slide


def _spin(model: Model, state: State, j: int, field: str) -> Array:
    """Return the angle or angular velocity of body b minus that of body a, (world,)."""
    a, b = model.joints["body_a"][j], model.joints["body_b"][j]
    if field == "angle":
        return np.asarray(state.bodies["angle"][:, b] - state.bodies["angle"][:, a])
    return np.asarray(state.bodies["velocity"][:, b, 2] - state.bodies["velocity"][:, a, 2])


def coordinate(model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return the coordinate (world,): rad since the initial pose, m along the axis, or m between the anchors.

    Raises:
        ValueError: the joint is a weld, target or user constraint, which has no coordinate.
    """
    kind = _with_coordinate(model, j)
    if kind == JointKind.REVOLUTE:
        return _spin(model, state, j, "angle") - parameters.joints["reference_angle"][:, j]
    if kind == JointKind.GEAR:
        a, b = model.joints["joint_a"][j], model.joints["joint_b"][j]
        ratio = parameters.joints["ratio"][:, j]
        whole = coordinate(model, parameters, state, a) + ratio * coordinate(model, parameters, state, b)
        return whole - parameters.joints["reference_angle"][:, j]
    ends = _ends(model, parameters, state, j)
    if kind in SLIDING:
        return np.asarray((ends.axis * ends.apart).sum(-1))
    return np.hypot(*ends.apart.T)


def rate(model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return the rate of change of the coordinate (world,), rad/s or m/s."""
    kind = _with_coordinate(model, j)
    if kind == JointKind.REVOLUTE:
        return _spin(model, state, j, "velocity")
    if kind == JointKind.GEAR:
        a, b = model.joints["joint_a"][j], model.joints["joint_b"][j]
        ratio = parameters.joints["ratio"][:, j]
        return rate(model, parameters, state, a) + ratio * rate(model, parameters, state, b)
    ends = _ends(model, parameters, state, j)
    if kind in SLIDING:
        turning = state.bodies["velocity"][:, model.joints["body_a"][j], 2]
        return np.asarray((ends.axis * ends.rate).sum(-1) + turning * (_left(ends.axis) * ends.apart).sum(-1))
    length = np.hypot(*ends.apart.T)
    return np.asarray((ends.apart * ends.rate).sum(-1) / np.maximum(length, 1e-300))


def slides(model: Model, j: int) -> bool:
    """Return whether the coordinate of a joint is a length."""
    return JointKind(int(model.joints["kind"][j])) in (*SLIDING, JointKind.DISTANCE)


def _with_coordinate(model: Model, j: int) -> JointKind:
    kind = JointKind(int(model.joints["kind"][j]))
    if kind in WITHOUT_COORDINATE:
        raise ValueError(f"joint {model.joint_names[j]!r} is a {kind.name.lower()} and has no coordinate.")
    return kind


@njit
def read_joint(body_a: Any, body_b: Any, a: Any, b: Any, joint: Any) -> Any:
    """Return (error in m, energy of the spring in J) of one joint; a, b: parameters of the bodies."""
    p = joint.parameters
    model = joint.model
    ax, ay = arm(body_a, a, p.anchor_a)
    bx, by = arm(body_b, b, p.anchor_b)
    x = body_b.position[0] + bx - body_a.position[0] - ax
    y = body_b.position[1] + by - body_a.position[1] - ay
    ax += x  # a spring acts on both bodies at b's anchor
    ay += y
    turn = body_b.angle - body_a.angle - p.reference_angle
    apart = (x * x + y * y) ** 0.5
    sprung = p.frequency > 0.0 or p.stiffness > 0.0
    if model.kind == _PRISMATIC or model.kind == _WHEEL:
        ux, uy = rotate(body_a.rotation[0], body_a.rotation[1], p.axis[0], p.axis[1])
        slid = ux * x + uy * y
        energy = limit_energy(p, slid, _along(a, b, ax, ay, bx, by, ux, uy))
        if sprung:
            energy += stored_energy(p, slid - joint.state.rest, _along(a, b, ax, ay, bx, by, ux, uy))
        return max(abs(cross(ux, uy, x, y)), beyond_limit(p, slid)), energy
    if model.kind == _DISTANCE:
        return distance_reading(p, apart, anchor_give(p, a, b))
    about = turn_give(a, b)
    if model.kind == _REVOLUTE:
        return apart, limit_energy(p, turn, about) + (
            stored_energy(p, turn - joint.state.rest, about) if sprung else 0.0
        )
    if not sprung:
        return (0.0 if p.damping > 0.0 else apart), 0.0
    c, s = sin_cos(turn)
    return 0.0, stored_energy(p, atan2(s, c), about) + stored_energy(p, apart, anchor_give(p, a, b))


@njit
def turned_off(body_a: Any, body_b: Any, joint: Any) -> Any:
    """Return the angle in rad by which a rotation that the joint locks or limits is off; 0 where it does neither."""
    p = joint.parameters
    if joint.model.kind == _REVOLUTE:
        return beyond_limit(p, body_b.angle - body_a.angle - p.reference_angle)
    soft = p.frequency > 0.0 or p.stiffness > 0.0 or p.damping > 0.0
    if joint.model.kind != _PRISMATIC and (joint.model.kind != _WELD or soft):
        return 0.0
    c, s = sin_cos(body_b.angle - body_a.angle - p.reference_angle)
    return abs(atan2(s, c))


@njit
def _along(a: Any, b: Any, ax: Any, ay: Any, bx: Any, by: Any, ux: Any, uy: Any) -> Any:
    """Return J M^-1 J^T of a row along a direction, 1/kg."""
    reach_a = cross(ax, ay, ux, uy)
    reach_b = cross(bx, by, ux, uy)
    return a.inv_mass + b.inv_mass + a.inv_inertia * reach_a**2 + b.inv_inertia * reach_b**2
