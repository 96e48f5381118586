"""Contact directions of spheres and capsules with each other and with boxes, and of spheres with cylinders."""

from __future__ import annotations

from ...jit import njit
from ..kinds import BOX, CYLINDER, SPHERE
from ..math import Vec, along, cross, dot, norm, rotate, scaled, sub, unit, unrotate
from .segments import lines_direction, point_box, point_cylinder, segment_box
from .solids import Solid

FACE_BIAS = 0.01  # of the extent: advantage in separation that an edge needs over a face


@njit
def round_direction(a: Solid, b: Solid) -> tuple[Vec, float, Vec]:
    """Return (normal, separation, midpoint of the nearest points).

    b is a sphere or capsule; a the same, a box, or, with a sphere, a cylinder.
    """
    d = sub(b.pose.at, a.pose.at)
    t = 0.0  # m, position of b's nearest point along its axis from its centre
    if a.kind == BOX or a.kind == CYLINDER:
        p = unrotate(a.pose, d)
        if a.kind == CYLINDER:
            local, distance = point_cylinder(p, a.radius, a.half[2])
        elif b.kind == SPHERE:
            local, distance = point_box(p, a.half)
        else:
            local, distance, t = capsule_direction(p, unrotate(a.pose, b.pose.z), b.half[2], a.half, a.extent)
        n = rotate(a.pose, local)
    else:
        n, distance, _, t = lines_direction(d, a.pose.z, a.half[2], b.pose.z, b.half[2])
    separation = distance - a.grown - b.grown
    middle = along(along(b.pose.at, t, b.pose.z), -b.grown - 0.5 * separation, n)
    return n, separation, middle


@njit
def capsule_direction(p: Vec, axis: Vec, half_length: float, half: Vec, extent: float) -> tuple[Vec, float, float]:
    """Return (unit direction from the box to the core, distance, position on the core), in the box's frame."""
    d = scaled(axis, half_length)
    t0, t1 = segment_box(p, d, half)
    t = 0.5 * (t0 + t1)
    n, distance = point_box(along(p, t, d), half)
    if distance > 1e-9 * (half[0] + half[1] + half[2]):
        return n, distance, t * half_length
    return through_box(p, d, half, extent, t * half_length)


@njit
def through_box(p: Vec, d: Vec, half: Vec, extent: float, t: float) -> tuple[Vec, float, float]:
    """Return the same where the segment p +- d intersects the box, by separating axes."""
    n = (1.0, 0.0, 0.0)
    best = abs(p[0]) - half[0] - abs(d[0])
    y = abs(p[1]) - half[1] - abs(d[1])
    z = abs(p[2]) - half[2] - abs(d[2])
    if y > best:
        best = y
        n = (0.0, 1.0, 0.0)
    if z > best:
        best = z
        n = (0.0, 0.0, 1.0)
    bias = FACE_BIAS * extent
    length = norm(d)
    for i in range(3):
        axis = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        x = cross(axis, d)
        if norm(x) > 1e-6 * length:
            x = unit(x)
            separation = abs(dot(x, p)) - abs(x[0]) * half[0] - abs(x[1]) * half[1] - abs(x[2]) * half[2]
            if separation > best + bias:
                best = separation
                bias = 0.0
                n = x
    if dot(n, p) < 0.0:
        n = scaled(n, -1.0)
    side = dot(n, d)
    if abs(side) > 1e-3 * length:
        t = -length if side > 0.0 else length
    return n, best, t
