"""Half-planes against everything that has corners: the lowest corner and its lower neighbour."""

from __future__ import annotations

from typing import Any

import numpy as np

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose, to_world
from gsenv.solver.planar.narrowphase.manifold import Manifold, no_manifold, point_manifold


@njit
def half_plane_box(
    plane: Pose, pose: Pose, half_x: float, half_y: float, radius: float, margin: float
) -> Manifold:
    """Half-plane a; b a circle, capsule or box: half-extents and a radius in m."""
    # the plane's normal in the frame of b
    nx = -plane.sin * pose.cos + plane.cos * pose.sin
    ny = plane.sin * pose.sin + plane.cos * pose.cos
    right = nx < 0.0
    top = ny < 0.0
    rise_x = 2.0 * half_x * abs(nx) if half_x > 0.0 else np.inf
    rise_y = 2.0 * half_y * abs(ny) if half_y > 0.0 else np.inf
    x0 = half_x if right else -half_x
    y0 = half_y if top else -half_y
    corner0 = _corner(right, top)
    height = -plane.sin * (pose.x - plane.x) + plane.cos * (pose.y - plane.y)
    separation0 = height + nx * x0 + ny * y0 - radius
    if not separation0 <= margin:
        return no_manifold()
    if rise_x <= rise_y:
        x1, y1, corner1 = -x0, y0, _corner(not right, top)
    else:
        x1, y1, corner1 = x0, -y0, _corner(right, not top)
    separation1 = separation0 + min(rise_x, rise_y)
    world_x0, world_y0 = to_world(pose, x0, y0)
    if not separation1 <= margin:
        return _one_point(plane, world_x0, world_y0, separation0, radius, corner0)
    world_x1, world_y1 = to_world(pose, x1, y1)
    return _two_points(
        plane, radius, world_x0, world_y0, separation0, corner0,
        world_x1, world_y1, separation1, corner1,
    )  # fmt: skip


@njit
def _corner(right: bool, top: bool) -> int:
    """Counter-clockwise from lower left: 0, 1, 2, 3."""
    if top:
        return 2 if right else 3
    return 1 if right else 0


@njit
def _one_point(
    plane: Pose, x: float, y: float, separation: float, radius: float, feature: int
) -> Manifold:
    """`(x, y)` is a corner of the core; the contact lies half-way down to the plane."""
    down = radius + 0.5 * separation
    return point_manifold(
        -plane.sin, plane.cos, x + plane.sin * down, y - plane.cos * down, separation, feature
    )


@njit
def _two_points(
    plane: Pose,
    radius: float,
    x0: float,
    y0: float,
    separation0: float,
    corner0: int,
    x1: float,
    y1: float,
    separation1: float,
    corner1: int,
) -> Manifold:
    """Two corners, the lower number first."""
    if corner1 < corner0:
        x0, x1 = x1, x0
        y0, y1 = y1, y0
        separation0, separation1 = separation1, separation0
        corner0, corner1 = corner1, corner0
    down0 = radius + 0.5 * separation0
    down1 = radius + 0.5 * separation1
    return Manifold(
        2, -plane.sin, plane.cos, min(separation0, separation1),
        x0 + plane.sin * down0, y0 - plane.cos * down0, separation0, corner0,
        x1 + plane.sin * down1, y1 - plane.cos * down1, separation1, corner1,
    )  # fmt: skip


@njit
def half_plane_polygon(
    plane: Pose, pose: Pose, vertices: Any, first: int, count: int, margin: float
) -> Manifold:
    """Half-plane a, polygon b with `count` vertices from `first` on."""
    nx = -plane.sin * pose.cos + plane.cos * pose.sin
    ny = plane.sin * pose.sin + plane.cos * pose.cos
    lowest = 0
    least = np.inf
    for i in range(count):
        vertex = vertices[first + i]
        rise = nx * vertex.position[0] + ny * vertex.position[1]
        if rise < least:
            least = rise
            lowest = i
    height = -plane.sin * (pose.x - plane.x) + plane.cos * (pose.y - plane.y)
    separation0 = height + least
    if not separation0 <= margin:
        return no_manifold()
    before = vertices[first + vertices[first + lowest].previous]
    after = vertices[first + vertices[first + lowest].next]
    rise_before = nx * before.position[0] + ny * before.position[1]
    rise_after = nx * after.position[0] + ny * after.position[1]
    other = vertices[first + lowest].next
    if rise_before < rise_after:
        other = vertices[first + lowest].previous
    separation1 = height + min(rise_before, rise_after)
    corner = vertices[first + lowest]
    x0, y0 = to_world(pose, corner.position[0], corner.position[1])
    if not separation1 <= margin:
        return _one_point(plane, x0, y0, separation0, 0.0, lowest)
    corner = vertices[first + other]
    x1, y1 = to_world(pose, corner.position[0], corner.position[1])
    return _two_points(plane, 0.0, x0, y0, separation0, lowest, x1, y1, separation1, other)
