"""What sensors of bodies and joints in space read, as arrays over the worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..model import Array
from .authored import turned_by

if TYPE_CHECKING:
    from ..world import World

POSE, VELOCITY, CONTACT = 0, 1, 2  # of sensors.SensorKind


def read_into(out: Array, world: World, sensors: Array) -> None:
    """Fill ``out`` (world, number) with the readings of ``sensors``, side by side.

    pose: position m and quaternion of the body's own frame; velocity: m/s of its centre of mass and
    rad/s; contact: touching (0 or 1) and the mean force on it over the step, N; joint: mean force N
    and torque N m on body_b at its anchor.
    """
    state = world.state
    for sensor in sensors:
        first = int(sensor["column"] - sensors[0]["column"])
        reading = out[:, first : first + int(sensor["count"])]
        body = int(sensor["body"])
        if sensor["kind"] == POSE:
            q = state.bodies["rotation"][:, body]
            reading[:, :3] = state.bodies["position"][:, body]
            reading[:, :3] -= turned_by(q, world.parameters.bodies["center"][:, body])
            reading[:, 3:] = q
        elif sensor["kind"] == VELOCITY:
            reading[:] = state.bodies["velocity"][:, body]
        elif sensor["kind"] == CONTACT:
            reading[:] = contact_forces(state, body, world.timestep)
        else:
            reading[:] = world.joint_reaction(int(sensor["joint"]))


def contact_forces(state: Any, body: int, timestep: float) -> Array:
    """(world, 4): whether a body touches something, and the mean force on it over the last step, N."""
    contacts = state.contacts
    used = np.arange(contacts.shape[1]) < state.worlds["contact_count"][:, None]
    sign = used * ((contacts["body_b"] == body).astype(float) - (contacts["body_a"] == body))
    impulse = contacts["total_impulse"]
    touches = (sign != 0.0) & ((impulse[..., 0] > 0.0) | (contacts["separation"] <= 0.0))
    force = (sign[..., None] * contact_impulses(contacts)).sum(1) / timestep
    return np.concatenate([touches.any(1)[:, None].astype(float), force], 1)


def contact_impulses(contacts: Array) -> Array:
    """(..., 3) N s of normal and tangents together, on body b."""
    n = contacts["normal"]
    t, s = tangents_of(n)
    p = contacts["total_impulse"]
    return np.asarray(p[..., 0:1] * n + p[..., 1:2] * t + p[..., 2:3] * s)


def tangents_of(n: Array) -> tuple[Array, Array]:
    """math.tangents of many normals (..., 3)."""
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
