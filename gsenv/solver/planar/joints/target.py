"""Target: pulls body b to a moving pose by a critically tunable spring of bounded force and torque.

The force bound is a box in world axes: |f_x|, |f_y| <= max_force; |torque| <= max_torque.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...model import ActuatorMode
from .build import bound_row, finish_row, set_direction, soften
from .point import arm

_VELOCITY = int(ActuatorMode.VELOCITY)


@njit
def move_targets(indices: Any, joint_models: Any, joint_states: Any, h: Any) -> None:
    """Target poses move on at their own velocity."""
    for k in range(len(indices)):
        if joint_models[indices[k]].wakes:
            state = joint_states[indices[k]]
            state.target_position[0] += h * state.target_velocity[0]
            state.target_position[1] += h * state.target_velocity[1]
            state.target_angle += h * state.target_velocity[2]


@njit
def add_target_rows(
    rows: Any, row: Any, parameters: Any, state: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slots: 0, 1 the anchor, 2 the angle."""
    j = rows[row].body_b
    b = bodies[j]
    bx, by = arm(b, body_parameters[j], parameters.anchor_b)
    set_direction(rows[row], 1.0, 0.0, 0.0, -by)
    set_direction(rows[row + 1], 0.0, 1.0, 0.0, bx)
    set_direction(rows[row + 2], 0.0, 0.0, 0.0, 1.0)
    for r in range(3):
        made = rows[row + r]
        for d in range(3):
            made.jacobian_a[d] = 0.0
        if r == 0:
            error = b.position[0] + bx - state.target_position[0]
        elif r == 1:
            error = b.position[1] + by - state.target_position[1]
        else:
            error = b.angle - state.target_angle
        finish_row(made, r, error, body_parameters)
        soften(made, parameters, state.target_velocity[r], body_parameters, motions, h)
        bound_row(made, h * (parameters.max_force if r < 2 else parameters.max_torque))
    return row + 3


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
    elif axis < 2:
        state.target_position[axis] = value
    else:
        state.target_angle = value


@njit
def _keep_near(actuator: Any, state: Any, parameters: Any, bodies: Any, body_parameters: Any) -> None:
    b = bodies[actuator.body]
    mass = body_parameters[actuator.body]
    omega = 6.283185307179586 * parameters.frequency
    axis = actuator.axis
    if axis == 2:
        reach = parameters.max_torque / max(mass.inertia * omega * omega, 1e-300)
        state.target_angle = min(max(state.target_angle, b.angle - reach), b.angle + reach)
        return
    bx, by = arm(b, mass, parameters.anchor_b)
    here = b.position[0] + bx if axis == 0 else b.position[1] + by
    reach = parameters.max_force / max(mass.mass * omega * omega, 1e-300)
    state.target_position[axis] = min(max(state.target_position[axis], here - reach), here + reach)
