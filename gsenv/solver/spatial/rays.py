"""Intersections of 3D rays with one shape; core/rays.py says what counts as a hit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..core.rays import SLACK, Hit, Ray, clip_interval, slab
from ..jit import njit
from .field_rays import field_hit, inside, miss
from .geometry import bounding_box, shape_place
from .kinds import BOX, CAPSULE, CYLINDER, HEIGHTFIELD, HULL, PLANE
from .math import Pose, Vec, along, cross, dot, norm, pose_of, rotate, to_local, unrotate, vec

Box = tuple[Vec, Vec]  # m, lower and upper corner


# ---------------------------------------------------------------- one shape, in its own frame


@njit
def sphere_hit(ray: Ray, z: float, radius: float) -> Hit:
    """Return the hit of a sphere with centre (0, 0, z)."""
    start = (ray.at[0], ray.at[1], ray.at[2] - z)
    aside = norm(cross(ray.way, start))
    half = (radius - aside) * (radius + aside)
    if not half > 0.0:
        return miss()
    half = np.sqrt(half)
    middle = -dot(start, ray.way)
    if not middle + half > 0.0:
        return miss()
    t = middle - half
    if t < 0.0:
        return inside(ray)
    out = along(start, t, ray.way)
    return Hit(t, (out[0] / radius, out[1] / radius, out[2] / radius))


@njit
def box_hit(ray: Ray, half: Vec) -> Hit:
    enter_x, leave_x = slab(ray.at[0], ray.way[0], half[0])
    enter_y, leave_y = slab(ray.at[1], ray.way[1], half[1])
    enter_z, leave_z = slab(ray.at[2], ray.way[2], half[2])
    enter = max(max(enter_x, enter_y), enter_z)
    leave = min(min(leave_x, leave_y), leave_z)
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    if enter_z == enter:
        return Hit(enter, (0.0, 0.0, -1.0 if ray.way[2] > 0.0 else 1.0))
    if enter_y == enter:
        return Hit(enter, (0.0, -1.0 if ray.way[1] > 0.0 else 1.0, 0.0))
    return Hit(enter, (-1.0 if ray.way[0] > 0.0 else 1.0, 0.0, 0.0))


@njit
def tube(ray: Ray, radius: float) -> tuple[float, float]:
    """Return the interval of t in which the ray is nearer to the z axis than the radius."""
    speed = np.sqrt(ray.way[0] * ray.way[0] + ray.way[1] * ray.way[1])
    if speed == 0.0:
        return slab(np.sqrt(ray.at[0] * ray.at[0] + ray.at[1] * ray.at[1]), 0.0, radius)
    x, y = ray.way[0] / speed, ray.way[1] / speed
    aside = x * ray.at[1] - y * ray.at[0]
    half = (radius - aside) * (radius + aside)
    if not half > 0.0:
        return np.inf, -np.inf
    half = np.sqrt(half)
    middle = -(x * ray.at[0] + y * ray.at[1])
    return (middle - half) / speed, (middle + half) / speed


@njit
def side_hit(ray: Ray, t: float, radius: float) -> Hit:
    """Return the hit at t on the round side about the z axis."""
    return Hit(t, ((ray.at[0] + t * ray.way[0]) / radius, (ray.at[1] + t * ray.way[1]) / radius, 0.0))


@njit
def capsule_hit(ray: Ray, half_length: float, radius: float) -> Hit:
    """Return the hit of a capsule: the point at which the ray enters the tube selects the side or an end."""
    enter, leave = tube(ray, radius)
    if not (enter < leave and leave > 0.0):
        return miss()
    z = ray.at[2] + max(enter, 0.0) * ray.way[2]
    if abs(z) > half_length:
        return sphere_hit(ray, half_length if z > 0.0 else -half_length, radius)
    if enter < 0.0:
        return inside(ray)
    return side_hit(ray, enter, radius)


@njit
def cylinder_hit(ray: Ray, half_length: float, radius: float) -> Hit:
    enter_side, leave_side = tube(ray, radius)
    enter_end, leave_end = slab(ray.at[2], ray.way[2], half_length)
    enter = max(enter_side, enter_end)
    leave = min(leave_side, leave_end)
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    if enter_end == enter:
        return Hit(enter, (0.0, 0.0, -1.0 if ray.way[2] > 0.0 else 1.0))
    return side_hit(ray, enter, radius)


@njit
def hull_hit(ray: Ray, first: int, vertices: Any) -> Hit:
    """Return the hit of a hull, by clipping the ray with the half-space of each face."""
    enter = -np.inf
    leave = np.inf
    face = first
    for i in range(first, first + vertices[first].face_count):
        n = vec(vertices[i].normal)
        height = dot(n, ray.at) - vertices[i].offset
        speed = dot(n, ray.way)
        enter, leave, face = clip_interval(enter, leave, face, i, height, speed)
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    return Hit(enter, vec(vertices[face].normal))


@njit
def plane_hit(ray: Ray) -> Hit:
    if ray.at[2] < 0.0:
        return inside(ray)
    if ray.way[2] < 0.0:
        return Hit(-ray.at[2] / ray.way[2], (0.0, 0.0, 1.0))
    return miss()


# ---------------------------------------------------------------- a shape in the world


@njit
def pose_of_shape(body: Any, body_parameter: Any, shape_parameter: Any) -> Pose:
    """Return the pose of a shape; `body.position` is the centre of mass."""
    place, rotation = shape_place(body, body_parameter, shape_parameter)
    return pose_of(place, rotation)


@njit
def box_of_shape(model: Any, parameter: Any, vertices: Any, pose: Pose, depth: float) -> Box:
    """Return the box outside of which no ray hits the shape."""
    lower, upper = bounding_box(model, parameter, vertices, pose)
    rim = depth if model.kind == HEIGHTFIELD else 0.0
    return (lower[0] - rim, lower[1] - rim, lower[2] - rim), (upper[0] + rim, upper[1] + rim, upper[2] + rim)


@njit
def misses_box(ray: Ray, box: Box) -> bool:
    """Whether a ray misses a box, by separating axes: those of the box, and those normal to the ray and one of them.

    There are no branches, since those are mispredicted for rays in all directions.
    """
    lower, upper = box
    reach = 0.5 * ray.length
    wx, wy, wz = abs(ray.way[0]), abs(ray.way[1]), abs(ray.way[2])
    pad = SLACK * (abs(ray.at[0]) + abs(ray.at[1]) + abs(ray.at[2]) + ray.length)
    hx = 0.5 * (upper[0] - lower[0]) * (1.0 + SLACK) + pad
    hy = 0.5 * (upper[1] - lower[1]) * (1.0 + SLACK) + pad
    hz = 0.5 * (upper[2] - lower[2]) * (1.0 + SLACK) + pad
    x = 0.5 * (upper[0] + lower[0]) - ray.at[0]
    y = 0.5 * (upper[1] + lower[1]) - ray.at[1]
    z = 0.5 * (upper[2] + lower[2]) - ray.at[2]
    aside = cross(ray.way, (x, y, z))
    return (
        (abs(x - reach * ray.way[0]) > hx + reach * wx)
        | (abs(y - reach * ray.way[1]) > hy + reach * wy)
        | (abs(z - reach * ray.way[2]) > hz + reach * wz)
        | (abs(aside[0]) > wy * hz + wz * hy + pad)
        | (abs(aside[1]) > wz * hx + wx * hz + pad)
        | (abs(aside[2]) > wx * hy + wy * hx + pad)
    )


@njit
def shape_hit(ray: Ray, model: Any, parameter: Any, vertices: Any, depth: float) -> Hit:
    """Return the hit of a shape; `ray` is in the shape's frame."""
    if model.kind == BOX:
        return box_hit(ray, vec(parameter.size))
    if model.kind == CAPSULE:
        return capsule_hit(ray, parameter.size[2], parameter.radius)
    if model.kind == CYLINDER:
        return cylinder_hit(ray, parameter.size[2], parameter.radius)
    if model.kind == PLANE:
        return plane_hit(ray)
    if vertices is not None:
        if model.kind == HULL:
            return hull_hit(ray, int64(model.vertex_first), vertices)
        if model.kind == HEIGHTFIELD:
            return field_hit(ray, model, vertices, depth)
    return sphere_hit(ray, 0.0, parameter.radius)


@njit
def hit_in_world(entry: Any, model: Any, parameter: Any, pose: Pose, box: Box, vertices: Any, depth: float) -> Hit:
    """Return the hit of a ray of ray_dtype with a shape, in the world."""
    ray = Ray(vec(entry.origin), vec(entry.direction), entry.distance)
    if model.kind != PLANE and misses_box(ray, box):
        return miss()
    local = Ray(to_local(pose, ray.at), unrotate(pose, ray.way), ray.length)
    hit = shape_hit(local, model, parameter, vertices, depth)
    return Hit(hit.distance, rotate(pose, hit.normal))
