"""Target: pulls body b to a moving pose by a critically tunable spring of bounded force and torque.

The force bound is a box in world axes: |f_x|, |f_y| <= max_force; |torque| <= max_torque.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from .point import finish_row, set_direction, soften


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
def set_target_rows(
    rows: Any, row: Any, parameters: Any, state: Any, bodies: Any, body_parameters: Any, h: Any
) -> None:
    b = bodies[rows[row].body_b]
    center = body_parameters[rows[row].body_b].center
    lx = parameters.anchor_b[0] - center[0]
    ly = parameters.anchor_b[1] - center[1]
    bx = b.rotation[0] * lx - b.rotation[1] * ly
    by = b.rotation[1] * lx + b.rotation[0] * ly
    set_direction(rows[row], 1.0, 0.0, 0.0, -by)
    set_direction(rows[row + 1], 0.0, 1.0, 0.0, bx)
    set_direction(rows[row + 2], 0.0, 0.0, 0.0, 1.0)
    rows[row].error = b.position[0] + bx - state.target_position[0]
    rows[row + 1].error = b.position[1] + by - state.target_position[1]
    rows[row + 2].error = b.angle - state.target_angle
    for r in range(3):
        target = rows[row + r]
        for d in range(3):
            target.jacobian_a[d] = 0.0
        error = target.error
        finish_row(target, body_parameters)
        target.error = error
        soften(target, parameters.frequency, parameters.damping_ratio, h)
        target.bias -= state.target_velocity[r]
        bound = h * (parameters.max_force if r < 2 else parameters.max_torque)
        target.lower = -bound
        target.upper = bound


@njit
def drive_targets(
    actuators: Any, control: Any, joint_parameters: Any, joint_states: Any, bodies: Any, body_parameters: Any
) -> None:
    """Actuators set the targets' velocities or positions from ``control``, clipped to their range.

    A target driven by velocity waits for a body that can't follow: it stays within the reach at
    which its spring is at the force bound, so nothing winds up.
    """
    for k in range(len(actuators)):
        actuator = actuators[k]
        state = joint_states[actuator.joint]
        axis = actuator.axis
        value = min(max(control[k], actuator.lower), actuator.upper)
        if actuator.position == 1:
            if axis < 2:
                state.target_position[axis] = value
            else:
                state.target_angle = value
            continue
        state.target_velocity[axis] = value
        _keep_near(actuator, state, joint_parameters[actuator.joint], bodies, body_parameters)


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
    lx = parameters.anchor_b[0] - mass.center[0]
    ly = parameters.anchor_b[1] - mass.center[1]
    if axis == 0:
        here = b.position[0] + b.rotation[0] * lx - b.rotation[1] * ly
    else:
        here = b.position[1] + b.rotation[1] * lx + b.rotation[0] * ly
    reach = parameters.max_force / max(mass.mass * omega * omega, 1e-300)
    state.target_position[axis] = min(max(state.target_position[axis], here - reach), here + reach)
