"""A convex shape over a heightfield: corners, faces and edges in the field's frame, written to scratch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from ...jit import njit
from ..kinds import BOX, CAPSULE, CYLINDER, HULL, SPHERE
from ..math import Pose, Vec, add, along, dot, rotate, scaled, sub, to_world, vec
from .fields import FLAT, TILT

FACING = 1e-3  # sine: a face that faces the ground less is a side
SHALLOW = 0.01  # of the extent: largest depth of an edge that is tilted beyond a ridge
UPRIGHT = 0.7  # cosine: a cylinder at a larger tilt does not stand on its flat end


class Body(NamedTuple):
    """A shape over a field; its corners, faces and edges are the first entries of scratch."""

    kind: int
    points: int  # number of points: the centre of a sphere, ends of a capsule, four on each rim of a cylinder
    faces: int
    edges: int
    radius: float  # m, rounding of the points; of a cylinder that of its rims
    half_length: float  # m
    extent: float  # m, smallest half-width
    turn: float  # rad, largest angle by which it may turn within the step
    pose: Pose
    low: Vec  # m, bounding box
    high: Vec


@njit
def body_over_field(model: Any, parameter: Any, vertices: Any, pose: Pose, turn: float, scratch: Any) -> Body:
    """Return the Body of a shape and write its parts; `pose`: in the field's frame."""
    kind = int64(model.kind)
    radius, half_length = parameter.radius, parameter.size[2]
    points, faces, edges = int64(1), int64(0), int64(0)
    if kind == BOX:
        points, faces, edges = write_box(vec(parameter.size), pose, scratch)
    elif kind == HULL:
        points, faces, edges = write_hull(int64(model.vertex_first), vertices, pose, scratch)
    elif kind == CAPSULE:
        points = int64(2)
        for k in range(2):
            write_point(scratch[k], along(pose.at, half_length if k else -half_length, pose.z))
    elif kind == CYLINDER:
        points = int64(8)
        for k in range(8):
            side = radius if k & 2 else -radius
            x, y = (side, 0.0) if k & 1 else (0.0, side)
            write_point(scratch[k], to_world(pose, (x, y, half_length if k & 4 else -half_length)))
    else:
        write_point(scratch[0], pose.at)
    low, high = box_around(kind, points, radius, half_length, pose, scratch)
    return Body(kind, points, faces, edges, radius, half_length, parameter.extent, turn, pose, low, high)


@njit
def write_point(entry: Any, p: Vec) -> None:
    entry.point[0] = p[0]
    entry.point[1] = p[1]
    entry.point[2] = p[2]


@njit
def write_face(entry: Any, n: Vec, offset: float) -> None:
    entry.normal[0] = n[0]
    entry.normal[1] = n[1]
    entry.normal[2] = n[2]
    entry.offset = offset


@njit
def write_box(half: Vec, pose: Pose, scratch: Any) -> tuple[int, int, int]:
    """Write a box: corner i has the signs of its bits, faces 2k and 2k + 1 have normals -axis k and +axis k."""
    for i in range(8):
        x = half[0] if i & 1 else -half[0]
        y = half[1] if i & 2 else -half[1]
        z = half[2] if i & 4 else -half[2]
        write_point(scratch[i], to_world(pose, (x, y, z)))
    edge = int64(0)
    for k in range(3):
        axis = pose.x if k == 0 else (pose.y if k == 1 else pose.z)
        width = half[0] if k == 0 else (half[1] if k == 1 else half[2])
        away = dot(axis, pose.at)
        write_face(scratch[2 * k], scaled(axis, -1.0), width - away)
        write_face(scratch[2 * k + 1], axis, width + away)
        i, j = (k + 1) % 3, (k + 2) % 3
        for sides in range(4):
            one, other = sides & 1, sides >> 1
            entry = scratch[edge]
            entry.start = (one << i) | (other << j)
            entry.end = entry.start | (1 << k)
            entry.left = 2 * i + one
            entry.right = 2 * j + other
            edge += 1
    return int64(8), int64(6), int64(12)


