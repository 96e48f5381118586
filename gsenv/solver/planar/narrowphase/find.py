"""Contacts of all pairs of one world."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.planar.geometry import BASE_MARGIN
from gsenv.solver.planar.math import Pose, relative, unrotate
from gsenv.solver.planar.narrowphase.manifold import Manifold
from gsenv.solver.planar.narrowphase.motion import Motion, motion_of, velocity_of
from gsenv.solver.planar.narrowphase.polygons import outline_of
from gsenv.solver.planar.narrowphase.predict import predict
from gsenv.solver.planar.narrowphase.table import CHAINS, NONE, PAIR_TABLE, PLANES, collide
from gsenv.solver.planar.narrowphase.terrains import Tally, chain_of, mover_of, terrain_contacts
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
    count = 0
    for p in range(pair_count):
        a = pairs[p].shape_a
        b = pairs[p].shape_b
        routine = PAIR_TABLE[shape_models[a].kind, shape_models[b].kind]
        if routine == NONE:
            continue
        body_a = shape_models[a].body
        body_b = shape_models[b].body
        motion_a = motion_of(
            bodies[body_a], body_parameters[body_a], body_models[body_a].kind, gravity, timestep
        )
        motion_b = motion_of(
            bodies[body_b], body_parameters[body_b], body_models[body_b].kind, gravity, timestep
        )
        extent = pair_extent(geometry, shape_models, shape_parameters, body_parameters, a, b)
        sensor = shape_models[a].sensor | shape_models[b].sensor
        margin = 0.0
        if sensor == 0:
            margin = pair_margin(bodies[body_a], bodies[body_b], geometry, a, b, extent, timestep)
        start = count
        if routine == CHAINS:
            if vertices is not None:
                count = find_chain_contacts(
                    shape_models, shape_parameters, vertices, geometry, a, b,
                    motion_a, motion_b, margin, timestep, contacts, count,
                )  # fmt: skip
        else:
            pose_a = pose_in(geometry[a])
            pose_b = pose_in(geometry[b])
            m = collide(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, margin)
            if not m.separation <= margin:
                continue
            time = 0.0
            to_come = m.separation > BASE_MARGIN * extent or (m.count == 0 and m.separation > 0.0)
            if to_come and routine != PLANES and sensor == 0:
                m, time = predict(
                    shape_models, shape_parameters, vertices, a, b, pose_a, pose_b,
                    motion_a, motion_b, m, margin, TOUCHING * extent, timestep,
                )  # fmt: skip
                if m.count > 0 and time > 0.0:
                    m = brought_back(
                        m, motion_a, motion_b, body_parameters[body_a].inv_mass,
                        body_parameters[body_b].inv_mass, time,
                    )  # fmt: skip
            count = write_manifold(contacts, count, m)
        for k in range(start, min(count, len(contacts))):
            label_contact(contacts[k], shape_models, shape_parameters, a, b, extent)
    return count


@njit
def pose_in(entry: Any) -> Pose:
    return Pose(entry.position[0], entry.position[1], entry.rotation[0], entry.rotation[1])


@njit
def pair_extent(
    geometry: Array,
    shape_models: Array,
    shape_parameters: Array,
    body_parameters: Array,
    a: int,
    b: int,
) -> float:
    """Length scale of a pair in m: the smaller extent of its dynamic bodies."""
    extent = np.inf
    if geometry[a].dynamic != 0:
        body_a = body_parameters[shape_models[a].body]
        extent = min(body_a.extent, shape_parameters[a].extent)
    if geometry[b].dynamic != 0:
        body_b = body_parameters[shape_models[b].body]
        extent = min(extent, body_b.extent, shape_parameters[b].extent)
    return extent


@njit
def pair_margin(
    body_a: Any, body_b: Any, geometry: Array, a: int, b: int, extent: float, timestep: float
) -> float:
    """Distance in m within which the two may touch in this step."""
    dx = body_b.velocity[0] - body_a.velocity[0]
    dy = body_b.velocity[1] - body_a.velocity[1]
    linear = timestep * np.sqrt(dx * dx + dy * dy)
    return BASE_MARGIN * extent + linear + geometry[a].reach + geometry[b].reach  # type: ignore[no-any-return]


@njit
def brought_back(
    m: Manifold, a: Motion, b: Motion, inv_mass_a: float, inv_mass_b: float, time: float
) -> Manifold:
    """A manifold of `time` s ahead, told for the present.

    Each separation grows by what is covered until then, so that the bound "normal velocity >=
    -separation / timestep" stops the bodies just where they meet.  The points move back with the
    lighter body, whose lever arm they must have.
    """
    weight = inv_mass_a / (inv_mass_a + inv_mass_b) if inv_mass_a + inv_mass_b > 0.0 else 0.5
    back_x = time * (weight * a.velocity_x + (1.0 - weight) * b.velocity_x)
    back_y = time * (weight * a.velocity_y + (1.0 - weight) * b.velocity_y)
    gap0 = time * closing_speed(m, a, b, m.x0, m.y0, time)
    gap1 = time * closing_speed(m, a, b, m.x1, m.y1, time)
    return Manifold(
        m.count, m.normal_x, m.normal_y, m.separation + gap0,
        m.x0 - back_x, m.y0 - back_y, m.separation0 + gap0, m.feature0,
        m.x1 - back_x, m.y1 - back_y, m.separation1 + gap1, m.feature1,
    )  # fmt: skip


@njit
def closing_speed(m: Manifold, a: Motion, b: Motion, x: float, y: float, time: float) -> float:
    ax, ay = velocity_of(a, x, y, time)
    bx, by = velocity_of(b, x, y, time)
    return m.normal_x * (ax - bx) + m.normal_y * (ay - by)


@njit
def write_manifold(contacts: Array, count: int, m: Manifold) -> int:
    if m.count > 0:
        if count < len(contacts):
            contact = contacts[count]
            write_point(contact, m, m.x0, m.y0, m.separation0, m.feature0)
        count += 1
    if m.count > 1:
        if count < len(contacts):
            contact = contacts[count]
            write_point(contact, m, m.x1, m.y1, m.separation1, m.feature1)
        count += 1
    return count


@njit
def write_point(
    contact: Any, m: Manifold, x: float, y: float, separation: float, feature: int
) -> None:
    contact.normal[0] = m.normal_x
    contact.normal[1] = m.normal_y
    contact.point[0] = x
    contact.point[1] = y
    contact.separation = separation
    contact.feature = feature


@njit
def label_contact(
    contact: Any, shape_models: Array, shape_parameters: Array, a: int, b: int, extent: float
) -> None:
    """What all points of a pair share: who, material, length scale; no impulse yet."""
    contact.shape_a = a
    contact.shape_b = b
    contact.body_a = shape_models[a].body
    contact.body_b = shape_models[b].body
    contact.sensor = shape_models[a].sensor | shape_models[b].sensor
    contact.friction = np.sqrt(shape_parameters[a].friction * shape_parameters[b].friction)
    contact.restitution = max(shape_parameters[a].restitution, shape_parameters[b].restitution)
    contact.extent = extent
    for axis in range(2):
        contact.impulse[axis] = 0.0
        contact.total_impulse[axis] = 0.0


@njit
def find_chain_contacts(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array,
    geometry: Array,
    a: int,
    b: int,
    motion_a: Motion,
    motion_b: Motion,
    margin: float,
    timestep: float,
    contacts: Array,
    count: int,
) -> int:
    """Contacts of a pair of which one is a terrain, normals from a to b."""
    if shape_models[a].kind == TERRAIN:
        tally = chain_contacts(
            shape_models, shape_parameters, vertices, a, b, pose_in(geometry[a]),
            pose_in(geometry[b]), motion_a, motion_b, margin, timestep, contacts, count,
        )  # fmt: skip
        return tally.count
    tally = chain_contacts(
        shape_models, shape_parameters, vertices, b, a, pose_in(geometry[b]),
        pose_in(geometry[a]), motion_b, motion_a, margin, timestep, contacts, count,
    )  # fmt: skip
    for k in range(count, min(tally.count, len(contacts))):
        for axis in range(2):
            contacts[k].normal[axis] = -contacts[k].normal[axis]
    return tally.count


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
    return terrain_contacts(
        chain_of(shape_models[terrain]), terrain_pose, outline, mover, vertices, contacts, count
    )
