"""Contacts of circles with circles, boxes and capsules, all of which are rounded boxes."""

from __future__ import annotations

import numpy as np
from numba import int64

from ...core.faces import FACE_OF_A, NO_FACE
from ...jit import njit
from ..math import Pose
from .boxes import RoundBox
from .manifold import Manifold, no_manifold, point_manifold


@njit
def box_circle(pose_a: Pose, box: RoundBox, pose_b: Pose, radius_b: float, margin: float) -> Manifold:
    """Return the contact of rounded box a and circle b, at the nearest point of the core or from inside."""
    half_x, half_y, radius_a = box
    dx = pose_b.x - pose_a.x
    dy = pose_b.y - pose_a.y
    x = pose_a.cos * dx + pose_a.sin * dy
    y = pose_a.cos * dy - pose_a.sin * dx
    near_x = min(max(x, -half_x), half_x)
    near_y = min(max(y, -half_y), half_y)
    on_face = abs(x) < half_x or abs(y) < half_y
    nx = x - near_x
    ny = y - near_y
    distance = np.sqrt(nx * nx + ny * ny)
    if not distance - radius_a - radius_b <= margin:
        return no_manifold()
    if distance > 0.0:
        nx /= distance
        ny /= distance
    elif half_x - abs(x) < half_y - abs(y):
        nx = 1.0 if x > 0.0 else -1.0
        near_x = nx * half_x
        distance = abs(x) - half_x
    else:
        ny = 1.0 if y >= 0.0 else -1.0
        near_y = ny * half_y
        distance = abs(y) - half_y
    separation = distance - radius_a - radius_b
    reach = radius_a + 0.5 * separation
    x = near_x + nx * reach
    y = near_y + ny * reach
    cos = pose_a.cos
    sin = pose_a.sin
    return point_manifold(
        cos * nx - sin * ny,
        sin * nx + cos * ny,
        pose_a.x + cos * x - sin * y,
        pose_a.y + sin * x + cos * y,
        separation,
        int64(0),
        FACE_OF_A if on_face else NO_FACE,
        radius_b,
    )
