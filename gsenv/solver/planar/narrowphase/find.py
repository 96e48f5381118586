"""Contacts of one pair of shapes."""

from __future__ import annotations

from typing import Any

from ...core.detection import TOUCHING, any_jointed, with_motion
from ...core.faces import opposite_face
from ...core.geometry import BASE_MARGIN, MEET, MovingShape, PlacedShape
from ...jit import inline_njit, njit
from ...records.model import Array
from ..geometry import pose_in
from ..kinds import BOX, TERRAIN
from ..math import relative, rotate, to_world, unrotate
from .boxes import REFERENCE_BIAS, box_of, reference_face, smaller_extent
from .chains import chain_near, mover_of
from .manifold import Manifold
from .motion import velocity_of
from .polygons import outline_of
from .predict import predict
from .table import CHAINS, PAIR_TABLE, PLANES, collide
from .terrains import Tally, terrain_contacts


@njit
def pair_contacts(world: Any, one: PlacedShape, other: PlacedShape, extent: float, margin: float, count: int) -> int:
    """Write the contacts of a pair from entry `count` of `world.scratch.found` on; returns the new count."""
    shapes = world.shapes
    routine = PAIR_TABLE[shapes.models[one.number].kind, shapes.models[other.number].kind]
    if routine == CHAINS:
        return find_chain_contacts(world, shapes.vertices, one, other, margin, count)
    m = collide(shapes, shapes.vertices, one, other, margin)
    if not m.separation <= margin:
        return count
    lift = 0.0
    miss = 0.0
    if m.separation > BASE_MARGIN * extent or (m.points == 0 and m.separation > 0.0):  # a future contact
        if routine == PLANES:
            lift = 0.5  # to the surface of the body, for the lever arm of friction
        else:
            miss, m = look_ahead(world, one, other, m, margin, extent)
    return write_points(m, lift, miss, world.scratch.found, count)


@inline_njit
def is_shallow(world: Any, a: int, b: int, depth: float) -> bool:
    """Whether two boxes overlap by less than the depth in m; False for others, of which only ``collide`` can tell."""
    models = world.shapes.models
    if models[a].kind != BOX or models[b].kind != BOX:
        return False
    one = box_of(world.shapes.parameters[a])
    other = box_of(world.shapes.parameters[b])
    geometry = world.scratch.geometry
    bias = REFERENCE_BIAS * smaller_extent(one, other)
    separation, _, _ = reference_face(pose_in(geometry[a]), one, pose_in(geometry[b]), other, bias)
    return separation - one.radius - other.radius > -depth


@njit
def look_ahead(
    world: Any, one: PlacedShape, other: PlacedShape, now: Manifold, margin: float, extent: float
) -> tuple[float, Manifold]:
    """Return the manifold at the time of contact, and the distance in m by which the shapes miss.

    Where joints affect paths and free flight misses, it is the present manifold. Other pairs that miss get
    the manifold at the time when this is known, since impacts of others may change their paths.
    """
    a = with_motion(world, one)
    b = with_motion(world, other)
    outcome, miss, ahead = predict(world.shapes, a, b, now, world.options.timestep, margin, TOUCHING * extent)
    if not any_jointed(world, one, other):
        return miss, ahead
    return 0.0, ahead if outcome == MEET and ahead.points > 0 else now


@njit
def write_points(m: Manifold, lift: float, miss: float, contacts: Array, count: int) -> int:
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
            contact.miss_distance = miss
            contact.face = m.face
            contact.core_distance = m.rounding + (0.5 - lift) * contact.separation
        count += 1
    return count


@njit
def find_chain_contacts(
    world: Any, vertices: Array | None, one: PlacedShape, other: PlacedShape, margin: float, count: int
) -> int:
    """Find the contacts of a pair with a terrain, with normals from `one` to `other`."""
    if vertices is None:
        return count
    flip = world.shapes.models[other.number].kind == TERRAIN
    terrain = with_motion(world, other if flip else one)
    shape = with_motion(world, one if flip else other)
    contacts = world.scratch.found
    tally = chain_contacts(world.shapes, vertices, terrain, shape, margin, world.options.timestep, contacts, count)
    pose = terrain.pose
    for k in range(count, min(tally.total, len(contacts))):
        contact = contacts[k]
        contact.miss_distance = 0.0
        if flip:
            contact.face = opposite_face(contact.face)
        contact.point[0], contact.point[1] = to_world(pose, contact.point[0], contact.point[1])
        nx, ny = rotate(pose.cos, pose.sin, contact.normal[0], contact.normal[1])
        contact.normal[0] = -nx if flip else nx
        contact.normal[1] = -ny if flip else ny
    return tally.total


@njit
def chain_contacts(
    shapes: Any,
    vertices: Array,
    terrain: MovingShape,
    shape: MovingShape,
    margin: float,
    horizon: float,
    contacts: Array,
    count: int,
) -> Tally:
    """Find these contacts for the next `horizon` s in the terrain's frame, with normals out of the terrain."""
    outline = outline_of(shapes.models[shape.number], shapes.parameters[shape.number])
    frame = terrain.pose
    ux, uy = velocity_of(shape.motion, shape.pose.x, shape.pose.y, 0.0)
    wx, wy = velocity_of(terrain.motion, shape.pose.x, shape.pose.y, 0.0)
    ux, uy = unrotate(frame.cos, frame.sin, ux - wx, uy - wy)
    velocity = (ux, uy, shape.motion.spin - terrain.motion.spin)
    mover = mover_of(outline, vertices, relative(frame, shape.pose), velocity, horizon, margin)
    chain = chain_near(shapes.models[terrain.number], vertices, mover)
    return terrain_contacts(chain, mover, vertices, contacts, count)
