"""Target: pulls a body's anchor and rotation to a pose that moves, with bounded force and torque.

The bound is a box in world axes: |f_x|, |f_y|, |f_z| <= max_force, and the same of torques.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...model import ActuatorMode
from ..math import add, multiply, norm, normalised, quaternion, scaled, turn_between, turn_of, vec
from .build import bound_row, finish_row, soften
from .point import arm, set_point_direction, set_turn_direction, unit_axis

_VELOCITY = int(ActuatorMode.VELOCITY)


@njit
def move_targets(indices: Any, joint_models: Any, joint_states: Any, h: Any) -> None:
    """Target poses move on at their own velocity."""
    for k in range(len(indices)):
        if joint_models[indices[k]].wakes:
            state = joint_states[indices[k]]
            v = state.target_velocity
            for d in range(3):
                state.target_position[d] += h * v[d]
            _set_rotation(state, multiply(turn_of((h * v[3], h * v[4], h * v[5])), quaternion(state.target_rotation)))


@njit
def _set_rotation(state: Any, rotation: Any) -> None:
    q = normalised(rotation)
    for d in range(4):
        state.target_rotation[d] = q[d]


@njit
def add_target_rows(
    rows: Any, row: Any, parameters: Any, state: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slots: 0 to 2 the anchor, 3 to 5 the rotation."""
    j = rows[row].body_b
    b = bodies[j]
    to_anchor = arm(b, body_parameters[j], parameters.anchor_b)
    place = add(vec(b.position), to_anchor)
    turn = turn_between(quaternion(state.target_rotation), quaternion(b.rotation))
    for r in range(6):
        made = rows[row + r]
        if r < 3:
            set_point_direction(made, motions, unit_axis(r), to_anchor, to_anchor)
            error = place[r] - state.target_position[r]
        else:
            set_turn_direction(made, motions, unit_axis(r - 3))
            error = turn[r - 3]
        for d in range(6):
            made.jacobian_a[d] = 0.0
        finish_row(made, r, error, motions)
        soften(made, parameters, state.target_velocity[r], motions, h)
        bound_row(made, h * (parameters.max_force if r < 3 else parameters.max_torque))
    return row + 6


@njit
def drive_target(actuator: Any, value: Any, state: Any, parameters: Any, bodies: Any, body_parameters: Any) -> None:
    """An actuator sets the target's velocity or position.

    A target driven by velocity waits for a body that can't follow: it stays within the reach at
    which its spring is at the force bound, so nothing winds up.
    """
    axis = actuator.axis
    if actuator.mode == _VELOCITY:
        state.target_velocity[axis] = value
        _keep_near(actuator, state, parameters, bodies, body_parameters)
    else:
        state.target_position[axis] = value


@njit
def _keep_near(actuator: Any, state: Any, parameters: Any, bodies: Any, body_parameters: Any) -> None:
    b = bodies[actuator.body]
    mass = body_parameters[actuator.body]
    omega = 6.283185307179586 * parameters.frequency
    axis = actuator.axis
    if axis < 3:
        here = b.position[axis] + arm(b, mass, parameters.anchor_b)[axis]
        reach = parameters.max_force / max(mass.mass * omega * omega, 1e-300)
        state.target_position[axis] = min(max(state.target_position[axis], here - reach), here + reach)
        return
    inertia = min(mass.inertia[0], min(mass.inertia[1], mass.inertia[2]))
    reach = parameters.max_torque / max(inertia * omega * omega, 1e-300)
    own = quaternion(b.rotation)
    ahead = turn_between(own, quaternion(state.target_rotation))
    size = norm(ahead)
    if size > reach:
        _set_rotation(state, multiply(turn_of(scaled(ahead, reach / size)), own))
