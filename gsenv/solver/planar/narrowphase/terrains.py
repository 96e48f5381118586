"""Terrains against circles, capsules, boxes and polygons.

Two kinds of contact: a corner of the shape (a circle's only corner is its centre) on the chain, and a
ridge of the chain on an edge of the shape.  A direction counts only if the chain as a whole allows it
(between the normals of the two edges that meet at a ridge; straight up from an edge; nothing at a
valley or where the chain goes straight on), so nothing catches on inner vertices.  A corner in a
valley touches both sides.

A corner behind the chain is pushed out of the nearest edge alone, and an edge that the middle of the
shape has passed by more than its extent is open from behind.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose, rotate, to_local, to_world
from gsenv.solver.planar.narrowphase.chains import (
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
from gsenv.solver.planar.narrowphase.polygons import Outline, corner_of, edge_normal
from gsenv.solver.planar.vertices import CONVEX, LEAF_SEGMENTS, leaf_misses

FACING = 1e-3  # sine: an edge of the shape that looks less against the ground is a side
TILT = 0.2  # sine: a ridge still holds a face that is tilted so far beyond its two edges
FACE, POINT, RIDGE = 0, 1, 2  # kinds of feature


class Tally(NamedTuple):
    """Contacts so far and the nearest of them, in the chain's frame, normal out of the chain."""

    total: int
    separation: float
    normal_x: float
    normal_y: float


@njit
def emit(
    contacts: Any,
    tally: Tally,
    terrain: Pose,
    x: float,
    y: float,
    nx: float,
    ny: float,
    separation: float,
    feature: int,
) -> Tally:
    """Write a contact between the chain and a surface point; `(x, y)` lies half-way between."""
    if tally.total < len(contacts):
        contact = contacts[tally.total]
        contact.point[0], contact.point[1] = to_world(terrain, x, y)
        contact.normal[0], contact.normal[1] = rotate(terrain.cos, terrain.sin, nx, ny)
        contact.separation = separation
        contact.feature = feature
    if separation < tally.separation:
        return Tally(tally.total + 1, separation, nx, ny)
    return Tally(tally.total + 1, tally.separation, tally.normal_x, tally.normal_y)


@njit
def terrain_contacts(
    chain: Chain,
    terrain: Pose,
    outline: Outline,
    mover: Mover,
    vertices: Any,
    contacts: Any,
    count: int,
) -> Tally:
    """All contacts of a shape with a terrain; writes point, normal (out of the terrain), separation
    and feature from entry `count` on, as far as there is room.
    """
    tally = Tally(count, np.inf, 0.0, 1.0)
    for corner in range(outline.corners):
        x, y = corner_of(outline, vertices, corner)
        x, y = to_world(mover.pose, x, y)
        edge, distance, outside = nearest_edge(chain, mover, vertices, x, y)
        if edge < 0:
            continue
        if outside:
            tally = corner_outside(
                chain, terrain, outline, mover, vertices, contacts, tally, corner, x, y
            )
        elif is_facing(outline, mover, vertices, corner, vertices[chain.first + edge].normal):
            tally = corner_inside(
                chain, terrain, mover, vertices, contacts, tally, corner, edge, distance, x, y
            )
    if outline.corners > 1:
        tally = ridges(chain, terrain, outline, mover, vertices, contacts, tally)
    return tally


@njit
def is_facing(outline: Outline, mover: Mover, vertices: Any, corner: int, normal: Any) -> bool:
    """False if both edges at the corner look the same way as the ground: it is on the far side."""
    if outline.radius > 0.0 or outline.corners < 3:
        return True
    nx = mover.pose.cos * normal[0] + mover.pose.sin * normal[1]
    ny = mover.pose.cos * normal[1] - mover.pose.sin * normal[0]
    ax, ay = edge_normal(outline, vertices, corner)
    bx, by = edge_normal(outline, vertices, corner - 1 if corner > 0 else outline.corners - 1)
    return min(ax * nx + ay * ny, bx * nx + by * ny) < -FACING


@njit
def corner_inside(
    chain: Chain,
    terrain: Pose,
    mover: Mover,
    vertices: Any,
    contacts: Any,
    tally: Tally,
    corner: int,
    edge: int,
    distance: float,
    x: float,
    y: float,
) -> Tally:
    """The corner is in the solid: out by the nearest edge."""
    vertex = vertices[chain.first + edge]
    if height_over(vertex, mover.middle_x, mover.middle_y) < -mover.extent:
        return tally  # the shape is behind
    along = along_edge(vertex, x, y)
    nx = vertex.normal[0]
    ny = vertex.normal[1]
    if along > vertex.length:  # under a valley, to its bottom; the later edge counts
        edge = vertex.next
        vertex = vertices[chain.first + edge]
        along = -1.0
    if along < 0.0 and distance > 0.0:
        nx = (vertex.position[0] - x) / distance
        ny = (vertex.position[1] - y) / distance
    separation = -distance - mover.radius
    back = mover.radius + 0.5 * separation
    return emit(
        contacts, tally, terrain, x - nx * back, y - ny * back, nx, ny, separation,
        (vertex.run * 3 + FACE) * 64 + corner,
    )  # fmt: skip


