"""Bodies moved along their present motion."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...core.geometry import DYNAMIC, STATIC, swing_of
from ...jit import njit
from ..math import Pose, Vec, add, along, cross, dot, norm, scaled, sub, turn_of, turned, vec


class Motion(NamedTuple):
    """A body's centre of mass and velocity."""

    at: Vec  # m
    velocity: Vec  # m/s
    spin: Vec  # rad/s
    swing: float  # m/s per rad/s, largest speed of a support plane by rotation


@njit
def at_rest() -> Motion:
    zero = (0.0, 0.0, 0.0)
    return Motion(zero, zero, zero, 0.0)


@njit
def motion_of(body: Any, parameter: Any, kind: int, gravity: Any, timestep: float) -> Motion:
    """Return the motion at the end of the step, if nothing is hit."""
    zero = (0.0, 0.0, 0.0)
    if kind == STATIC:
        return Motion(vec(body.position), zero, zero, 0.0)
    velocity = vec(body.velocity)
    if kind == DYNAMIC:
        velocity = along(velocity, timestep * parameter.gravity_scale, vec(gravity))
        velocity = along(velocity, timestep * parameter.inv_mass, vec(body.force))
    spin = (body.velocity[3], body.velocity[4], body.velocity[5])
    return Motion(vec(body.position), velocity, spin, swing_of(parameter))


@njit
def spin_rate(motion: Motion) -> float:
    """Return the angular speed in rad/s."""
    return norm(motion.spin)


@njit
def advanced(pose: Pose, motion: Motion, time: float) -> Pose:
    """Return a pose on a moving body, `time` s later."""
    at = sub(pose.at, motion.at)
    x, y, z = pose.x, pose.y, pose.z
    w = motion.spin
    if w[0] != 0.0 or w[1] != 0.0 or w[2] != 0.0:
        q = turn_of(scaled(w, time))
        at = turned(q, at)
        x = turned(q, x)
        y = turned(q, y)
        z = turned(q, z)
    return Pose(add(along(motion.at, time, motion.velocity), at), x, y, z)


@njit
def velocity_of(motion: Motion, p: Vec, time: float) -> Vec:
    """Return the velocity in m/s of the material point that is at p after `time` s."""
    arm = sub(p, along(motion.at, time, motion.velocity))
    return add(motion.velocity, cross(motion.spin, arm))


@njit
def approach_speed(contact: Any, body_a: Any, body_b: Any) -> float:
    """Return the present speed in m/s at which two bodies approach each other at a contact."""
    point = vec(contact.point)
    return dot(vec(contact.normal), sub(point_velocity(body_a, point), point_velocity(body_b, point)))


@njit
def point_velocity(body: Any, point: Vec) -> Vec:
    """Return the velocity in m/s of a body's material point."""
    v = body.velocity
    return add((v[0], v[1], v[2]), cross((v[3], v[4], v[5]), sub(point, vec(body.position))))
