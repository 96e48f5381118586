"""Readings of 2D sensors: one jitted call for all sensors of all worlds except those of joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import int64

from ..jit import njit
from ..records.model import Array, Model
from ..records.plain import as_records
from ..records.sensors import CONTACT, FRAME, JOINT, POSE, RAYS, VELOCITY
from . import rays
from .joint_readings import coordinate, rate
from .math import rotate, unrotate

if TYPE_CHECKING:
    from ..records.parameters import ParameterArrays
    from ..records.state import State


def read_into(
    out: Array, model: Model, parameters: ParameterArrays, state: State, timestep: float, sensors: Array
) -> None:
    """Fill ``out`` (world, number) with the readings of ``sensors``, in columns."""
    seen = fan = None
    if len(model.sensor_rays):
        seen = rays.surroundings(model, parameters, state)
        fan = np.zeros(int(sensors["count"].max()), rays.RAY_DTYPE)
    arrays = (state.worlds, state.bodies, state.contacts, parameters.bodies)
    states = States(*(as_records(array) for array in arrays))
    _read(out, timestep, as_records(sensors), states, model.sensor_rays, seen, as_records(fan))
    for sensor in sensors[sensors["kind"] == JOINT]:
        column, j = sensor["column"] - sensors[0]["column"], int(sensor["joint"])
        reading = out[:, column : column + sensor["count"]]
        reading[:, 0] = coordinate(model, parameters, state, j)
        reading[:, 1] = rate(model, parameters, state, j)
        reading[:, 2:] = state.joints["reaction"][:, j] / timestep


class States(NamedTuple):
    """The input of sensors other than rays, with a world axis."""

    worlds: Any
    bodies: Any
    contacts: Any
    body_parameters: Any


@njit
def _read(out: Array, timestep: float, sensors: Any, states: Any, directions: Any, seen: Any, fan: Any) -> None:
    """Fill `out` (world, number); `seen` and `fan` are None in a scene without rays."""
    bodies = states.bodies
    body_parameters = states.body_parameters
    for w in range(len(bodies)):
        for s in range(len(sensors)):
            sensor = sensors[s]
            column = sensor.column - sensors[0].column
            reading = out[w, column : column + sensor.count]
            body = int64(sensor.body)
            if sensor.kind == POSE:
                _read_pose(bodies[w, body], body_parameters[w, body], reading)
            elif sensor.kind == VELOCITY:
                for axis in range(3):  # a slice would take seconds to compile
                    reading[axis] = bodies[w, body].velocity[axis]
            elif sensor.kind == CONTACT:
                count = states.worlds[w].contact_count
                _read_contact(states.contacts[w, :count], body, timestep, reading)
            elif sensor.kind == FRAME:
                _read_frame(bodies[w, body], body_parameters[w, body], sensor, reading)
            elif seen is not None:
                if sensor.kind == RAYS:
                    part = fan[: sensor.count]
                    _place_rays(sensor, directions, bodies[w, body], body_parameters[w, body], part)
                    rays.cast_rays_in_world(seen, w, seen.vertices, sensor.mask, body, part)
                    for r in range(len(part)):
                        reading[r] = part[r].distance


@njit
def _site(body: Any, body_parameter: Any, x: float, y: float) -> tuple[float, float]:
    """Return the vector from the centre of mass to a point of the body's own frame, in world axes, m."""
    center = body_parameter.center
    return rotate(body.rotation[0], body.rotation[1], x - center[0], y - center[1])


@njit
def _read_pose(body: Any, body_parameter: Any, reading: Array) -> None:
    x, y = _site(body, body_parameter, 0.0, 0.0)
    reading[0] = body.position[0] + x
    reading[1] = body.position[1] + y
    reading[2] = body.angle


@njit
def _read_contact(contacts: Array, body: int, timestep: float, reading: Array) -> None:
    """Write touching and the mean force over the step, as in Contacts.touching and Contacts.force_vector."""
    for k in range(len(contacts)):
        contact = contacts[k]
        if contact.body_b == body:
            scale = 1.0 / timestep
        elif contact.body_a == body:
            scale = -1.0 / timestep
        else:
            continue
        push = contact.total_impulse[0]
        drag = contact.total_impulse[1]
        if push > 0.0 or contact.separation <= 0.0:
            reading[0] = 1.0
        reading[1] += scale * (contact.normal[0] * push - contact.normal[1] * drag)
        reading[2] += scale * (contact.normal[1] * push + contact.normal[0] * drag)


@njit
def _read_frame(body: Any, body_parameter: Any, sensor: Any, reading: Array) -> None:
    x, y = _site(body, body_parameter, sensor.local_position[0], sensor.local_position[1])
    spin = body.velocity[2]
    vx = body.velocity[0] - spin * y
    vy = body.velocity[1] + spin * x
    reading[0] = body.position[0] + x
    reading[1] = body.position[1] + y
    reading[2] = body.rotation[0]
    reading[3] = body.rotation[1]
    reading[4], reading[5] = unrotate(body.rotation[0], body.rotation[1], vx, vy)
    reading[6] = spin


@njit
def _place_rays(sensor: Any, directions: Array, body: Any, body_parameter: Any, fan: Array) -> None:
    x, y = _site(body, body_parameter, sensor.local_position[0], sensor.local_position[1])
    for r in range(len(fan)):
        local = directions[sensor.ray_first + r]
        dx, dy = rotate(body.rotation[0], body.rotation[1], local[0], local[1])
        ray = fan[r]
        ray.origin[0] = body.position[0] + x
        ray.origin[1] = body.position[1] + y
        ray.direction[0] = dx
        ray.direction[1] = dy
        ray.distance = sensor.length


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
