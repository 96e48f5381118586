"""Contacts of polygons with polygons, boxes, capsules and circles: separating axes and clipping.

Both shapes are outlines: corners counter-clockwise and a radius around them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64

from ...core.faces import FACE_OF_A, NO_FACE
from ...jit import njit
from ..math import Pose, relative, to_world
from .boxes import GRAZE, REFERENCE_BIAS, Face, Segment, clip_faces
from .manifold import Manifold, flipped, no_manifold, point_manifold


class Outline(NamedTuple):
    """Corners of a convex shape in its own frame: vertices if `first` >= 0, else those of a box."""

    first: int
    corners: int
    half_x: float  # m
    half_y: float
    radius: float  # m, around the corners
    extent: float  # m, smallest half-width


@njit
def outline_of(shape_model: Any, shape_parameter: Any) -> Outline:
    """Return the outline of a shape; a circle has one corner, a capsule two, a box four."""
    half_x = shape_parameter.size[0]
    half_y = shape_parameter.size[1]
    radius = shape_parameter.radius
    extent = shape_parameter.extent
    first = -1
    count = 4 if half_y > 0.0 else (2 if half_x > 0.0 else 1)
    if shape_model.vertex_count > 0:
        first = shape_model.vertex_first
        count = shape_model.vertex_count
    return Outline(first, count, half_x, half_y, radius, extent)


@njit
def corner_of(outline: Outline, vertices: Any, i: int) -> tuple[float, float]:
    if outline.first >= 0:
        position = vertices[outline.first + i].position
        return position[0], position[1]
    x = outline.half_x if i == 1 or i == 2 else -outline.half_x
    return x, outline.half_y if i >= 2 else -outline.half_y


@njit
def edge_normal(outline: Outline, vertices: Any, i: int) -> tuple[float, float]:
    """Return the outward normal of the edge from corner i to the next one; a capsule has edges 0 and 1."""
    if outline.first >= 0:
        normal = vertices[outline.first + i].normal
        return normal[0], normal[1]
    if outline.corners == 2:
        return 0.0, -1.0 if i == 0 else 1.0
    if i == 0:
        return 0.0, -1.0
    if i == 1:
        return 1.0, 0.0
    if i == 2:
        return 0.0, 1.0
    return -1.0, 0.0


@njit
def support(outline: Outline, vertices: Any, x: float, y: float) -> tuple[float, int]:
    """Return the smallest dot product of (x, y) and a corner, and that corner."""
    least = np.inf
    lowest = 0
    for i in range(outline.corners):
        corner_x, corner_y = corner_of(outline, vertices, i)
        height = x * corner_x + y * corner_y
        if height < least:
            least = height
            lowest = i
    return least, lowest


@njit
def best_edge(a: Outline, b: Outline, vertices: Any, b_in_a: Pose) -> tuple[float, int]:
    """Return the largest core separation of an edge of a from b, and that edge."""
    best = -np.inf
    edge = 0
    for i in range(a.corners if a.corners > 1 else 0):
        nx, ny = edge_normal(a, vertices, i)
        x, y = corner_of(a, vertices, i)
        least, _ = support(b, vertices, b_in_a.cos * nx + b_in_a.sin * ny, b_in_a.cos * ny - b_in_a.sin * nx)
        separation = nx * (b_in_a.x - x) + ny * (b_in_a.y - y) + least
        if separation > best:
            best = separation
            edge = i
    return best, edge


@njit
def edge_face(outline: Outline, vertices: Any, edge: int, pose: Pose) -> Face:
    """Return an edge as a face in the world."""
    nx, ny = edge_normal(outline, vertices, edge)
    x0, y0 = corner_of(outline, vertices, edge)
    x1, y1 = corner_of(outline, vertices, (edge + 1) % outline.corners)
    x, y = to_world(pose, 0.5 * (x0 + x1), 0.5 * (y0 + y1))
    cos = pose.cos * nx - pose.sin * ny
    sin = pose.sin * nx + pose.cos * ny
    return Face(Pose(x, y, cos, sin), 0.5 * abs(nx * (y1 - y0) - ny * (x1 - x0)), outline.radius)


@njit
def looking_edge(outline: Outline, vertices: Any, shape_in_frame: Pose) -> tuple[int, int]:
    """Return the corners of the edge that is most opposite to the frame's x axis, the lower one first."""
    if outline.corners == 1:
        return 0, 0
    least = np.inf
    edge = 0
    for i in range(outline.corners):
        nx, ny = edge_normal(outline, vertices, i)
        along = shape_in_frame.cos * nx - shape_in_frame.sin * ny
        if along < least:
            least = along
            edge = i
    after = (edge + 1) % outline.corners
    return min(edge, after), max(edge, after)


@njit
def polygon_polygon(a: Outline, pose_a: Pose, b: Outline, pose_b: Pose, vertices: Any, margin: float) -> Manifold:
    """Return the contact of two outlines of which one is a polygon; features are in base 64, edges of b from 64 on."""
    radius = a.radius + b.radius
    best, edge = best_edge(a, b, vertices, relative(pose_a, pose_b))
    other, other_edge = best_edge(b, a, vertices, relative(pose_b, pose_a))
    if not max(best, other) - radius <= margin:
        return no_manifold()
    extent = min(a.extent, b.extent)
    graze = GRAZE * extent
    if other > best + REFERENCE_BIAS * extent:
        face = edge_face(b, vertices, other_edge, pose_b)
        return flipped(face_manifold(face, a, pose_a, vertices, graze, margin, (64 + other_edge) * 64))
    face = edge_face(a, vertices, edge, pose_a)
    return face_manifold(face, b, pose_b, vertices, graze, margin, edge * 64)


@njit
def face_manifold(
    face: Face, b: Outline, pose_b: Pose, vertices: Any, graze: float, margin: float, feature: int
) -> Manifold:
    """Return the contact of a face with an outline; `feature` is the first of 64 ids."""
    b_in_frame = relative(face.frame, pose_b)
    corner0, corner1 = looking_edge(b, vertices, b_in_frame)
    x0, y0 = corner_of(b, vertices, corner0)
    normal0, side0 = to_world(b_in_frame, x0, y0)
    if b.corners == 1:
        return corner_contact(face, normal0, side0, b.radius, margin)
    x1, y1 = corner_of(b, vertices, corner1)
    normal1, side1 = to_world(b_in_frame, x1, y1)
    segment = Segment(normal0, side0, normal1, side1, feature + corner0, feature + corner1)
    return clip_faces(face, segment, b.radius, graze, margin)


@njit
def corner_contact(face: Face, normal: float, side: float, radius_b: float, margin: float) -> Manifold:
    """Return the contact of a face with a circle, at the nearest point of the face; all have one feature id."""
    frame, half_width, radius_a = face
    near = min(max(side, -half_width), half_width)
    beside = side - near
    distance = normal
    nx = 1.0
    ny = 0.0
    if normal > 0.0 and beside != 0.0:
        distance = np.sqrt(normal * normal + beside * beside)
        nx = normal / distance
        ny = beside / distance
    separation = distance - radius_a - radius_b
    if not separation <= margin:
        return no_manifold()
    reach = radius_a + 0.5 * separation
    px, py = to_world(frame, nx * reach, near + ny * reach)
    return point_manifold(
        frame.cos * nx - frame.sin * ny,
        frame.sin * nx + frame.cos * ny,
        px,
        py,
        separation,
        int64(0),
        NO_FACE if normal > 0.0 and beside != 0.0 else FACE_OF_A,
        radius_b,
    )
