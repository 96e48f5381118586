"""Intersections of 2D rays with one shape; core/rays.py says what counts as a hit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..core.rays import SLACK, Hit, Ray, clip_interval, slab
from ..jit import njit
from .geometry import bounding_box, shape_pose
from .kinds import BOX, CIRCLE, HALF_PLANE, POLYGON, TERRAIN
from .math import Pose, cross, rotate, to_local, unrotate
from .narrowphase.chains import Mover, chain_near, nearest_edge
from .narrowphase.polygons import Outline
from .vertices import LEAF_SEGMENTS, leaf_count

Box = tuple[tuple[float, float], tuple[float, float]]  # m, lower and upper corner


@njit
def miss() -> Hit:
    return Hit(np.inf, (0.0, 0.0))


@njit
def inside(ray: Ray) -> Hit:
    return Hit(0.0, (-ray.way[0], -ray.way[1]))


# ---------------------------------------------------------------- one shape, in its own frame


@njit
def circle_hit(ray: Ray, x: float, radius: float) -> Hit:
    """Return the hit of a circle with centre (x, 0)."""
    ox = ray.at[0] - x
    aside = cross(ray.way[0], ray.way[1], ox, ray.at[1])
    half = (radius - aside) * (radius + aside)
    if not half > 0.0:
        return miss()
    half = np.sqrt(half)
    middle = -(ox * ray.way[0] + ray.at[1] * ray.way[1])
    if not middle + half > 0.0:
        return miss()
    t = middle - half
    if t < 0.0:
        return inside(ray)
    return Hit(t, ((ox + t * ray.way[0]) / radius, (ray.at[1] + t * ray.way[1]) / radius))


@njit
def box_hit(ray: Ray, half_x: float, half_y: float) -> Hit:
    enter_x, leave_x = slab(ray.at[0], ray.way[0], half_x)
    enter_y, leave_y = slab(ray.at[1], ray.way[1], half_y)
    enter = max(enter_x, enter_y)
    leave = min(leave_x, leave_y)
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    if enter_x > enter_y:
        return Hit(enter, (-1.0 if ray.way[0] > 0.0 else 1.0, 0.0))
    return Hit(enter, (0.0, -1.0 if ray.way[1] > 0.0 else 1.0))


@njit
def capsule_hit(ray: Ray, half_length: float, radius: float) -> Hit:
    """Return the hit of a capsule: the point at which the ray enters |y| < radius selects a side or an end."""
    enter, leave = slab(ray.at[1], ray.way[1], radius)
    if not (enter < leave and leave > 0.0):
        return miss()
    x = ray.at[0] + max(enter, 0.0) * ray.way[0]
    if abs(x) > half_length:
        return circle_hit(ray, half_length if x > 0.0 else -half_length, radius)
    if enter < 0.0:
        return inside(ray)
    return Hit(enter, (0.0, -1.0 if ray.way[1] > 0.0 else 1.0))


@njit
def polygon_hit(ray: Ray, first: int, count: int, vertices: Any) -> Hit:
    """Return the hit of a polygon, by clipping the ray with the half-plane of each edge."""
    enter = -np.inf
    leave = np.inf
    edge = first
    for i in range(first, first + count):
        vertex = vertices[i]
        nx = vertex.normal[0]
        ny = vertex.normal[1]
        height = nx * (ray.at[0] - vertex.position[0]) + ny * (ray.at[1] - vertex.position[1])
        speed = nx * ray.way[0] + ny * ray.way[1]
        enter, leave, edge = clip_interval(enter, leave, edge, i, height, speed)
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    return Hit(enter, (vertices[edge].normal[0], vertices[edge].normal[1]))


@njit
def half_plane_hit(ray: Ray) -> Hit:
    if ray.at[1] < 0.0:
        return inside(ray)
    if ray.way[1] < 0.0:
        return Hit(-ray.at[1] / ray.way[1], (0.0, 1.0))
    return miss()


@njit
def terrain_hit(ray: Ray, shape_model: Any, vertices: Any, depth: float) -> Hit:
    """Return the hit of the nearest edge that is crossed from outside, found by the chain's bounding tree."""
    if depth > 0.0 and lies_behind(shape_model, vertices, ray.at[0], ray.at[1], depth):
        return inside(ray)
    first = int64(shape_model.vertex_first)
    count = int64(shape_model.vertex_count)
    leaves = leaf_count(count)
    nearest = np.inf
    edge = int64(-1)
    node = int64(1)
    while True:
        entry = vertices[first + node - 1]
        reach = min(nearest, ray.length)
        lower = entry.node_lower
        upper = entry.node_upper
        if not misses_box(ray, reach, lower[0], lower[1], upper[0], upper[1]):
            if node < leaves:
                node *= 2
                continue
            leaf = node - leaves
            for i in range(leaf * LEAF_SEGMENTS, min((leaf + 1) * LEAF_SEGMENTS, count)):
                t = edge_distance(ray, vertices, first, i)
                if t < nearest:
                    nearest = t
                    edge = i
        while node & 1:  # up from right children
            node >>= 1
        if node == 0:
            break
        node += 1
    if edge < 0:
        return miss()
    normal = vertices[first + edge].normal
    return Hit(nearest, (normal[0], normal[1]))


