"""Contacts of all pairs of one world."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import inline_njit, njit
from gsenv.solver.spatial.geometry import BASE_MARGIN
from gsenv.solver.spatial.kinds import HEIGHTFIELD, SPHERE
from gsenv.solver.spatial.math import Pose, norm, pose_of, quaternion, sub, vec
from gsenv.solver.spatial.narrowphase.heightfields import heightfield_contacts
from gsenv.solver.spatial.narrowphase.manifold import clear_manifold
from gsenv.solver.spatial.narrowphase.predict import MISS, predict
from gsenv.solver.spatial.narrowphase.table import FIELDS, PAIR_TABLE, collide

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
    manifolds: Array,
    scratches: Array,
    field_scratch: Array | None,
    convex: Any,
) -> int:
    """Fill `contacts` for the first `pair_count` pairs, sorted as they are; returns how many.

    As planar/narrowphase/find.py; `manifolds`, `scratches` (1,) are scratch; `field_scratch`: None in a scene
    without heightfields, `convex` in one without cylinders and hulls.
    """
    count = int64(0)  # not a literal: callees would be compiled for that as well
    m = manifolds[0]
    scratch = scratches[0]
    for p in range(pair_count):
        a = int64(pairs[p].shape_a)
        b = int64(pairs[p].shape_b)
        routine = PAIR_TABLE[shape_models[a].kind, shape_models[b].kind]
        extent, margin = pair_scale(
            geometry[a], geometry[b], bodies[shape_models[a].body], bodies[shape_models[b].body],
            shape_models[a].sensor | shape_models[b].sensor, timestep,
        )  # fmt: skip
        if far_apart(
            geometry[a], geometry[b], shape_models[a], shape_models[b], shape_parameters[a], shape_parameters[b], margin
        ):
            continue
        start = count
        miss = 0.0
        if routine == FIELDS:
            if field_scratch is not None:
                count = find_field_contacts(
                    shape_models, shape_parameters, vertices, geometry, a, b, margin, contacts, count, m, field_scratch
                )
        else:
            pose_a = pose_in(geometry[a])
            pose_b = pose_in(geometry[b])
            collide(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, margin, m, scratch, convex)
            if not m.separation <= margin:
                continue
            if m.separation > BASE_MARGIN * extent or (m.count == 0 and m.separation > 0.0):
                miss = look_ahead(
                    bodies, body_models, body_parameters, shape_models, shape_parameters, vertices, a, b, pose_a,
                    pose_b, gravity, timestep, margin, extent, m, scratch, convex,
                )  # fmt: skip
            count = write_points(m, contacts, count)
        for k in range(start, min(count, len(contacts))):
            contacts[k].miss = miss
            label_contact(
                contacts[k], shape_models[a], shape_models[b], shape_parameters[a], shape_parameters[b], a, b, extent
            )
    return count


@njit
def look_ahead(
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    gravity: Array,
    timestep: float,
    margin: float,
    extent: float,
    m: Any,
    scratch: Any,
    convex: Any,
) -> float:
    """A manifold to come becomes that of the moment of contact; returns by how many m the two miss each other.

    Where joints bend paths, free flight may miss: then the present manifold stays. All others that miss
    have that of the moment when they do, for impacts of others may bend their paths.
    """
    outcome, miss = predict(
        bodies, body_models, body_parameters, shape_models, shape_parameters, vertices, a, b, pose_a, pose_b,
        gravity, timestep, margin, TOUCHING * extent, m, scratch, convex,
    )  # fmt: skip
    if body_models[shape_models[a].body].jointed | body_models[shape_models[b].body].jointed == 0:
        if outcome == MISS and m.separation == np.inf:
            clear_manifold(m)
        return miss
    if outcome == MISS:
        collide(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, margin, m, scratch, convex)
    return 0.0


@inline_njit
def far_apart(one: Any, other: Any, model_a: Any, model_b: Any, a: Any, b: Any, margin: float) -> bool:
    """Whether two balls are beyond the margin; of other shapes the boxes alone have said what they could."""
    if model_a.kind != SPHERE or model_b.kind != SPHERE:
        return False
    reach = a.radius + b.radius + margin
    square = 0.0
    for d in range(3):
        square += (one.position[d] - other.position[d]) ** 2
    return square > reach * reach


@njit
def write_points(m: Any, contacts: Array, count: int) -> int:
    for k in range(m.count):
        if count < len(contacts):
            contact = contacts[count]
            for d in range(3):
                contact.normal[d] = m.normal[d]
                contact.point[d] = m.point[k, d]
            contact.separation = m.gap[k]
            contact.feature = m.feature[k]
        count += 1
    return count


@njit
def pose_in(entry: Any) -> Pose:
    return pose_of(vec(entry.position), quaternion(entry.rotation))


@inline_njit
def pair_scale(
    one: Any, other: Any, body_a: Any, body_b: Any, sensor: int, timestep: float
) -> tuple[float, float]:
    """(extent, margin) of a pair in m; see planar/narrowphase/find.py; together: an impact may turn either's way."""
    extent = min(one.extent, other.extent)
    if sensor != 0:
        return extent, 0.0
    va = vec(body_a.velocity)
    vb = vec(body_b.velocity)
    together = min(timestep * (norm(va) + norm(vb)), extent)
    speed = norm(sub(vb, va))
    return extent, BASE_MARGIN * extent + max(timestep * speed, together) + one.reach + other.reach


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
    contact.torsional_friction = max(one.torsional_friction, other.torsional_friction)
    contact.rolling_friction = max(one.rolling_friction, other.rolling_friction)
    contact.restitution = max(one.restitution, other.restitution)
    contact.extent = extent
    for k in range(len(contact.impulse)):
        contact.impulse[k] = 0.0
        contact.total_impulse[k] = 0.0


@njit
def find_field_contacts(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    geometry: Array,
    a: int,
    b: int,
    margin: float,
    contacts: Array,
    count: int,
    m: Any,
    scratch: Array,
) -> int:
    """Contacts of a pair of which one is a heightfield, normals from a to b."""
    field = a
    shape = b
    if shape_models[b].kind == HEIGHTFIELD:
        field = b
        shape = a
    start = count
    count = heightfield_contacts(
        shape_models, shape_parameters, vertices, field, shape, pose_in(geometry[field]), pose_in(geometry[shape]),
        margin, contacts, count, m, scratch,
    )  # fmt: skip
    if field == b:
        for k in range(start, min(count, len(contacts))):
            for d in range(3):
                contacts[k].normal[d] = -contacts[k].normal[d]
    return count
