"""Bodies moved ahead in time along their present motion."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gsenv.solver.jit import njit
from gsenv.solver.planar.geometry import DYNAMIC, STATIC
from gsenv.solver.planar.math import Pose, rotate
from gsenv.solver.trig import sin_cos


class Motion(NamedTuple):
    """A body's centre of mass and velocity."""

    x: float  # m
    y: float
    velocity_x: float  # m/s
    velocity_y: float
    spin: float  # rad/s
    swing: float  # m: spin moves a support plane of the body at most so fast, per rad/s


@njit
def motion_of(body: Any, parameter: Any, kind: int, gravity: Any, timestep: float) -> Motion:
    """Velocity as it will be at the end of the step, if nothing is hit."""
    x = body.position[0]
    y = body.position[1]
    if kind == STATIC:
        return Motion(x, y, 0.0, 0.0, 0.0, 0.0)
    vx = body.velocity[0]
    vy = body.velocity[1]
    if kind == DYNAMIC:
        vx += timestep * (parameter.gravity_scale * gravity[0] + parameter.inv_mass * body.force[0])
        vy += timestep * (parameter.gravity_scale * gravity[1] + parameter.inv_mass * body.force[1])
    spare = parameter.radius * parameter.radius - parameter.extent * parameter.extent
    return Motion(x, y, vx, vy, body.velocity[2], np.sqrt(max(spare, 0.0)))


@njit
def advanced(pose: Pose, motion: Motion, time: float) -> Pose:
    """A pose on a moving body, `time` s later."""
    x = pose.x - motion.x
    y = pose.y - motion.y
    cos = pose.cos
    sin = pose.sin
    if motion.spin != 0.0:
        c, s = sin_cos(motion.spin * time)
        x, y = rotate(c, s, x, y)
        cos, sin = rotate(c, s, cos, sin)
    return Pose(
        motion.x + motion.velocity_x * time + x, motion.y + motion.velocity_y * time + y, cos, sin
    )


@njit
def velocity_of(motion: Motion, x: float, y: float, time: float) -> tuple[float, float]:
    """Velocity in m/s of the material point that is at (x, y) after `time` s."""
    return (
        motion.velocity_x - motion.spin * (y - motion.y - motion.velocity_y * time),
        motion.velocity_y + motion.spin * (x - motion.x - motion.velocity_x * time),
    )
