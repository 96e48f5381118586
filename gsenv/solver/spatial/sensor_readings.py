"""Readings of 3D sensors, as arrays over the worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..records.model import Array, Model
from ..records.sensors import CONTACT, POSE, VELOCITY
from .initial_state import multiplied, turned_by
from .joint_readings import coordinate, rate

if TYPE_CHECKING:
    from ..records.parameters import ParameterArrays
    from ..records.state import State


def read_into(
    out: Array, model: Model, parameters: ParameterArrays, state: State, timestep: float, sensors: Array
) -> None:
    """Fill ``out`` (world, number) with the readings of ``sensors``, in columns.

    pose: position m and quaternion of the body's own frame; velocity: m/s of its centre of mass and
    rad/s; contact: touching (0 or 1) and the mean force on it over the step, N; joint: coordinate and rate, where it
    has one, mean force N and torque N m on body_b at its anchor.
    """
    for sensor in sensors:
        first = int(sensor["column"] - sensors[0]["column"])
        reading = out[:, first : first + int(sensor["count"])]
        body = int(sensor["body"])
        if sensor["kind"] == POSE:
            q = state.bodies["rotation"][:, body]
            reading[:, :3] = state.bodies["position"][:, body]
            reading[:, :3] -= turned_by(q, parameters.bodies["center"][:, body])
            reading[:, 3:] = q
        elif sensor["kind"] == VELOCITY:
            reading[:] = state.bodies["velocity"][:, body]
        elif sensor["kind"] == CONTACT:
            reading[:] = contact_forces(state, body, timestep)
        else:
            j = int(sensor["joint"])
            if sensor["count"] > 6:
                reading[:, 0] = coordinate(model, parameters, state, j)
                reading[:, 1] = rate(model, parameters, state, j)
            reaction = state.joints["reaction"]
            reading[:, -6:] = (reaction[:, j] + reaction[:, model.parts_of(j)].sum(1)) / timestep


def contact_forces(state: State, body: int, timestep: float) -> Array:
    """Return (world, 4): whether a body touches something, and the mean force on it over the last step, N."""
    contacts = state.contacts
    used = np.arange(contacts.shape[1]) < state.worlds["contact_count"][:, None]
    sign = used * ((contacts["body_b"] == body).astype(float) - (contacts["body_a"] == body))
    impulse = contacts["total_impulse"]
    touches = (sign != 0.0) & ((impulse[..., 0] > 0.0) | (contacts["separation"] <= 0.0))
    force = (sign[..., None] * contact_impulses(contacts)).sum(1) / timestep
    return np.concatenate([touches.any(1)[:, None].astype(float), force], 1)


def contact_impulses(contacts: Array) -> Array:
    """Return the total linear impulse on body b, (..., 3) N s."""
    n = contacts["normal"]
    t, s = tangents_of(n)
    p = contacts["total_impulse"]
    return np.asarray(p[..., 0:1] * n + p[..., 1:2] * t + p[..., 2:3] * s)


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


# ---------------------------------------------------------------- arrays of bodies and contacts


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
