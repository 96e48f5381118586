"""Wheel: b rotates freely, driven by a motor, and translates along an axis of a on a spring within limits."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import (
    copy_direction,
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
)
from ...core.springs import has_spring
from ...jit import njit
from .angle import set_angle_direction
from .prismatic import add_slide_row, set_axis_direction

_INFINITY = float("inf")


@njit
def add_wheel_rows(
    rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a wheel. Slots: 0 across the axis, 1 spring, 2 limit, 3 motor, 4 friction, 6 armature."""
    parameters = joint.parameters
    coordinate = add_slide_row(rows, row, parameters, bodies, body_parameters, substep_bodies, h)
    row += 1
    if has_armature(parameters):
        set_angle_direction(rows[row])
        set_armature_row(rows[row], 6, joint, 0.0, substep_bodies)
        row += 1
    if has_motor(parameters):
        set_angle_direction(rows[row])
        speeds = (-_INFINITY, _INFINITY)  # limits apply to the translation
        set_motor_row(rows[row], 3, joint, speeds, 0.0, substep_bodies, h)
        row += 1
    if has_friction(parameters):
        set_angle_direction(rows[row])
        set_friction_row(rows[row], 4, parameters, 0.0, substep_bodies, h)
        row += 1
    if not (has_limit(parameters) or has_spring(parameters)):
        return
    first = row
    curve = set_axis_direction(rows[first], parameters, bodies, body_parameters, substep_bodies, h)
    if has_spring(parameters):
        set_spring_row(rows[row], 1, coordinate - joint.state.rest, 0.0, parameters, 0.0, substep_bodies, h)
        row += 1
    if has_limit(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        set_limit_row(rows[row], 2, coordinate, curve, parameters, substep_bodies, h)
        soften_limit(rows[row], parameters, 0.0, substep_bodies, h)
