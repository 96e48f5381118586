"""Circles against circles and boxes."""

from __future__ import annotations

import numpy as np

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose, rotate, to_local, to_world
from gsenv.solver.planar.narrowphase.manifold import Manifold, no_manifold, point_manifold


@njit
def circle_circle(
    pose_a: Pose, radius_a: float, pose_b: Pose, radius_b: float, margin: float
) -> Manifold:
    dx = pose_b.x - pose_a.x
    dy = pose_b.y - pose_a.y
    distance = np.sqrt(dx * dx + dy * dy)
    separation = distance - radius_a - radius_b
    if not separation <= margin:
        return no_manifold()
    nx = 0.0
    ny = 1.0  # same centre: any direction, up is the kindest
    if distance > 0.0:
        nx = dx / distance
        ny = dy / distance
    reach = radius_a + 0.5 * separation
    return point_manifold(nx, ny, pose_a.x + nx * reach, pose_a.y + ny * reach, separation, 0)


@njit
def box_circle(
    pose_a: Pose,
    half_x: float,
    half_y: float,
    pose_b: Pose,
    radius: float,
    margin: float,
) -> Manifold:
    """Box a, circle b: nearest point of the box, or the nearest face if the centre is inside."""
    x, y = to_local(pose_a, pose_b.x, pose_b.y)
    near_x = min(max(x, -half_x), half_x)
    near_y = min(max(y, -half_y), half_y)
    dx = x - near_x
    dy = y - near_y
    distance = np.sqrt(dx * dx + dy * dy)
    if not distance - radius <= margin:
        return no_manifold()
    if distance > 0.0:
        dx /= distance
        dy /= distance
    elif half_x - abs(x) < half_y - abs(y):
        dx = 1.0 if x > 0.0 else -1.0
        near_x = dx * half_x
        distance = abs(x) - half_x
    else:
        dy = 1.0 if y >= 0.0 else -1.0
        near_y = dy * half_y
        distance = abs(y) - half_y
    separation = distance - radius
    nx, ny = rotate(pose_a.cos, pose_a.sin, dx, dy)
    px, py = to_world(pose_a, near_x + 0.5 * separation * dx, near_y + 0.5 * separation * dy)
    return point_manifold(nx, ny, px, py, separation, 0)
