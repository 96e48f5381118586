"""Contacts of one pair of shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.detection import TOUCHING, any_jointed, with_motion
from ...core.faces import opposite_face
from ...core.geometry import BASE_MARGIN, MISS, PlacedShape
from ...jit import inline_njit, njit
from ...records.model import Array
from ..geometry import pose_in
from ..kinds import BOX, CYLINDER, HEIGHTFIELD, PLANE, SPHERE
from ..math import dot, sub, unrotate, vec
from .boxes import FACE_BIAS, best_face
from .heightfields import heightfield_contacts
from .manifold import clear_manifold
from .predict import predict
from .table import FIELDS, PAIR_TABLE, collide


@njit
def pair_contacts(world: Any, one: PlacedShape, other: PlacedShape, extent: float, margin: float, count: int) -> int:
    """Write the contacts of a pair from entry `count` of `world.scratch.found` on; returns the new count."""
    shapes = world.shapes
    found = world.scratch.found
    narrowphase = world.scratch.narrowphase
    start = count
    miss = 0.0
    if PAIR_TABLE[shapes.models[one.number].kind, shapes.models[other.number].kind] == FIELDS:
        count = find_field_contacts(world, one, other, extent, margin, count, narrowphase.field)
    else:
        collide(shapes, one, other, margin, narrowphase)
        m = narrowphase.manifold
        if not m.separation <= margin:
            return count
        if m.separation > BASE_MARGIN * extent or (m.count == 0 and m.separation > 0.0):  # a future contact
            miss = look_ahead(world, one, other, margin, extent)
        count = write_points(m, found, count)
    for k in range(start, min(count, len(found))):
        found[k].miss_distance = miss
    return count


@inline_njit
def label_rolling(contact: Any, one: Any, other: Any) -> None:
    """Set the torsional and rolling friction of a contact of shapes with these parameters."""
    contact.torsional_friction = max(one.torsional_friction, other.torsional_friction)
    contact.rolling_friction = max(one.rolling_friction, other.rolling_friction)


@njit
def look_ahead(world: Any, one: PlacedShape, other: PlacedShape, margin: float, extent: float) -> float:
    """Replace the manifold by that at the time of contact; returns the distance in m by which the shapes miss.

    Where joints affect paths and free flight misses, the present manifold stays. Other pairs that miss get
    the manifold at the time when this is known, since impacts of others may change their paths.
    """
    shapes = world.shapes
    narrowphase = world.scratch.narrowphase
    a = with_motion(world, one)
    b = with_motion(world, other)
    outcome, miss = predict(shapes, a, b, world.options.timestep, margin, TOUCHING * extent, narrowphase)
    if not any_jointed(world, one, other):
        if outcome == MISS and narrowphase.manifold.separation == np.inf:
            clear_manifold(narrowphase.manifold)
        return miss
    if outcome == MISS:
        collide(shapes, one, other, margin, narrowphase)
    return 0.0


@inline_njit
def far_apart(world: Any, a: int, b: int, margin: float) -> bool:
    """Whether two spheres, or a plane and a solid, are beyond the margin; for others the boxes are sufficient."""
    models = world.shapes.models
    if models[a].kind == PLANE:
        return is_above(world, a, b, margin)
    if models[b].kind == PLANE:
        return is_above(world, b, a, margin)
    if models[a].kind != SPHERE or models[b].kind != SPHERE:
        return False
    parameters = world.shapes.parameters
    one = world.scratch.geometry[a]
    other = world.scratch.geometry[b]
    reach = parameters[a].radius + parameters[b].radius + margin
    square = 0.0
    for d in range(3):
        square += (one.position[d] - other.position[d]) ** 2
    return square > reach * reach


@inline_njit
def is_shallow(world: Any, a: int, b: int, depth: float) -> bool:
    """Whether two boxes overlap by less than the depth in m; False for others, of which only ``collide`` can tell."""
    models = world.shapes.models
    if models[a].kind != BOX or models[b].kind != BOX:
        return False
    parameters = world.shapes.parameters
    one, other = pose_in(world.scratch.geometry[a]), pose_in(world.scratch.geometry[b])
    x, y, z = unrotate(one, other.x), unrotate(one, other.y), unrotate(one, other.z)
    bias = FACE_BIAS * min(parameters[a].extent, parameters[b].extent)
    half, other_half = vec(parameters[a].size), vec(parameters[b].size)
    separation, _ = best_face(unrotate(one, sub(other.at, one.at)), x, y, z, half, other_half, bias)
    return separation > -depth


@inline_njit
def is_above(world: Any, plane: int, solid: int, margin: float) -> bool:
    """Whether the sphere around a solid is above a plane by more than the margin; hulls are not tested."""
    if world.shapes.models[solid].kind > CYLINDER:
        return False
    floor = world.scratch.geometry[plane]
    height = dot(pose_in(floor).z, sub(vec(world.scratch.geometry[solid].position), vec(floor.position)))
    size = world.shapes.parameters[solid].size
    return height > size[0] + size[1] + size[2] + world.shapes.parameters[solid].radius + margin


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
            contact.face = m.face
            contact.core_distance = m.rounding + 0.5 * m.gap[k]
        count += 1
    return count


@njit
def find_field_contacts(
    world: Any, one: PlacedShape, other: PlacedShape, extent: float, margin: float, count: int, scratch: Array | None
) -> int:
    """Find the contacts of a pair with a heightfield, normals from `one` to `other`; `scratch`: None without any.

    The margin contains how far the surface may move within the step, and so how far the shape may turn.
    """
    if scratch is None:
        return count
    contacts = world.scratch.found
    flip = world.shapes.models[other.number].kind == HEIGHTFIELD
    field = other if flip else one
    shape = one if flip else other
    start = count
    turn = max(margin / extent - BASE_MARGIN, 0.0)
    narrowphase = world.scratch.narrowphase
    count = heightfield_contacts(world.shapes, field, shape, margin, turn, contacts, count, narrowphase)
    if flip:
        for k in range(start, min(count, len(contacts))):
            contacts[k].face = opposite_face(contacts[k].face)
            for d in range(3):
                contacts[k].normal[d] = -contacts[k].normal[d]
    return count
