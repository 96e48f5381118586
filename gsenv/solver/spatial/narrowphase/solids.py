"""Convex shapes for the narrowphase: a core, rounded by a radius, and its support points.

Spheres, capsules and boxes are boxes with some half-extents zero; poses are relative to a common origin.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...jit import njit
from ..kinds import BOX, CYLINDER, HULL
from ..math import Pose, Vec, add, dot, rotate, sub, unrotate

Array = NDArray[Any]


class Solid(NamedTuple):
    kind: int
    half: Vec  # m, of the core
    radius: float  # m, of a cylinder
    grown: float  # m, rounding of the core
    extent: float  # m, smallest half-width
    first: int  # entry in vertices, of a hull
    pose: Pose


@njit
def solid_of(model: Any, parameter: Any, pose: Pose) -> Solid:
    kind = int64(model.kind)
    radius = 0.0
    grown = 0.0
    half = (0.0, 0.0, 0.0)
    if kind == BOX:
        half = (parameter.size[0], parameter.size[1], parameter.size[2])
    elif kind == CYLINDER:
        half = (0.0, 0.0, parameter.size[2])
        radius = parameter.radius
    elif kind != HULL:
        half = (0.0, 0.0, parameter.size[2])  # a sphere's size is zero
        grown = parameter.radius
    first = int64(model.vertex_first)
    return Solid(kind, half, radius, grown, parameter.extent, first, pose)


@njit
def from_origin(solid: Solid, origin: Vec) -> Solid:
    """Return the solid with its pose relative to `origin`."""
    pose = Pose(sub(solid.pose.at, origin), solid.pose.x, solid.pose.y, solid.pose.z)
    return Solid(solid.kind, solid.half, solid.radius, solid.grown, solid.extent, solid.first, pose)


@njit
def support_vertex(vertices: Array, first: int, d: Vec) -> int:
    """Return the hull's vertex farthest along d (in its frame); of equal ones the lowest index."""
    best = int64(0)
    far = -np.inf
    for i in range(int64(vertices[first].vertex_count)):
        p = vertices[first + i].position
        x = p[0] * d[0] + p[1] * d[1] + p[2] * d[2]
        if x > far:
            far = x
            best = int64(i)
    return best


@njit
def support(solid: Solid, vertices: Array | None, d: Vec) -> Vec:
    """Return a point of the core farthest along d, which may have any length but zero."""
    pose = solid.pose
    look = unrotate(pose, d)
    half = solid.half
    p = (
        half[0] if look[0] >= 0.0 else -half[0],
        half[1] if look[1] >= 0.0 else -half[1],
        half[2] if look[2] >= 0.0 else -half[2],
    )
    if solid.kind == CYLINDER:
        across = np.sqrt(look[0] * look[0] + look[1] * look[1])
        if across > 1e-12 * abs(look[2]):
            k = solid.radius / across
            p = (k * look[0], k * look[1], p[2])
    if vertices is not None:
        if solid.kind == HULL:
            q = vertices[solid.first + support_vertex(vertices, solid.first, look)].position
            p = (q[0], q[1], q[2])
    return add(pose.at, rotate(pose, p))


@njit
def separation_along(a: Solid, b: Solid, vertices: Array | None, n: Vec) -> float:
    """Return the separation of the shapes along the unit vector n from a to b, at most their distance."""
    top = dot(n, support(a, vertices, n))
    low = dot(n, support(b, vertices, (-n[0], -n[1], -n[2])))
    return low - top - a.grown - b.grown
