"""Revolute: two anchors held together; the angle may have limits, a motor and a spring."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from .angle import set_angle_direction, unwrapped_angle
from .build import add_limit, add_motor, add_spring, has_limit, has_motor, speeds_within
from .point import set_point_rows


@njit
def add_revolute_rows(
    rows: Any, row: Any, model: Any, parameters: Any, state: Any, bodies: Any, body_parameters: Any,
    motions: Any, h: Any,
) -> Any:  # fmt: skip
    """Slots: 0, 1 the anchors, 2 limit, 3 motor, 4 spring."""
    set_point_rows(rows, row, parameters, bodies, body_parameters, motions, h)
    angle = unwrapped_angle(bodies[model.body_a], bodies[model.body_b], parameters)
    row += 2
    if has_motor(parameters):
        set_angle_direction(rows[row])
        speeds = speeds_within(angle, 0.0, parameters, h)
        row = add_motor(rows, row, 3, model, parameters, state, speeds, body_parameters, h)
    if has_spring(parameters):
        set_angle_direction(rows[row])
        row = add_spring(rows, row, 4, angle - state.rest, parameters, body_parameters, motions, h)
    if has_limit(parameters):  # last: in a sweep it has the last word
        set_angle_direction(rows[row])
        row = add_limit(rows, row, 2, angle, 0.0, parameters, body_parameters, motions, h)
    return row
