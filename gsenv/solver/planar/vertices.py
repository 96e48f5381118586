"""Vertices of polygons and terrains, and the quantities derived from their positions.

A terrain's bounding tree is implicit: L leaves (a power of two) of LEAF_SEGMENTS edges each in the
order of the chain; node 1 is the root, node k has the children 2k and 2k+1, nodes L..2L-1 are the
leaves.  Node k is stored in vertex entry k-1, and 2L-1 never exceeds the vertex count.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ..jit import njit
from ..records.plain import as_records

Array = NDArray[Any]

LEAF_SEGMENTS = 4  # number of edges in a leaf of the tree
FLAT_SINE = 1e-7  # sine of the largest angle between two edges that count as straight


class Turn(IntEnum):
    """Whether a chain is convex or concave at a vertex, seen from its outside."""

    CONVEX = -1  # a ridge, on whose point a shape can rest
    FLAT = 0
    CONCAVE = 1  # a valley


CONVEX, FLAT, CONCAVE = int(Turn.CONVEX), int(Turn.FLAT), int(Turn.CONCAVE)


def vertex_dtype() -> np.dtype[Any]:
    """Return the dtype of a vertex of a polygon or terrain, in the shape's frame; indices count within the shape."""
    return np.dtype(
        [
            ("position", "f8", (2,)),  # m
            ("normal", "f8", (2,)),  # outward, of the edge to the next vertex
            ("length", "f8"),  # m, of that edge; 0 if there is none
            ("outside", "f8"),  # 1: outside on the right of the edge (polygons), -1: on the left (terrains)
            ("turn", "i4"),  # Turn; an end of an open chain counts as convex
            ("run", "i4"),  # first edge of the straight run that this edge belongs to
            ("next", "i4"),  # vertex, -1 at the end of an open chain
            ("previous", "i4"),  # vertex, -1 at its start
            ("node_lower", "f8", (2,)),  # m, entry k-1 holds node k of the bounding tree
            ("node_upper", "f8", (2,)),
        ],
        align=True,
    )


def linked_vertices(points: Array, closed: bool, outside: float) -> Array:
    """Return the `(n,)` vertices of one shape at `points` (n, 2), with all derived fields."""
    count = len(points)
    vertices = np.zeros(count, vertex_dtype())
    vertices["position"] = points
    vertices["outside"] = outside
    vertices["next"] = (np.arange(count) + 1) % count
    vertices["previous"] = (np.arange(count) - 1) % count
    if not closed:
        vertices["next"][-1] = -1
        vertices["previous"][0] = -1
    derive_outline(as_records(vertices))
    return vertices


@njit
def derive_vertices(shape_models: Array, vertices: Array) -> None:
    """Compute all fields that depend on the positions, for all shapes of one world.

    `shape_models` (shape,), `vertices` (vertex,) of one world.
    """
    for k in range(len(shape_models)):
        first = shape_models[k].vertex_first
        count = shape_models[k].vertex_count
        if count > 0:
            derive_outline(vertices[first : first + count])


@njit
def derive_outline(vertices: Array) -> None:
    """Compute these fields for one shape; `vertices` are those of the shape."""
    for i in range(len(vertices)):
        vertex = vertices[i]
        vertex.length = 0.0
        if vertex.next >= 0:
            after = vertices[vertex.next]
            dx = after.position[0] - vertex.position[0]
            dy = after.position[1] - vertex.position[1]
            length = np.sqrt(dx * dx + dy * dy)
            vertex.length = length
            if length > 0.0:
                vertex.normal[0] = vertex.outside * dy / length
                vertex.normal[1] = -vertex.outside * dx / length
    for i in range(len(vertices)):
        derive_turn(vertices, i)
    build_tree(vertices)


@njit
def derive_turn(vertices: Array, i: int) -> None:
    vertex = vertices[i]
    vertex.run = i
    vertex.turn = CONVEX
    if vertex.next < 0 or vertex.previous < 0:
        return
    before = vertices[vertex.previous]
    sine = before.normal[0] * vertex.normal[1] - before.normal[1] * vertex.normal[0]
    cosine = before.normal[0] * vertex.normal[0] + before.normal[1] * vertex.normal[1]
    if cosine > 0.0 and abs(sine) <= FLAT_SINE:
        vertex.turn = FLAT
        if i > 0:
            vertex.run = before.run
    elif sine * vertex.outside < 0.0:
        vertex.turn = CONCAVE


@njit
def leaf_count(count: int) -> int:
    """Return the number of leaves of the tree over `count` vertices."""
    leaves = 1
    while leaves * LEAF_SEGMENTS < count:
        leaves *= 2
    return leaves


@njit
def build_tree(vertices: Array) -> None:
    leaves = leaf_count(len(vertices))
    for leaf in range(leaves):
        node = vertices[leaves + leaf - 1]
        for axis in range(2):
            node.node_lower[axis] = np.inf
            node.node_upper[axis] = -np.inf
        stop = min((leaf + 1) * LEAF_SEGMENTS, len(vertices))
        for i in range(leaf * LEAF_SEGMENTS, stop):
            end = vertices[i].next if vertices[i].next >= 0 else i
            for axis in range(2):
                a = vertices[i].position[axis]
                b = vertices[end].position[axis]
                node.node_lower[axis] = min(node.node_lower[axis], a, b)
                node.node_upper[axis] = max(node.node_upper[axis], a, b)
    for k in range(leaves - 1, 0, -1):
        left = vertices[2 * k - 1]
        right = vertices[2 * k]
        node = vertices[k - 1]
        for axis in range(2):
            node.node_lower[axis] = min(left.node_lower[axis], right.node_lower[axis])
            node.node_upper[axis] = max(left.node_upper[axis], right.node_upper[axis])


@njit
def leaf_span(
    vertices: Array,
    first: int,
    leaves: int,
    lower_x: float,
    lower_y: float,
    upper_x: float,
    upper_y: float,
) -> tuple[int, int]:
    """Return the first leaf whose box overlaps a box and the one after the last; (0, 0) if there is none.

    Leaf k contains the edges from k * LEAF_SEGMENTS on; its box is in entry leaves - 1 + k.
    """
    start = int64(-1)
    stop = int64(0)
    node = int64(1)
    while True:
        entry = vertices[first + node - 1]
        if (
            entry.node_lower[0] <= upper_x
            and entry.node_upper[0] >= lower_x
            and entry.node_lower[1] <= upper_y
            and entry.node_upper[1] >= lower_y
        ):
            if node < leaves:
                node *= 2
                continue
            stop = node - leaves + 1
            if start < 0:
                start = stop - 1
        while node & 1:  # up from right children
            node >>= 1
        if node == 0:
            return max(start, 0), stop
        node += 1


@njit
def leaf_misses(entry: Any, x: float, y: float, reach: float) -> bool:
    """Whether the leaf's box, stored in `entry`, is farther than `reach` from the point along an axis."""
    return (
        entry.node_lower[0] > x + reach
        or entry.node_upper[0] < x - reach
        or entry.node_lower[1] > y + reach
        or entry.node_upper[1] < y - reach
    )
