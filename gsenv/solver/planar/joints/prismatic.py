"""Prismatic: b slides along an axis of a and doesn't turn in it; limits, motor and spring along the axis."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from .angle import relative_angle, set_angle_row
from .build import add_limit, add_motor, add_spring, copy_direction, finish_row, has_limit, has_motor, speeds_within
from .point import axis_ahead, curve_of, frame_ahead, set_frame_direction


@njit
def add_slide_row(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slot 0: b's anchor stays on the axis; returns the coordinate along it.

    With u the axis and n its left: C = n . (anchor_b - anchor_a), directions and bias as in
    ``set_point_rows``.
    """
    made = rows[row]
    i = made.body_a
    j = made.body_b
    ux, uy = axis_ahead(bodies, motions, i, parameters, 0.0)
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.0)
    error = ux * dy - uy * dx
    coordinate = ux * dx + uy * dy
    vx, vy = axis_ahead(bodies, motions, i, parameters, 0.5 * h)
    middle = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.5 * h)
    wx, wy = axis_ahead(bodies, motions, i, parameters, h)
    end = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h)
    set_frame_direction(made, middle, -vy, vx)
    curve = curve_of(made, end, -wy, wx, motions)
    set_frame_direction(made, middle, -vy, vx)
    finish_row(made, 0, error, body_parameters)
    made.bias = curve
    return coordinate


@njit
def set_axis_direction(row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any) -> Any:
    """J of the coordinate along the axis, half a substep ahead; returns its h/2 dJ/dt v."""
    i = row.body_a
    j = row.body_b
    ux, uy = axis_ahead(bodies, motions, i, parameters, 0.5 * h)
    middle = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.5 * h)
    wx, wy = axis_ahead(bodies, motions, i, parameters, h)
    end = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h)
    set_frame_direction(row, middle, ux, uy)
    curve = curve_of(row, end, wx, wy, motions)
    set_frame_direction(row, middle, ux, uy)
    return curve


@njit
def add_prismatic_rows(
    rows: Any, row: Any, model: Any, parameters: Any, state: Any, bodies: Any, body_parameters: Any,
    motions: Any, h: Any,
) -> Any:  # fmt: skip
    """Slots: 0 across the axis, 1 the angle, 2 limit, 3 motor, 4 spring."""
    coordinate = add_slide_row(rows, row, parameters, bodies, body_parameters, motions, h)
    error = relative_angle(bodies[model.body_a], bodies[model.body_b], parameters.reference)
    set_angle_row(rows[row + 1], 1, error, body_parameters)
    row += 2
    if not (has_limit(parameters) or has_motor(parameters) or has_spring(parameters)):
        return row
    first = row
    curve = set_axis_direction(rows[first], parameters, bodies, body_parameters, motions, h)
    if has_spring(parameters):
        row = add_spring(rows, row, 4, coordinate - state.rest, parameters, body_parameters, motions, h)
    if has_motor(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        speeds = speeds_within(coordinate, curve, parameters, h)
        row = add_motor(rows, row, 3, model, parameters, state, speeds, body_parameters, h)
    if has_limit(parameters):  # last: it may turn its direction round
        copy_direction(rows[row], rows[first], 1.0)
        row = add_limit(rows, row, 2, coordinate, curve, parameters, body_parameters, motions, h)
    return row
