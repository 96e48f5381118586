"""Contacts of two boxes: separating axes, then clipping of the faces, or the point where two edges cross.

S. Gottschalk, M. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996: six face normals and nine edge pairs.
"""

from __future__ import annotations

import numpy as np
from numba import int64

from ...jit import njit
from ..math import Pose, Vec, add, along, cross, dot, rotate, scaled, sub, unrotate
from .clip import FEATURES, LABELS, WITNESS
from .features import EDGE_ID
from .solids import Solid

FACE_BIAS = 0.01  # of the extent: advantage that a face of b or edges need, so that two do not alternate
EDGE_BIAS = 0.05  # of the depth, likewise
MIN_SINE2 = 1e-8  # edges nearer to parallel have no common normal; the faces suffice


@njit
def edge_axis(e: Vec, f: Vec, d: Vec, half: Vec, one: Vec, half_one: float, two: Vec, half_two: float) -> float:
    """Return the separation along e x f, in the frame of box a with `half`; one, two: b's other axes with extents."""
    look = cross(e, f)
    length2 = dot(look, look)
    if length2 < MIN_SINE2:
        return -np.inf
    reach = abs(look[0]) * half[0] + abs(look[1]) * half[1] + abs(look[2]) * half[2]
    reach += abs(dot(look, one)) * half_one + abs(dot(look, two)) * half_two
    return (abs(dot(look, d)) - reach) / np.sqrt(length2)


@njit
def best_face(d: Vec, x: Vec, y: Vec, z: Vec, a: Vec, b: Vec, bias: float) -> tuple[float, int]:
    """Return (separation, face normal: 0, 1, 2 of a or 3, 4, 5 of b); b's centre d and axes in a's frame."""
    best = abs(d[0]) - a[0] - b[0] * abs(x[0]) - b[1] * abs(y[0]) - b[2] * abs(z[0])
    face = int64(0)
    s = abs(d[1]) - a[1] - b[0] * abs(x[1]) - b[1] * abs(y[1]) - b[2] * abs(z[1])
    if s > best:
        best = s
        face = int64(1)
    s = abs(d[2]) - a[2] - b[0] * abs(x[2]) - b[1] * abs(y[2]) - b[2] * abs(z[2])
    if s > best:
        best = s
        face = int64(2)
    limit = best + bias
    s = abs(dot(d, x)) - b[0] - a[0] * abs(x[0]) - a[1] * abs(x[1]) - a[2] * abs(x[2])
    if s > limit:
        best = s
        limit = s
        face = int64(3)
    s = abs(dot(d, y)) - b[1] - a[0] * abs(y[0]) - a[1] * abs(y[1]) - a[2] * abs(y[2])
    if s > limit:
        best = s
        limit = s
        face = int64(4)
    s = abs(dot(d, z)) - b[2] - a[0] * abs(z[0]) - a[1] * abs(z[1]) - a[2] * abs(z[2])
    if s > limit:
        best = s
        face = int64(5)
    return best, face


@njit
def best_edges(d: Vec, x: Vec, y: Vec, z: Vec, a: Vec, b: Vec) -> tuple[float, int]:
    """Return (separation, 3 i + j: edges i of a and j of b)."""
    best = -np.inf
    pair = int64(0)
    for i in range(3):
        e = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        s = edge_axis(e, x, d, a, y, b[1], z, b[2])
        if s > best:
            best = s
            pair = int64(3 * i)
        s = edge_axis(e, y, d, a, z, b[2], x, b[0])
        if s > best:
            best = s
            pair = int64(3 * i + 1)
        s = edge_axis(e, z, d, a, x, b[0], y, b[1])
        if s > best:
            best = s
            pair = int64(3 * i + 2)
    return best, pair


@njit
def axis_of(pose: Pose, i: int) -> Vec:
    if i == 0:
        return pose.x
    return pose.y if i == 1 else pose.z


@njit
def is_axis(pose: Pose, n: Vec) -> bool:
    """Whether a direction is exactly an axis of the pose, or the opposite of one."""
    m = scaled(n, -1.0)
    return n == pose.x or n == pose.y or n == pose.z or m == pose.x or m == pose.y or m == pose.z


