"""Contacts of terrains with circles, capsules, boxes and polygons.

Two kinds of contact: a corner of the shape (a circle's only corner is its centre) on the chain, and a
ridge of the chain on an edge of the shape.  A direction counts only if the chain as a whole allows it
(between the normals of the two edges that meet at a ridge; straight up from an edge; nothing at a
valley or where the chain is straight), so nothing catches on inner vertices.  A corner in a valley
touches both sides.

A corner behind the chain is pushed out of the nearest edge only.  An edge that the centre of the shape
has passed by more than its extent has no contacts with it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from ...core.faces import FACE_OF_A, FACE_OF_B, NO_FACE
from ...jit import njit
from ..math import rotate, to_local, to_world
from ..vertices import CONVEX, LEAF_SEGMENTS, leaf_misses
from .chains import (
    Chain,
    Mover,
    along_edge,
    beyond_arc,
    height_over,
    lies_over,
    nearest_edge,
    time_to_close,
    velocity_at,
)
from .polygons import corner_of, edge_normal

Point = tuple[float, float]

FACING = 1e-3  # sine: an edge of the shape that faces the ground less is a side
TILT = 0.2  # sine: largest tilt of a face beyond the two edges of a ridge that supports it
FACE, POINT, RIDGE = 0, 1, 2  # kinds of feature


class Tally(NamedTuple):
    """The number of contacts so far and the nearest of them, in the chain's frame, normal out of the chain."""

    total: int
    separation: float
    normal_x: float
    normal_y: float


class Corner(NamedTuple):
    """A corner of the shape, in the chain's frame."""

    number: int
    x: float  # m
    y: float


@njit
def emit(
    contacts: Any, tally: Tally, point: Point, normal: Point, separation: float, feature: int, face: int, radius: float
) -> Tally:
    """Write a contact of the chain with a surface point; `point` is the midpoint.

    `face`: whose face has the normal; `radius`: m, rounding of the other's corner.
    """
    if tally.total < len(contacts):
        contact = contacts[tally.total]
        contact.point[0], contact.point[1] = point
        contact.normal[0], contact.normal[1] = normal
        contact.separation = separation
        contact.feature = feature
        contact.face = face
        contact.core_distance = radius + 0.5 * separation
    if separation < tally.separation:
        return Tally(tally.total + 1, separation, normal[0], normal[1])
    return Tally(tally.total + 1, tally.separation, tally.normal_x, tally.normal_y)


@njit
def emit_corner(
    contacts: Any,
    tally: Tally,
    mover: Mover,
    corner: Corner,
    normal: Point,
    separation: float,
    feature: int,
    face: int,
) -> Tally:
    """Write a contact of a corner of the shape, rounded by its radius; `feature` is the first of 64 ids."""
    back = mover.outline.radius + 0.5 * separation
    point = (corner.x - normal[0] * back, corner.y - normal[1] * back)
    return emit(contacts, tally, point, normal, separation, feature + corner.number, face, mover.outline.radius)


@njit
def terrain_contacts(chain: Chain, mover: Mover, vertices: Any, contacts: Any, count: int) -> Tally:
    """Find all contacts of a shape with a terrain, in the terrain's frame.

    Writes point, normal (out of the terrain), separation and feature from entry `count` on, as far as
    there is room.
    """
    outline = mover.outline
    tally = Tally(count, np.inf, 0.0, 1.0)
    for i in range(outline.corners):
        x, y = corner_of(outline, vertices, i)
        x, y = to_world(mover.pose, x, y)
        corner = Corner(int64(i), x, y)
        edge, distance, outside = nearest_edge(chain, mover, vertices, x, y)
        if edge < 0:
            continue
        if outside:
            tally = corner_outside(chain, mover, vertices, contacts, tally, corner)
        elif is_facing(mover, vertices, i, vertices[chain.first + edge].normal):
            tally = corner_inside(chain, mover, vertices, contacts, tally, corner, edge, distance)
    if outline.corners > 1:
        tally = ridges(chain, mover, vertices, contacts, tally)
    return tally


