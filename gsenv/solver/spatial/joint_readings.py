"""Readings of 3D joints: coordinates, rates, errors and spring energies, as arrays over the worlds."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.springs import distance_reading, stored_energy
from ..jit import njit
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.state import State
from .initial_state import turned_by
from .joints.point import arm, unit_axis
from .math import Vec, add, conjugate, cross, dot, multiply, norm, quaternion, scaled, sub, turn_between, turned, vec

_DISTANCE = int(JointKind.DISTANCE)


def rotated(rotation: Array, vector: Array) -> Array:
    """Rotate vectors (..., 3) by quaternions (..., 4)."""
    return turned_by(rotation, vector)


def coordinate(model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return the distance in m between the anchors of a distance joint, (world,).

    Raises:
        ValueError: the joint is of another kind, which has no coordinate.
    """
    apart, _ = _anchors(model, parameters, state, j)
    return np.sqrt((apart**2).sum(-1))


def rate(model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return the rate of change of the coordinate (world,), m/s."""
    apart, speed = _anchors(model, parameters, state, j)
    length = np.sqrt((apart**2).sum(-1))
    return np.asarray((apart * speed).sum(-1) / np.maximum(length, 1e-300))


def _anchors(model: Model, parameters: ParameterArrays, state: State, j: int) -> tuple[Array, Array]:
    """Return anchor_b - anchor_a, (world, 3) m, and its rate, m/s."""
    kind = JointKind(int(model.joints["kind"][j]))
    if kind != JointKind.DISTANCE:
        raise ValueError(f"joint {model.joint_names[j]!r} is a {kind.name.lower()} and has no coordinate.")
    points, speeds = [], []
    for side in ("a", "b"):
        i = model.joints[f"body_{side}"][j]
        body = state.bodies[:, i]
        local = parameters.joints[f"anchor_{side}"][:, j] - parameters.bodies["center"][:, i]
        to_anchor = turned_by(body["rotation"], local)
        points.append(body["position"] + to_anchor)
        speeds.append(body["velocity"][:, :3] + np.cross(body["velocity"][:, 3:], to_anchor))
    return points[1] - points[0], speeds[1] - speeds[0]


@njit
def read_joint(body_a: Any, body_b: Any, a: Any, b: Any, joint: Any) -> Any:
    """Return (error in m, energy of the spring in J) of one joint; a, b: parameters of the bodies."""
    p = joint.parameters
    model = joint.model
    arm_a = arm(body_a, a, p.anchor_a)
    arm_b = arm(body_b, b, p.anchor_b)
    d = sub(add(vec(body_b.position), arm_b), add(vec(body_a.position), arm_a))
    arm_a = add(arm_a, d)  # a spring acts on both bodies at b's anchor
    apart = norm(d)
    sprung = p.frequency > 0.0 or p.stiffness > 0.0
    if model.kind == _DISTANCE:
        u = scaled(d, 1.0 / max(apart, 1e-300))
        return distance_reading(p, apart, _give(body_a, body_b, a, b, arm_a, arm_b, u))
    if not sprung:
        return (0.0 if p.damping > 0.0 else apart), 0.0
    wanted = multiply(quaternion(body_a.rotation), quaternion(p.reference))
    turn = turn_between(wanted, quaternion(body_b.rotation))
    energy = 0.0
    for k in range(3):
        u = unit_axis(k)
        energy += stored_energy(p, d[k], _give(body_a, body_b, a, b, arm_a, arm_b, u))
        energy += stored_energy(p, turn[k], _turning(body_a, a, u) + _turning(body_b, b, u))
    return 0.0, energy


@njit
def _turning(body: Any, parameters: Any, u: Vec) -> float:
    """u I^-1 u, 1/(kg m^2)."""
    q = multiply(quaternion(body.rotation), quaternion(parameters.axes))
    own = turned(conjugate(q), u)
    return dot(vec(parameters.inv_inertia), (own[0] * own[0], own[1] * own[1], own[2] * own[2]))


@njit
def _give(body_a: Any, body_b: Any, a: Any, b: Any, arm_a: Vec, arm_b: Vec, u: Vec) -> float:
    """J M^-1 J^T of a row along a direction, 1/kg."""
    turning = _turning(body_a, a, cross(arm_a, u)) + _turning(body_b, b, cross(arm_b, u))
    return a.inv_mass + b.inv_mass + turning
