"""Gear: couples the coordinates of two joints, q_a + ratio q_b = constant.

The row acts on the joints' second bodies.  Where both joints are hinges on one moving body, that body takes the
reaction torque -T, T = u_a + ratio u_b.  Hinges share all rotations across their axes with that body: for axes that
are not parallel T is therefore the sum of one torque across each axis, which the two hinges transmit.  For parallel
axes it is a pair of forces at the two axes, like meshing teeth.  Of other joints on moving bodies the row has two
halves, one on the bodies of each joint.
"""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...jit import njit
from ..math import Vec, add, along, cross, dot, scaled, sub, vec
from ..rotation import in_frame, set_spin
from .axes import axes_ahead, axes_of, axis_of, counts_turns, turn_coordinate, turn_direction, unwrapped
from .axis_joints import set_axis_coordinate
from .point import frame_ahead

_PARALLEL = 0.01  # squared sine of the angle between axes that count as parallel
_ZERO = (0.0, 0.0, 0.0)


@njit
def _coordinate(joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> tuple[float, Vec, Vec]:
    """Return (coordinate, the force and the torque on body b of its Jacobian)."""
    number = joint.model.coordinate
    now = axes_ahead(joint, bodies, substep_bodies, h, 0.0)
    middle = axes_ahead(joint, bodies, substep_bodies, h, 0.5 * h)
    if number >= 3:
        angle = turn_coordinate(number, now[0], now[1])
        if counts_turns(number):
            angle = unwrapped(angle, joint.state.angle)
        return angle, _ZERO, turn_direction(number, middle[0], middle[1])
    i = joint.model.body_a
    j = joint.model.body_b
    p = joint.parameters
    here = frame_ahead(bodies, body_parameters, substep_bodies, i, j, p, h, 0.0)
    ahead = frame_ahead(bodies, body_parameters, substep_bodies, i, j, p, h, 0.5 * h)
    u = axis_of(middle[0], number)
    return dot(axis_of(now[0], number), here[2]), u, cross(ahead[1], u)


@njit
def _pin_ahead(joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> tuple[Vec, Vec]:
    """Return (arm, position) of the anchor on body b half a substep ahead."""
    i = joint.model.body_a
    j = joint.model.body_b
    frame = frame_ahead(bodies, body_parameters, substep_bodies, i, j, joint.parameters, h, 0.5 * h)
    place = along(vec(bodies[j].position), 0.5 * h, vec(substep_bodies[j].start_velocity))
    return frame[1], add(place, frame[1])


@njit
def _is_moving(body: Any, parameters: Any) -> bool:
    if parameters.inv_mass > 0.0:
        return True
    for d in range(3, 6):
        if body.velocity[d] != 0.0:
            return True
    return False


@njit
def add_gear_rows(
    made: Any, gear: Any, first: Any, second: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the row ``made``, slot 0, of a gear between the joints ``first`` and ``second``."""
    k = gear.parameters.ratio
    p, force_a, u = _coordinate(first, bodies, body_parameters, substep_bodies, h)
    q, force_b, v = _coordinate(second, bodies, body_parameters, substep_bodies, h)
    turn_a = u
    turn_b = scaled(v, k)
    force_b = scaled(force_b, k)
    frame = first.model.body_a
    if _is_moving(bodies[frame], body_parameters[frame]):
        torque = along(u, k, v)
        c = cross(u, v)
        square = dot(c, c)
        if square > _PARALLEL:
            turn_a = along(turn_a, -dot(torque, v) / square, cross(c, u))
            turn_b = along(turn_b, dot(torque, u) / square, cross(c, v))
        else:
            arm_a, at_a = _pin_ahead(first, bodies, body_parameters, substep_bodies, h)
            arm_b, at_b = _pin_ahead(second, bodies, body_parameters, substep_bodies, h)
            apart = sub(at_b, at_a)
            shift = dot(u, apart)  # to the point of the second axis beside the first pin
            apart = along(apart, -shift, u)
            force = scaled(cross(torque, apart), 1.0 / max(dot(apart, apart), 1e-300))
            force_a = add(force_a, force)
            force_b = sub(force_b, force)
            turn_a = add(turn_a, cross(arm_a, force))
            turn_b = sub(turn_b, cross(along(arm_b, -shift, u), force))
    for d in range(3):
        made.jacobian_a[d] = force_a[d]
        made.jacobian_b[d] = force_b[d]
    set_spin(made.jacobian_a, in_frame(substep_bodies[made.body_a], turn_a))
    set_spin(made.jacobian_b, in_frame(substep_bodies[made.body_b], turn_b))
    finish_row(made, 0, p + k * q - gear.parameters.reference_angle, substep_bodies)


@njit
def set_coordinate(made: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> Any:
    """Set bodies and Jacobian of a row to those of a joint's coordinate; returns (coordinate, h/2 dJ/dt v)."""
    made.body_a = joint.model.body_a
    made.body_b = joint.model.body_b
    axes = axes_of(joint, bodies, substep_bodies, h)
    number = joint.model.coordinate
    return set_axis_coordinate(made, joint, number, axes, bodies, body_parameters, substep_bodies, h)
