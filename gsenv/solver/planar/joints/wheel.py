"""Wheel: b turns freely and slides along an axis of a on a spring, within limits; a motor turns it."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from .angle import set_angle_direction
from .build import add_limit, add_motor, add_spring, copy_direction, has_limit, has_motor
from .prismatic import add_slide_row, set_axis_direction

_INFINITY = float("inf")


@njit
def add_wheel_rows(
    rows: Any, row: Any, model: Any, parameters: Any, state: Any, bodies: Any, body_parameters: Any,
    motions: Any, h: Any,
) -> Any:  # fmt: skip
    """Slots: 0 across the axis, 1 spring, 2 limit, 3 motor."""
    coordinate = add_slide_row(rows, row, parameters, bodies, body_parameters, motions, h)
    row += 1
    if has_motor(parameters):
        set_angle_direction(rows[row])
        speeds = (-_INFINITY, _INFINITY)  # limits are those of the travel
        row = add_motor(rows, row, 3, model, parameters, state, speeds, body_parameters, h)
    if not (has_limit(parameters) or has_spring(parameters)):
        return row
    first = row
    curve = set_axis_direction(rows[first], parameters, bodies, body_parameters, motions, h)
    if has_spring(parameters):
        row = add_spring(rows, row, 1, coordinate - state.rest, parameters, body_parameters, motions, h)
    if has_limit(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        row = add_limit(rows, row, 2, coordinate, curve, parameters, body_parameters, motions, h)
    return row
