"""Errors of rigid joints and gears, and the energy in springs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.dispatch import by_dimension
from ..core.joints import Joint
from ..dimension import dimension
from ..jit import njit
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.plain import as_records
from ..records.state import State

read_joint = by_dimension("joint_readings", "read_joint")
turned_off = by_dimension("joint_readings", "turned_off")

_UNMEASURED = (
    int(JointKind.ROWS),
    int(JointKind.TARGET),
    int(JointKind.GEAR),
)  # kinds without their own energy, and without an error of their own poses
_DISTANCE = int(JointKind.DISTANCE)


class JointReadings(NamedTuple):
    """Of the enabled joints of each world, (world,).

    error: m, the largest position error of a rigid joint: distance of the anchors from each other or from the
    axis, difference of a rod or rope from its length, or error of a gear whose first coordinate is a length.
    angular_error: rad, the largest angle by which a rotation is off that a weld, prismatic joint or joint with axes
    locks, or the error of another gear. relative_error: the largest error over the length of its joint (see
    ``joint_length``), or half the angular error, which is the arc at a body's edge over its diameter. torn: number of
    joints whose relative error exceeds a given bound. spring_energy: J, in the springs of joints other than targets.
    """

    error: Array
    angular_error: Array
    relative_error: Array
    torn: Array
    spring_energy: Array


def read_joints(model: Model, parameters: ParameterArrays, state: State, bound: float = np.inf) -> JointReadings:
    """Return errors and spring energies; joints whose relative error exceeds ``bound`` count as torn."""
    count = len(state.worlds)
    zero = np.zeros(count)
    readings = JointReadings(zero, zero.copy(), zero.copy(), np.zeros(count, np.int32), zero.copy())
    if model.has_joints:  # otherwise nothing is compiled
        arrays = (model.joints, parameters.joints, state.joints, state.bodies, parameters.bodies)
        models, joint_parameters, states, bodies, body_parameters = map(as_records, arrays)
        _read_all(models, joint_parameters, states, bodies, body_parameters, bound, readings)
    for j in np.flatnonzero(model.joints["kind"] == JointKind.GEAR).tolist():
        _read_gear(model, parameters, state, j, bound, readings)
    return readings


def _read_gear(
    model: Model, parameters: ParameterArrays, state: State, j: int, bound: float, readings: JointReadings
) -> None:
    """Add the error of a gear, in the unit of its first coordinate, to the readings."""
    of_joints = dimension(model.dim).joint_readings
    sizes = parameters.joints["enabled"][:, j] * np.abs(of_joints.coordinate(model, parameters, state, j))
    if of_joints.slides(model, int(model.joints["joint_a"][j])):
        ends = parameters.bodies[:, [model.joints["body_a"][j], model.joints["body_b"][j]]]
        radii = np.where((ends["inv_mass"] > 0.0) & (ends["radius"] > 0.0), ends["radius"], np.inf).min(1)
        relative = sizes / np.where(radii < np.inf, 2.0 * radii, 1.0)
        np.maximum(readings.error, sizes, out=readings.error)
    else:
        relative = 0.5 * sizes
        np.maximum(readings.angular_error, sizes, out=readings.angular_error)
    np.maximum(readings.relative_error, relative, out=readings.relative_error)
    readings.torn[relative > bound] += 1


@njit
def _read_all(
    models: Any, parameters: Any, states: Any, bodies: Any, body_parameters: Any, bound: Any, readings: Any
) -> None:
    for w in range(len(readings.error)):
        for j in range(len(models)):
            model = models[j]
            if parameters[w, j].enabled == 0 or model.kind in _UNMEASURED:
                continue
            a = body_parameters[w, model.body_a]
            b = body_parameters[w, model.body_b]
            joint = Joint(model, parameters[w, j], states[w, j])
            error, energy = read_joint(bodies[w, model.body_a], bodies[w, model.body_b], a, b, joint)
            readings.error[w] = max(readings.error[w], error)
            readings.spring_energy[w] += energy
            angle = turned_off(bodies[w, model.body_a], bodies[w, model.body_b], joint)
            readings.angular_error[w] = max(readings.angular_error[w], angle)
            relative = 0.5 * angle
            if error > 0.0:
                relative = max(relative, error / joint_length(joint, a, b))
            readings.relative_error[w] = max(readings.relative_error[w], relative)
            if relative > bound:
                readings.torn[w] += 1


@njit
def joint_length(joint: Any, a: Any, b: Any) -> Any:
    """Return the length in m by which the error of a joint is judged; ``a``, ``b``: parameters of its bodies.

    It is the length of a rod or rope. Of other joints, and of rods of length 0, it is the diameter of the smaller
    dynamic body, or the longest distance of an anchor from its centre of mass if no dynamic body has a shape.
    """
    p = joint.parameters
    if joint.model.kind == _DISTANCE:
        length = p.length
        if p.rigid == 0:
            length = p.upper if p.upper < np.inf else p.lower
        if length > 0.0:
            return length
    least = np.inf
    if a.inv_mass > 0.0 and a.radius > 0.0:
        least = 2.0 * a.radius
    if b.inv_mass > 0.0 and b.radius > 0.0:
        least = min(least, 2.0 * b.radius)
    if least < np.inf:
        return least
    arm = max(_arm_length(a, p.anchor_a), _arm_length(b, p.anchor_b))
    return arm if arm > 0.0 else 1.0


@njit
def _arm_length(parameters: Any, anchor: Any) -> Any:
    square = 0.0
    for d in range(len(anchor)):
        square += (anchor[d] - parameters.center[d]) ** 2
    return square**0.5
