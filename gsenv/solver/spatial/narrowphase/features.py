"""Supporting features: the face, line or point of a shape that is farthest along a direction.

A feature is written to scratch as a polygon of 1 to FACE_MAX corners, projected along the contact normal,
with the height of its surface as a linear function of the position.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...jit import njit
from ..kinds import BOX, CYLINDER, HULL
from ..math import Pose, Vec, along, cross, dot, rotate, scaled, sub, tangents, unit, unrotate, vec
from .scratch import FACE_MAX
from .solids import Solid, support_vertex

Array = NDArray[Any]

FACING = 0.92  # cosine: for faces at a larger angle their edge is the feature
RIM = 16  # number of corners that represent a disc
STEADY = 1e-3  # rad: up to this tilt the corners of a disc do not move
LEANING = 5e-3  # rad: from this tilt on one of them is the lowest point of the disc
LOWEST = RIM  # label of that corner
EDGE_ID = 1 << 10  # feature ids: faces below, edges from this number on
# cos of 0, 22.5, ... degrees
_COS = (
    1.0, 0.9238795325112867, 0.7071067811865476, 0.3826834323650898,
    0.0, -0.3826834323650898, -0.7071067811865476, -0.9238795325112867,
    -1.0, -0.9238795325112867, -0.7071067811865476, -0.3826834323650898,
    0.0, 0.3826834323650898, 0.7071067811865476, 0.9238795325112867,
)  # fmt: skip


class Basis(NamedTuple):
    """Three unit vectors with t x s = n, the contact normal."""

    t: Vec
    s: Vec
    n: Vec


@njit
def basis_of(n: Vec) -> Basis:
    t, s = tangents(n)
    return Basis(t, s, n)


@njit
def find_feature(solid: Solid, vertices: Array | None, d: Vec, basis: Basis, side: int, scratch: Any) -> None:
    """Write the feature of the shape that is farthest along d = n (side 0) or -n (side 1)."""
    look = unrotate(solid.pose, d)
    scratch.face_count[side] = 0
    scratch.face_bend[side] = 0.0
    if solid.kind == BOX:
        box_feature(solid.half, solid.pose, look, basis, side, scratch)
    elif solid.kind == CYLINDER:
        cylinder_feature(solid, d, look, basis, side, scratch)
    elif solid.kind == HULL:
        if vertices is not None:
            hull_feature(vertices, solid.first, solid.pose, look, basis, side, scratch)
    else:
        line_feature(solid, d, basis, side, scratch)


@njit
def put_corner(p: Vec, label: int, basis: Basis, side: int, scratch: Any) -> None:
    k = scratch.face_count[side]
    scratch.face[side, k, 0] = dot(basis.t, p)
    scratch.face[side, k, 1] = dot(basis.s, p)
    scratch.face_label[side, k] = label
    scratch.face_count[side] = k + 1


@njit
def put_plane(f: Vec, p: Vec, basis: Basis, side: int, scratch: Any) -> None:
    """Set the heights to those of the plane through p with normal f."""
    k = 1.0 / dot(f, basis.n)
    scratch.face_plane[side, 0] = k * dot(f, p)
    scratch.face_plane[side, 1] = -k * dot(f, basis.t)
    scratch.face_plane[side, 2] = -k * dot(f, basis.s)


@njit
def put_line(p: Vec, q: Vec, basis: Basis, side: int, scratch: Any) -> None:
    """Write a segment as the feature, with its heights, or a point where the segment is along the normal."""
    t, s, n = basis
    e = sub(q, p)
    u = dot(t, e)
    v = dot(s, e)
    length2 = u * u + v * v
    thin = not length2 > 1e-4 * dot(e, e)
    if thin and (dot(n, e) > 0.0) == (side == 0):
        p = q  # the farther end
    put_corner(p, int64(0), basis, side, scratch)
    scratch.face_plane[side, 0] = dot(n, p)
    scratch.face_plane[side, 1] = 0.0
    scratch.face_plane[side, 2] = 0.0
    if not thin:
        put_corner(q, int64(1), basis, side, scratch)
        k = dot(n, e) / length2
        scratch.face_plane[side, 1] = k * u
        scratch.face_plane[side, 2] = k * v
        scratch.face_plane[side, 0] -= k * (u * dot(t, p) + v * dot(s, p))


@njit
def line_feature(solid: Solid, d: Vec, basis: Basis, side: int, scratch: Any) -> None:
    """Write the feature of a sphere or capsule: its core, moved to the surface."""
    pose = solid.pose
    middle = along(pose.at, solid.grown, d)
    put_line(along(middle, -solid.half[2], pose.z), along(middle, solid.half[2], pose.z), basis, side, scratch)
    scratch.face_id[side] = EDGE_ID
    scratch.face_bend[side] = solid.grown


@njit
def box_feature(half: Vec, pose: Pose, look: Vec, basis: Basis, side: int, scratch: Any) -> None:
    ax, ay, az = abs(look[0]), abs(look[1]), abs(look[2])
    # half-axes towards d
    x = scaled(pose.x, half[0] if look[0] >= 0.0 else -half[0])
    y = scaled(pose.y, half[1] if look[1] >= 0.0 else -half[1])
    z = scaled(pose.z, half[2] if look[2] >= 0.0 else -half[2])
    if max(ax, ay, az) >= FACING:
        if ax >= ay and ax >= az:
            box_face(pose.at, pose.x, x, scaled(pose.y, half[1]), scaled(pose.z, half[2]), basis, side, scratch)
            scratch.face_id[side] = 0 if look[0] >= 0.0 else 1
        elif ay >= az:
            box_face(pose.at, pose.y, y, scaled(pose.z, half[2]), scaled(pose.x, half[0]), basis, side, scratch)
            scratch.face_id[side] = 2 if look[1] >= 0.0 else 3
        else:
            box_face(pose.at, pose.z, z, scaled(pose.x, half[0]), scaled(pose.y, half[1]), basis, side, scratch)
            scratch.face_id[side] = 4 if look[2] >= 0.0 else 5
        return
    edge = EDGE_ID + (1 if look[0] >= 0.0 else 0) + (2 if look[1] >= 0.0 else 0) + (4 if look[2] >= 0.0 else 0)
    p = pose.at
    if ax <= ay and ax <= az:
        e = scaled(pose.x, half[0])
        p = along(along(p, 1.0, y), 1.0, z)
        edge = edge & ~1
    elif ay <= az:
        e = scaled(pose.y, half[1])
        p = along(along(p, 1.0, z), 1.0, x)
        edge = (edge & ~2) + 8
    else:
        e = scaled(pose.z, half[2])
        p = along(along(p, 1.0, x), 1.0, y)
        edge = (edge & ~4) + 16
    put_line(along(p, -1.0, e), along(p, 1.0, e), basis, side, scratch)
    scratch.face_id[side] = edge


@njit
def box_face(at: Vec, f: Vec, out: Vec, e: Vec, g: Vec, basis: Basis, side: int, scratch: Any) -> None:
    """Write a face at `at + out` with half-sides e and g and normal f (of either sign)."""
    p = along(at, 1.0, out)
    put_corner(along(along(p, 1.0, e), 1.0, g), int64(0), basis, side, scratch)
    put_corner(along(along(p, -1.0, e), 1.0, g), int64(1), basis, side, scratch)
    put_corner(along(along(p, -1.0, e), -1.0, g), int64(2), basis, side, scratch)
    put_corner(along(along(p, 1.0, e), -1.0, g), int64(3), basis, side, scratch)
    put_plane(f, p, basis, side, scratch)


@njit
def cylinder_feature(solid: Solid, d: Vec, look: Vec, basis: Basis, side: int, scratch: Any) -> None:
    pose = solid.pose
    if abs(look[2]) < FACING:
        across = np.sqrt(look[0] * look[0] + look[1] * look[1])
        k = solid.radius / across
        middle = along(pose.at, 1.0, rotate(pose, (k * look[0], k * look[1], 0.0)))
        put_line(along(middle, -solid.half[2], pose.z), along(middle, solid.half[2], pose.z), basis, side, scratch)
        scratch.face_id[side] = EDGE_ID
        scratch.face_bend[side] = solid.radius
        return
    axis = pose.z if look[2] >= 0.0 else scaled(pose.z, -1.0)
    middle = along(pose.at, solid.half[2], axis)
    for k in range(RIM):
        rim, label = rim_direction(axis, d, basis.t, int64(k), int64(1))
        put_corner(along(middle, solid.radius, rim), label, basis, side, scratch)
    put_plane(axis, middle, basis, side, scratch)
    scratch.face_id[side] = 0 if look[2] >= 0.0 else 1


@njit
def rim_direction(axis: Vec, d: Vec, t: Vec, k: int, stride: int) -> tuple[Vec, int]:
    """Return the k-th of RIM / stride directions around a disc, from t on, and its label.

    They do not rotate with the disc.  If the disc is tilted, the one nearest to the direction of its lowest
    point (d projected on the disc) moves to it.
    """
    e = unit(along(t, -dot(t, axis), axis))
    g = cross(axis, e)
    slope = along(d, -dot(d, axis), axis)
    lean = np.sqrt(dot(slope, slope))
    i = k * stride
    sine = _COS[(i + 12) % RIM]
    rim = along(scaled(e, _COS[i]), sine, g)
    if lean <= STEADY:
        return rim, i
    # nearest: no neighbour is nearer, of two equal ones the lower number
    here = dot(rim, slope)
    after = (i + stride) % RIM
    before = (i + RIM - stride) % RIM
    next_one = dot(along(scaled(e, _COS[after]), _COS[(after + 12) % RIM], g), slope)
    last_one = dot(along(scaled(e, _COS[before]), _COS[(before + 12) % RIM], g), slope)
    if here <= 0.0 or here < last_one or here <= next_one:
        return rim, i
    part = min((lean - STEADY) / (LEANING - STEADY), 1.0)
    moved = along(scaled(rim, 1.0 - part), part / lean, slope)
    return unit(moved), LOWEST if part >= 1.0 else i


@njit
def hull_feature(vertices: Array, first: int, pose: Pose, look: Vec, basis: Basis, side: int, scratch: Any) -> None:
    """Write the face at the supporting vertex that faces `look`, else the edge there nearest to the tangent plane."""
    corner = support_vertex(vertices, first, look)
    start = int64(vertices[first + corner].vertex_edge)
    here = vec(vertices[first + corner].position)
    face = int64(0)
    edge = start
    facing = -2.0
    level = 2.0
    e = start
    for _ in range(int64(vertices[first].edge_count)):
        entry = vertices[first + e]
        x = dot(vec(vertices[first + entry.face].normal), look)
        if x > facing:
            facing = x
            face = int64(entry.face)
        twin = int64(entry.twin)
        step = sub(vec(vertices[first + vertices[first + twin].origin].position), here)
        drop = abs(dot(step, look)) / np.sqrt(max(dot(step, step), 1e-300))
        if drop < level:
            level = drop
            edge = e
        e = int64(vertices[first + twin].next)
        if e == start:
            break
    if facing >= FACING:
        hull_face(vertices, first, face, pose, basis, side, scratch)
        return
    twin = int64(vertices[first + edge].twin)
    low = min(edge, twin)
    p = vec(vertices[first + vertices[first + low].origin].position)
    q = vec(vertices[first + vertices[first + max(edge, twin)].origin].position)
    put_line(along(pose.at, 1.0, rotate(pose, p)), along(pose.at, 1.0, rotate(pose, q)), basis, side, scratch)
    scratch.face_id[side] = EDGE_ID + low


@njit
def hull_face(vertices: Array, first: int, face: int, pose: Pose, basis: Basis, side: int, scratch: Any) -> None:
    start = int64(vertices[first + face].face_edge)
    sides = int64(0)
    e = start
    for _ in range(int64(vertices[first].edge_count)):
        sides += 1
        e = int64(vertices[first + e].next)
        if e == start:
            break
    stride = (sides + FACE_MAX - 1) // FACE_MAX
    p = pose.at
    for k in range(sides):
        if k % stride == 0:
            p = along(pose.at, 1.0, rotate(pose, vec(vertices[first + vertices[first + e].origin].position)))
            put_corner(p, int64(k), basis, side, scratch)
        e = int64(vertices[first + e].next)
    put_plane(rotate(pose, vec(vertices[first + face].normal)), p, basis, side, scratch)
    scratch.face_id[side] = face
