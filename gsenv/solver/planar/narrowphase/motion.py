"""Bodies moved along their present motion."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...core.geometry import DYNAMIC, STATIC, swing_of
from ...core.trig import sin_cos
from ...jit import njit
from ..math import Pose, rotate


class Motion(NamedTuple):
    """A body's centre of mass and velocity."""

    x: float  # m
    y: float
    velocity_x: float  # m/s
    velocity_y: float
    spin: float  # rad/s
    swing: float  # m/s per rad/s, largest speed of a support plane by rotation


@njit
def motion_of(body: Any, parameter: Any, kind: int, gravity: Any, timestep: float) -> Motion:
    """Return the motion at the end of the step, if nothing is hit."""
    x = body.position[0]
    y = body.position[1]
    if kind == STATIC:
        return Motion(x, y, 0.0, 0.0, 0.0, 0.0)
    vx = body.velocity[0]
    vy = body.velocity[1]
    if kind == DYNAMIC:
        vx += timestep * (parameter.gravity_scale * gravity[0] + parameter.inv_mass * body.force[0])
        vy += timestep * (parameter.gravity_scale * gravity[1] + parameter.inv_mass * body.force[1])
    return Motion(x, y, vx, vy, body.velocity[2], swing_of(parameter))


@njit
def spin_rate(motion: Motion) -> float:
    """Return the unsigned angular speed in rad/s."""
    return abs(motion.spin)


@njit
def advanced(pose: Pose, motion: Motion, time: float) -> Pose:
    """Return a pose on a moving body, `time` s later."""
    x = pose.x - motion.x
    y = pose.y - motion.y
    cos = pose.cos
    sin = pose.sin
    if motion.spin != 0.0:
        c, s = sin_cos(motion.spin * time)
        x, y = rotate(c, s, x, y)
        cos, sin = rotate(c, s, cos, sin)
    return Pose(motion.x + motion.velocity_x * time + x, motion.y + motion.velocity_y * time + y, cos, sin)


@njit
def velocity_of(motion: Motion, x: float, y: float, time: float) -> tuple[float, float]:
    """Return the velocity in m/s of the material point that is at (x, y) after `time` s."""
    return (
        motion.velocity_x - motion.spin * (y - motion.y - motion.velocity_y * time),
        motion.velocity_y + motion.spin * (x - motion.x - motion.velocity_x * time),
    )


@njit
def approach_speed(contact: Any, body_a: Any, body_b: Any) -> float:
    """Return the present speed in m/s at which two bodies approach each other at a contact."""
    x = contact.point[0]
    y = contact.point[1]
    a = body_a.velocity
    b = body_b.velocity
    ux = a[0] - a[2] * (y - body_a.position[1]) - b[0] + b[2] * (y - body_b.position[1])
    uy = a[1] + a[2] * (x - body_a.position[0]) - b[1] - b[2] * (x - body_b.position[0])
    return contact.normal[0] * ux + contact.normal[1] * uy
