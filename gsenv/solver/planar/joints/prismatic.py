"""Prismatic: b translates along an axis of a without rotation; limits, motor and spring act along the axis."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import (
    copy_direction,
    finish_row,
    has_armature,
    has_friction,
    has_limit,
    has_motor,
    set_armature_row,
    set_friction_row,
    set_limit_row,
    set_motor_row,
    set_spring_row,
    soften_limit,
    speeds_within,
)
from ...core.springs import has_spring
from ...jit import njit
from .angle import relative_angle, set_angle_row
from .point import axis_ahead, curve_of, frame_ahead, set_frame_direction


@njit
def add_slide_row(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> Any:
    """Write the row in slot 0 that keeps b's anchor on the axis; returns the coordinate along it.

    With u the axis and n its left: C = n . (anchor_b - anchor_a), directions and bias as in
    ``set_point_rows``.
    """
    made = rows[row]
    i = made.body_a
    j = made.body_b
    ux, uy = axis_ahead(bodies, substep_bodies, i, parameters, 0.0)
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.0)
    error = ux * dy - uy * dx
    coordinate = ux * dx + uy * dy
    vx, vy = axis_ahead(bodies, substep_bodies, i, parameters, 0.5 * h)
    middle = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.5 * h)
    wx, wy = axis_ahead(bodies, substep_bodies, i, parameters, h)
    end = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h)
    set_frame_direction(made, middle, -vy, vx)
    curve = curve_of(made, end, -wy, wx, substep_bodies)
    set_frame_direction(made, middle, -vy, vx)
    finish_row(made, 0, error, substep_bodies)
    made.bias = curve
    return coordinate


@njit
def set_axis_direction(
    row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> Any:
    """Set J of the coordinate along the axis, half a substep ahead; returns its h/2 dJ/dt v."""
    i = row.body_a
    j = row.body_b
    ux, uy = axis_ahead(bodies, substep_bodies, i, parameters, 0.5 * h)
    middle = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.5 * h)
    wx, wy = axis_ahead(bodies, substep_bodies, i, parameters, h)
    end = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h)
    set_frame_direction(row, middle, ux, uy)
    curve = curve_of(row, end, wx, wy, substep_bodies)
    set_frame_direction(row, middle, ux, uy)
    return curve


@njit
def add_prismatic_rows(
    rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a prismatic joint.

    Slots: 0 across the axis, 1 the angle, 2 limit, 3 motor, 4 spring, 5 friction, 6 armature.
    """
    parameters = joint.parameters
    coordinate = add_slide_row(rows, row, parameters, bodies, body_parameters, substep_bodies, h)
    error = relative_angle(bodies[joint.model.body_a], bodies[joint.model.body_b], parameters.reference)
    set_angle_row(rows[row + 1], 1, error, substep_bodies)
    row += 2
    driven = has_motor(parameters) or has_friction(parameters) or has_armature(parameters)
    if not (driven or has_limit(parameters) or has_spring(parameters)):
        return
    first = row
    curve = set_axis_direction(rows[first], parameters, bodies, body_parameters, substep_bodies, h)
    if has_spring(parameters):
        set_spring_row(rows[row], 4, coordinate - joint.state.rest, 0.0, parameters, 0.0, substep_bodies, h)
        row += 1
    if has_armature(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        set_armature_row(rows[row], 6, joint, curve, substep_bodies)
        row += 1
    if has_friction(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        set_friction_row(rows[row], 5, parameters, 0.0, substep_bodies, h)
        row += 1
    if has_motor(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        speeds = speeds_within(coordinate, curve, parameters, h)
        set_motor_row(rows[row], 3, joint, speeds, 0.0, substep_bodies, h)
        row += 1
    if has_limit(parameters):  # last, since it may reverse its direction
        copy_direction(rows[row], rows[first], 1.0)
        set_limit_row(rows[row], 2, coordinate, curve, parameters, substep_bodies, h)
        soften_limit(rows[row], parameters, 0.0, substep_bodies, h)
