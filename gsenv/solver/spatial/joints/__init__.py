"""The joints of space: which rows each kind adds. One file a kind, one branch line here."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from ...jit import njit
from ...model import ActuatorMode
from ...rows import EQUATION, HELD_APART
from ...springs import has_spring
from ..frames import in_world, spin_of
from ..math import Vec, along, conjugate, cross, multiply, norm, quaternion, scaled, sub, turn_of, turned, vec
from .ball import add_ball_rows
from .build import has_limit, has_motor
from .distance import add_distance_rows
from .point import arm, bend_across
from .rows_of_user import add_user_rows
from .target import add_target_rows, drive_target
from .weld import add_weld_rows


class JointKind(IntEnum):
    ROWS = 0  # rows of a user-written constraint
    WELD = 1
    TARGET = 2
    BALL = 3
    DISTANCE = 4


_ROWS = int(JointKind.ROWS)
_WELD = int(JointKind.WELD)
_TARGET = int(JointKind.TARGET)
_BALL = int(JointKind.BALL)
_DISTANCE = int(JointKind.DISTANCE)
_VELOCITY = int(ActuatorMode.VELOCITY)
_POSITION = int(ActuatorMode.POSITION)
SWING_PER_SUBSTEP = 1.5  # rad: how far a taut link may swing in a substep
TURN_PER_SUBSTEP = 0.15  # rad: how far a body that is held off its centre may turn in a substep
NUTATION_PER_SUBSTEP = 0.85  # rad: how far a top's own inertia may turn the motion of its arm in one of two substeps
OFF_CENTER = 0.1  # of the radius: wheels turn about their centres and need no more substeps


@njit
def joint_row_count(model: Any, parameters: Any) -> Any:
    """Rows that a joint adds; the parameters alone decide."""
    if model.kind < _DISTANCE:
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

    ``linked`` is None in scenes without the kinds from ball on.  ``scale``: what the stored
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
            add_user_rows(rows, row, model, constraint_rows, bodies, motions, h)
        elif model.kind == _WELD:
            add_weld_rows(rows, row, parameters, bodies, body_parameters, motions, h)
        elif model.kind == _TARGET:
            add_target_rows(rows, row, parameters, state, bodies, body_parameters, motions, h)
        elif linked is not None:
            if model.kind == _BALL:
                add_ball_rows(rows, row, parameters, bodies, body_parameters, motions, h)
            else:
                add_distance_rows(rows, row, parameters, bodies, body_parameters, motions, h)
        for r in range(row, end):
            slot = rows[r].slot
            rows[r].impulse = max(-scale * state.impulse[-1 - slot], 0.0) if slot < 0 else scale * state.impulse[slot]
            if rows[r].hold == HELD_APART and slot >= 0:
                rows[r].impulse = max(rows[r].impulse, 0.0)
        row = end


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
        motion = motions[i]
        # bodies have moved; rows are of the pose before, or half a substep on
        back = in_world(motion, spin_of(motion.correction))
        if joint_models[row.source].kind >= _BALL or joint_models[row.source].kind == _WELD:
            back = along(back, -0.5 * h, in_world(motion, spin_of(motion.start_velocity)))
        to_anchor = arm(bodies[i], body_parameters[i], joint_parameters[row.source].anchor_b)
        to_anchor = turned(turn_of(scaled(back, -1.0)), to_anchor)
        force = scaled(vec(j), row.impulse)
        torque = sub(scaled(in_world(motion, spin_of(j)), row.impulse), cross(to_anchor, force))
        for d in range(3):
            state.reaction[d] += force[d]
            state.reaction[3 + d] += torque[d]


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
    fastest_top = 0.0
    spin = 0.0
    for k in range(len(indices)):
        j = indices[k]
        model = joint_models[j]
        if model.kind == _ROWS or model.kind == _TARGET:
            continue
        tension = norm(vec(joint_states[j].reaction)) / dt
        parameters = joint_parameters[j]
        square = 0.0
        for side in range(2):
            i = model.body_a if side == 0 else model.body_b
            masses = body_parameters[i]
            anchor = parameters.anchor_a if side == 0 else parameters.anchor_b
            reach = turned(conjugate(quaternion(masses.axes)), sub(vec(anchor), vec(masses.center)))
            length = norm(reach)
            square += length * _swing_inverse(masses, reach, length)
            if length > OFF_CENTER * masses.radius:
                swing, nutation = _swing_speeds(bodies[i], masses, arm(bodies[i], masses, anchor), length)
                spin = max(spin, swing)
                fastest_top = max(fastest_top, nutation)
        if model.kind == _DISTANCE and parameters.length > 0.0:
            square += (body_parameters[model.body_a].inv_mass + body_parameters[model.body_b].inv_mass) / (
                parameters.length
            )
        fastest = max(fastest, tension * square)
    needed = max(dt * fastest**0.5 / SWING_PER_SUBSTEP, dt * spin / TURN_PER_SUBSTEP)
    count = min(max(least, int(np.ceil(min(needed, 1e6)))), max(least, most))
    tops = 0.5 * least * dt * fastest_top / NUTATION_PER_SUBSTEP  # finer where more substeps are asked for
    return max(count, min(int(np.ceil(min(tops, 1e6))), max(most, 2 * least)))


@njit
def _swing_inverse(masses: Any, reach: Vec, length: Any) -> Any:
    """1/(kg m^2) against turning across an arm, in principal axes: the mean of the two directions."""
    inverse = masses.inv_inertia
    trace = inverse[0] + inverse[1] + inverse[2]
    if length <= 0.0:
        return trace / 3.0
    about = inverse[0] * reach[0] ** 2 + inverse[1] * reach[1] ** 2 + inverse[2] * reach[2] ** 2
    return 0.5 * (trace - about / (length * length))


@njit
def _swing_speeds(body: Any, masses: Any, to_anchor: Vec, length: Any) -> Any:
    """rad/s at which the arm changes its direction, a spin about it moves nothing; and at which the body's own
    inertia turns that motion."""
    w = spin_of(body.velocity)
    way = norm(cross(w, to_anchor))
    axes = multiply(quaternion(body.rotation), quaternion(masses.axes))
    own = turned(conjugate(axes), w)
    i = masses.inertia
    if way <= 0.0 or i[0] <= 0.0 or i[1] <= 0.0 or i[2] <= 0.0:
        return way / length, 0.0
    turning = cross((i[0] * own[0], i[1] * own[1], i[2] * own[2]), own)
    change = turned(axes, (turning[0] / i[0], turning[1] / i[1], turning[2] / i[2]))
    return way / length, norm(bend_across(w, change, to_anchor)) / way
