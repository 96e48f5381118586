"""Weld: two anchors and the angle between two bodies held, rigidly or by a spring."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from .angle import relative_angle, set_angle_row
from .build import finish_row, soften
from .point import frame_ahead, set_frame_direction, set_point_rows


@njit
def add_weld_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slots: 0, 1 the anchors, 2 the angle."""
    angle = rows[row + 2]
    error = relative_angle(bodies[angle.body_a], bodies[angle.body_b], parameters.reference)
    set_angle_row(angle, 2, error, body_parameters)
    if has_spring(parameters):
        _set_stretch_rows(rows, row, parameters, bodies, body_parameters, motions, h)
        for r in range(3):
            soften(rows[row + r], parameters, 0.0, body_parameters, motions, h)
    else:
        set_point_rows(rows, row, parameters, bodies, body_parameters, motions, h)
    return row + 3


@njit
def _set_stretch_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> None:
    """As ``set_point_rows`` for anchors that may be apart: both forces act at b's, or they would make a torque."""
    i = rows[row].body_a
    j = rows[row].body_b
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.0)
    middle = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.5 * h)
    set_frame_direction(rows[row], middle, 1.0, 0.0)
    set_frame_direction(rows[row + 1], middle, 0.0, 1.0)
    finish_row(rows[row], 0, dx, body_parameters)
    finish_row(rows[row + 1], 1, dy, body_parameters)
