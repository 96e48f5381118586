"""Contacts of planes with convex shapes: the lowest points of the shape above the plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...core.faces import FACE_OF_A
from ...jit import njit
from ..kinds import CYLINDER, HULL
from ..math import Pose, Vec, add, along, dot, rotate, scaled, sub, vec
from .clip import add_spot, choose_spots
from .features import LOWEST, RIM, Basis, basis_of, rim_direction
from .manifold import begin_manifold, clear_manifold, set_face
from .scratch import CLIP_MAX
from .solids import Solid, from_origin, support, support_vertex

Array = NDArray[Any]

STANDING = 0.7  # cosine: a cylinder at a larger tilt touches only with the lowest point of each cap
RIMS = 4  # number of points of a standing cap
CAP_LABELS = 32


@njit
def collide_plane(plane: Pose, solid: Solid, vertices: Array | None, margin: float, m: Any, scratch: Any) -> None:
    """Fill m for a plane, z <= 0 in its frame, and a solid; both poses are in the world."""
    n = plane.z
    origin = solid.pose.at
    b = from_origin(solid, origin)
    height = dot(n, sub(origin, plane.at))
    separation = height + dot(n, support(b, vertices, scaled(n, -1.0))) - b.grown
    if not separation <= margin:
        clear_manifold(m)
        return
    begin_manifold(m, n, separation)
    set_face(m, FACE_OF_A, solid)
    basis = basis_of(n)
    reach = min(margin, separation + b.extent)  # the upper corners of a body smaller than the margin carry nothing
    count = int64(0)
    if b.kind == CYLINDER:
        count = cylinder_spots(b, basis, height, reach, scratch)
    elif b.kind == HULL:
        if vertices is not None:
            count = hull_spots(b, vertices, basis, height, reach, scratch)
    else:
        count = box_spots(b, basis, height, reach, scratch)
    least = np.inf
    for i in range(count):
        least = min(least, scratch.spot[i, 3])
    for i in range(choose_spots(count, least, scratch)):
        k = scratch.chosen[i]
        add_spot(m, basis, origin, k, scratch.spot_label[k], scratch)


@njit
def put_low(p: Vec, label: int, basis: Basis, height: float, margin: float, count: int, scratch: Any) -> int:
    """Add a candidate at the surface point p, relative to a point at `height` above the plane."""
    h = dot(basis.n, p)
    gap = height + h
    if not gap <= margin or count >= CLIP_MAX:
        return count
    scratch.spot[count, 0] = dot(basis.t, p)
    scratch.spot[count, 1] = dot(basis.s, p)
    scratch.spot[count, 2] = h - 0.5 * gap
    scratch.spot[count, 3] = gap
    scratch.spot_label[count] = label
    return count + 1


@njit
def box_spots(b: Solid, basis: Basis, height: float, margin: float, scratch: Any) -> int:
    """Write the corners of a box as spots, each only once where the core has no width in some direction."""
    count = int64(0)
    for corner in range(8):
        flat_x = b.half[0] == 0.0 and corner & 1
        flat_y = b.half[1] == 0.0 and corner & 2
        flat_z = b.half[2] == 0.0 and corner & 4
        if flat_x or flat_y or flat_z:
            continue
        local = (
            b.half[0] if corner & 1 else -b.half[0],
            b.half[1] if corner & 2 else -b.half[1],
            b.half[2] if corner & 4 else -b.half[2],
        )
        p = along(rotate(b.pose, local), -b.grown, basis.n)
        count = put_low(p, int64(corner), basis, height, margin, count, scratch)
    return count


@njit
def cylinder_spots(b: Solid, basis: Basis, height: float, margin: float, scratch: Any) -> int:
    """Write four points of the lower rim if the cylinder stands, and each rim's lowest point if it is none of them."""
    pose = b.pose
    n = basis.n
    upright = dot(pose.z, n)
    count = int64(0)
    stands = abs(upright) > STANDING
    down = scaled(n, -1.0)
    lower = int64(1) if upright < 0.0 else int64(0)
    slope = along(down, upright, pose.z)
    lean = np.sqrt(dot(slope, slope))
    for cap in range(2):
        axis = scaled(pose.z, 1.0 if cap == 1 else -1.0)
        middle = scaled(axis, b.half[2])
        if stands and cap == lower:
            for k in range(RIMS):
                rim, label = rim_direction(axis, down, basis.t, int64(k), int64(RIM // RIMS))
                p = along(middle, b.radius, rim)
                count = put_low(p, CAP_LABELS * cap + label, basis, height, margin, count, scratch)
        elif lean > 0.0:
            p = along(middle, b.radius / lean, slope)
            count = put_low(p, int64(CAP_LABELS * cap + LOWEST), basis, height, margin, count, scratch)
    return count


@njit
def hull_spots(b: Solid, vertices: Array, basis: Basis, height: float, margin: float, scratch: Any) -> int:
    """Write the vertices of a hull within the margin, the lowest one first."""
    pose = b.pose
    n = basis.n
    down = (-dot(n, pose.x), -dot(n, pose.y), -dot(n, pose.z))
    low = support_vertex(vertices, b.first, down)
    p = add(pose.at, rotate(pose, vec(vertices[b.first + low].position)))
    count = put_low(p, low, basis, height, margin, int64(0), scratch)
    for i in range(int64(vertices[b.first].vertex_count)):
        if i != low:
            p = add(pose.at, rotate(pose, vec(vertices[b.first + i].position)))
            count = put_low(p, int64(i), basis, height, margin, count, scratch)
    return count