@njit
def corner_outside(
    chain: Chain,
    terrain: Pose,
    outline: Outline,
    mover: Mover,
    vertices: Any,
    contacts: Any,
    tally: Tally,
    corner: int,
    x: float,
    y: float,
) -> Tally:
    """The corner is in the open: all edges under it, and ridges that it is beside."""
    reach = mover.margin + mover.radius
    ux, uy = velocity_at(mover, x, y)
    for leaf in range(chain.start, chain.stop):
        if leaf_misses(vertices[chain.first + chain.leaves - 1 + leaf], x, y, reach):
            continue
        for i in range(leaf * LEAF_SEGMENTS, min((leaf + 1) * LEAF_SEGMENTS, chain.vertices)):
            vertex = vertices[chain.first + i]
            if vertex.turn == CONVEX:
                tally = corner_beside_ridge(
                    chain, terrain, mover, vertices, contacts, tally, corner, i, x, y
                )
            if vertex.next < 0:
                continue
            height = height_over(vertex, x, y)
            separation = height - mover.radius
            if height < 0.0 or separation > mover.margin:
                continue
            # where the corner comes down, not where it is now
            time = time_to_close(separation, -(ux * vertex.normal[0] + uy * vertex.normal[1]), mover)
            if not lies_over(chain, vertices, i, x + time * ux, y + time * uy):
                continue
            if not is_facing(outline, mover, vertices, corner, vertex.normal):
                continue
            back = mover.radius + 0.5 * separation
            tally = emit(
                contacts, tally, terrain,
                x - vertex.normal[0] * back, y - vertex.normal[1] * back,
                vertex.normal[0], vertex.normal[1], separation,
                (vertex.run * 3 + FACE) * 64 + corner,
            )  # fmt: skip
    return tally


@njit
def corner_beside_ridge(
    chain: Chain,
    terrain: Pose,
    mover: Mover,
    vertices: Any,
    contacts: Any,
    tally: Tally,
    corner: int,
    i: int,
    x: float,
    y: float,
) -> Tally:
    """Corner against a convex vertex, if it lies between the normals of the two edges there."""
    vertex = vertices[chain.first + i]
    dx = x - vertex.position[0]
    dy = y - vertex.position[1]
    distance = np.sqrt(dx * dx + dy * dy)
    separation = distance - mover.radius
    if separation > mover.margin or not distance > 0.0:
        return tally
    before, after = beyond_arc(chain, vertices, i, dx, dy)
    if before >= 0.0 or after >= 0.0:
        return tally
    nx = dx / distance
    ny = dy / distance
    back = mover.radius + 0.5 * separation
    return emit(
        contacts, tally, terrain, x - nx * back, y - ny * back, nx, ny, separation,
        (i * 3 + POINT) * 64 + corner,
    )  # fmt: skip


@njit
def ridges(
    chain: Chain,
    terrain: Pose,
    outline: Outline,
    mover: Mover,
    vertices: Any,
    contacts: Any,
    tally: Tally,
) -> Tally:
    """Convex vertices of the chain against the edges of the shape."""
    reach = mover.size + mover.radius + mover.margin
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
                tally = ridge(chain, terrain, outline, mover, vertices, contacts, tally, i)
    return tally


@njit
def ridge(
    chain: Chain,
    terrain: Pose,
    outline: Outline,
    mover: Mover,
    vertices: Any,
    contacts: Any,
    tally: Tally,
    i: int,
) -> Tally:
    """Vertex i against the edge that it has entered least, of those that the chain lets touch it."""
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
    separation = best - mover.radius
    if edge < 0 or separation > mover.margin or best < -2.0 * mover.extent:
        return tally
    mx, my = edge_normal(outline, vertices, edge)
    if not over_shape_edge(outline, mover, vertices, vertex, edge, x, y, separation, highest):
        return tally
    nx, ny = rotate(mover.pose.cos, mover.pose.sin, -mx, -my)
    px, py = to_world(mover.pose, x - 0.5 * separation * mx, y - 0.5 * separation * my)
    feature = (i * 3 + RIDGE) * 64 + edge
    return emit(contacts, tally, terrain, px, py, nx, ny, separation, feature)


@njit
def over_shape_edge(
    outline: Outline,
    mover: Mover,
    vertices: Any,
    vertex: Any,
    edge: int,
    x: float,
    y: float,
    separation: float,
    highest: float,
) -> bool:
    """True if the vertex, (x, y) in the shape's frame, is under that edge when they meet."""
    if highest <= 0.0:
        return True  # inside of the shape
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
