"""Rays against all shapes of a world: where each first enters a solid.

Solids are open sets: a ray that only touches one, or runs along its face, passes. One that starts
inside is hit at distance 0, with the normal against its own direction. A terrain is hit from its
outside alone, as bodies are: from behind it is open. But a start that lies behind it by no more
than `depth` (the extent of the body that carries the rays) is inside, again as for bodies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.optional import at
from gsenv.solver.planar.geometry import bounding_box, shape_pose
from gsenv.solver.planar.math import Pose, cross, rotate, to_local, unrotate
from gsenv.solver.planar.narrowphase.chains import Mover, chain_near, nearest_edge
from gsenv.solver.planar.shapes import BOX, CIRCLE, HALF_PLANE, POLYGON, TERRAIN
from gsenv.solver.planar.vertices import LEAF_SEGMENTS, leaf_count

Array = NDArray[Any]

SLACK = 1e-12  # relative, of boxes: rounding must not hide what lies on their rim


RAY_DTYPE = np.dtype(  # a ray in the world, and the nearest shape on it
    [
        ("origin", "f8", (2,)),  # m
        ("direction", "f8", (2,)),  # unit
        ("distance", "f8"),  # m: how far to look, then where the hit is
        ("normal", "f8", (2,)),  # of the surface, outward; zero without a hit
        ("shape", "i8"),  # -1: none
    ],
    align=True,
)


class Ray(NamedTuple):
    """A ray in the world or in a shape's frame."""

    x: float  # m, where it starts
    y: float
    dx: float  # unit direction
    dy: float
    length: float  # m, how far it looks


class Hit(NamedTuple):
    """Where a ray enters a solid, in the ray's frame."""

    distance: float  # m, infinite without a hit
    normal_x: float  # outward
    normal_y: float


@njit
def miss() -> Hit:
    return Hit(np.inf, 0.0, 0.0)


@njit
def inside(ray: Ray) -> Hit:
    return Hit(0.0, -ray.dx, -ray.dy)


# ---------------------------------------------------------------- one shape, in its own frame


@njit
def slab(place: float, speed: float, half: float) -> tuple[float, float]:
    """From when until when |place + t speed| < half."""
    if speed == 0.0:
        if abs(place) < half:
            return -np.inf, np.inf
        return np.inf, -np.inf
    far = half if speed > 0.0 else -half
    return (-far - place) / speed, (far - place) / speed


@njit
def circle_hit(ray: Ray, x: float, radius: float) -> Hit:
    """The circle's centre is (x, 0)."""
    ox = ray.x - x
    aside = cross(ray.dx, ray.dy, ox, ray.y)
    half = (radius - aside) * (radius + aside)
    if not half > 0.0:
        return miss()
    half = np.sqrt(half)
    middle = -(ox * ray.dx + ray.y * ray.dy)
    if not middle + half > 0.0:
        return miss()
    t = middle - half
    if t < 0.0:
        return inside(ray)
    return Hit(t, (ox + t * ray.dx) / radius, (ray.y + t * ray.dy) / radius)


@njit
def box_hit(ray: Ray, half_x: float, half_y: float) -> Hit:
    enter_x, leave_x = slab(ray.x, ray.dx, half_x)
    enter_y, leave_y = slab(ray.y, ray.dy, half_y)
    enter = max(enter_x, enter_y)
    leave = min(leave_x, leave_y)
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    if enter_x > enter_y:
        return Hit(enter, -1.0 if ray.dx > 0.0 else 1.0, 0.0)
    return Hit(enter, 0.0, -1.0 if ray.dy > 0.0 else 1.0)


@njit
def capsule_hit(ray: Ray, half_length: float, radius: float) -> Hit:
    """Where the ray comes into the strip |y| < radius decides what it can hit: a side or one end."""
    enter, leave = slab(ray.y, ray.dy, radius)
    if not (enter < leave and leave > 0.0):
        return miss()
    x = ray.x + max(enter, 0.0) * ray.dx
    if abs(x) > half_length:
        return circle_hit(ray, half_length if x > 0.0 else -half_length, radius)
    if enter < 0.0:
        return inside(ray)
    return Hit(enter, 0.0, -1.0 if ray.dy > 0.0 else 1.0)


@njit
def polygon_hit(ray: Ray, first: int, count: int, vertices: Any) -> Hit:
    """Clipped by the half-plane of each edge."""
    enter = -np.inf
    leave = np.inf
    edge = first
    for i in range(first, first + count):
        vertex = vertices[i]
        nx = vertex.normal[0]
        ny = vertex.normal[1]
        height = nx * (ray.x - vertex.position[0]) + ny * (ray.y - vertex.position[1])
        speed = nx * ray.dx + ny * ray.dy
        if speed < 0.0:
            t = -height / speed
            if t > enter:
                enter = t
                edge = i
        elif speed > 0.0:
            leave = min(leave, -height / speed)
        elif height >= 0.0:
            return miss()
    if not (enter < leave and leave > 0.0):
        return miss()
    if enter < 0.0:
        return inside(ray)
    return Hit(enter, vertices[edge].normal[0], vertices[edge].normal[1])


@njit
def half_plane_hit(ray: Ray) -> Hit:
    if ray.y < 0.0:
        return inside(ray)
    if ray.dy < 0.0:
        return Hit(-ray.y / ray.dy, 0.0, 1.0)
    return miss()


@njit
def terrain_hit(ray: Ray, shape_model: Any, vertices: Any, depth: float) -> Hit:
    """The nearest edge that is crossed from outside, by the chain's bounding tree."""
    if depth > 0.0 and lies_behind(shape_model, vertices, ray.x, ray.y, depth):
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
    return Hit(nearest, normal[0], normal[1])


