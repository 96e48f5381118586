"""Contacts of all pairs of one world."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import inline_njit, njit
from gsenv.solver.planar.geometry import BASE_MARGIN
from gsenv.solver.planar.math import Pose, relative, unrotate
from gsenv.solver.planar.narrowphase.chains import chain_near, mover_of
from gsenv.solver.planar.narrowphase.motion import Motion, motion_of, velocity_of
from gsenv.solver.planar.narrowphase.polygons import outline_of
from gsenv.solver.planar.narrowphase.predict import predict
from gsenv.solver.planar.narrowphase.table import CHAINS, PAIR_TABLE, PLANES, collide
from gsenv.solver.planar.narrowphase.terrains import Tally, terrain_contacts
from gsenv.solver.planar.shapes import TERRAIN

Array = NDArray[Any]

TOUCHING = 0.005  # of the extent: a predicted pair this near is in contact


@njit
def find_contacts(
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    geometry: Array,
    pairs: Array,
    pair_count: int,
    gravity: Array,
    timestep: float,
    contacts: Array,
) -> int:
    """Fill `contacts` for the first `pair_count` pairs, sorted as they are; returns how many.

    `bodies`, `body_models`, `body_parameters` (body,); `shape_models`, `shape_parameters`,
    `geometry` (shape,); `vertices` (vertex,) or None in a scene without polygons and terrains;
    `pairs` (pair,); `gravity` (2,) m/s^2; `timestep` s; `contacts` (contact,).  If the result
    exceeds len(contacts), only the first ones were written.
    """
    count = int64(0)  # not a literal: callees would be compiled for that as well
    for p in range(pair_count):
        a = int64(pairs[p].shape_a)
        b = int64(pairs[p].shape_b)
        routine = PAIR_TABLE[shape_models[a].kind, shape_models[b].kind]
        extent, margin = pair_scale(
            geometry[a], geometry[b], bodies[shape_models[a].body], bodies[shape_models[b].body],
            shape_models[a].sensor | shape_models[b].sensor, timestep,
        )  # fmt: skip
        if routine == CHAINS:
            if vertices is not None:
                start = count
                count = find_chain_contacts(
                    bodies, body_models, body_parameters, shape_models, shape_parameters,
                    vertices, geometry, a, b, gravity, timestep, margin, contacts, count,
                )  # fmt: skip
                for k in range(start, min(count, len(contacts))):
                    label_contact(
                        contacts[k], shape_models[a], shape_models[b], shape_parameters[a], shape_parameters[b],
                        a, b, extent,
                    )  # fmt: skip
            continue
        pose_a = pose_in(geometry[a])
        pose_b = pose_in(geometry[b])
        m = collide(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, margin)
        if not m.separation <= margin:
            continue
        to_come = m.separation > BASE_MARGIN * extent or (m.points == 0 and m.separation > 0.0)
        if to_come and routine != PLANES:
            ahead = predict(
                bodies, body_models, body_parameters, shape_models, shape_parameters, vertices,
                a, b, pose_a, pose_b, m, gravity, timestep, margin, TOUCHING * extent,
            )  # fmt: skip
            jointed = body_models[shape_models[a].body].jointed | body_models[shape_models[b].body].jointed
            if ahead.points > 0 or jointed == 0:  # where joints bend paths, free flight may miss
                m = ahead
        lift = 0.5 if to_come and routine == PLANES else 0.0  # onto the body, whose lever arm friction has
        for k in range(m.points):
            if count < len(contacts):
                contact = contacts[count]
                contact.normal[0] = m.normal_x
                contact.normal[1] = m.normal_y
                contact.point[0] = m.x1 if k else m.x0
                contact.point[1] = m.y1 if k else m.y0
                contact.separation = m.separation1 if k else m.separation0
                contact.point[0] += lift * contact.separation * m.normal_x
                contact.point[1] += lift * contact.separation * m.normal_y
                contact.feature = m.feature1 if k else m.feature0
                label_contact(
                    contact, shape_models[a], shape_models[b], shape_parameters[a], shape_parameters[b],
                    a, b, extent,
                )  # fmt: skip
            count += 1
    return count


@inline_njit
def pose_in(entry: Any) -> Pose:
    return Pose(entry.position[0], entry.position[1], entry.rotation[0], entry.rotation[1])


@inline_njit
def pair_scale(
    one: Any, other: Any, body_a: Any, body_b: Any, sensor: int, timestep: float
) -> tuple[float, float]:
    """(extent, margin) of a pair in m, from the entries of its geometry and its bodies' states.

    The smaller extent of its dynamic bodies; and the distance within which the two may touch in
    this step.  Sensors see only what is there now.
    """
    extent = min(one.extent, other.extent)
    if sensor != 0:
        return extent, 0.0
    dx = body_b.velocity[0] - body_a.velocity[0]
    dy = body_b.velocity[1] - body_a.velocity[1]
    margin = BASE_MARGIN * extent + timestep * np.sqrt(dx * dx + dy * dy)
    return extent, margin + one.reach + other.reach


@inline_njit
def label_contact(
    contact: Any, model_a: Any, model_b: Any, one: Any, other: Any, a: int, b: int, extent: float
) -> None:
    """What all points of a pair share: who, material, length scale; no impulse yet.

    `one`, `other` are the parameters of shapes a and b.
    """
    contact.shape_a = a
    contact.shape_b = b
    contact.body_a = model_a.body
    contact.body_b = model_b.body
    contact.sensor = model_a.sensor | model_b.sensor
    contact.friction = np.sqrt(one.friction * other.friction)
    contact.restitution = max(one.restitution, other.restitution)
    contact.extent = extent
    for axis in range(2):
        contact.impulse[axis] = 0.0
        contact.total_impulse[axis] = 0.0


@njit
def find_chain_contacts(
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array,
    geometry: Array,
    a: int,
    b: int,
    gravity: Array,
    timestep: float,
    margin: float,
    contacts: Array,
    count: int,
) -> int:
    """Contacts of a pair of which one is a terrain, normals from a to b."""
    terrain = a
    shape = b
    if shape_models[b].kind == TERRAIN:
        terrain = b
        shape = a
    body = shape_models[terrain].body
    terrain_motion = motion_of(
        bodies[body], body_parameters[body], body_models[body].kind, gravity, timestep
    )
    body = shape_models[shape].body
    shape_motion = motion_of(
        bodies[body], body_parameters[body], body_models[body].kind, gravity, timestep
    )
    tally = chain_contacts(
        shape_models, shape_parameters, vertices, terrain, shape, pose_in(geometry[terrain]),
        pose_in(geometry[shape]), terrain_motion, shape_motion, margin, timestep, contacts, count,
    )  # fmt: skip
    if terrain == b:
        for k in range(count, min(tally.total, len(contacts))):
            for axis in range(2):
                contacts[k].normal[axis] = -contacts[k].normal[axis]
    return tally.total


@njit
def chain_contacts(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array,
    terrain: int,
    shape: int,
    terrain_pose: Pose,
    shape_pose: Pose,
    terrain_motion: Motion,
    shape_motion: Motion,
    margin: float,
    timestep: float,
    contacts: Array,
    count: int,
) -> Tally:
    """The same with the terrain first: everything is put into its frame."""
    outline = outline_of(shape_models[shape], shape_parameters[shape])
    ux, uy = velocity_of(shape_motion, shape_pose.x, shape_pose.y, 0.0)
    wx, wy = velocity_of(terrain_motion, shape_pose.x, shape_pose.y, 0.0)
    ux, uy = unrotate(terrain_pose.cos, terrain_pose.sin, ux - wx, uy - wy)
    velocity = (ux, uy, shape_motion.spin - terrain_motion.spin)
    mover = mover_of(
        outline, vertices, relative(terrain_pose, shape_pose), velocity, timestep, margin
    )
    chain = chain_near(shape_models[terrain], vertices, mover)
    return terrain_contacts(chain, terrain_pose, outline, mover, vertices, contacts, count)
