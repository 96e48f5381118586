"""A plane against everything: the lowest points of the shape above it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.spatial.kinds import CYLINDER, HULL
from gsenv.solver.spatial.math import Pose, Vec, add, along, dot, rotate, scaled, sub, tangents, vec
from gsenv.solver.spatial.narrowphase.clip import add_spot, choose_spots
from gsenv.solver.spatial.narrowphase.features import LOWEST, RIM, rim_direction
from gsenv.solver.spatial.narrowphase.manifold import clear_manifold, set_normal
from gsenv.solver.spatial.narrowphase.scratch import CLIP_MAX
from gsenv.solver.spatial.narrowphase.solids import Solid, support, support_vertex

Array = NDArray[Any]

STANDING = 0.7  # cosine: a cylinder that leans more touches with the lowest point of each cap only
RIMS = 4  # points of a cap that stands
CAP_LABELS = 32


@njit
def collide_plane(
    plane: Pose, b: Solid, pose_b: Pose, vertices: Array | None, margin: float, m: Any, scratch: Any
) -> None:
    """The plane is z <= 0 of its frame; both poses in the world."""
    n = plane.z
    origin = pose_b.at
    pose = Pose((0.0, 0.0, 0.0), pose_b.x, pose_b.y, pose_b.z)
    height = dot(n, sub(origin, plane.at))
    down = scaled(n, -1.0)
    separation = height + dot(n, support(b, vertices, pose, down)) - b.grown
    if not separation <= margin:
        clear_manifold(m)
        return
    m.count = 0
    m.separation = separation
    set_normal(m, n)
    t, s = tangents(n)
    count = int64(0)
    if b.kind == CYLINDER:
        count = cylinder_spots(b, pose, t, s, n, height, margin, scratch)
    elif b.kind == HULL:
        if vertices is not None:
            count = hull_spots(b, pose, vertices, t, s, n, height, separation, margin, scratch)
    else:
        count = box_spots(b, pose, t, s, n, height, margin, scratch)
    least = np.inf
    for i in range(count):
        least = min(least, scratch.spot[i, 3])
    for i in range(choose_spots(count, least, scratch)):
        k = scratch.chosen[i]
        add_spot(m, t, s, n, origin, k, scratch.spot_label[k], scratch)


@njit
def put_low(
    p: Vec, label: int, t: Vec, s: Vec, n: Vec, height: float, margin: float, count: int, scratch: Any
) -> int:
    """One more possible contact at the surface point p, which counts from a point `height` over the plane."""
    h = dot(n, p)
    gap = height + h
    if not gap <= margin or count >= CLIP_MAX:
        return count
    scratch.spot[count, 0] = dot(t, p)
    scratch.spot[count, 1] = dot(s, p)
    scratch.spot[count, 2] = h - 0.5 * gap
    scratch.spot[count, 3] = gap
    scratch.spot_label[count] = label
    return count + 1


@njit
def box_spots(
    b: Solid, pose: Pose, t: Vec, s: Vec, n: Vec, height: float, margin: float, scratch: Any
) -> int:
    """Corners of a box; of a core without width in some direction each once."""
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
        p = along(rotate(pose, local), -b.grown, n)
        count = put_low(p, int64(corner), t, s, n, height, margin, count, scratch)
    return count


@njit
def cylinder_spots(
    b: Solid, pose: Pose, t: Vec, s: Vec, n: Vec, height: float, margin: float, scratch: Any
) -> int:
    """Standing: four points of the lower rim; the lowest point of each rim where it is not one of them."""
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
                rim, label = rim_direction(axis, down, t, int64(k), int64(RIM // RIMS))
                p = along(middle, b.radius, rim)
                count = put_low(p, CAP_LABELS * cap + label, t, s, n, height, margin, count, scratch)
        elif lean > 0.0:
            p = along(middle, b.radius / lean, slope)
            count = put_low(p, int64(CAP_LABELS * cap + LOWEST), t, s, n, height, margin, count, scratch)
    return count


@njit
def hull_spots(
    b: Solid, pose: Pose, vertices: Array, t: Vec, s: Vec, n: Vec, height: float, separation: float,
    margin: float, scratch: Any,
) -> int:  # fmt: skip
    """Vertices of a hull within the margin, the lowest one first."""
    down = (-dot(n, pose.x), -dot(n, pose.y), -dot(n, pose.z))
    low = support_vertex(vertices, b.first, down)
    reach = min(margin, separation + b.extent)
    p = add(pose.at, rotate(pose, vec(vertices[b.first + low].position)))
    count = put_low(p, low, t, s, n, height, margin, int64(0), scratch)
    for i in range(int64(vertices[b.first].vertex_count)):
        if i != low:
            p = add(pose.at, rotate(pose, vec(vertices[b.first + i].position)))
            count = put_low(p, int64(i), t, s, n, height, reach, count, scratch)
    return count
