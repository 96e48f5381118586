"""Nearest points of two convex cores, by the GJK algorithm.

E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex objects
in three-dimensional space", 1988: the point of a - b nearest to the origin, by simplices of support points.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...jit import njit
from ..math import Vec, cross, dot, scaled, sub
from .solids import Solid, support

Array = NDArray[Any]

ROUNDS = 64
TOUCHING = 1e-8  # of the sizes: cores nearer than this overlap
EXACT = 1e-13  # of the squared distance: tolerance


@njit
def put_support(a: Solid, b: Solid, vertices: Array | None, d: Vec, row: Any) -> Vec:
    """Write the point of a - b farthest along d to a row of 9, with its points of a and b; returns it."""
    p = support(a, vertices, d)
    q = support(b, vertices, (-d[0], -d[1], -d[2]))
    w = sub(p, q)
    for i in range(3):
        row[i] = w[i]
        row[3 + i] = p[i]
        row[6 + i] = q[i]
    return w


@njit
def nearest_of_cores(
    a: Solid, b: Solid, vertices: Array | None, start: Vec, reach: float, scratch: Any
) -> tuple[bool, Vec, Vec]:
    """Return (whether the cores are separate, nearest point of a, of b).  `start`: a direction from a to b.

    For cores farther apart than `reach`, the points are any two that prove this.
    """
    simplex = scratch.simplex
    v = put_support(a, b, vertices, start, simplex[0])
    scratch.weight[0] = 1.0
    count = int64(1)
    p, q = nearest_points(count, scratch)
    scale2 = 0.0
    for _ in range(ROUNDS):
        vv = dot(v, v)
        scale2 = max(scale2, max(dot(p, p), dot(q, q)))
        if not vv > TOUCHING * TOUCHING * scale2:
            return False, p, q
        w = put_support(a, b, vertices, scaled(v, -1.0), simplex[count])
        bound = dot(v, w)
        if vv - bound <= EXACT * vv or is_known(w, count, scratch):
            return True, p, q
        if bound > 0.0 and bound > reach * np.sqrt(vv):
            return True, p, q
        count = nearest_of_simplex(count + 1, scratch)
        closer = weighted(count, int64(0), scratch)
        if count == 4:
            return False, p, q
        if not dot(closer, closer) < vv:  # no progress beyond rounding
            return True, p, q
        v = closer
        p, q = nearest_points(count, scratch)
    return True, p, q


@njit
def is_known(w: Vec, count: int, scratch: Any) -> bool:
    s = scratch.simplex
    for i in range(count):
        if w[0] == s[i, 0] and w[1] == s[i, 1] and w[2] == s[i, 2]:
            return True
    return False


@njit
def weighted(count: int, column: int, scratch: Any) -> Vec:
    x, y, z = 0.0, 0.0, 0.0
    for i in range(count):
        k = scratch.weight[i]
        x += k * scratch.simplex[i, column]
        y += k * scratch.simplex[i, column + 1]
        z += k * scratch.simplex[i, column + 2]
    return x, y, z


@njit
def nearest_points(count: int, scratch: Any) -> tuple[Vec, Vec]:
    return weighted(count, int64(3), scratch), weighted(count, int64(6), scratch)


@njit
def simplex_point(i: int, scratch: Any) -> Vec:
    s = scratch.simplex
    return s[i, 0], s[i, 1], s[i, 2]


@njit
def nearest_of_simplex(count: int, scratch: Any) -> int:
    """Reduce the simplex to its face nearest the origin, with weights; returns its size, 4 if the origin is inside."""
    p = simplex_point(int64(0), scratch)
    q = simplex_point(int64(1), scratch)
    if count == 2:
        k0, k1, k2 = segment_weights(p, q)
        return keep(int64(0), int64(1), int64(1), k0, k1, k2, scratch)
    r = simplex_point(int64(2), scratch)
    if count == 3:
        k0, k1, k2 = triangle_weights(p, q, r)
        return keep(int64(0), int64(1), int64(2), k0, k1, k2, scratch)
    best = np.inf
    skip = int64(-1)
    weights = (0.0, 0.0, 0.0)
    for i in range(4):  # the face without corner i
        one = simplex_point(int64(1 if i == 0 else 0), scratch)
        two = simplex_point(int64(2 if i <= 1 else 1), scratch)
        three = simplex_point(int64(3 if i <= 2 else 2), scratch)
        n = cross(sub(two, one), sub(three, one))
        here = -dot(n, one)
        corner = dot(n, sub(simplex_point(int64(i), scratch), one))
        if here * corner > 0.0:
            continue  # the origin is on the side of the corner
        k = triangle_weights(one, two, three)
        x = k[0] * one[0] + k[1] * two[0] + k[2] * three[0]
        y = k[0] * one[1] + k[1] * two[1] + k[2] * three[1]
        z = k[0] * one[2] + k[1] * two[2] + k[2] * three[2]
        distance = x * x + y * y + z * z
        if distance < best:
            best = distance
            skip = int64(i)
            weights = k
    if skip < 0:
        return int64(4)
    i0 = int64(1 if skip == 0 else 0)
    i1 = int64(2 if skip <= 1 else 1)
    i2 = int64(3 if skip <= 2 else 2)
    return keep(i0, i1, i2, weights[0], weights[1], weights[2], scratch)


@njit
def keep(i: int, j: int, k: int, wi: float, wj: float, wk: float, scratch: Any) -> int:
    """Move the corners i < j < k with a positive weight to the front; returns their number."""
    count = int64(0)
    if wi > 0.0:
        count = move(i, count, wi, scratch)
    if wj > 0.0:
        count = move(j, count, wj, scratch)
    if wk > 0.0:
        count = move(k, count, wk, scratch)
    return count


@njit
def move(source: int, target: int, weight: float, scratch: Any) -> int:
    if source != target:
        for c in range(9):
            scratch.simplex[target, c] = scratch.simplex[source, c]
    scratch.weight[target] = weight
    return target + 1


@njit
def segment_weights(p: Vec, q: Vec) -> tuple[float, float, float]:
    """Return the weights of the point of the segment nearest to the origin (and 0)."""
    e = sub(q, p)
    length2 = dot(e, e)
    t = 0.0
    if length2 > 0.0:
        t = min(max(-dot(p, e) / length2, 0.0), 1.0)
    return 1.0 - t, t, 0.0


@njit
def triangle_weights(p: Vec, q: Vec, r: Vec) -> tuple[float, float, float]:
    """Return the weights of the point of the triangle nearest to the origin."""
    n = cross(sub(q, p), sub(r, p))
    area2 = dot(n, n)
    if area2 > 0.0:
        a = dot(n, cross(q, r))
        b = dot(n, cross(r, p))
        c = dot(n, cross(p, q))
        if a > 0.0 and b > 0.0 and c > 0.0:
            total = a + b + c
            return a / total, b / total, c / total
    pq = segment_weights(p, q)
    qr = segment_weights(q, r)
    rp = segment_weights(r, p)
    d0 = squared(pq, p, q)
    d1 = squared(qr, q, r)
    d2 = squared(rp, r, p)
    if d0 <= d1 and d0 <= d2:
        return pq[0], pq[1], 0.0
    if d1 <= d2:
        return 0.0, qr[0], qr[1]
    return rp[1], 0.0, rp[0]


@njit
def squared(k: tuple[float, float, float], p: Vec, q: Vec) -> float:
    x = k[0] * p[0] + k[1] * q[0]
    y = k[0] * p[1] + k[1] * q[1]
    z = k[0] * p[2] + k[1] * q[2]
    return x * x + y * y + z * z
