"""Depth and direction of the overlap of two convex cores, by the expanding polytope algorithm.

G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", 2001: the
hull of support points of a - b grows towards its boundary point nearest to the origin.  The first hull is
a large tetrahedron that need not contain the origin: a face with the origin outside is grown like others.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...jit import njit
from ..math import Vec, along, cross, dot, norm, scaled, sub, tangents, unit
from .gjk import put_support, triangle_weights
from .scratch import EPA_EDGES, EPA_FACES, EPA_VERTICES
from .solids import Solid

Array = NDArray[Any]

EXACT = 1e-11  # of the sizes: tolerance of the depth
FLAT = 1e-12  # of the sizes: points this little above a face are on it


@njit
def corner_of(i: int, scratch: Any) -> Vec:
    c = scratch.corner
    return c[i, 0], c[i, 1], c[i, 2]


@njit
def first_hull(a: Solid, b: Solid, vertices: Array | None, scratch: Any) -> float:
    """Write four corners, far apart after few searches; returns their size in m, 0 if all are in a plane."""
    corner = scratch.corner
    p = put_support(a, b, vertices, (1.0, 0.0, 0.0), corner[0])
    q = put_support(a, b, vertices, (-1.0, 0.0, 0.0), corner[1])
    axis = unit(sub(q, p))
    size = norm(sub(q, p))
    t, s = tangents(axis)
    far = 0.0
    n = s
    for k in range(4):  # row 4 is temporary
        d = t if k < 2 else s
        d = scaled(d, -1.0) if k & 1 else d
        w = sub(put_support(a, b, vertices, d, corner[4]), p)
        x = cross(axis, w)
        if norm(x) > far:
            far = norm(x)
            n = scaled(x, 1.0 / far)
            copy_corner(int64(4), int64(2), scratch)
    high = 0.0
    for k in range(2):
        w = put_support(a, b, vertices, scaled(n, -1.0) if k else n, corner[4])
        h = abs(dot(sub(w, p), n))
        if h > high:
            high = h
            copy_corner(int64(4), int64(3), scratch)
    if not high > FLAT * (size + far):
        return 0.0
    return size + far + high


@njit
def copy_corner(source: int, target: int, scratch: Any) -> None:
    for c in range(9):
        scratch.corner[target, c] = scratch.corner[source, c]


@njit
def put_triangle(i: int, j: int, k: int, count: int, scratch: Any) -> int:
    """Add a face, counter-clockwise seen from outside; a face without area is never grown."""
    p = corner_of(i, scratch)
    n = cross(sub(corner_of(j, scratch), p), sub(corner_of(k, scratch), p))
    length = norm(n)
    scratch.triangle[count, 0] = i
    scratch.triangle[count, 1] = j
    scratch.triangle[count, 2] = k
    distance = np.inf
    if length > 1e-200:
        n = scaled(n, 1.0 / length)
        distance = dot(n, p)
    else:
        n = (0.0, 0.0, 0.0)
    scratch.triangle_plane[count, 0] = n[0]
    scratch.triangle_plane[count, 1] = n[1]
    scratch.triangle_plane[count, 2] = n[2]
    scratch.triangle_plane[count, 3] = distance
    return count + 1


@njit
def first_faces(scratch: Any) -> int:
    p = corner_of(int64(0), scratch)
    q = sub(corner_of(int64(1), scratch), p)
    r = sub(corner_of(int64(2), scratch), p)
    j, k = int64(1), int64(2)
    if dot(cross(q, r), sub(corner_of(int64(3), scratch), p)) > 0.0:
        j, k = k, j
    zero, three = int64(0), int64(3)
    count = put_triangle(zero, j, k, zero, scratch)
    count = put_triangle(zero, three, j, count, scratch)
    count = put_triangle(j, three, k, count, scratch)
    return put_triangle(k, three, zero, count, scratch)


@njit
def nearest_face(count: int, scratch: Any) -> int:
    best = np.inf
    face = int64(-1)
    for f in range(count):
        if scratch.triangle_plane[f, 3] < best:
            best = scratch.triangle_plane[f, 3]
            face = int64(f)
    return face


@njit
def overlap_of_cores(a: Solid, b: Solid, vertices: Array | None, scratch: Any) -> tuple[bool, Vec, float, Vec, Vec]:
    """Return (found, unit direction from a to b, separation along it, point of a, point of b) of overlapping cores."""
    size = first_hull(a, b, vertices, scratch)
    normal = (0.0, 0.0, 1.0)
    p = (0.0, 0.0, 0.0)
    q = p
    if not size > 0.0:
        return False, normal, 0.0, p, q
    faces = first_faces(scratch)
    depth = np.inf
    corners = int64(4)
    while corners < EPA_VERTICES:
        face = nearest_face(faces, scratch)
        if face < 0:
            break
        plane = scratch.triangle_plane[face]
        n = (plane[0], plane[1], plane[2])
        low = plane[3]
        w = put_support(a, b, vertices, n, scratch.corner[corners])
        reach = dot(n, w)
        if reach < depth:
            depth = reach
            normal = n
            p, q = points_of(face, scratch)
        if reach - low <= EXACT * size:
            break
        faces = grow(w, corners, faces, FLAT * size, scratch)
        if faces == 0:
            break
        corners += 1
    return depth < np.inf, normal, -depth, p, q


@njit
def points_of(face: int, scratch: Any) -> tuple[Vec, Vec]:
    """Return the points of a and b that belong to the point of a face nearest to the origin."""
    i, j, k = scratch.triangle[face, 0], scratch.triangle[face, 1], scratch.triangle[face, 2]
    weights = triangle_weights(corner_of(i, scratch), corner_of(j, scratch), corner_of(k, scratch))
    p = (0.0, 0.0, 0.0)
    q = p
    for c in range(3):
        row = scratch.corner[scratch.triangle[face, c]]
        p = along(p, weights[c], (row[3], row[4], row[5]))
        q = along(q, weights[c], (row[6], row[7], row[8]))
    return p, q


@njit
def grow(w: Vec, corner: int, faces: int, flat: float, scratch: Any) -> int:
    """Replace the faces visible from w by faces from w to the border of the hole; returns 0 if that fails."""
    edges = int64(0)
    f = int64(0)
    while f < faces:
        plane = scratch.triangle_plane[f]
        if plane[0] * w[0] + plane[1] * w[1] + plane[2] * w[2] - plane[3] > flat:
            for k in range(3):
                i = scratch.triangle[f, k]
                j = scratch.triangle[f, k + 1 if k < 2 else 0]
                edges = toggle_edge(i, j, edges, scratch)
            faces -= 1
            for k in range(3):
                scratch.triangle[f, k] = scratch.triangle[faces, k]
            for k in range(4):
                scratch.triangle_plane[f, k] = scratch.triangle_plane[faces, k]
        else:
            f += 1
    if edges < 3 or faces + edges > EPA_FACES:
        return int64(0)
    for e in range(edges):
        faces = put_triangle(scratch.rim[e, 0], scratch.rim[e, 1], corner, faces, scratch)
    return faces


@njit
def toggle_edge(i: int, j: int, edges: int, scratch: Any) -> int:
    """Add an edge to the border, or remove it where the other side has it as well."""
    rim = scratch.rim
    for e in range(edges):
        if rim[e, 0] == j and rim[e, 1] == i:
            rim[e, 0] = rim[edges - 1, 0]
            rim[e, 1] = rim[edges - 1, 1]
            return edges - 1
    if edges < EPA_EDGES:
        rim[edges, 0] = i
        rim[edges, 1] = j
        return edges + 1
    return edges
