"""Bodies moved ahead in time along their present motion."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gsenv.solver.jit import njit
from gsenv.solver.spatial.geometry import DYNAMIC, STATIC
from gsenv.solver.spatial.math import Pose, Vec, add, along, cross, scaled, sub, turn_of, turned, vec


class Motion(NamedTuple):
    """A body's centre of mass and velocity."""

    at: Vec  # m
    velocity: Vec  # m/s
    spin: Vec  # rad/s
    swing: float  # m: spin moves a support plane of the body at most so fast, per rad/s


@njit
def at_rest() -> Motion:
    zero = (0.0, 0.0, 0.0)
    return Motion(zero, zero, zero, 0.0)


@njit
def swing_of(parameter: Any) -> float:
    spare = parameter.radius * parameter.radius - parameter.extent * parameter.extent
    return np.sqrt(max(spare, 0.0))


@njit
def motion_of(body: Any, parameter: Any, kind: int, gravity: Any, timestep: float) -> Motion:
    """Velocity as it will be at the end of the step, if nothing is hit."""
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
def advanced(pose: Pose, motion: Motion, time: float) -> Pose:
    """A pose on a moving body, `time` s later."""
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
    """Velocity in m/s of the material point that is at p after `time` s."""
    arm = sub(p, along(motion.at, time, motion.velocity))
    return add(motion.velocity, cross(motion.spin, arm))
