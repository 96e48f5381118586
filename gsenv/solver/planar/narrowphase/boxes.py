"""Contacts of boxes and capsules: rounded boxes, by separating axes and clipping.

A capsule is a box of half-height 0 rounded by its radius.  The reference face is the one of largest
separation; the face of the other box that is most opposite to it is clipped to its width, and the
ends of the clipped face are the contact points (E. Catto, "Contact Manifolds", GDC 2007).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...core.faces import FACE_OF_A, NO_FACE
from ...jit import njit
from ..math import Pose
from .manifold import Manifold, bare_manifold, flipped, no_manifold, point_manifold

REFERENCE_BIAS = 0.02  # of the extent: advantage that a later face needs, so that two do not alternate
ROUND_SLOPE = 0.05  # largest slope at which a round segment rests on the end of a face
GRAZE = 0.01  # of the extent: shapes with a smaller lateral overlap pass each other
TOUCH = 0.1  # of GRAZE: corners that overlap less in both directions pass each other as well


class RoundBox(NamedTuple):
    """A box rounded by a radius: a capsule has no height, a circle also no width."""

    half_x: float  # m
    half_y: float
    radius: float  # m


class Face(NamedTuple):
    """A reference face, rounded by a radius."""

    frame: Pose  # its centre, x along the outward normal
    half_width: float  # m, along y
    radius: float  # m


class Segment(NamedTuple):
    """A segment opposite to a face, in the frame of the face."""

    normal0: float  # m, of the first end, along the face's normal
    side0: float  # m, along the face
    normal1: float
    side1: float
    feature0: int
    feature1: int


@njit
def box_of(shape_parameter: Any) -> RoundBox:
    return RoundBox(shape_parameter.size[0], shape_parameter.size[1], shape_parameter.radius)


@njit
def clip_faces(face: Face, segment: Segment, radius_incident: float, graze: float, margin: float) -> Manifold:
    """Return the contact of a reference face with an opposite segment, rounded by a radius.

    The normal points from the reference face to the shape of the segment.
    """
    frame, half_width, radius_reference = face
    normal0, side0, normal1, side1, feature0, feature1 = segment
    radius = radius_reference + radius_incident
    nearest = min(normal0, normal1) - radius
    overlap = min(half_width, max(side0, side1)) - max(-half_width, min(side0, side1))
    sharp = radius == 0.0
    if sharp and nearest > -TOUCH * graze and overlap < min(graze, 0.5 * half_width):
        return bare_manifold(frame.cos, frame.sin, nearest)
    slope = 0.0
    if side1 != side0:
        slope = (normal1 - normal0) / (side1 - side0)
    deepest = side0 if normal0 < normal1 else side1
    beside = overlap < 0.0 or (abs(slope) > ROUND_SLOPE and abs(deepest) > half_width)
    if beside and not sharp:
        return round_ends(face, segment, radius_incident, margin)
    cut0 = min(max(side0, -half_width), half_width)
    cut1 = min(max(side1, -half_width), half_width)
    if overlap >= 0.0:
        normal0 += slope * (cut0 - side0)
        normal1 += slope * (cut1 - side1)
    elif normal0 < normal1:  # deep and beside the face: only the deepest end counts
        cut0 = side0
        cut1 = side0
        normal1 = normal0
    else:
        cut0 = side1
        cut1 = side1
        normal0 = normal1
        feature0 = feature1
    separation0 = normal0 - radius
    separation1 = normal1 - radius
    shift = 0.5 * (radius_reference - radius_incident)
    x0, y0 = _on_face(frame, 0.5 * normal0 + shift, cut0)
    x1, y1 = _on_face(frame, 0.5 * normal1 + shift, cut1)
    separation = min(separation0, separation1)
    keep0 = separation0 <= margin
    keep1 = separation1 <= margin and cut0 != cut1
    if keep0 and keep1:
        return Manifold(
            2, frame.cos, frame.sin, separation,
            x0, y0, separation0, feature0, x1, y1, separation1, feature1, FACE_OF_A, radius_incident,
        )  # fmt: skip
    if keep0:
        return point_manifold(frame.cos, frame.sin, x0, y0, separation0, feature0, FACE_OF_A, radius_incident)
    if keep1:
        return point_manifold(frame.cos, frame.sin, x1, y1, separation1, feature1, FACE_OF_A, radius_incident)
    return bare_manifold(frame.cos, frame.sin, separation)


@njit
def _on_face(frame: Pose, normal: float, side: float) -> tuple[float, float]:
    x = frame.x + frame.cos * normal - frame.sin * side
    return x, frame.y + frame.sin * normal + frame.cos * side


@njit
def round_ends(face: Face, segment: Segment, radius_incident: float, margin: float) -> Manifold:
    """Return the contact of a rounded corner of the face with a segment whose nearer end is beside the face."""
    frame, half_width, radius_reference = face
    normal0, side0, normal1, side1, feature0, feature1 = segment
    deepest = side0 if normal0 < normal1 else side1
    corner = half_width if deepest > 0.0 else -half_width
    dx = normal1 - normal0
    dy = side1 - side0
    length2 = dx * dx + dy * dy
    part = 0.0
    if length2 > 0.0:
        part = min(max((-normal0 * dx + (corner - side0) * dy) / length2, 0.0), 1.0)
    x = normal0 + part * dx
    y = side0 + part * dy - corner
    distance = np.sqrt(x * x + y * y)
    nx = 1.0
    ny = 0.0
    if distance > 0.0:
        nx = x / distance
        ny = y / distance
    if -x >= abs(y):  # more below the face than beside it: the cores overlap
        nx = 1.0
        ny = 0.0
        distance = x
    separation = distance - radius_reference - radius_incident
    if not separation <= margin:
        return no_manifold()
    reach = radius_reference + 0.5 * separation
    px, py = _on_face(frame, nx * reach, corner + ny * reach)
    world_x = frame.cos * nx - frame.sin * ny
    world_y = frame.sin * nx + frame.cos * ny
    feature = feature0 if part < 0.5 else feature1
    return point_manifold(world_x, world_y, px, py, separation, feature, NO_FACE, 0.0)


@njit
def incident_face(frame: Pose, pose: Pose, box: RoundBox, feature: int) -> Segment:
    """Return the face of the box's core that is most opposite to the face with that frame.

    Features: `feature` plus the corner (0..3, counter-clockwise from lower left), the lower one first.
    """
    half_x = box.half_x
    half_y = box.half_y
    cos = frame.cos * pose.cos + frame.sin * pose.sin  # the box rotated to the frame
    sin = frame.cos * pose.sin - frame.sin * pose.cos
    dx = pose.x - frame.x
    dy = pose.y - frame.y
    x = frame.cos * dx + frame.sin * dy
    y = frame.cos * dy - frame.sin * dx
    if abs(cos) >= abs(sin):  # left or right face
        if cos > 0.0:  # left: corners 0 and 3
            x -= half_x * cos
            y -= half_x * sin
            corner0, corner1 = 0, 3
        else:  # right: corners 1 and 2
            x += half_x * cos
            y += half_x * sin
            corner0, corner1 = 1, 2
        return Segment(
            x + half_y * sin, y - half_y * cos, x - half_y * sin, y + half_y * cos,
            feature + corner0, feature + corner1,
        )  # fmt: skip
    # frame coordinates of the box's y axis are (-sin, cos)
    if sin < 0.0:  # bottom: corners 0 and 1
        x += half_y * sin
        y -= half_y * cos
        corner0, corner1 = 0, 1
        sign = 1.0
    else:  # top: corners 2 and 3
        x -= half_y * sin
        y += half_y * cos
        corner0, corner1 = 2, 3
        sign = -1.0
    dx = sign * half_x * cos
    dy = sign * half_x * sin
    return Segment(x - dx, y - dy, x + dx, y + dy, feature + corner0, feature + corner1)


@njit
def face_of(pose: Pose, box: RoundBox, axis: int, side: float) -> Face:
    """Return a face of a box: axis 0 or 1 of the box, side 1 or -1."""
    if axis == 0:
        cos = side * pose.cos
        sin = side * pose.sin
        half = box.half_x
        width = box.half_y
    else:
        cos = -side * pose.sin
        sin = side * pose.cos
        half = box.half_y
        width = box.half_x
    return Face(Pose(pose.x + cos * half, pose.y + sin * half, cos, sin), width, box.radius)


@njit
def reference_face(pose_a: Pose, a: RoundBox, pose_b: Pose, b: RoundBox, bias: float) -> tuple[float, int, float]:
    """Return (core separation, face axis: 0, 1 of a or 2, 3 of b, side that faces the other box)."""
    ax, ay, _ = a
    bx, by, _ = b
    cos = abs(pose_a.cos * pose_b.cos + pose_a.sin * pose_b.sin)
    sin = abs(pose_a.cos * pose_b.sin - pose_a.sin * pose_b.cos)
    dx = pose_b.x - pose_a.x
    dy = pose_b.y - pose_a.y
    place = pose_a.cos * dx + pose_a.sin * dy
    best = abs(place) - ax - bx * cos - by * sin
    face = 0
    side = 1.0 if place >= 0.0 else -1.0
    place = pose_a.cos * dy - pose_a.sin * dx
    separation = abs(place) - ay - bx * sin - by * cos
    if separation > best:
        best = separation
        face = 1
        side = 1.0 if place >= 0.0 else -1.0
    place = -(pose_b.cos * dx + pose_b.sin * dy)
    separation = abs(place) - bx - ax * cos - ay * sin
    if separation > best + bias:
        best = separation
        face = 2
        side = 1.0 if place >= 0.0 else -1.0
    place = pose_b.sin * dx - pose_b.cos * dy
    separation = abs(place) - by - ax * sin - ay * cos
    if separation > best + bias:
        best = separation
        face = 3
        side = 1.0 if place >= 0.0 else -1.0
    return best, face, side


@njit
def smaller_extent(a: RoundBox, b: RoundBox) -> float:
    """Return the smallest half-width of two boxes, m."""
    return min(min(a.half_x, a.half_y) + a.radius, min(b.half_x, b.half_y) + b.radius)


@njit
def box_box(pose_a: Pose, a: RoundBox, pose_b: Pose, b: RoundBox, margin: float) -> Manifold:
    extent = smaller_extent(a, b)
    best, axis, side = reference_face(pose_a, a, pose_b, b, REFERENCE_BIAS * extent)
    if not best - a.radius - b.radius <= margin:
        return no_manifold()
    graze = GRAZE * extent
    feature = (axis * 2 + (1 if side > 0.0 else 0)) * 4
    if axis < 2:
        face = face_of(pose_a, a, axis, side)
        return clip_faces(face, incident_face(face.frame, pose_b, b, feature), b.radius, graze, margin)
    face = face_of(pose_b, b, axis - 2, side)
    return flipped(clip_faces(face, incident_face(face.frame, pose_a, a, feature), a.radius, graze, margin))
