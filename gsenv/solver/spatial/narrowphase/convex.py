"""Cylinders and hulls against everything: faces first, then the nearest points or the depth of the cores.

A direction in which two supporting features lie over each other with the gap that separates the shapes
along it is the one of least distance, and close to the one of least depth where they overlap little.  So
a face normal (or the common normal of two axes) that does it is taken at once; else GJK and EPA decide.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.spatial.kinds import BOX, CYLINDER, HULL
from gsenv.solver.spatial.math import Pose, Vec, add, along, dot, rotate, scaled, sub, to_local, unit, vec
from gsenv.solver.spatial.narrowphase.epa import overlap_of_cores
from gsenv.solver.spatial.narrowphase.gjk import nearest_of_cores
from gsenv.solver.spatial.narrowphase.segments import lines_direction
from gsenv.solver.spatial.narrowphase.solids import Solid, separation_along, support

Array = NDArray[Any]

SHALLOW = 0.02  # of the extent: an overlap up to this is taken along a face that does
SAME = 1e-9  # of the extent: gaps that are equal
FACE_BIAS = 0.01  # of the extent: another direction must part the shapes this much better than a face


@njit
def face_direction(
    a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array | None
) -> tuple[Vec, float]:
    """(unit normal, separation along it) of the face, or pair of axes, that parts the shapes best."""
    d = sub(pose_b.at, pose_a.at)
    n, best = axes_normal(a, pose_a, b, pose_b, vertices, d, unit(d), -np.inf)
    n, best = best_face_of(a, pose_a, b, pose_b, vertices, d, 1.0, n, best)
    return best_face_of(b, pose_b, a, pose_a, vertices, scaled(d, -1.0), -1.0, n, best)


@njit
def core_direction(
    a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array | None, n: Vec, best: float, margin: float,
    scratch: Any,
) -> tuple[Vec, float, Vec]:  # fmt: skip
    """(normal, separation, half-way between the nearest or deepest points); `best` along n where that is no worse."""
    apart, p, q = nearest_of_cores(a, pose_a, b, pose_b, vertices, n, margin + a.grown + b.grown, scratch)
    if apart:
        other = unit(sub(q, p))
        separation = separation_along(a, pose_a, b, pose_b, vertices, other)
    else:
        found, other, separation, p, q = overlap_of_cores(a, pose_a, b, pose_b, vertices, scratch)
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
def axes_normal(
    a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array | None, d: Vec, n: Vec, best: float
) -> tuple[Vec, float]:
    """The direction between the axes of two round solids."""
    if a.kind == BOX or a.kind == HULL or b.kind == BOX or b.kind == HULL:
        return n, best
    axis, _, _, _ = lines_direction(d, pose_a.z, a.half[2], pose_b.z, b.half[2])
    return better(a, pose_a, b, pose_b, vertices, axis, n, best)


@njit
def better(
    a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array | None, axis: Vec, n: Vec, best: float
) -> tuple[Vec, float]:
    """`axis` and the separation along it, if that is more than `best` by more than rounding."""
    separation = separation_along(a, pose_a, b, pose_b, vertices, axis)
    if separation > best + SAME * min(a.extent, b.extent):
        return axis, separation
    return n, best


@njit
def best_face_of(
    a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array | None, d: Vec, sign: float, n: Vec, best: float
) -> tuple[Vec, float]:
    """The face normal of a that parts a from b best (times `sign`), if it does better than `best` along n."""
    n = scaled(n, sign)
    if a.kind == BOX:
        for i in range(3):
            axis = pose_a.x if i == 0 else (pose_a.y if i == 1 else pose_a.z)
            axis = scaled(axis, -1.0) if dot(axis, d) < 0.0 else axis
            n, best = better(a, pose_a, b, pose_b, vertices, axis, n, best)
    elif a.kind == CYLINDER:
        axis = scaled(pose_a.z, -1.0) if dot(pose_a.z, d) < 0.0 else pose_a.z
        n, best = better(a, pose_a, b, pose_b, vertices, axis, n, best)
    if vertices is not None:
        if a.kind == HULL:
            n, best = best_hull_face(a, pose_a, b, pose_b, vertices, n, best)
    return scaled(n, sign), best


@njit
def best_hull_face(
    a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array, n: Vec, best: float
) -> tuple[Vec, float]:
    """The same of a hull: the last point of b that was looked at rules most faces out."""
    slack = SAME * min(a.extent, b.extent)
    p = support(b, vertices, pose_b, scaled(n, -1.0))
    local = to_local(pose_a, p)
    for i in range(int64(vertices[a.first].face_count)):
        face = vertices[a.first + i]
        normal = vec(face.normal)
        offset = face.offset + a.grown + b.grown
        if dot(normal, local) - offset > best + slack:
            axis = rotate(pose_a, normal)
            local = to_local(pose_a, support(b, vertices, pose_b, scaled(axis, -1.0)))
            separation = dot(normal, local) - offset
            if separation > best + slack:
                best = separation
                n = axis
    return n, best