@njit
def edge_distance(ray: Ray, vertices: Any, first: int, i: int) -> float:
    """Where the ray crosses edge i of a chain from its outside, or infinity.

    By the sides of the ray on which the two ends lie: neighbours share them bit by bit, so that no ray
    slips through between two edges.
    """
    start = vertices[first + i]
    if start.next < 0:
        return np.inf
    end = vertices[first + start.next]
    ax = start.position[0] - ray.x
    ay = start.position[1] - ray.y
    bx = end.position[0] - ray.x
    by = end.position[1] - ray.y
    right = cross(ray.dx, ray.dy, ax, ay)
    left = cross(ray.dx, ray.dy, bx, by)
    if not (right <= 0.0 and left >= 0.0 and right < left):
        return np.inf
    a = ax * ray.dx + ay * ray.dy
    b = bx * ray.dx + by * ray.dy
    t = a + (b - a) * (right / (right - left))
    return t if t >= 0.0 else np.inf


@njit
def lies_behind(shape_model: Any, vertices: Any, x: float, y: float, depth: float) -> bool:
    """True if the chain's nearest edge within `depth` has the point behind it."""
    point = Mover(Pose(x, y, 1.0, 0.0), x, y, 0.0, 0.0, 0.0, 0.0, 0.0, depth, 0.0, 0.0)
    chain = chain_near(shape_model, vertices, point)
    _, _, is_outside = nearest_edge(chain, point, vertices, x, y)
    return not is_outside


# ---------------------------------------------------------------- all shapes of a world


@njit
def misses_box(
    ray: Ray, reach: float, lower_x: float, lower_y: float, upper_x: float, upper_y: float
) -> bool:
    """True if the first `reach` m of a ray stay out of a box: separating axes.

    Without branches, which rays in all directions would mispredict.
    """
    ex = ray.x + reach * ray.dx
    ey = ray.y + reach * ray.dy
    pad = SLACK * (abs(ray.x) + abs(ray.y) + reach)
    wide = 0.5 * (upper_x - lower_x)
    high = 0.5 * (upper_y - lower_y)
    aside = ray.dx * (lower_y + high - ray.y) - ray.dy * (lower_x + wide - ray.x)
    return (
        (min(ray.x, ex) - pad > upper_x)
        | (max(ray.x, ex) + pad < lower_x)
        | (min(ray.y, ey) - pad > upper_y)
        | (max(ray.y, ey) + pad < lower_y)
        | (abs(aside) > abs(ray.dx) * high + abs(ray.dy) * wide + SLACK * (wide + high) + pad)
    )


@njit
def shape_hit(ray: Ray, model: Any, parameter: Any, vertices: Any, depth: float) -> Hit:
    """`ray` in the shape's frame."""
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
def look_at_shape(
    rays: Array,
    s: int,
    model: Any,
    parameter: Any,
    pose: Pose,
    vertices: Array | None,
    depth: float,
) -> None:
    """Shorten the rays that hit shape `s`; of shapes at the same distance the first stays."""
    lower_x, lower_y, upper_x, upper_y = bounding_box(model, parameter, vertices, pose)
    rim = depth if model.kind == TERRAIN else 0.0
    for r in range(len(rays)):
        entry = rays[r]
        reach = entry.distance
        ray = Ray(entry.origin[0], entry.origin[1], entry.direction[0], entry.direction[1], reach)
        if model.kind != HALF_PLANE and misses_box(
            ray, reach, lower_x - rim, lower_y - rim, upper_x + rim, upper_y + rim
        ):
            continue
        x, y = to_local(pose, ray.x, ray.y)
        dx, dy = unrotate(pose.cos, pose.sin, ray.dx, ray.dy)
        hit = shape_hit(Ray(x, y, dx, dy, reach), model, parameter, vertices, depth)
        if hit.distance < reach or (hit.distance == reach and entry.shape < 0):
            entry.distance = hit.distance
            entry.shape = s
            entry.normal[0], entry.normal[1] = rotate(pose.cos, pose.sin, hit.normal_x, hit.normal_y)


@njit
def cast_rays_in_world(
    bodies: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    mask: int,
    exclude: int,
    rays: Array,
) -> None:
    """Find the nearest hits of `rays` (ray,) of RAY_DTYPE in one world.

    `bodies`, `body_parameters` (body,); `shape_models`, `shape_parameters` (shape,); `vertices` (vertex,)
    or None. Seen are enabled shapes of the categories in `mask` on enabled bodies, but for sensor
    shapes and those of body `exclude` (-1: none).
    """
    for r in range(len(rays)):
        rays[r].shape = -1
        rays[r].normal[0] = 0.0
        rays[r].normal[1] = 0.0
    depth = 0.0
    if exclude >= 0 and body_parameters[exclude].extent < np.inf:
        depth = body_parameters[exclude].extent
    for s in range(len(shape_models)):
        model = shape_models[s]
        b = model.body
        if model.sensor != 0 or model.category & mask == 0 or b == exclude:
            continue
        if shape_parameters[s].enabled == 0 or body_parameters[b].enabled == 0:
            continue
        pose = shape_pose(bodies[b], body_parameters[b], shape_parameters[s])
        look_at_shape(rays, s, model, shape_parameters[s], pose, vertices, depth)


@njit
def cast_rays(
    worlds: Array,
    bodies: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    mask: int,
    exclude: int,
    rays: Array,
) -> None:
    """The same with a world axis: `rays` (chosen, ray), `worlds` (chosen,) their indices."""
    for k in range(len(worlds)):
        w = worlds[k]
        cast_rays_in_world(
            bodies[w], body_parameters[w], shape_models, shape_parameters[w], at(vertices, w),
            mask, exclude, rays[k],
        )  # fmt: skip
