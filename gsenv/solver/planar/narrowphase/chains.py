"""Chains of segments for terrains.py: the near part, the outside, and feet of points on edges."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from ...jit import njit
from ..math import Pose, to_world
from ..vertices import CONCAVE, CONVEX, FLAT, LEAF_SEGMENTS, leaf_count, leaf_misses, leaf_span
from .polygons import Outline, corner_of


class Chain(NamedTuple):
    """A terrain in its own frame."""

    first: int
    vertices: int  # number of vertices
    leaves: int
    start: int  # leaves start .. stop - 1 are near the shape
    stop: int


class Mover(NamedTuple):
    """A shape near a chain, in the chain's frame."""

    outline: Outline
    pose: Pose
    middle_x: float  # m, centre of its corners
    middle_y: float
    size: float  # m, from this centre to the farthest corner
    velocity_x: float  # m/s, of its frame's origin, relative to the chain
    velocity_y: float
    spin: float  # rad/s
    horizon: float  # s, time ahead in which contacts are searched
    margin: float  # m


@njit
def mover_of(
    outline: Outline,
    vertices: Any,
    pose: Pose,
    velocity: tuple[float, float, float],
    horizon: float,
    margin: float,
) -> Mover:
    """Return the Mover of a shape; `pose` and `velocity` (m/s, m/s, rad/s) are relative to the chain."""
    x = 0.0
    y = 0.0
    for i in range(outline.corners):
        corner_x, corner_y = corner_of(outline, vertices, i)
        x += corner_x
        y += corner_y
    x /= outline.corners
    y /= outline.corners
    size2 = 0.0
    for i in range(outline.corners):
        corner_x, corner_y = corner_of(outline, vertices, i)
        size2 = max(size2, (corner_x - x) ** 2 + (corner_y - y) ** 2)
    x, y = to_world(pose, x, y)
    return Mover(outline, pose, x, y, np.sqrt(size2), velocity[0], velocity[1], velocity[2], horizon, margin)


@njit
def chain_near(shape_model: Any, vertices: Any, mover: Mover) -> Chain:
    first = int64(shape_model.vertex_first)
    count = int64(shape_model.vertex_count)
    leaves = leaf_count(count)
    reach = 2.0 * mover.size + mover.outline.radius + mover.margin + mover.outline.extent
    x = mover.middle_x
    y = mover.middle_y
    start, stop = leaf_span(vertices, first, leaves, x - reach, y - reach, x + reach, y + reach)
    return Chain(first, count, leaves, start, stop)


@njit
def velocity_at(mover: Mover, x: float, y: float) -> tuple[float, float]:
    return (
        mover.velocity_x - mover.spin * (y - mover.pose.y),
        mover.velocity_y + mover.spin * (x - mover.pose.x),
    )


@njit
def time_to_close(separation: float, approach: float, mover: Mover) -> float:
    """Return the time in s until a gap closes; at most the horizon, 0 if it is closed."""
    if separation <= 0.0:
        return 0.0
    if approach * mover.horizon <= separation:
        return mover.horizon if approach > 0.0 else 0.0
    return separation / approach


@njit
def nearest_edge(chain: Chain, mover: Mover, vertices: Any, x: float, y: float) -> tuple[int, float, bool]:
    """Return (edge or -1, signed distance in m, whether the point is outside the solid)."""
    reach = mover.margin + mover.outline.radius + mover.size + mover.outline.extent
    best = reach * reach
    edge = int64(-1)
    for leaf in range(chain.start, chain.stop):
        if leaf_misses(vertices[chain.first + chain.leaves - 1 + leaf], x, y, reach):
            continue
        for i in range(leaf * LEAF_SEGMENTS, min((leaf + 1) * LEAF_SEGMENTS, chain.vertices)):
            if vertices[chain.first + i].next < 0:
                continue
            distance2 = distance_squared(vertices[chain.first + i], x, y)
            if distance2 < best:
                best = distance2
                edge = i
                reach = np.sqrt(best)
    if edge < 0:
        return -1, 0.0, True
    return edge, np.sqrt(best), is_outside(chain, vertices, edge, x, y)


@njit
def along_edge(vertex: Any, x: float, y: float) -> float:
    """Return the coordinate along the edge from its start, m; the normal is on the left."""
    return vertex.normal[1] * (x - vertex.position[0]) - vertex.normal[0] * (y - vertex.position[1])


@njit
def height_over(vertex: Any, x: float, y: float) -> float:
    return vertex.normal[0] * (x - vertex.position[0]) + vertex.normal[1] * (y - vertex.position[1])


@njit
def distance_squared(vertex: Any, x: float, y: float) -> float:
    along = along_edge(vertex, x, y)
    beyond = along - min(max(along, 0.0), vertex.length)
    height = height_over(vertex, x, y)
    return beyond * beyond + height * height


@njit
def is_outside(chain: Chain, vertices: Any, edge: int, x: float, y: float) -> bool:
    """Whether a point is outside, given its nearest edge; beyond its ends outside at a ridge, inside at a valley."""
    vertex = vertices[chain.first + edge]
    along = along_edge(vertex, x, y)
    turn = FLAT
    if along < 0.0:
        turn = vertex.turn
    elif along > vertex.length:
        turn = vertices[chain.first + vertex.next].turn
    if turn == CONVEX:
        return True
    if turn == CONCAVE:
        return False
    return height_over(vertex, x, y) >= 0.0


@njit
def lies_over(chain: Chain, vertices: Any, edge: int, x: float, y: float) -> bool:
    """Whether the foot of the point is on the edge.

    Where the chain is straight, the shared vertex belongs to the later edge, so that exactly one of the
    two has the foot.
    """
    vertex = vertices[chain.first + edge]
    if along_edge(vertex, x, y) < 0.0:
        return False
    end = vertices[chain.first + vertex.next]
    if end.turn == FLAT:
        return along_edge(end, x, y) < 0.0
    return along_edge(vertex, x, y) <= vertex.length


@njit
def beyond_arc(chain: Chain, vertices: Any, i: int, dx: float, dy: float) -> tuple[float, float]:
    """Return by how much (dx, dy) is beyond the normal of the edge before vertex i, and of the edge after it.

    Both are negative between the normals.  At an end of an open chain the arc ends at the direction of
    the chain: nothing hits the end from behind.
    """
    vertex = vertices[chain.first + i]
    if vertex.previous >= 0:
        edge = vertices[chain.first + vertex.previous]
        before = -(edge.normal[1] * dx - edge.normal[0] * dy)
    else:
        before = -(vertex.normal[0] * dx + vertex.normal[1] * dy)
    if vertex.next >= 0:
        after = vertex.normal[1] * dx - vertex.normal[0] * dy
    else:
        edge = vertices[chain.first + vertex.previous]
        after = -(edge.normal[0] * dx + edge.normal[1] * dy)
    return before, after
