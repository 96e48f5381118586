"""Target: pulls body b to a moving pose by a spring and damper of bounded force and torque.

The force bound is a box in world axes: |f_x|, |f_y| <= max_force; |torque| <= max_torque.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from .point import arm, set_direction


@njit
def move_target(state: Any, h: Any) -> None:
    """Move a target pose by ``h`` s at its velocity."""
    state.target_position[0] += h * state.target_velocity[0]
    state.target_position[1] += h * state.target_velocity[1]
    state.target_angle += h * state.target_velocity[2]


@njit
def set_target_direction(row: Any, slot: Any, joint: Any, body: Any, masses: Any, substep_bodies: Any) -> Any:
    """Set the Jacobian of x, y or the angle (slots 0 to 2) and return the error, m or rad."""
    state = joint.state
    if slot == 2:
        set_direction(row, 0.0, 0.0, 0.0, 1.0)
        return body.angle - state.target_angle
    bx, by = arm(body, masses, joint.parameters.anchor_b)
    if slot == 0:
        set_direction(row, 1.0, 0.0, 0.0, -by)
        return body.position[0] + bx - state.target_position[0]
    set_direction(row, 0.0, 1.0, 0.0, bx)
    return body.position[1] + by - state.target_position[1]


@njit
def set_target(state: Any, axis: Any, value: Any) -> None:
    """Set one coordinate of the target pose, m or rad."""
    if axis < 2:
        state.target_position[axis] = value
    else:
        state.target_angle = value


@njit
def keep_near(state: Any, axis: Any, parameters: Any, body: Any, masses: Any) -> None:
    """Limit the distance of the target to that at which its spring reaches the force bound."""
    omega = 6.283185307179586 * parameters.frequency
    if axis == 2:
        reach = parameters.max_torque / max(masses.inertia * omega * omega, 1e-300)
        state.target_angle = min(max(state.target_angle, body.angle - reach), body.angle + reach)
        return
    bx, by = arm(body, masses, parameters.anchor_b)
    here = body.position[0] + bx if axis == 0 else body.position[1] + by
    reach = parameters.max_force / max(masses.mass * omega * omega, 1e-300)
    state.target_position[axis] = min(max(state.target_position[axis], here - reach), here + reach)
