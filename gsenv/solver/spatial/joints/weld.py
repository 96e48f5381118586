"""Weld: two anchors and the rotation between two bodies held, rigidly or by springs."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from ..math import multiply, quaternion, turn_between
from .build import finish_row, soften
from .point import frame_ahead, set_frame_direction, set_point_rows, set_turn_direction, unit_axis


@njit
def add_weld_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slots: 0 to 2 the anchors, 3 to 5 the turn of b in a."""
    i = rows[row].body_a
    j = rows[row].body_b
    wanted = multiply(quaternion(bodies[i].rotation), quaternion(parameters.reference))
    error = turn_between(wanted, quaternion(bodies[j].rotation))
    for k in range(3):
        set_turn_direction(rows[row + 3 + k], motions, unit_axis(k))
        finish_row(rows[row + 3 + k], 3 + k, error[k], motions)
    if has_spring(parameters):
        _set_stretch_rows(rows, row, parameters, bodies, body_parameters, motions, h)
        for r in range(6):
            soften(rows[row + r], parameters, 0.0, motions, h)
    else:
        set_point_rows(rows, row, parameters, bodies, body_parameters, motions, h)
    return row + 6


@njit
def _set_stretch_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> None:
    """As ``set_point_rows`` for anchors that may be apart: both forces act at b's, or they would make a torque."""
    i = rows[row].body_a
    j = rows[row].body_b
    now = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h, 0.0)
    middle = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h, 0.5 * h)
    for k in range(3):
        set_frame_direction(rows[row + k], motions, middle, unit_axis(k))
        finish_row(rows[row + k], k, now[2][k], motions)