@njit
def is_facing(mover: Mover, vertices: Any, corner: int, normal: Any) -> bool:
    """Whether a corner can face the ground; False if the normals of both its edges point away from it."""
    outline = mover.outline
    if outline.radius > 0.0 or outline.corners < 3:
        return True
    nx = mover.pose.cos * normal[0] + mover.pose.sin * normal[1]
    ny = mover.pose.cos * normal[1] - mover.pose.sin * normal[0]
    ax, ay = edge_normal(outline, vertices, corner)
    bx, by = edge_normal(outline, vertices, corner - 1 if corner > 0 else outline.corners - 1)
    return min(ax * nx + ay * ny, bx * nx + by * ny) < -FACING


@njit
def corner_inside(
    chain: Chain, mover: Mover, vertices: Any, contacts: Any, tally: Tally, corner: Corner, edge: int, distance: float
) -> Tally:
    """Add the contact of a corner inside the solid, out of the nearest edge."""
    vertex = vertices[chain.first + edge]
    if height_over(vertex, mover.middle_x, mover.middle_y) < -mover.outline.extent:
        return tally  # the shape is behind the edge
    along = along_edge(vertex, corner.x, corner.y)
    nx = vertex.normal[0]
    ny = vertex.normal[1]
    face = FACE_OF_A
    if along > vertex.length:  # under a valley, to its bottom; the later edge counts
        edge = vertex.next
        vertex = vertices[chain.first + edge]
        along = -1.0
    if along < 0.0 and distance > 0.0:
        nx = (vertex.position[0] - corner.x) / distance
        ny = (vertex.position[1] - corner.y) / distance
        face = NO_FACE
    separation = -distance - mover.outline.radius
    return emit_corner(contacts, tally, mover, corner, (nx, ny), separation, (vertex.run * 3 + FACE) * 64, face)


@njit
def corner_outside(chain: Chain, mover: Mover, vertices: Any, contacts: Any, tally: Tally, corner: Corner) -> Tally:
    """Add the contacts of a corner outside the solid with all edges under it and ridges beside it."""
    radius = mover.outline.radius
    reach = mover.margin + radius
    x = corner.x
    y = corner.y
    ux, uy = velocity_at(mover, x, y)
    for leaf in range(chain.start, chain.stop):
        if leaf_misses(vertices[chain.first + chain.leaves - 1 + leaf], x, y, reach):
            continue
        for i in range(leaf * LEAF_SEGMENTS, min((leaf + 1) * LEAF_SEGMENTS, chain.vertices)):
            vertex = vertices[chain.first + i]
            if vertex.turn == CONVEX:
                tally = corner_beside_ridge(chain, mover, vertices, contacts, tally, corner, i)
            if vertex.next < 0:
                continue
            height = height_over(vertex, x, y)
            separation = height - radius
            if height < 0.0 or separation > mover.margin:
                continue
            # where the corner lands, not where it is now
            time = time_to_close(separation, -(ux * vertex.normal[0] + uy * vertex.normal[1]), mover)
            if not lies_over(chain, vertices, i, x + time * ux, y + time * uy):
                continue
            if not is_facing(mover, vertices, corner.number, vertex.normal):
                continue
            normal = (vertex.normal[0], vertex.normal[1])
            feature = (vertex.run * 3 + FACE) * 64
            tally = emit_corner(contacts, tally, mover, corner, normal, separation, feature, FACE_OF_A)
    return tally


@njit
def corner_beside_ridge(
    chain: Chain, mover: Mover, vertices: Any, contacts: Any, tally: Tally, corner: Corner, i: int
) -> Tally:
    """Add the contact of a corner with a convex vertex, if it lies between the normals of the two edges there."""
    vertex = vertices[chain.first + i]
    dx = corner.x - vertex.position[0]
    dy = corner.y - vertex.position[1]
    distance = np.sqrt(dx * dx + dy * dy)
    separation = distance - mover.outline.radius
    if separation > mover.margin or not distance > 0.0:
        return tally
    before, after = beyond_arc(chain, vertices, i, dx, dy)
    if before >= 0.0 or after >= 0.0:
        return tally
    normal = (dx / distance, dy / distance)
    return emit_corner(contacts, tally, mover, corner, normal, separation, (i * 3 + POINT) * 64, NO_FACE)


