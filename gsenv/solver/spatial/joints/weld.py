"""Weld: two anchors coincide and the rotation between two bodies is fixed, rigidly or by springs."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...jit import njit
from ..math import Vec, multiply, quaternion, sub, turn_between
from ..rotation import in_world, spin_change
from .point import frame_ahead, set_frame_direction, set_turn_direction, unit_axis


@njit
def set_rotation_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of the rotation of b in a, slots 3 to 5.

    The bias is the change of J v by the bodies' own inertia from the midpoint to the end.
    """
    first = rows[row]
    bend = sub(
        own_change(body_parameters, substep_bodies, first.body_b),
        own_change(body_parameters, substep_bodies, first.body_a),
    )
    wanted = multiply(quaternion(bodies[first.body_a].rotation), quaternion(parameters.reference))
    error = turn_between(wanted, quaternion(bodies[first.body_b].rotation))
    for k in range(3):
        set_turn_direction(rows[row + 3 + k], substep_bodies, unit_axis(k))
        finish_row(rows[row + 3 + k], 3 + k, error[k], substep_bodies)
        rows[row + 3 + k].bias = 0.5 * h * bend[k]


@njit
def own_change(body_parameters: Any, substep_bodies: Any, i: Any) -> Vec:
    """Return the angular acceleration of a body by its own inertia, rad/s^2 in the world."""
    return in_world(substep_bodies[i], spin_change(substep_bodies[i], body_parameters[i]))


@njit
def set_stretch_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the point rows of a soft weld, whose anchors may differ: both forces act at b's, so they make no torque."""
    i = rows[row].body_a
    j = rows[row].body_b
    now = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h, 0.0)
    middle = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h, 0.5 * h)
    for k in range(3):
        set_frame_direction(rows[row + k], substep_bodies, middle, unit_axis(k))
        finish_row(rows[row + k], k, now[2][k], substep_bodies)