@njit
def boxes_direction(a: Solid, b: Solid, margin: float) -> tuple[Vec, float, float, int, bool, Vec]:
    """Find the faces or edges with the largest separation of the boxes.

    Returns (normal of the face, separation along it, along the best edges' normal, these edges as in best_edges,
    whether the edges decide, midpoint under the corner that is deepest below the face).
    """
    d = sub(b.pose.at, a.pose.at)
    local = unrotate(a.pose, d)
    x = unrotate(a.pose, b.pose.x)
    y = unrotate(a.pose, b.pose.y)
    z = unrotate(a.pose, b.pose.z)
    bias = FACE_BIAS * min(a.extent, b.extent)
    best, face = best_face(local, x, y, z, a.half, b.half, bias)
    n = axis_of(a.pose, face) if face < 3 else axis_of(b.pose, face - 3)
    if dot(n, d) < 0.0:
        n = scaled(n, -1.0)
    if not best <= margin:
        return n, best, -np.inf, int64(0), False, n
    by_edges, pair = best_edges(local, x, y, z, a.half, b.half)
    corner = box_corner(b.half, b.pose, scaled(n, -1.0)) if face < 3 else box_corner(a.half, a.pose, n)
    middle = along(corner, (-0.5 if face < 3 else 0.5) * best, n)
    return n, best, by_edges, pair, by_edges > best + max(bias, EDGE_BIAS * abs(best)), middle


@njit
def box_corner(half: Vec, pose: Pose, d: Vec) -> Vec:
    """Return the corner farthest along d."""
    look = unrotate(pose, d)
    x = half[0] if look[0] >= 0.0 else -half[0]
    y = half[1] if look[1] >= 0.0 else -half[1]
    z = half[2] if look[2] >= 0.0 else -half[2]
    return add(pose.at, rotate(pose, (x, y, z)))


@njit
def cross_edges(a: Solid, b: Solid, pair: int) -> tuple[Vec, bool, Vec, int]:
    """Return (common normal of two edges, whether they cross along it, midpoint there, feature id)."""
    d = sub(b.pose.at, a.pose.at)
    i = pair // 3
    j = pair - 3 * i
    e = axis_of(a.pose, i)
    f = axis_of(b.pose, j)
    n = cross(e, f)
    sine2 = dot(n, n)
    n = scaled(n, 1.0 / np.sqrt(sine2))
    if dot(n, d) < 0.0:
        n = scaled(n, -1.0)
    p, code_a = edge_middle(a.half, a.pose, i, n)
    q, code_b = edge_middle(b.half, b.pose, j, scaled(n, -1.0))
    gap = sub(q, p)
    c = dot(e, f)
    s = (dot(gap, e) - c * dot(gap, f)) / sine2
    t = c * s - dot(gap, f)
    s = min(max(s, -a.half[i]), a.half[i])
    inside = abs(t) <= b.half[j] * 1.000001 and abs(dot(gap, e) + c * t - s) <= 1e-6 * a.half[i]
    t = min(max(t, -b.half[j]), b.half[j])
    middle = scaled(add(along(p, s, e), along(q, t, f)), 0.5)
    feature = (EDGE_ID + code_a) * FEATURES + EDGE_ID + code_b
    return n, inside, middle, feature * LABELS + WITNESS


@njit
def edge_middle(half: Vec, pose: Pose, axis: int, d: Vec) -> tuple[Vec, int]:
    """Return the midpoint of the edge along an axis that is farthest along d, and its number."""
    look = unrotate(pose, d)
    x = 0.0 if axis == 0 else (half[0] if look[0] >= 0.0 else -half[0])
    y = 0.0 if axis == 1 else (half[1] if look[1] >= 0.0 else -half[1])
    z = 0.0 if axis == 2 else (half[2] if look[2] >= 0.0 else -half[2])
    code = 8 * axis + (1 if x > 0.0 else 0) + (2 if y > 0.0 else 0) + (4 if z > 0.0 else 0)
    return add(pose.at, rotate(pose, (x, y, z))), code
