"""Coordinates of joints with axes, their directions, and the change of a direction within a substep.

A joint has a frame of three axes in each body; both coincide at the initial poses.  Rotations are the Cardan angles
about the first axis of a, the node and the last axis of b (B = A R_x R_y R_z), or those of another pair below.  Each
rotational coordinate q has a direction u with dq/dt = u . (w_b - w_a).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.trig import atan2
from ...jit import njit
from ..math import (
    Quaternion,
    Vec,
    add,
    along,
    conjugate,
    cross,
    dot,
    multiply,
    norm,
    quaternion,
    scaled,
    sub,
    turn_between,
    turned,
)
from ..rotation import in_world, spin_change
from .point import frame_rate, rotation_ahead, start_spin, unit_axis

# Numbers of coordinates: 0 to 2 translations along the axes of a, and
FIRST_TURN = 3  # about the first axis of a
NODE_TURN = 4  # about the node, the axis perpendicular to the first axis of a and the last of b
LAST_TURN = 5  # about the last axis of b
SWING = 6  # angle between the last axes of a and b
TWIST = 7  # about the last axis, by swing and twist: the angle of a hinge about it
BALL_TURN = 8  # to 10: components of the rotation vector in the frame of a
BALL_ANGLE = 11  # length of the rotation vector

_PI = 3.141592653589793
_LEAST_COSINE = 0.01  # of the node's angle, below which directions are those of this cosine


class Axes(NamedTuple):
    """The rotations of a joint's frames on both bodies: now, half a substep ahead, and at the end of the substep."""

    now: tuple[Quaternion, Quaternion]
    middle: tuple[Quaternion, Quaternion]
    end: tuple[Quaternion, Quaternion]


@njit
def axes_ahead(joint: Any, bodies: Any, substep_bodies: Any, h: Any, t: Any) -> tuple[Quaternion, Quaternion]:
    """Return the rotations of the joint's frames on bodies a and b, ``t`` s into a substep of h s, if nothing acts."""
    i = joint.model.body_a
    j = joint.model.body_b
    frame = quaternion(joint.parameters.frame)
    on_b = multiply(conjugate(quaternion(joint.parameters.reference)), frame)
    a = multiply(rotation_ahead(bodies[i], substep_bodies[i], h, t), frame)
    return a, multiply(rotation_ahead(bodies[j], substep_bodies[j], h, t), on_b)


@njit
def axes_of(joint: Any, bodies: Any, substep_bodies: Any, h: Any) -> Axes:
    """Return the frames at the three times."""
    return Axes(
        axes_ahead(joint, bodies, substep_bodies, h, 0.0),
        axes_ahead(joint, bodies, substep_bodies, h, 0.5 * h),
        axes_ahead(joint, bodies, substep_bodies, h, h),
    )


@njit
def axis_of(frame: Quaternion, k: int) -> Vec:
    """Return axis k of a frame in the world."""
    return turned(frame, unit_axis(k))


@njit
def _sine_cosine(a: Quaternion, b: Quaternion) -> tuple[float, float, Vec]:
    """Return sine and cosine of the node's angle, and the node times the cosine."""
    first = axis_of(a, 0)
    last = axis_of(b, 2)
    node = cross(last, first)
    return dot(first, last), norm(node), node


@njit
def _wrapped(angle: float) -> float:
    """Return an angle of at most two turns in (-pi, pi]."""
    if angle > _PI:
        return angle - 2.0 * _PI
    return angle + 2.0 * _PI if angle <= -_PI else angle


@njit
def angle_of(along_axis: float, scalar: float) -> float:
    """Return the angle in rad, (-pi, pi], of a rotation about an axis, from these parts of its quaternion."""
    return _wrapped(2.0 * atan2(along_axis, scalar))


@njit
def cardan_angle(number: int, e: Quaternion) -> float:
    """Return the first, the node's or the last angle in rad of a rotation e = R_x R_y R_z."""
    w, x, y, z = e
    if number == FIRST_TURN:
        return atan2(2.0 * (w * x - y * z), 1.0 - 2.0 * (x * x + y * y))
    if number == LAST_TURN:
        return atan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (y * y + z * z))
    p, q = 1.0 - 2.0 * (y * y + z * z), 2.0 * (w * z - x * y)
    return atan2(2.0 * (x * z + w * y), np.sqrt(p * p + q * q))


