"""The joints of the plane: which rows each kind adds. One file a kind, one branch line here."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from ...jit import njit
from .rows_of_user import set_user_rows
from .target import set_target_rows
from .weld import set_weld_rows


class JointKind(IntEnum):
    ROWS = 0  # rows of a user-written constraint
    WELD = 1
    TARGET = 2


_ROWS = int(JointKind.ROWS)
_WELD = int(JointKind.WELD)


@njit
def add_joint_rows(
    rows: Any,
    row: Any,
    indices: Any,
    joint_models: Any,
    joint_parameters: Any,
    joint_states: Any,
    constraint_rows: Any,
    bodies: Any,
    body_parameters: Any,
    warm_start: Any,
    h: Any,
) -> Any:
    """Rows of the joints ``indices`` from ``rows[row]`` on; returns the row after the last."""
    for k in range(len(indices)):
        j = indices[k]
        model = joint_models[j]
        parameters = joint_parameters[j]
        for r in range(model.row_count):
            rows[row + r].body_a = model.body_a
            rows[row + r].body_b = model.body_b
            rows[row + r].source = j
            rows[row + r].flying = 0
        if model.kind == _ROWS:
            set_user_rows(rows, row, model, constraint_rows, bodies, body_parameters, h)
        elif model.kind == _WELD:
            set_weld_rows(rows, row, parameters, bodies, body_parameters, h)
        else:
            set_target_rows(rows, row, parameters, joint_states[j], bodies, body_parameters, h)
        for r in range(model.row_count):
            rows[row + r].impulse = joint_states[j].impulse[r] if warm_start else 0.0
        row += model.row_count
    return row


@njit
def store_joint_impulses(rows: Any, row: Any, indices: Any, joint_models: Any, joint_states: Any) -> Any:
    for k in range(len(indices)):
        state = joint_states[indices[k]]
        for r in range(joint_models[indices[k]].row_count):
            state.impulse[r] = rows[row].impulse
            state.total_impulse[r] += rows[row].impulse
            row += 1
    return row


@njit
def any_driven(indices: Any, joint_models: Any, joint_parameters: Any) -> Any:
    """Whether a joint may do work, or give back stored energy: no case for the energy guard."""
    for k in range(len(indices)):
        j = indices[k]
        if joint_models[j].kind != _WELD or joint_parameters[j].frequency > 0.0:
            return True
    return False


@njit
def start_joints(joint_states: Any, joint_parameters: Any) -> None:
    """No impulse yet in this step; a disabled joint forgets its warm start."""
    for j in range(len(joint_states)):
        for d in range(len(joint_states[j].total_impulse)):
            joint_states[j].total_impulse[d] = 0.0
            if joint_parameters[j].enabled == 0:
                joint_states[j].impulse[d] = 0.0
