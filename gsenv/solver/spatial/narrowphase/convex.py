"""Contacts of cylinders and hulls with convex shapes: faces first, then nearest points or depth of the cores.

A direction along which the supporting features overlap in projection, with a gap equal to the separation, is
the one of smallest distance, and close to that of smallest depth for small overlaps.  So a face normal (or the
common normal of two axes) with this property is used directly; otherwise GJK and EPA find the direction.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...core.faces import FACE_OF_A, FACE_OF_B, NO_FACE
from ...jit import njit
from ..kinds import BOX, CYLINDER, HULL
from ..math import Vec, add, along, dot, rotate, scaled, sub, to_local, unit, vec
from .epa import overlap_of_cores
from .gjk import nearest_of_cores
from .segments import lines_direction
from .solids import Solid, separation_along, support

Array = NDArray[Any]

SHALLOW = 0.02  # of the extent: largest overlap that is resolved along such a face
SAME = 1e-9  # of the extent: gaps that differ by less are equal
FACE_BIAS = 0.01  # of the extent: advantage in separation that another direction needs over a face


@njit
def face_direction(a: Solid, b: Solid, vertices: Array | None) -> tuple[Vec, float, int]:
    """Return (unit normal, separation, whose face) of the face, or pair of axes, with the largest separation."""
    d = sub(b.pose.at, a.pose.at)
    n, by_axes = axes_normal(a, b, vertices, d, unit(d), -np.inf)
    n, by_a = best_face_of(a, b, vertices, d, 1.0, n, by_axes)
    n, by_b = best_face_of(b, a, vertices, scaled(d, -1.0), -1.0, n, by_a)
    if by_b > by_a:
        return n, by_b, FACE_OF_B
    return n, by_b, FACE_OF_A if by_a > by_axes else NO_FACE


@njit
def core_direction(
    a: Solid, b: Solid, vertices: Array | None, n: Vec, best: float, margin: float,
    scratch: Any,
) -> tuple[Vec, float, Vec]:  # fmt: skip
    """Return (normal, separation, midpoint of the nearest or deepest points); n with `best` where it is no worse."""
    apart, p, q = nearest_of_cores(a, b, vertices, n, margin + a.grown + b.grown, scratch)
    if apart:
        other = unit(sub(q, p))
        separation = separation_along(a, b, vertices, other)
    else:
        found, other, separation, p, q = overlap_of_cores(a, b, vertices, scratch)
        separation -= a.grown + b.grown
        if not found or separation <= best + FACE_BIAS * min(a.extent, b.extent):
            other = n
            separation = best
    if separation < best:
        other = n
        separation = best
    p = along(p, a.grown, other)
    q = along(q, -b.grown, other)
    return other, separation, scaled(add(p, q), 0.5)


@njit
def axes_normal(a: Solid, b: Solid, vertices: Array | None, d: Vec, n: Vec, best: float) -> tuple[Vec, float]:
    """Return the better of n and the direction between the axes of two round solids, with its separation."""
    if a.kind == BOX or a.kind == HULL or b.kind == BOX or b.kind == HULL:
        return n, best
    axis, _, _, _ = lines_direction(d, a.pose.z, a.half[2], b.pose.z, b.half[2])
    return better(a, b, vertices, axis, n, best)


@njit
def better(a: Solid, b: Solid, vertices: Array | None, axis: Vec, n: Vec, best: float) -> tuple[Vec, float]:
    """Return `axis` and its separation if that exceeds `best` by more than rounding, else n and `best`."""
    separation = separation_along(a, b, vertices, axis)
    if separation > best + SAME * min(a.extent, b.extent):
        return axis, separation
    return n, best


@njit
def best_face_of(
    a: Solid, b: Solid, vertices: Array | None, d: Vec, sign: float, n: Vec, best: float
) -> tuple[Vec, float]:
    """Return the face normal of a (times `sign`) with the largest separation, if that exceeds `best` along n."""
    n = scaled(n, sign)
    if a.kind == BOX:
        for i in range(3):
            axis = a.pose.x if i == 0 else (a.pose.y if i == 1 else a.pose.z)
            axis = scaled(axis, -1.0) if dot(axis, d) < 0.0 else axis
            n, best = better(a, b, vertices, axis, n, best)
    elif a.kind == CYLINDER:
        axis = scaled(a.pose.z, -1.0) if dot(a.pose.z, d) < 0.0 else a.pose.z
        n, best = better(a, b, vertices, axis, n, best)
    if vertices is not None:
        if a.kind == HULL:
            n, best = best_hull_face(a, b, vertices, n, best)
    return scaled(n, sign), best


@njit
def best_hull_face(a: Solid, b: Solid, vertices: Array, n: Vec, best: float) -> tuple[Vec, float]:
    """Do the same for a hull: the last support point of b excludes most faces."""
    slack = SAME * min(a.extent, b.extent)
    p = support(b, vertices, scaled(n, -1.0))
    local = to_local(a.pose, p)
    for i in range(int64(vertices[a.first].face_count)):
        face = vertices[a.first + i]
        normal = vec(face.normal)
        offset = face.offset + a.grown + b.grown
        if dot(normal, local) - offset > best + slack:
            axis = rotate(a.pose, normal)
            local = to_local(a.pose, support(b, vertices, scaled(axis, -1.0)))
            separation = dot(normal, local) - offset
            if separation > best + slack:
                best = separation
                n = axis
    return n, best