@njit
def edge_distance(ray: Ray, vertices: Any, first: int, i: int) -> float:
    """Return the distance in m at which the ray crosses edge i of a chain from its outside, or infinity.

    The test is on which side of the ray each end lies: neighbours share their ends bit by bit, so that no
    ray passes between two edges.
    """
    start = vertices[first + i]
    if start.next < 0:
        return np.inf
    end = vertices[first + start.next]
    ax = start.position[0] - ray.at[0]
    ay = start.position[1] - ray.at[1]
    bx = end.position[0] - ray.at[0]
    by = end.position[1] - ray.at[1]
    right = cross(ray.way[0], ray.way[1], ax, ay)
    left = cross(ray.way[0], ray.way[1], bx, by)
    if not (right <= 0.0 and left >= 0.0 and right < left):
        return np.inf
    a = ax * ray.way[0] + ay * ray.way[1]
    b = bx * ray.way[0] + by * ray.way[1]
    t = a + (b - a) * (right / (right - left))
    return t if t >= 0.0 else np.inf


@njit
def lies_behind(shape_model: Any, vertices: Any, x: float, y: float, depth: float) -> bool:
    """Whether the point lies behind the chain's nearest edge within `depth`."""
    outline = Outline(int64(-1), int64(1), 0.0, 0.0, 0.0, 0.0)
    point = Mover(outline, Pose(x, y, 1.0, 0.0), x, y, 0.0, 0.0, 0.0, 0.0, 0.0, depth)
    chain = chain_near(shape_model, vertices, point)
    _, _, is_outside = nearest_edge(chain, point, vertices, x, y)
    return not is_outside


# ---------------------------------------------------------------- a shape in the world


@njit
def pose_of_shape(body: Any, body_parameter: Any, shape_parameter: Any) -> Pose:
    """Return the pose of a shape; `body.position` is the centre of mass."""
    return shape_pose(body, body_parameter, shape_parameter)


@njit
def box_of_shape(model: Any, parameter: Any, vertices: Any, pose: Pose, depth: float) -> Box:
    """Return the box outside of which no ray hits the shape."""
    lower, upper = bounding_box(model, parameter, vertices, pose)
    rim = depth if model.kind == TERRAIN else 0.0
    return (lower[0] - rim, lower[1] - rim), (upper[0] + rim, upper[1] + rim)


@njit
def misses_box(ray: Ray, reach: float, lower_x: float, lower_y: float, upper_x: float, upper_y: float) -> bool:
    """Whether the first `reach` m of a ray miss a box, by separating axes.

    There are no branches, since those are mispredicted for rays in all directions.
    """
    ex = ray.at[0] + reach * ray.way[0]
    ey = ray.at[1] + reach * ray.way[1]
    pad = SLACK * (abs(ray.at[0]) + abs(ray.at[1]) + reach)
    wide = 0.5 * (upper_x - lower_x)
    high = 0.5 * (upper_y - lower_y)
    aside = ray.way[0] * (lower_y + high - ray.at[1]) - ray.way[1] * (lower_x + wide - ray.at[0])
    return (
        (min(ray.at[0], ex) - pad > upper_x)
        | (max(ray.at[0], ex) + pad < lower_x)
        | (min(ray.at[1], ey) - pad > upper_y)
        | (max(ray.at[1], ey) + pad < lower_y)
        | (abs(aside) > abs(ray.way[0]) * high + abs(ray.way[1]) * wide + SLACK * (wide + high) + pad)
    )


@njit
def shape_hit(ray: Ray, model: Any, parameter: Any, vertices: Any, depth: float) -> Hit:
    """Return the hit of a shape; `ray` is in the shape's frame."""
    if model.kind == CIRCLE:
        return circle_hit(ray, 0.0, parameter.radius)
    if model.kind == BOX:
        return box_hit(ray, parameter.size[0], parameter.size[1])
    if model.kind == HALF_PLANE:
        return half_plane_hit(ray)
    if vertices is not None:
        if model.kind == POLYGON:
            return polygon_hit(ray, int64(model.vertex_first), int64(model.vertex_count), vertices)
        if model.kind == TERRAIN:
            return terrain_hit(ray, model, vertices, depth)
    return capsule_hit(ray, parameter.size[0], parameter.radius)


@njit
def hit_in_world(entry: Any, model: Any, parameter: Any, pose: Pose, box: Box, vertices: Any, depth: float) -> Hit:
    """Return the hit of a ray of ray_dtype with a shape, in the world."""
    reach = entry.distance
    ray = Ray((entry.origin[0], entry.origin[1]), (entry.direction[0], entry.direction[1]), reach)
    if model.kind != HALF_PLANE and misses_box(ray, reach, box[0][0], box[0][1], box[1][0], box[1][1]):
        return miss()
    start = to_local(pose, ray.at[0], ray.at[1])
    way = unrotate(pose.cos, pose.sin, ray.way[0], ray.way[1])
    hit = shape_hit(Ray(start, way, reach), model, parameter, vertices, depth)
    return Hit(hit.distance, rotate(pose.cos, pose.sin, hit.normal[0], hit.normal[1]))
