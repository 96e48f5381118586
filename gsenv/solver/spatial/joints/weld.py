"""Weld: two anchors coincide and the rotation between two bodies is fixed, rigidly or by springs."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...core.rows import EQUATION
from ...jit import njit
from ..math import Vec, multiply, norm, quaternion, scaled, sub, turn_between
from ..rotation import in_world, spin_change, spin_of
from .point import frame_ahead, set_frame_direction, set_turn_direction, unit_axis

MOST_PHASE = 0.5  # rad: largest angle by which its own inertia may turn a body's spin within the substep, in full


@njit
def set_rotation_rows(rows: Any, row: Any, parameters: Any, bodies: Any, substep_bodies: Any) -> None:
    """Write the rows of the rotation of b in a, slots 3 to 5."""
    first = rows[row]
    wanted = multiply(quaternion(bodies[first.body_a].rotation), quaternion(parameters.reference))
    error = turn_between(wanted, quaternion(bodies[first.body_b].rotation))
    for k in range(3):
        set_turn_direction(rows[row + 3 + k], substep_bodies, unit_axis(k))
        finish_row(rows[row + 3 + k], 3 + k, error[k], substep_bodies)


@njit
def add_inertia_biases(rows: Any, row: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> None:
    """Add the change of J v by the bodies' own inertia, from the midpoint to the end, to the rotation rows.

    Not to slow springs, which let the bodies turn against each other.
    """
    first = rows[row]
    b = _own_change(body_parameters[first.body_b], substep_bodies[first.body_b], h)
    a = _own_change(body_parameters[first.body_a], substep_bodies[first.body_a], h)
    bend = sub(b, a)
    for k in range(3):
        if rows[row + 3 + k].kind == EQUATION:
            rows[row + 3 + k].bias += 0.5 * h * bend[k]


@njit
def _own_change(parameters: Any, substep_body: Any, h: Any) -> Vec:
    """Return the angular acceleration of a body by its own inertia, rad/s^2 in the world, reduced where it is no guide.

    Rows that do not resolve the free rotation would add energy with all of it.
    """
    change = spin_change(substep_body, parameters)
    phase = h * norm(change)
    most = MOST_PHASE * norm(spin_of(substep_body.start_velocity))
    return in_world(substep_body, scaled(change, (most / phase) ** 2 if phase > most else 1.0))


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