@njit
def write_hull(first: int, vertices: Any, pose: Pose, scratch: Any) -> tuple[int, int, int]:
    head = vertices[first]
    points, faces = int64(head.vertex_count), int64(head.face_count)
    for i in range(points):
        write_point(scratch[i], to_world(pose, vec(vertices[first + i].position)))
    for i in range(faces):
        n = rotate(pose, vec(vertices[first + i].normal))
        write_face(scratch[i], n, vertices[first + i].offset + dot(n, pose.at))
    edges = int64(0)
    for i in range(head.edge_count):
        half = vertices[first + i]
        if half.twin > i:
            entry = scratch[edges]
            entry.start = half.origin
            entry.end = vertices[first + half.twin].origin
            entry.left = half.face
            entry.right = vertices[first + half.twin].face
            edges += 1
    return points, faces, edges


@njit
def box_around(kind: int, points: int, radius: float, half_length: float, pose: Pose, scratch: Any) -> tuple[Vec, Vec]:
    if kind == CYLINDER:
        z = pose.z
        reach = (
            half_length * abs(z[0]) + radius * np.sqrt(max(1.0 - z[0] * z[0], 0.0)),
            half_length * abs(z[1]) + radius * np.sqrt(max(1.0 - z[1] * z[1], 0.0)),
            half_length * abs(z[2]) + radius * np.sqrt(max(1.0 - z[2] * z[2], 0.0)),
        )
        return sub(pose.at, reach), add(pose.at, reach)
    low = high = vec(scratch[0].point)
    for i in range(1, points):
        p = vec(scratch[i].point)
        low = (min(low[0], p[0]), min(low[1], p[1]), min(low[2], p[2]))
        high = (max(high[0], p[0]), max(high[1], p[1]), max(high[2], p[2]))
    return sub(low, (radius, radius, radius)), add(high, (radius, radius, radius))


@njit
def faces_ground(body: Body, scratch: Any, index: int, n: Vec) -> bool:
    """Whether a corner can face the ground; False if the normals of all its faces point away from it."""
    if body.kind == SPHERE or body.kind == CAPSULE:
        return True
    if body.kind == CYLINDER:
        return dot(n, body.pose.z) * (1.0 if index & 4 else -1.0) < -UPRIGHT
    p = vec(scratch[index].point)
    for f in range(body.faces):
        m = vec(scratch[f].normal)
        if dot(m, p) - scratch[f].offset > -1e-4 * body.extent and dot(m, n) < -FACING:
            return True
    return False


@njit
def slack_of(body: Body, gap: float) -> float:
    """Return the sine by which a direction may be beyond the range of normals of two edges that cross at a gap, m.

    A small rotation brings it into the range: an edge that rocks on a triangle has its weight on one of the ridges
    around this, and must not fall through another. Nothing else holds it there.
    """
    return FLAT + (min(body.turn, TILT) if gap > -SHALLOW * body.extent else 0.0)


@njit
def depth_inside(body: Body, scratch: Any, p: Vec, left: int, right: int) -> float:
    """Return the depth of a point in a box or hull, m, without two of its faces; negative outside."""
    highest = -np.inf
    for f in range(body.faces):
        if f != left and f != right:
            highest = max(highest, dot(vec(scratch[f].normal), p) - scratch[f].offset)
    return -highest


@njit
def reach_along(body: Body, scratch: Any, d: Vec) -> float:
    """Return the largest d . x of the body's points x, d of unit length."""
    if body.kind == CYLINDER:
        tilt = dot(d, body.pose.z)
        across = np.sqrt(max(1.0 - tilt * tilt, 0.0))
        return dot(d, body.pose.at) + body.half_length * abs(tilt) + body.radius * across
    most = -np.inf
    for i in range(body.points):
        most = max(most, dot(d, vec(scratch[i].point)))
    return most + body.radius