@njit
def ridges(chain: Chain, mover: Mover, vertices: Any, contacts: Any, tally: Tally) -> Tally:
    """Add the contacts of convex vertices of the chain with edges of the shape."""
    reach = mover.size + mover.outline.radius + mover.margin
    x = mover.middle_x
    y = mover.middle_y
    for leaf in range(chain.start, chain.stop):
        if leaf_misses(vertices[chain.first + chain.leaves - 1 + leaf], x, y, reach):
            continue
        for i in range(leaf * LEAF_SEGMENTS, min((leaf + 1) * LEAF_SEGMENTS, chain.vertices)):
            vertex = vertices[chain.first + i]
            if vertex.turn != CONVEX:
                continue
            dx = vertex.position[0] - x
            dy = vertex.position[1] - y
            if dx * dx + dy * dy <= reach * reach:
                tally = ridge(chain, mover, vertices, contacts, tally, i)
    return tally


@njit
def ridge(chain: Chain, mover: Mover, vertices: Any, contacts: Any, tally: Tally, i: int) -> Tally:
    """Add the contact of vertex i with the edge that it penetrates least, of those that the chain allows."""
    outline = mover.outline
    vertex = vertices[chain.first + i]
    x, y = to_local(mover.pose, vertex.position[0], vertex.position[1])
    best = -np.inf
    highest = -np.inf
    edge = int64(-1)
    for k in range(outline.corners):
        mx, my = edge_normal(outline, vertices, k)
        corner_x, corner_y = corner_of(outline, vertices, k)
        height = mx * (x - corner_x) + my * (y - corner_y)
        highest = max(highest, height)
        if height <= best:
            continue
        wx, wy = rotate(mover.pose.cos, mover.pose.sin, -mx, -my)
        before, after = beyond_arc(chain, vertices, i, wx, wy)
        if before < TILT and after < TILT:
            best = height
            edge = k
    separation = best - outline.radius
    if edge < 0 or separation > mover.margin or best < -2.0 * outline.extent:
        return tally
    mx, my = edge_normal(outline, vertices, edge)
    if highest > 0.0 and not over_shape_edge(mover, vertices, vertex, edge, x, y, separation):  # otherwise it is inside
        return tally
    nx, ny = rotate(mover.pose.cos, mover.pose.sin, -mx, -my)
    point = to_world(mover.pose, x - 0.5 * separation * mx, y - 0.5 * separation * my)
    return emit(contacts, tally, point, (nx, ny), separation, (i * 3 + RIDGE) * 64 + edge, FACE_OF_B, 0.0)


@njit
def over_shape_edge(mover: Mover, vertices: Any, vertex: Any, edge: int, x: float, y: float, separation: float) -> bool:
    """Whether the vertex, outside the shape at (x, y) in its frame, is under that edge when they touch."""
    outline = mover.outline
    mx, my = edge_normal(outline, vertices, edge)
    ux, uy = velocity_at(mover, vertex.position[0], vertex.position[1])
    ux, uy = (
        mover.pose.cos * ux + mover.pose.sin * uy,
        mover.pose.cos * uy - mover.pose.sin * ux,
    )
    time = time_to_close(separation, ux * mx + uy * my, mover)
    x -= time * ux
    y -= time * uy
    corner_x, corner_y = corner_of(outline, vertices, edge)
    end_x, end_y = corner_of(outline, vertices, (edge + 1) % outline.corners)
    # counter-clockwise: the edge runs along (-my, mx)
    along = -my * (x - corner_x) + mx * (y - corner_y)
    length = -my * (end_x - corner_x) + mx * (end_y - corner_y)
    return 0.0 <= along <= length
