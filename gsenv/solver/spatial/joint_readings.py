"""Where joints of space are: coordinates, rates, errors and spring energies, as arrays over the worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..jit import njit
from ..model import Array, Model
from ..optional import as_records
from .authored import turned_by
from .joints import JointKind
from .joints.point import arm, unit_axis
from .math import (
    Vec,
    add,
    conjugate,
    cross,
    dot,
    multiply,
    norm,
    quaternion,
    scaled,
    sub,
    turn_between,
    turned,
    vec,
)

if TYPE_CHECKING:
    from ..parameters import Parameters
    from ..state import State

_UNMEASURED = (int(JointKind.ROWS), int(JointKind.TARGET))  # no error or energy of its own
_DISTANCE = int(JointKind.DISTANCE)


def rotated(rotation: Array, vector: Array) -> Array:
    """(..., 3) vectors turned by quaternions (..., 4)."""
    return turned_by(rotation, vector)


def coordinate(model: Model, parameters: Parameters, state: State, j: int) -> Array:
    """(world,) m between the anchors of a distance joint.

    Raises:
        ValueError: another joint, which has none.
    """
    apart, _ = _anchors(model, parameters, state, j)
    return np.sqrt((apart**2).sum(-1))


def rate(model: Model, parameters: Parameters, state: State, j: int) -> Array:
    """(world,) m/s: how fast the coordinate changes."""
    apart, speed = _anchors(model, parameters, state, j)
    length = np.sqrt((apart**2).sum(-1))
    return np.asarray((apart * speed).sum(-1) / np.maximum(length, 1e-300))


def _anchors(model: Model, parameters: Parameters, state: State, j: int) -> tuple[Array, Array]:
    """anchor_b - anchor_a, (world, 3) m, and its rate."""
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


def joint_errors_and_energies(model: Model, parameters: Parameters, state: State) -> tuple[Array, Array]:
    """(world,) m, largest error of position of an enabled rigid joint: anchors apart, a rod or rope too long;
    and (world,) J in the springs of enabled joints other than targets."""
    errors, energies = np.zeros(len(state.worlds)), np.zeros(len(state.worlds))
    if model.has_joints:  # or nothing is compiled
        arrays = (model.joints, parameters.joints, parameters.bodies, state.bodies)
        models, joints, masses, bodies = (as_records(array) for array in arrays)
        _read_all(models, joints, masses, bodies, errors, energies)
    return errors, energies


@njit
def _read_all(models: Any, parameters: Any, body_parameters: Any, bodies: Any, errors: Any, energies: Any) -> None:
    for w in range(len(errors)):
        for j in range(len(models)):
            model = models[j]
            if parameters[w, j].enabled == 0 or model.kind in _UNMEASURED:
                continue
            a = body_parameters[w, model.body_a]
            b = body_parameters[w, model.body_b]
            error, energy = _read_joint(
                model, parameters[w, j], bodies[w, model.body_a], bodies[w, model.body_b], a, b
            )
            errors[w] = max(errors[w], error)
            energies[w] += energy


@njit
def _read_joint(model: Any, p: Any, body_a: Any, body_b: Any, a: Any, b: Any) -> Any:
    """(m, J) of one joint."""
    arm_a = arm(body_a, a, p.anchor_a)
    arm_b = arm(body_b, b, p.anchor_b)
    d = sub(add(vec(body_b.position), arm_b), add(vec(body_a.position), arm_a))
    arm_a = add(arm_a, d)  # what pulls at b's anchor pulls at a there as well
    apart = norm(d)
    sprung = p.frequency > 0.0 or p.stiffness > 0.0
    if model.kind == _DISTANCE:
        if p.rigid != 0:
            return max(abs(apart - p.length), p.lower - apart, apart - p.upper), 0.0
        energy = 0.0
        if sprung:
            u = scaled(d, 1.0 / max(apart, 1e-300))
            energy = _stored(p, apart - p.length, _give(body_a, body_b, a, b, arm_a, arm_b, u))
        return max(p.lower - apart, apart - p.upper), energy
    if not sprung:
        return (0.0 if p.damping > 0.0 else apart), 0.0
    wanted = multiply(quaternion(body_a.rotation), quaternion(p.reference))
    turn = turn_between(wanted, quaternion(body_b.rotation))
    energy = 0.0
    for k in range(3):
        u = unit_axis(k)
        energy += _stored(p, d[k], _give(body_a, body_b, a, b, arm_a, arm_b, u))
        energy += _stored(p, turn[k], _turning(body_a, a, u) + _turning(body_b, b, u))
    return 0.0, energy


@njit
def _stored(p: Any, stretch: Any, give: Any) -> Any:
    """J in a spring; one of given frequency is as stiff as the mass that its row sees asks for."""
    if give <= 0.0:
        return 0.0
    stiffness = p.stiffness if p.stiffness > 0.0 else (2.0 * np.pi * p.frequency) ** 2 / give
    return 0.5 * stiffness * stretch * stretch


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
