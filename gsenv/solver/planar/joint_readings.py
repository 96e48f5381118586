"""Where joints are: coordinates, rates, errors and spring energies, as arrays over the worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..jit import njit
from ..model import Array, Model
from ..optional import as_records
from ..trig import atan2, sin_cos
from .joints import JointKind
from .joints.point import arm
from .math import cross, rotate

if TYPE_CHECKING:
    from ..parameters import Parameters
    from ..state import State

SLIDING = (JointKind.PRISMATIC, JointKind.WHEEL)
WITHOUT_COORDINATE = (JointKind.WELD, JointKind.ROWS, JointKind.TARGET)
_UNMEASURED = (int(JointKind.ROWS), int(JointKind.TARGET), int(JointKind.GEAR))  # no error or energy of its own
_REVOLUTE = int(JointKind.REVOLUTE)
_PRISMATIC = int(JointKind.PRISMATIC)
_DISTANCE = int(JointKind.DISTANCE)
_WHEEL = int(JointKind.WHEEL)


class _Ends(NamedTuple):
    """Of one joint in all worlds: arms from the centres of mass, anchors' difference, its rate, the axis."""

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


def _ends(model: Model, parameters: Parameters, state: State, j: int) -> _Ends:
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


def _spin(model: Model, state: State, j: int, field: str) -> Array:
    """Angle or angular velocity of body b less that of body a, (world,)."""
    a, b = model.joints["body_a"][j], model.joints["body_b"][j]
    if field == "angle":
        return np.asarray(state.bodies["angle"][:, b] - state.bodies["angle"][:, a])
    return np.asarray(state.bodies["velocity"][:, b, 2] - state.bodies["velocity"][:, a, 2])


def coordinate(model: Model, parameters: Parameters, state: State, j: int) -> Array:
    """(world,) rad since the authored pose, m along the axis, or m between the anchors.

    Raises:
        ValueError: a weld, target or constraint, which has none.
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


def rate(model: Model, parameters: Parameters, state: State, j: int) -> Array:
    """(world,) rad/s or m/s: how fast the coordinate changes."""
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


def _with_coordinate(model: Model, j: int) -> JointKind:
    kind = JointKind(int(model.joints["kind"][j]))
    if kind in WITHOUT_COORDINATE:
        raise ValueError(f"joint {model.joint_names[j]!r} is a {kind.name.lower()} and has no coordinate.")
    return kind


def joint_errors_and_energies(model: Model, parameters: Parameters, state: State) -> tuple[Array, Array]:
    """(world,) m, largest error of position of an enabled rigid joint: anchors apart, off the axis, a rod or
    rope too long; and (world,) J in the springs of enabled joints other than targets."""
    errors, energies = np.zeros(len(state.worlds)), np.zeros(len(state.worlds))
    if model.has_joints:  # or nothing is compiled
        arrays = (model.joints, parameters.joints, parameters.bodies, state.joints, state.bodies)
        models, joints, masses, states, bodies = (as_records(array) for array in arrays)
        _read_all(models, joints, masses, states, bodies, errors, energies)
    return errors, energies


@njit
def _read_all(
    models: Any, parameters: Any, body_parameters: Any, states: Any, bodies: Any, errors: Any, energies: Any
) -> None:
    for w in range(len(errors)):
        for j in range(len(models)):
            model = models[j]
            if parameters[w, j].enabled == 0 or model.kind in _UNMEASURED:
                continue
            a = body_parameters[w, model.body_a]
            b = body_parameters[w, model.body_b]
            error, energy = _read_joint(
                model, parameters[w, j], states[w, j], bodies[w, model.body_a], bodies[w, model.body_b], a, b
            )
            errors[w] = max(errors[w], error)
            energies[w] += energy


@njit
def _read_joint(model: Any, p: Any, state: Any, body_a: Any, body_b: Any, a: Any, b: Any) -> Any:
    """(m, J) of one joint."""
    ax, ay = arm(body_a, a, p.anchor_a)
    bx, by = arm(body_b, b, p.anchor_b)
    x = body_b.position[0] + bx - body_a.position[0] - ax
    y = body_b.position[1] + by - body_a.position[1] - ay
    ax += x  # what pulls at b's anchor pulls at a there as well
    ay += y
    turn = body_b.angle - body_a.angle - p.reference_angle
    apart = (x * x + y * y) ** 0.5
    sprung = p.frequency > 0.0 or p.stiffness > 0.0
    if model.kind == _PRISMATIC or model.kind == _WHEEL:
        ux, uy = rotate(body_a.rotation[0], body_a.rotation[1], p.axis[0], p.axis[1])
        energy = 0.0
        if sprung:
            energy = _stored(p, ux * x + uy * y - state.rest, _along(a, b, ax, ay, bx, by, ux, uy))
        return abs(cross(ux, uy, x, y)), energy
    if model.kind == _DISTANCE:
        if p.rigid != 0:
            return max(abs(apart - p.length), p.lower - apart, apart - p.upper), 0.0
        energy = 0.0
        if sprung:
            length = max(apart, 1e-300)
            energy = _stored(p, apart - p.length, _along(a, b, ax, ay, bx, by, x / length, y / length))
        return max(p.lower - apart, apart - p.upper), energy
    about = a.inv_inertia + b.inv_inertia
    if model.kind == _REVOLUTE:
        return apart, _stored(p, turn - state.rest, about) if sprung else 0.0
    if not sprung:
        return (0.0 if p.damping > 0.0 else apart), 0.0
    c, s = sin_cos(turn)
    energy = _stored(p, atan2(s, c), about)
    energy += _stored(p, x, _along(a, b, ax, ay, bx, by, 1.0, 0.0))
    return 0.0, energy + _stored(p, y, _along(a, b, ax, ay, bx, by, 0.0, 1.0))


@njit
def _stored(p: Any, stretch: Any, give: Any) -> Any:
    """J in a spring; one of given frequency is as stiff as the mass that its row sees asks for."""
    if give <= 0.0:
        return 0.0
    stiffness = p.stiffness if p.stiffness > 0.0 else (2.0 * np.pi * p.frequency) ** 2 / give
    return 0.5 * stiffness * stretch * stretch


@njit
def _along(a: Any, b: Any, ax: Any, ay: Any, bx: Any, by: Any, ux: Any, uy: Any) -> Any:
    """J M^-1 J^T of a row along a direction, 1/kg."""
    reach_a = cross(ax, ay, ux, uy)
    reach_b = cross(bx, by, ux, uy)
    return a.inv_mass + b.inv_mass + a.inv_inertia * reach_a**2 + b.inv_inertia * reach_b**2
