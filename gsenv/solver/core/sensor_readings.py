"""Readings of all sensors of all worlds except those of joints, in one call; the same for 2D and 3D."""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import int64
from numpy.typing import NDArray

from ..jit import njit
from ..records.sensors import ACCELERATION, CONTACT, CONTACT_FORCE, FRAME, POSE, RAYS, VELOCITY
from .dispatch import by_dimension
from .rays import cast_rays_in_world

Array = NDArray[Any]

read_pose = by_dimension("sensor_readings", "read_pose")
read_frame = by_dimension("sensor_readings", "read_frame")
read_acceleration = by_dimension("sensor_readings", "read_acceleration")
place_ray = by_dimension("sensor_readings", "place_ray")
contact_impulse = by_dimension("sensor_readings", "contact_impulse")
contact_moment = by_dimension("sensor_readings", "contact_moment")


class States(NamedTuple):
    """The input of sensors, with a world axis."""

    worlds: Any
    bodies: Any
    contacts: Any
    body_parameters: Any
    world_parameters: Any


@njit
def read_sensors(
    out: Array, timestep: float, sensors: Any, states: Any, motions: Any, directions: Any, seen: Any, fan: Any
) -> None:
    """Fill `out` (world, number) with the readings of `sensors`, in columns.

    `motions` is None in a scene without sensors of accelerations and contact forces, `seen` and `fan` are None
    in a scene without rays.
    """
    bodies = states.bodies
    body_parameters = states.body_parameters
    for w in range(len(bodies)):
        for s in range(len(sensors)):
            sensor = sensors[s]
            column = sensor.column - sensors[0].column
            reading = out[w, column : column + sensor.count]
            body = int64(sensor.body)
            if sensor.kind == POSE:
                read_pose(bodies[w, body], body_parameters[w, body], reading)
            elif sensor.kind == VELOCITY:
                for axis in range(len(reading)):  # a slice would take seconds to compile
                    reading[axis] = bodies[w, body].velocity[axis]
            elif sensor.kind == CONTACT:
                read_contact(states.contacts[w, : states.worlds[w].contact_count], body, timestep, reading)
            elif sensor.kind == FRAME:
                read_frame(bodies[w, body], body_parameters[w, body], sensor, reading)
            if motions is not None:
                if sensor.kind == ACCELERATION:
                    parameter = body_parameters[w, body]
                    world_parameter = states.world_parameters[w]
                    read_acceleration(motions[w, body], parameter, world_parameter, sensor, timestep, reading)
                elif sensor.kind == CONTACT_FORCE:
                    contacts = states.contacts[w, : states.worlds[w].contact_count]
                    read_contact_force(contacts, body, motions[w, body], timestep, reading)
            if seen is not None:
                if sensor.kind == RAYS:
                    rays = fan[: sensor.count]
                    place_rays(sensor, directions, bodies[w, body], body_parameters[w, body], rays)
                    cast_rays_in_world(seen, w, seen.vertices, sensor.mask, body, rays)
                    for r in range(len(rays)):
                        reading[r] = rays[r].distance


@njit
def sign_of(contact: Any, body: int) -> float:
    """Return the factor of a contact's impulses as they act on a body, 0 for contacts of others."""
    if contact.body_b == body:
        return 1.0
    return -1.0 if contact.body_a == body else 0.0


@njit
def read_contact(contacts: Array, body: int, timestep: float, reading: Array) -> None:
    """Write touching and the mean force over the step, as in Contacts.touching and Contacts.force_vector."""
    for k in range(len(contacts)):
        contact = contacts[k]
        sign = sign_of(contact, body)
        if sign == 0.0:
            continue
        if contact.total_impulse[0] > 0.0 or contact.separation <= 0.0:
            reading[0] = 1.0
        impulse = contact_impulse(contact)
        scale = sign / timestep
        for d in range(len(impulse)):
            reading[1 + d] += scale * impulse[d]


@njit
def read_contact_force(contacts: Array, body: int, motion: Any, timestep: float, reading: Array) -> None:
    """Write the mean over the step of force, torque about the centre of mass and normal forces, the last as a sum.

    The lever arms are those of the solver, from the centre of mass; they turn with the body within the step.
    """
    dim = len(motion.position)
    last = len(reading) - 1
    for k in range(len(contacts)):
        contact = contacts[k]
        sign = sign_of(contact, body)
        if sign == 0.0:
            continue
        scale = sign / timestep
        impulse = contact_impulse(contact)
        for d in range(dim):
            reading[d] += scale * impulse[d]
        moment = contact_moment(contact, motion, impulse, 1 if sign > 0.0 else 0)
        for d in range(len(moment)):
            reading[dim + d] += scale * moment[d]
        reading[last] += contact.total_impulse[0] / timestep


@njit
def place_rays(sensor: Any, directions: Array, body: Any, body_parameter: Any, rays: Array) -> None:
    """Place the rays of a sensor on its body."""
    for r in range(len(rays)):
        place_ray(body, body_parameter, sensor, directions[sensor.ray_first + r], rays[r])
        rays[r].distance = sensor.length
