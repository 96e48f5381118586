"""Position errors of rigid joints, and the energy in springs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.dispatch import by_dimension
from ..core.joints import Joint
from ..jit import njit
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.plain import as_records
from ..records.state import State

read_joint = by_dimension("joint_readings", "read_joint")

_UNMEASURED = (
    int(JointKind.ROWS),
    int(JointKind.TARGET),
    int(JointKind.GEAR),
)  # kinds without their own error or energy
_DISTANCE = int(JointKind.DISTANCE)


class JointReadings(NamedTuple):
    """Of the enabled joints of each world, (world,).

    error: m, the largest position error of a rigid joint: distance of the anchors from each other or from the
    axis, or difference of a rod or rope from its length. relative_error: the largest error over the length of
    its joint (see ``joint_length``). torn: number of joints whose relative error exceeds a given bound.
    spring_energy: J, in the springs of joints other than targets.
    """

    error: Array
    relative_error: Array
    torn: Array
    spring_energy: Array


def read_joints(model: Model, parameters: ParameterArrays, state: State, bound: float = np.inf) -> JointReadings:
    """Return errors and spring energies; joints whose relative error exceeds ``bound`` count as torn."""
    count = len(state.worlds)
    readings = JointReadings(np.zeros(count), np.zeros(count), np.zeros(count, np.int32), np.zeros(count))
    if model.has_joints:  # otherwise nothing is compiled
        arrays = (model.joints, parameters.joints, state.joints, state.bodies, parameters.bodies)
        models, joint_parameters, states, bodies, body_parameters = map(as_records, arrays)
        _read_all(models, joint_parameters, states, bodies, body_parameters, bound, readings)
    return readings


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
            if error > 0.0:
                relative = error / joint_length(joint, a, b)
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
