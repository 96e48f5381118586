"""Revolute: two anchors coincide; the angle may have limits, a motor and a spring."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import (
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
from .angle import set_angle_direction, unwrapped_angle
from .point import set_point_rows


@njit
def add_revolute_rows(
    rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a revolute joint.

    Slots: 0, 1 the anchors, 2 limit, 3 motor, 4 spring, 5 friction, 6 armature.
    """
    parameters = joint.parameters
    set_point_rows(rows, row, parameters, bodies, body_parameters, substep_bodies, h)
    angle = unwrapped_angle(bodies[joint.model.body_a], bodies[joint.model.body_b], parameters)
    row += 2
    if has_armature(parameters):
        set_angle_direction(rows[row])
        set_armature_row(rows[row], 6, joint, 0.0, substep_bodies)
        row += 1
    if has_motor(parameters):
        set_angle_direction(rows[row])
        speeds = speeds_within(angle, 0.0, parameters, h)
        set_motor_row(rows[row], 3, joint, speeds, 0.0, substep_bodies, h)
        row += 1
    if has_friction(parameters):
        set_angle_direction(rows[row])
        set_friction_row(rows[row], 5, parameters, 0.0, substep_bodies, h)
        row += 1
    if has_spring(parameters):
        set_angle_direction(rows[row])
        set_spring_row(rows[row], 4, angle - joint.state.rest, 0.0, parameters, 0.0, substep_bodies, h)
        row += 1
    if has_limit(parameters):  # last in a sweep, so that it overrides the motor
        set_angle_direction(rows[row])
        set_limit_row(rows[row], 2, angle, 0.0, parameters, substep_bodies, h)
        soften_limit(rows[row], parameters, 0.0, substep_bodies, h)
