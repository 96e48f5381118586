"""Boxes and capsules against each other: boxes with a radius, by separating axes and clipping.

A capsule is a box of half-height 0 grown by its radius.  The reference face is the one of greatest
separation; the face of the other box that looks at it most squarely is cut to its width, and the
ends of what is left are the contact points (E. Catto, "Contact Manifolds", GDC 2007).
"""

from __future__ import annotations

import numpy as np

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose
from gsenv.solver.planar.narrowphase.manifold import (
    Manifold,
    bare_manifold,
    flipped,
    no_manifold,
    point_manifold,
)

REFERENCE_BIAS = 0.02  # of the extent: a later face must be this much better, or two would alternate
ROUND_SLOPE = 0.05  # steeper than this, a round segment rolls over the end of a face
GRAZE = 0.01  # of the extent: less overlap sideways than this is a pass, not a hit
TOUCH = 0.1  # of the above: corners that overlap less in both directions pass as well


@njit
def clip_faces(
    frame: Pose,
    half_width: float,
    normal0: float,
    side0: float,
    normal1: float,
    side1: float,
    radius_reference: float,
    radius_incident: float,
    graze: float,
    margin: float,
    feature0: int,
    feature1: int,
) -> Manifold:
    """Contact of a reference face with a segment that looks at it.

    `frame` is the middle of the face, x along its outward normal; the face is y in
    [-half_width, half_width].  The segment runs from (normal0, side0) to (normal1, side1) in it.
    Normal from the reference to the segment's shape, as `frame` has it.
    """
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
        return round_ends(
            frame, half_width, normal0, side0, normal1, side1,
            radius_reference, radius_incident, margin, feature0, feature1,
        )  # fmt: skip
    cut0 = min(max(side0, -half_width), half_width)
    cut1 = min(max(side1, -half_width), half_width)
    if overlap >= 0.0:
        normal0 += slope * (cut0 - side0)
        normal1 += slope * (cut1 - side1)
    elif normal0 < normal1:  # deep and beside the face: the deepest end stands for all
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
            x0, y0, separation0, feature0, x1, y1, separation1, feature1,
        )  # fmt: skip
    if keep0:
        return point_manifold(frame.cos, frame.sin, x0, y0, separation0, feature0)
    if keep1:
        return point_manifold(frame.cos, frame.sin, x1, y1, separation1, feature1)
    return bare_manifold(frame.cos, frame.sin, separation)


@njit
def _on_face(frame: Pose, normal: float, side: float) -> tuple[float, float]:
    x = frame.x + frame.cos * normal - frame.sin * side
    return x, frame.y + frame.sin * normal + frame.cos * side


@njit
def round_ends(
    frame: Pose,
    half_width: float,
    normal0: float,
    side0: float,
    normal1: float,
    side1: float,
    radius_reference: float,
    radius_incident: float,
    margin: float,
    feature0: int,
    feature1: int,
) -> Manifold:
    """Corner of the face with a radius against a segment whose nearer end is beside the face."""
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
    if -x >= abs(y):  # more behind the face than beside it: the cores overlap
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
    return point_manifold(world_x, world_y, px, py, separation, feature)


@njit
def incident_face(
    frame: Pose, pose: Pose, half_x: float, half_y: float
) -> tuple[float, float, float, float, int, int]:
    """Ends of the box face that looks at the face `frame` (see clip_faces) most squarely.

    (normal0, side0, normal1, side1) in that frame and the two corners (0..3, counter-clockwise
    from lower left), the lower number first.
    """
    cos = frame.cos * pose.cos + frame.sin * pose.sin  # the box turned into the frame
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
        return (
            x + half_y * sin, y - half_y * cos, x - half_y * sin, y + half_y * cos,
            corner0, corner1,
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
    return x - dx, y - dy, x + dx, y + dy, corner0, corner1


@njit
def face_frame(pose: Pose, half_x: float, half_y: float, axis: int, side: float) -> Pose:
    """Middle of a face of a box: axis 0 or 1 of the box, side 1 or -1; x along its normal."""
    if axis == 0:
        cos = side * pose.cos
        sin = side * pose.sin
        half = half_x
    else:
        cos = -side * pose.sin
        sin = side * pose.cos
        half = half_y
    return Pose(pose.x + cos * half, pose.y + sin * half, cos, sin)


@njit
def reference_face(
    pose_a: Pose, ax: float, ay: float, pose_b: Pose, bx: float, by: float, bias: float
) -> tuple[float, int, float]:
    """(core separation, face axis: 0, 1 of a or 2, 3 of b, side of it that looks at the other)."""
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
def box_box(
    pose_a: Pose,
    ax: float,
    ay: float,
    radius_a: float,
    pose_b: Pose,
    bx: float,
    by: float,
    radius_b: float,
    margin: float,
) -> Manifold:
    """Boxes of half-extents (ax, ay), (bx, by), each grown by its radius, in m."""
    extent = min(min(ax, ay) + radius_a, min(bx, by) + radius_b)
    best, face, side = reference_face(pose_a, ax, ay, pose_b, bx, by, REFERENCE_BIAS * extent)
    if not best - radius_a - radius_b <= margin:
        return no_manifold()
    graze = GRAZE * extent
    feature = (face * 2 + (1 if side > 0.0 else 0)) * 4
    if face < 2:
        frame = face_frame(pose_a, ax, ay, face, side)
        width = ay if face == 0 else ax
        n0, s0, n1, s1, corner0, corner1 = incident_face(frame, pose_b, bx, by)
        return clip_faces(
            frame, width, n0, s0, n1, s1, radius_a, radius_b,
            graze, margin, feature + corner0, feature + corner1,
        )  # fmt: skip
    frame = face_frame(pose_b, bx, by, face - 2, side)
    width = by if face == 2 else bx
    n0, s0, n1, s1, corner0, corner1 = incident_face(frame, pose_a, ax, ay)
    m = clip_faces(
        frame, width, n0, s0, n1, s1, radius_b, radius_a,
        graze, margin, feature + corner0, feature + corner1,
    )  # fmt: skip
    return flipped(m)
