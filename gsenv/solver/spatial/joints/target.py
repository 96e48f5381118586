"""Target: pulls a body to a moving pose by springs of bounded force and torque.

The bound is a box in world axes: |f_x|, |f_y|, |f_z| <= max_force, and the same of torques.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..math import add, multiply, norm, normalised, quaternion, scaled, turn_between, turn_of, vec
from .point import arm, set_point_direction, set_turn_direction, unit_axis


@njit
def move_target(state: Any, h: Any) -> None:
    """Move a target pose by ``h`` s at its velocity."""
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
def set_target_direction(row: Any, slot: Any, joint: Any, body: Any, masses: Any, substep_bodies: Any) -> Any:
    """Set the Jacobian of an axis (slots 0 to 2) or rotation (3 to 5); return the error, m or rad."""
    state = joint.state
    if slot < 3:
        to_anchor = arm(body, masses, joint.parameters.anchor_b)
        set_point_direction(row, substep_bodies, unit_axis(slot), to_anchor, to_anchor)
        return add(vec(body.position), to_anchor)[slot] - state.target_position[slot]
    set_turn_direction(row, substep_bodies, unit_axis(slot - 3))
    return turn_between(quaternion(state.target_rotation), quaternion(body.rotation))[slot - 3]


@njit
def set_target(state: Any, axis: Any, value: Any) -> None:
    """Set one coordinate of the target position, m; rotations are driven by velocity."""
    state.target_position[axis] = value


@njit
def keep_near(state: Any, axis: Any, parameters: Any, body: Any, masses: Any) -> None:
    """Limit the distance of the target to that at which its spring reaches the force bound."""
    omega = 6.283185307179586 * parameters.frequency
    if axis < 3:
        here = body.position[axis] + arm(body, masses, parameters.anchor_b)[axis]
        reach = parameters.max_force / max(masses.mass * omega * omega, 1e-300)
        state.target_position[axis] = min(max(state.target_position[axis], here - reach), here + reach)
        return
    inertia = min(masses.inertia[0], min(masses.inertia[1], masses.inertia[2]))
    reach = parameters.max_torque / max(inertia * omega * omega, 1e-300)
    own = quaternion(body.rotation)
    ahead = turn_between(own, quaternion(state.target_rotation))
    size = norm(ahead)
    if size > reach:
        _set_rotation(state, multiply(turn_of(scaled(ahead, reach / size)), own))
