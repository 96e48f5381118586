"""Readings of 2D sensors; core/sensor_readings.py calls them for all sensors of all worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..jit import njit
from ..records.model import Array, Model
from .joint_readings import coordinate, rate
from .math import rotate, unrotate

if TYPE_CHECKING:
    from ..records.parameters import ParameterArrays
    from ..records.state import State


def read_joint(
    reading: Array, model: Model, parameters: ParameterArrays, state: State, timestep: float, joint: int
) -> None:
    """Write coordinate, rate and mean reaction of a joint (world, 5)."""
    reading[:, 0] = coordinate(model, parameters, state, joint)
    reading[:, 1] = rate(model, parameters, state, joint)
    reading[:, 2:] = state.joints["reaction"][:, joint] / timestep


@njit
def _arm(rotation: Any, body_parameter: Any, x: float, y: float) -> tuple[float, float]:
    """Return the vector from the centre of mass to a point of the body's own frame, in world axes, m."""
    center = body_parameter.center
    return rotate(rotation[0], rotation[1], x - center[0], y - center[1])


@njit
def _speed(velocity: Any, arm: tuple[float, float]) -> tuple[float, float]:
    """Return the velocity of a point of the body, m/s."""
    return velocity[0] - velocity[2] * arm[1], velocity[1] + velocity[2] * arm[0]


@njit
def read_pose(body: Any, body_parameter: Any, reading: Array) -> None:
    arm = _arm(body.rotation, body_parameter, 0.0, 0.0)
    reading[0] = body.position[0] + arm[0]
    reading[1] = body.position[1] + arm[1]
    reading[2] = body.angle


@njit
def read_frame(body: Any, body_parameter: Any, sensor: Any, reading: Array) -> None:
    arm = _arm(body.rotation, body_parameter, sensor.local_position[0], sensor.local_position[1])
    speed = _speed(body.velocity, arm)
    reading[0] = body.position[0] + arm[0]
    reading[1] = body.position[1] + arm[1]
    reading[2] = body.rotation[0]
    reading[3] = body.rotation[1]
    reading[4], reading[5] = unrotate(body.rotation[0], body.rotation[1], speed[0], speed[1])
    reading[6] = body.velocity[2]


@njit
def read_acceleration(
    motion: Any, body_parameter: Any, world_parameter: Any, sensor: Any, timestep: float, reading: Array
) -> None:
    """Write the mean acceleration of the site over the step along the body's axes half-way, and the angular one."""
    x, y = sensor.local_position[0], sensor.local_position[1]
    old, new = motion.rotation, motion.end_rotation
    before = _speed(motion.velocity, _arm(old, body_parameter, x, y))
    after = _speed(motion.end_velocity, _arm(new, body_parameter, x, y))
    pull = body_parameter.gravity_scale if sensor.subtract_gravity != 0 else 0.0
    ax = (after[0] - before[0]) / timestep - pull * world_parameter.gravity[0]
    ay = (after[1] - before[1]) / timestep - pull * world_parameter.gravity[1]
    c, s = old[0] + new[0], old[1] + new[1]
    length = np.sqrt(c * c + s * s)
    if not length > 0.0:  # half a turn in one step
        c, s, length = new[0], new[1], 1.0
    reading[0], reading[1] = unrotate(c / length, s / length, ax, ay)
    reading[2] = (motion.end_velocity[2] - motion.velocity[2]) / timestep


@njit
def place_ray(body: Any, body_parameter: Any, sensor: Any, direction: Array, ray: Any) -> None:
    """Write origin and direction of a ray that is fixed to the site of a sensor."""
    arm = _arm(body.rotation, body_parameter, sensor.local_position[0], sensor.local_position[1])
    dx, dy = rotate(body.rotation[0], body.rotation[1], direction[0], direction[1])
    ray.origin[0] = body.position[0] + arm[0]
    ray.origin[1] = body.position[1] + arm[1]
    ray.direction[0] = dx
    ray.direction[1] = dy


@njit
def contact_impulse(contact: Any) -> tuple[float, float]:
    """Return the impulse on body b, N s, summed over the step."""
    n = contact.normal
    push = contact.total_impulse[0]
    drag = contact.total_impulse[1]
    return n[0] * push - n[1] * drag, n[1] * push + n[0] * drag


@njit
def contact_moment(contact: Any, motion: Any, impulse: tuple[float, float], side: int) -> tuple[float]:
    """Return the angular impulse on body b about the centre of mass of a body's motion, N m s; ``side``: 0 of a."""
    x = contact.point[0] - motion.position[0]
    y = contact.point[1] - motion.position[1]
    return (x * impulse[1] - y * impulse[0] + contact.moments[side, 0],)


# ---------------------------------------------------------------- arrays of bodies and contacts


def turning(parameters: Array, bodies: Array, dynamic: Array) -> tuple[Array, Array]:
    """Return (world, body) twice the rotational energy, J, and the angular momentum about the centre of mass, N m s."""
    spin = np.where(dynamic, parameters["inertia"], 0.0) * bodies["velocity"][..., 2]
    return spin * bodies["velocity"][..., 2], spin


def orbital(position: Array, linear: Array) -> Array:
    """Return the angular momentum about the origin, N m s, of momenta (..., 2) at positions (..., 2)."""
    return np.asarray(position[..., 0] * linear[..., 1] - position[..., 1] * linear[..., 0])


def contact_force(normal: Array, impulse: Array) -> Array:
    """Return the total impulse on body b, (contact, 2) N s."""
    t = np.stack([-normal[:, 1], normal[:, 0]], -1)
    return np.asarray(normal * impulse[:, :1] + t * impulse[:, 1:2])
