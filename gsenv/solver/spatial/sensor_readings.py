"""Readings of 3D sensors; core/sensor_readings.py calls them for all sensors of all worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..jit import njit
from ..records.model import Array, Model
from .initial_state import multiplied, turned_by
from .joint_readings import coordinate, rate
from .math import (
    Quaternion,
    Vec,
    add,
    along,
    conjugate,
    cross,
    normalised,
    quaternion,
    scaled,
    sub,
    tangents,
    turned,
    vec,
)

if TYPE_CHECKING:
    from ..records.parameters import ParameterArrays
    from ..records.state import State


def read_joint(
    reading: Array, model: Model, parameters: ParameterArrays, state: State, timestep: float, joint: int
) -> None:
    """Write coordinate and rate of a joint, where it has one, and its mean force N and torque N m at body_b's anchor.

    reading: (world, 8), or (world, 6) of a joint without a coordinate.
    """
    if reading.shape[1] > 6:
        reading[:, 0] = coordinate(model, parameters, state, joint)
        reading[:, 1] = rate(model, parameters, state, joint)
    reaction = state.joints["reaction"]
    reading[:, -6:] = (reaction[:, joint] + reaction[:, model.parts_of(joint)].sum(1)) / timestep


@njit
def _arm(rotation: Quaternion, body_parameter: Any, site: Vec) -> Vec:
    """Return the vector from the centre of mass to a point of the body's own frame, in world axes, m."""
    return turned(rotation, sub(site, vec(body_parameter.center)))


@njit
def _spin(velocity: Any) -> Vec:
    return velocity[3], velocity[4], velocity[5]


@njit
def _speed(velocity: Any, arm: Vec) -> Vec:
    """Return the velocity of a point of the body, m/s."""
    return add(vec(velocity), cross(_spin(velocity), arm))


@njit
def _write(reading: Array, first: int, v: Vec) -> None:
    for d in range(3):
        reading[first + d] = v[d]


@njit
def read_pose(body: Any, body_parameter: Any, reading: Array) -> None:
    arm = _arm(quaternion(body.rotation), body_parameter, (0.0, 0.0, 0.0))
    _write(reading, 0, add(vec(body.position), arm))
    for d in range(4):
        reading[3 + d] = body.rotation[d]


@njit
def read_frame(body: Any, body_parameter: Any, sensor: Any, reading: Array) -> None:
    q = quaternion(body.rotation)
    arm = _arm(q, body_parameter, vec(sensor.local_position))
    back = conjugate(q)
    _write(reading, 0, add(vec(body.position), arm))
    for d in range(4):
        reading[3 + d] = body.rotation[d]
    _write(reading, 7, turned(back, _speed(body.velocity, arm)))
    _write(reading, 10, turned(back, _spin(body.velocity)))


@njit
def _half_way(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the rotation half-way between two."""
    if p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3] < 0.0:
        p = (-p[0], -p[1], -p[2], -p[3])
    return normalised((p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]))


@njit
def read_acceleration(
    motion: Any, body_parameter: Any, world_parameter: Any, sensor: Any, timestep: float, reading: Array
) -> None:
    """Write the mean acceleration of the site over the step along the body's axes half-way, and the angular one."""
    site = vec(sensor.local_position)
    old, new = quaternion(motion.rotation), quaternion(motion.end_rotation)
    before = _speed(motion.velocity, _arm(old, body_parameter, site))
    after = _speed(motion.end_velocity, _arm(new, body_parameter, site))
    pull = body_parameter.gravity_scale if sensor.subtract_gravity != 0 else 0.0
    mean = along(scaled(sub(after, before), 1.0 / timestep), -pull, vec(world_parameter.gravity))
    turn = scaled(sub(_spin(motion.end_velocity), _spin(motion.velocity)), 1.0 / timestep)
    back = conjugate(_half_way(old, new))
    _write(reading, 0, turned(back, mean))
    _write(reading, 3, turned(back, turn))


@njit
def place_ray(body: Any, body_parameter: Any, sensor: Any, direction: Array, ray: Any) -> None:
    """Write origin and direction of a ray that is fixed to the site of a sensor."""
    q = quaternion(body.rotation)
    _write(ray.origin, 0, add(vec(body.position), _arm(q, body_parameter, vec(sensor.local_position))))
    _write(ray.direction, 0, turned(q, vec(direction)))


@njit
def contact_impulse(contact: Any) -> Vec:
    """Return the impulse on body b, N s, summed over the step."""
    n = vec(contact.normal)
    t, s = tangents(n)
    p = contact.total_impulse
    return along(along(scaled(n, p[0]), p[1], t), p[2], s)


@njit
def contact_moment(contact: Any, motion: Any, impulse: Vec, side: int) -> Vec:
    """Return the angular impulse on body b about the centre of mass of a body's motion, N m s; ``side``: 0 of a.

    Torsional and rolling friction add torques of their own.
    """
    n = vec(contact.normal)
    t, s = tangents(n)
    p = contact.total_impulse
    own = along(along(scaled(n, p[3]), p[4], t), p[5], s)
    beyond = contact.moments[side]
    own = add(own, (beyond[0], beyond[1], beyond[2]))
    return add(cross(sub(vec(contact.point), vec(motion.position)), impulse), own)


# ---------------------------------------------------------------- arrays of bodies and contacts


def tangents_of(n: Array) -> tuple[Array, Array]:
    """Return math.tangents of many normals (..., 3)."""
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    steep = abs(z) > 0.62
    t = np.where(
        steep[..., None],
        np.stack([1.0 - x * x, -x * y, -x * z], -1),
        np.stack([-y, x, np.zeros_like(x)], -1),
    )
    length = np.sqrt((t * t).sum(-1, keepdims=True))
    t = t / np.where(length > 0.0, length, 1.0)
    return t, np.cross(n, t)


def turning(parameters: Array, bodies: Array, dynamic: Array) -> tuple[Array, Array]:
    """Return (world, body) twice the rotational energy, J, and (.., 3) angular momentum about the centre, N m s."""
    axes = multiplied(bodies["rotation"], parameters["axes"])
    own = turned_by(axes * np.array([1.0, -1.0, -1.0, -1.0]), bodies["velocity"][..., 3:])
    spin = np.where(dynamic[..., None], parameters["inertia"], 0.0) * own
    return (spin * own).sum(-1), turned_by(axes, spin)


def orbital(position: Array, linear: Array) -> Array:
    """Return the angular momentum about the origin, N m s, of momenta (..., 3) at positions (..., 3)."""
    return np.cross(position, linear)


def contact_force(normal: Array, impulse: Array) -> Array:
    """Return the total impulse on body b, (contact, 3) N s."""
    t, s = tangents_of(normal)
    return np.asarray(normal * impulse[:, :1] + t * impulse[:, 1:2] + s * impulse[:, 2:3])
