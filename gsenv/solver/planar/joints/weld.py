"""Weld: two anchors coincide and the angle between two bodies is fixed, rigidly or by a spring."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...jit import njit
from .angle import relative_angle, set_angle_row
from .point import frame_ahead, set_frame_direction


@njit
def set_rotation_rows(rows: Any, row: Any, parameters: Any, bodies: Any, substep_bodies: Any) -> None:
    """Write the row of the angle of b in a, slot 2."""
    angle = rows[row + 2]
    error = relative_angle(bodies[angle.body_a], bodies[angle.body_b], parameters.reference)
    set_angle_row(angle, 2, error, substep_bodies)


@njit
def add_inertia_biases(rows: Any, row: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> None:
    """Do nothing: in the plane, a body's own inertia never turns its spin."""


@njit
def set_stretch_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the point rows of a soft weld, whose anchors may differ: both forces act at b's, so they make no torque."""
    i = rows[row].body_a
    j = rows[row].body_b
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.0)
    midpoint = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.5 * h)
    set_frame_direction(rows[row], midpoint, 1.0, 0.0)
    set_frame_direction(rows[row + 1], midpoint, 0.0, 1.0)
    finish_row(rows[row], 0, dx, substep_bodies)
    finish_row(rows[row + 1], 1, dy, substep_bodies)
