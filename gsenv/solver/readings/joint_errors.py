"""Position errors of rigid joints, and the energy in springs."""

from __future__ import annotations

from typing import Any

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


def joint_errors_and_energies(model: Model, parameters: ParameterArrays, state: State) -> tuple[Array, Array]:
    """Return (errors, energies), each (world,).

    errors: m, the largest position error of an enabled rigid joint: distance of the anchors
    from each other or from the axis, or difference of a rod or rope from its length.
    energies: J, in the springs of enabled joints other than targets.
    """
    errors, energies = np.zeros(len(state.worlds)), np.zeros(len(state.worlds))
    if model.has_joints:  # otherwise nothing is compiled
        arrays = (model.joints, parameters.joints, state.joints, state.bodies, parameters.bodies)
        models, joint_parameters, states, bodies, body_parameters = map(as_records, arrays)
        _read_all(models, joint_parameters, states, bodies, body_parameters, errors, energies)
    return errors, energies


@njit
def _read_all(
    models: Any, parameters: Any, states: Any, bodies: Any, body_parameters: Any, errors: Any, energies: Any
) -> None:
    for w in range(len(errors)):
        for j in range(len(models)):
            model = models[j]
            if parameters[w, j].enabled == 0 or model.kind in _UNMEASURED:
                continue
            a = model.body_a
            b = model.body_b
            joint = Joint(model, parameters[w, j], states[w, j])
            error, energy = read_joint(bodies[w, a], bodies[w, b], body_parameters[w, a], body_parameters[w, b], joint)
            errors[w] = max(errors[w], error)
            energies[w] += energy