@njit
def turn_coordinate(number: int, a: Quaternion, b: Quaternion) -> float:
    """Return a rotational coordinate in rad, not unwrapped."""
    if number == TWIST:
        e = multiply(conjugate(a), b)
        return angle_of(e[3], e[0])
    if number == SWING:
        p = axis_of(a, 2)
        q = axis_of(b, 2)
        return atan2(norm(cross(p, q)), dot(p, q))
    if number >= BALL_TURN:
        turn = turn_between((1.0, 0.0, 0.0, 0.0), multiply(conjugate(a), b))
        return norm(turn) if number == BALL_ANGLE else turn[number - BALL_TURN]
    return cardan_angle(number, multiply(conjugate(a), b))


@njit
def turn_direction(number: int, a: Quaternion, b: Quaternion) -> Vec:
    """Return the direction u of a rotational coordinate in the world."""
    if number == TWIST:
        p = axis_of(a, 2)
        q = axis_of(b, 2)
        whole = 1.0 + dot(p, q)
        return scaled(add(p, q), 1.0 / whole) if whole > _LEAST_COSINE else p
    if number == SWING:
        c = cross(axis_of(a, 2), axis_of(b, 2))
        sine = norm(c)
        return scaled(c, 1.0 / sine) if sine > 1e-9 else axis_of(a, 0)
    if number == BALL_ANGLE:
        turn = turn_between((1.0, 0.0, 0.0, 0.0), multiply(conjugate(a), b))
        angle = norm(turn)
        return turned(a, scaled(turn, 1.0 / angle)) if angle > 1e-9 else axis_of(a, 0)
    if number >= BALL_TURN:
        return axis_of(a, number - BALL_TURN)
    sine, cosine, node = _sine_cosine(a, b)
    if number == NODE_TURN:
        return scaled(node, 1.0 / cosine) if cosine > 1e-9 else axis_of(a, 1)
    square = max(cosine, _LEAST_COSINE) ** 2
    if number == FIRST_TURN:
        return scaled(along(axis_of(a, 0), -sine, axis_of(b, 2)), 1.0 / square)
    return scaled(along(axis_of(b, 2), -sine, axis_of(a, 0)), 1.0 / square)


@njit
def counts_turns(number: int) -> bool:
    """Whether a coordinate is an angle that can exceed half a turn."""
    return number == FIRST_TURN or number == LAST_TURN or number == TWIST


@njit
def unwrapped(angle: float, before: float) -> float:
    """Return the angle plus the number of turns that brings it within half a turn of ``before``."""
    turns = (before - angle) / (2.0 * _PI)
    whole = float(int(turns + 0.5 if turns >= 0.0 else turns - 0.5))
    return angle + 2.0 * _PI * whole


@njit
def turn_curve(substep_bodies: Any, body_parameters: Any, i: Any, j: Any, middle: Vec, end: Vec, h: Any) -> float:
    """Return the change of J v from the middle to the end of the substep for a direction of rotation.

    It contains the change of the spins by the bodies' own inertia.
    """
    relative = sub(start_spin(substep_bodies[j]), start_spin(substep_bodies[i]))
    change = sub(
        _spin_change(substep_bodies[j], body_parameters[j]), _spin_change(substep_bodies[i], body_parameters[i])
    )
    return dot(sub(end, middle), relative) + 0.5 * h * dot(end, change)


@njit
def slide_curve(substep_bodies: Any, body_parameters: Any, i: Any, j: Any, middle: Any, end: Any, h: Any) -> float:
    """Return the change of J v from the middle to the end of the substep for a translation.

    ``middle``, ``end``: (frame of ``frame_ahead``, direction) each.
    """
    rate = frame_rate(substep_bodies, i, j, end[0], end[1]) - frame_rate(substep_bodies, i, j, middle[0], middle[1])
    arm_a, arm_b, apart = end[0]
    change = cross(_spin_change(substep_bodies[j], body_parameters[j]), arm_b)
    change = sub(change, cross(_spin_change(substep_bodies[i], body_parameters[i]), add(arm_a, apart)))
    return rate + 0.5 * h * dot(end[1], change)


@njit
def _spin_change(substep_body: Any, parameters: Any) -> Vec:
    return in_world(substep_body, spin_change(substep_body, parameters))
