"""The joints of the plane: which rows each kind adds. One file a kind, one branch line here."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from ...jit import njit
from ...model import ActuatorMode
from ...rows import EQUATION, HELD_APART
from ...springs import has_spring
from ..math import cross
from .build import has_limit, has_motor
from .distance import add_distance_rows
from .gear import add_gear_rows
from .point import arm, turned
from .prismatic import add_prismatic_rows
from .revolute import add_revolute_rows
from .rows_of_user import add_user_rows
from .target import add_target_rows, drive_target
from .weld import add_weld_rows
from .wheel import add_wheel_rows


class JointKind(IntEnum):
    ROWS = 0  # rows of a user-written constraint
    WELD = 1
    TARGET = 2
    REVOLUTE = 3
    PRISMATIC = 4
    DISTANCE = 5
    WHEEL = 6
    GEAR = 7


_ROWS = int(JointKind.ROWS)
_WELD = int(JointKind.WELD)
_TARGET = int(JointKind.TARGET)
_REVOLUTE = int(JointKind.REVOLUTE)
_PRISMATIC = int(JointKind.PRISMATIC)
_DISTANCE = int(JointKind.DISTANCE)
_WHEEL = int(JointKind.WHEEL)
_VELOCITY = int(ActuatorMode.VELOCITY)
_POSITION = int(ActuatorMode.POSITION)
SWING_PER_SUBSTEP = 1.5  # rad: how far a taut link may swing in a substep
TURN_PER_SUBSTEP = 0.15  # rad: how far a body that is held off its centre may turn in a substep
OFF_CENTER = 0.1  # of the radius: wheels turn about their centres and need no more substeps


@njit
def joint_row_count(model: Any, parameters: Any) -> Any:
    """Rows that a joint adds; the parameters alone decide."""
    if model.kind < _REVOLUTE:
        return model.row_count
    count = model.row_count + int(has_limit(parameters)) + int(has_motor(parameters))
    if model.kind == _DISTANCE:
        return count + int(has_spring(parameters) or parameters.rigid != 0)
    return count + int(has_spring(parameters))


@njit
def count_joint_rows(indices: Any, joint_models: Any, joint_parameters: Any) -> Any:
    count = 0
    for k in range(len(indices)):
        count += joint_row_count(joint_models[indices[k]], joint_parameters[indices[k]])
    return count


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
    motions: Any,
    linked: Any,
    scale: Any,
    h: Any,
) -> None:
    """Rows of the joints ``indices`` from ``rows[row]`` on.

    ``linked`` is None in scenes without the kinds from revolute on.  ``scale``: what the stored
    impulses are multiplied with, 0 for a cold start.
    """
    for k in range(len(indices)):
        j = indices[k]
        model = joint_models[j]
        parameters = joint_parameters[j]
        state = joint_states[j]
        end = row + joint_row_count(model, parameters)
        for r in range(row, end):
            rows[r].body_a = model.body_a
            rows[r].body_b = model.body_b
            rows[r].source = j
        if model.kind == _ROWS:
            add_user_rows(rows, row, model, constraint_rows, bodies, body_parameters, motions, h)
        elif model.kind == _WELD:
            add_weld_rows(rows, row, parameters, bodies, body_parameters, motions, h)
        elif model.kind == _TARGET:
            add_target_rows(rows, row, parameters, state, bodies, body_parameters, motions, h)
        elif linked is not None:
            _add_linked_rows(
                rows, row, model, joint_models, joint_parameters, j, state, bodies, body_parameters, motions, h
            )
        for r in range(row, end):
            slot = rows[r].slot
            rows[r].impulse = max(-scale * state.impulse[-1 - slot], 0.0) if slot < 0 else scale * state.impulse[slot]
            if rows[r].hold == HELD_APART and slot >= 0:
                rows[r].impulse = max(rows[r].impulse, 0.0)
        row = end


@njit
def _add_linked_rows(
    rows: Any, row: Any, model: Any, joint_models: Any, joint_parameters: Any, j: Any, state: Any, bodies: Any,
    body_parameters: Any, motions: Any, h: Any,
) -> None:  # fmt: skip
    parameters = joint_parameters[j]
    if model.kind == _REVOLUTE:
        add_revolute_rows(rows, row, model, parameters, state, bodies, body_parameters, motions, h)
    elif model.kind == _PRISMATIC:
        add_prismatic_rows(rows, row, model, parameters, state, bodies, body_parameters, motions, h)
    elif model.kind == _DISTANCE:
        add_distance_rows(rows, row, parameters, bodies, body_parameters, motions, h)
    elif model.kind == _WHEEL:
        add_wheel_rows(rows, row, model, parameters, state, bodies, body_parameters, motions, h)
    else:
        a = model.joint_a
        b = model.joint_b
        slides_a = joint_models[a].kind == _PRISMATIC
        slides_b = joint_models[b].kind == _PRISMATIC
        add_gear_rows(
            rows, row, model, parameters, joint_models[a], joint_parameters[a], slides_a, joint_models[b],
            joint_parameters[b], slides_b, bodies, body_parameters, motions, h,
        )  # fmt: skip


@njit
def store_joint_impulses(
    rows: Any, end: Any, joint_models: Any, joint_parameters: Any, joint_states: Any, bodies: Any,
    body_parameters: Any, motions: Any, scale: Any, h: Any,
) -> None:  # fmt: skip
    """Impulses of a substep: ``scale`` times them start the next; the reactions of the step grow."""
    for r in range(end):
        row = rows[r]
        state = joint_states[row.source]
        if row.slot < 0:
            state.impulse[-1 - row.slot] = -scale * row.impulse
            state.total_impulse[-1 - row.slot] -= row.impulse
        else:
            state.impulse[row.slot] = scale * row.impulse
            state.total_impulse[row.slot] += row.impulse
        j = row.jacobian_b
        i = row.body_b
        bx, by = arm(bodies[i], body_parameters[i], joint_parameters[row.source].anchor_b)
        back = motions[i].correction[2]  # bodies have moved; rows are of the pose before, or half a substep on
        if joint_models[row.source].kind >= _REVOLUTE or joint_models[row.source].kind == _WELD:
            back -= 0.5 * h * motions[i].start_velocity[2]
        bx, by = turned(bx, by, -back)
        state.reaction[0] += row.impulse * j[0]
        state.reaction[1] += row.impulse * j[1]
        state.reaction[2] += row.impulse * (j[2] - cross(bx, by, j[0], j[1]))


@njit
def forget_joint_impulses(rows: Any, end: Any, joint_states: Any) -> None:
    """No warm start from rows that contradict each other: it would grow in each step."""
    for r in range(end):
        for d in range(len(joint_states[rows[r].source].impulse)):
            joint_states[rows[r].source].impulse[d] = 0.0


@njit
def any_driven(indices: Any, joint_models: Any, joint_parameters: Any) -> Any:
    """Whether a joint may do work: no case for the energy guard."""
    for k in range(len(indices)):
        kind = joint_models[indices[k]].kind
        parameters = joint_parameters[indices[k]]
        if kind == _ROWS or kind == _TARGET or has_motor(parameters):
            return True
    return False


@njit
def any_equation(rows: Any, end: Any) -> Any:
    for r in range(end):
        if rows[r].kind == EQUATION:
            return True
    return False


@njit
def start_joints(joint_states: Any, joint_parameters: Any) -> None:
    """A disabled joint forgets its impulses."""
    for j in range(len(joint_states)):
        if joint_parameters[j].enabled == 0:
            state = joint_states[j]
            for d in range(len(state.impulse)):
                state.impulse[d] = 0.0
                state.total_impulse[d] = 0.0
            for d in range(len(state.reaction)):
                state.reaction[d] = 0.0


@njit
def clear_totals(indices: Any, joint_states: Any) -> None:
    """No impulse yet in this step; joints of sleeping islands keep theirs."""
    for k in range(len(indices)):
        state = joint_states[indices[k]]
        for d in range(len(state.total_impulse)):
            state.total_impulse[d] = 0.0
        for d in range(len(state.reaction)):
            state.reaction[d] = 0.0


@njit
def drive_joints(
    actuators: Any,
    control: Any,
    joint_models: Any,
    joint_parameters: Any,
    joint_states: Any,
    bodies: Any,
    body_parameters: Any,
) -> None:
    """Actuators take ``control``, clipped to their range."""
    for k in range(len(actuators)):
        actuator = actuators[k]
        value = min(max(control[k], actuator.lower), actuator.upper)
        state = joint_states[actuator.joint]
        if joint_models[actuator.joint].kind == _TARGET:
            drive_target(actuator, value, state, joint_parameters[actuator.joint], bodies, body_parameters)
        elif actuator.mode == _VELOCITY:
            state.motor_speed = value
        elif actuator.mode == _POSITION:
            state.rest = value
        else:
            state.effort = value


@njit
def substeps_for(
    indices: Any,
    joint_models: Any,
    joint_parameters: Any,
    joint_states: Any,
    bodies: Any,
    body_parameters: Any,
    least: Any,
    most: Any,
    dt: Any,
) -> Any:
    """Substeps that keep taut joints stable, from the tension T of the last step, and turning ones accurate.

    A link under tension swings at omega^2 = T (r_a / I_a + r_b / I_b), and a rod's ends at
    T / L (1/m_a + 1/m_b); the explicit step follows it for omega h < 2.
    """
    fastest = 0.0
    spin = 0.0
    for k in range(len(indices)):
        j = indices[k]
        model = joint_models[j]
        if model.kind == _ROWS or model.kind == _TARGET:
            continue
        reaction = joint_states[j].reaction
        tension = (reaction[0] * reaction[0] + reaction[1] * reaction[1]) ** 0.5 / dt
        parameters = joint_parameters[j]
        a = body_parameters[model.body_a]
        b = body_parameters[model.body_b]
        reach_a = _reach(parameters.anchor_a, a.center)
        reach_b = _reach(parameters.anchor_b, b.center)
        square = reach_a * a.inv_inertia + reach_b * b.inv_inertia
        if reach_a > OFF_CENTER * a.radius:
            spin = max(spin, abs(bodies[model.body_a].velocity[2]))
        if reach_b > OFF_CENTER * b.radius:
            spin = max(spin, abs(bodies[model.body_b].velocity[2]))
        if model.kind == _DISTANCE and parameters.length > 0.0:
            square += (a.inv_mass + b.inv_mass) / parameters.length
        fastest = max(fastest, tension * square)
    needed = max(dt * fastest**0.5 / SWING_PER_SUBSTEP, dt * spin / TURN_PER_SUBSTEP)
    return min(max(least, int(np.ceil(min(needed, 1e6)))), max(least, most))


@njit
def _reach(anchor: Any, center: Any) -> Any:
    x = anchor[0] - center[0]
    y = anchor[1] - center[1]
    return (x * x + y * y) ** 0.5
