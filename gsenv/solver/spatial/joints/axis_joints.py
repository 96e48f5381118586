"""Joints with axes: hinge, slider, universal, wheel, six-axis, and single coordinates of these and of balls.

Slots of the impulses: 0 to 2 locked translations, 3 to 5 locked rotations, 6 limit, 7 motor, 8 spring, 9 friction,
10 armature.
"""

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
from ...core.rows import start_rate
from ...core.springs import has_spring
from ...core.trig import atan2
from ...jit import njit
from ..math import Vec, cross, dot, norm, scaled, turn_between
from .axes import (
    NODE_TURN,
    Axes,
    axes_of,
    axis_of,
    counts_turns,
    slide_curve,
    turn_coordinate,
    turn_curve,
    turn_direction,
    unwrapped,
)
from .point import JUMP, frame_ahead, set_frame_direction, set_point_rows, set_turn_direction, start_spin, unit_axis
from .reference import reference_give

_ALL = 7  # bits of three locked axes
_SWING = 3  # of the first two: rotation about the last axis is free
_NODE = 2  # of the second: a universal joint
_PI = 3.141592653589793
_INFINITY = float("inf")


@njit
def add_axis_rows(
    rows: Any, row: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a joint with axes: those of locked axes, then those of its coordinate."""
    axes = axes_of(joint, bodies, substep_bodies, h)
    locked = joint.model.locked
    if locked & _ALL == _ALL:
        set_point_rows(rows, row, joint.parameters, bodies, body_parameters, substep_bodies, h)
        row += 3
    elif locked & _ALL:
        for k in range(3):
            if (locked >> k) & 1:
                error, curve = _set_slide(rows[row], joint, k, axes, bodies, body_parameters, substep_bodies, h)
                finish_row(rows[row], k, error, substep_bodies)
                rows[row].bias = curve
                row += 1
    row = _add_locked_turns(rows, row, locked >> 3, axes, body_parameters, substep_bodies, h)
    _add_servo_rows(rows, row, joint, axes, bodies, body_parameters, substep_bodies, h)


@njit
def _set_slide(
    row: Any, joint: Any, k: Any, axes: Axes, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> tuple[float, float]:
    """Set J of the translation along axis k of a, half a substep ahead; returns (translation now, h/2 dJ/dt v)."""
    i = joint.model.body_a
    j = joint.model.body_b
    p = joint.parameters
    now = frame_ahead(bodies, body_parameters, substep_bodies, i, j, p, h, 0.0)
    middle = frame_ahead(bodies, body_parameters, substep_bodies, i, j, p, h, 0.5 * h)
    end = frame_ahead(bodies, body_parameters, substep_bodies, i, j, p, h, h)
    u = axis_of(axes.middle[0], k)
    set_frame_direction(row, substep_bodies, middle, u)
    last = (end, axis_of(axes.end[0], k))
    return dot(axis_of(axes.now[0], k), now[2]), slide_curve(
        substep_bodies, body_parameters, i, j, (middle, u), last, h
    )


@njit
def _add_locked_turns(
    rows: Any, row: Any, bits: Any, axes: Axes, body_parameters: Any, substep_bodies: Any, h: Any
) -> int:
    """Write the rows of the locked rotations; returns the number of the next row."""
    if bits == _ALL:
        error = turn_between(axes.now[0], axes.now[1])
        for k in range(3):
            u = unit_axis(k)
            _set_turn(rows[row], 3 + k, error[k], u, u, body_parameters, substep_bodies, h)
            row += 1
    elif bits == _SWING:
        swing = _swing(axes)
        for k in range(2):
            error_k = dot(axis_of(axes.now[0], k), swing)
            u = axis_of(axes.middle[0], k)
            _set_turn(rows[row], 3 + k, error_k, u, axis_of(axes.end[0], k), body_parameters, substep_bodies, h)
            row += 1
    elif bits == _NODE:
        angle = turn_coordinate(NODE_TURN, axes.now[0], axes.now[1])
        u = turn_direction(NODE_TURN, axes.middle[0], axes.middle[1])
        end = turn_direction(NODE_TURN, axes.end[0], axes.end[1])
        _set_turn(rows[row], 4, angle, u, end, body_parameters, substep_bodies, h)
        row += 1
    return row


@njit
def _swing(axes: Axes) -> Vec:
    """Return the shortest rotation vector, rad in the world, from the last axis of a to that of b."""
    p = axis_of(axes.now[0], 2)
    q = axis_of(axes.now[1], 2)
    c = cross(p, q)
    sine = norm(c)
    cosine = dot(p, q)
    if sine < 1e-9:
        return c if cosine > 0.0 else scaled(axis_of(axes.now[0], 0), _PI)
    return scaled(c, atan2(sine, cosine) / sine)


@njit
def _set_turn(
    row: Any, slot: Any, error: Any, u: Vec, end: Vec, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Make a rigid row of the rotation about u, which is ``end`` at the end of the substep."""
    set_turn_direction(row, substep_bodies, u)
    finish_row(row, slot, error, substep_bodies)
    speed = norm(start_spin(substep_bodies[row.body_a])) + norm(start_spin(substep_bodies[row.body_b]))
    if abs(start_rate(row, substep_bodies)) <= JUMP * speed:  # else velocities will jump
        row.bias = turn_curve(substep_bodies, body_parameters, row.body_a, row.body_b, u, end, h)


@njit
def set_axis_coordinate(
    row: Any, joint: Any, number: Any, axes: Axes, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> tuple[float, float]:
    """Set J of a coordinate; returns (coordinate, h/2 dJ/dt v)."""
    if number < 3:
        return _set_slide(row, joint, number, axes, bodies, body_parameters, substep_bodies, h)
    u = turn_direction(number, axes.middle[0], axes.middle[1])
    end = turn_direction(number, axes.end[0], axes.end[1])
    set_turn_direction(row, substep_bodies, u)
    i = joint.model.body_a
    j = joint.model.body_b
    angle = turn_coordinate(number, axes.now[0], axes.now[1])
    if counts_turns(number):
        angle = unwrapped(angle, joint.state.angle)
    return angle, turn_curve(substep_bodies, body_parameters, i, j, u, end, h)


@njit
def _add_servo_rows(
    rows: Any, row: Any, joint: Any, axes: Axes, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of armature, friction, motor, spring and limit, and count the turns of the coordinate."""
    number = joint.model.coordinate
    turning = joint.model.motor_coordinate
    p = joint.parameters
    if counts_turns(number):
        joint.state.angle = unwrapped(turn_coordinate(number, axes.now[0], axes.now[1]), joint.state.angle)
    driven = has_motor(p) or has_friction(p) or has_armature(p)
    if driven:
        first = row
        q, curve = set_axis_coordinate(rows[first], joint, turning, axes, bodies, body_parameters, substep_bodies, h)
        if has_armature(p):
            set_armature_row(rows[row], 10, joint, curve, substep_bodies)
            row += 1
        if has_friction(p):
            copy_direction(rows[row], rows[first], 1.0)
            set_friction_row(rows[row], 9, p, curve, substep_bodies, h)
            row += 1
        if has_motor(p):
            copy_direction(rows[row], rows[first], 1.0)
            speeds = speeds_within(q, 0.0, p, h) if turning == number else (-_INFINITY, _INFINITY)
            set_motor_row(rows[row], 7, joint, speeds, curve, substep_bodies, h)
            row += 1
    if has_spring(p) or has_limit(p):
        first = row
        give = reference_give(joint, body_parameters[joint.model.body_a], body_parameters[joint.model.body_b])
        q, curve = set_axis_coordinate(rows[first], joint, number, axes, bodies, body_parameters, substep_bodies, h)
        if has_spring(p):
            set_spring_row(rows[row], 8, q - joint.state.rest, curve, p, give, substep_bodies, h)
            row += 1
        if has_limit(p):  # last in a sweep, so that it overrides the motor
            copy_direction(rows[row], rows[first], 1.0)
            set_limit_row(rows[row], 6, q, curve, p, substep_bodies, h)
            soften_limit(rows[row], p, give, substep_bodies, h)
