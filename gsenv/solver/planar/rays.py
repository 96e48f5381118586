"""Intersections of rays with all shapes of a world: the first point at which each enters a solid.

Solids are open sets: a ray that only touches one, or runs along its face, passes. A ray that starts
inside has its hit at distance 0, with the normal opposite to its direction. A terrain is hit only from
its outside, as it is by bodies: from behind it is open. But a start that lies behind it by at most
`depth` (the extent of the body that the rays start from) is inside, again as for bodies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ..core.optional import at
from ..jit import njit
from ..records.model import Model
from ..records.plain import as_records
from .geometry import bounding_box, shape_pose
from .kinds import BOX, CIRCLE, HALF_PLANE, POLYGON, TERRAIN
from .math import Pose, cross, rotate, to_local, unrotate
from .narrowphase.chains import Mover, chain_near, nearest_edge
from .narrowphase.polygons import Outline
from .vertices import LEAF_SEGMENTS, leaf_count

Array = NDArray[Any]

SLACK = 1e-12  # relative enlargement of boxes, for rounding


RAY_DTYPE = np.dtype(  # a ray in the world and its nearest hit
    [
        ("origin", "f8", (2,)),  # m
        ("direction", "f8", (2,)),  # unit
        ("distance", "f8"),  # m: length of the ray, then distance of the hit
        ("normal", "f8", (2,)),  # of the surface, outward; zero without a hit
        ("shape", "i8"),  # -1: none
    ],
    align=True,
)


class Ray(NamedTuple):
    """A ray in the world or in a shape's frame."""

    x: float  # m, its start
    y: float
    dx: float  # unit direction
    dy: float
    length: float  # m


class Hit(NamedTuple):
    """The point at which a ray enters a solid, in the ray's frame."""

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
    """Return the interval of t in which |place + t speed| < half."""
    if speed == 0.0:
        if abs(place) < half:
            return -np.inf, np.inf
        return np.inf, -np.inf
    far = half if speed > 0.0 else -half
    return (-far - place) / speed, (far - place) / speed


@njit
def circle_hit(ray: Ray, x: float, radius: float) -> Hit:
    """Return the hit of a circle with centre (x, 0)."""
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
    """Return the hit of a capsule: the point at which the ray enters |y| < radius selects a side or an end."""
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
    """Return the hit of a polygon, by clipping the ray with the half-plane of each edge."""
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
    """Return the hit of the nearest edge that is crossed from outside, found by the chain's bounding tree."""
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
    """Return the distance in m at which the ray crosses edge i of a chain from its outside, or infinity.

    The test is on which side of the ray each end lies: neighbours share their ends bit by bit, so that no
    ray passes between two edges.
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
    """Whether the point lies behind the chain's nearest edge within `depth`."""
    outline = Outline(int64(-1), int64(1), 0.0, 0.0, 0.0, 0.0)
    point = Mover(outline, Pose(x, y, 1.0, 0.0), x, y, 0.0, 0.0, 0.0, 0.0, 0.0, depth)
    chain = chain_near(shape_model, vertices, point)
    _, _, is_outside = nearest_edge(chain, point, vertices, x, y)
    return not is_outside


# ---------------------------------------------------------------- all shapes of a world


@njit
def misses_box(ray: Ray, reach: float, lower_x: float, lower_y: float, upper_x: float, upper_y: float) -> bool:
    """Whether the first `reach` m of a ray miss a box, by separating axes.

    There are no branches, since those are mispredicted for rays in all directions.
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
def intersect_shape(
    rays: Array,
    s: int,
    model: Any,
    parameter: Any,
    pose: Pose,
    vertices: Array | None,
    depth: float,
) -> None:
    """Shorten the rays that hit shape `s`; of shapes at the same distance the first one counts."""
    lower, upper = bounding_box(model, parameter, vertices, pose)
    rim = depth if model.kind == TERRAIN else 0.0
    for r in range(len(rays)):
        entry = rays[r]
        reach = entry.distance
        ray = Ray(entry.origin[0], entry.origin[1], entry.direction[0], entry.direction[1], reach)
        if model.kind != HALF_PLANE and misses_box(
            ray, reach, lower[0] - rim, lower[1] - rim, upper[0] + rim, upper[1] + rim
        ):
            continue
        x, y = to_local(pose, ray.x, ray.y)
        dx, dy = unrotate(pose.cos, pose.sin, ray.dx, ray.dy)
        hit = shape_hit(Ray(x, y, dx, dy, reach), model, parameter, vertices, depth)
        if hit.distance < reach or (hit.distance == reach and entry.shape < 0):
            entry.distance = hit.distance
            entry.shape = s
            entry.normal[0], entry.normal[1] = rotate(pose.cos, pose.sin, hit.normal_x, hit.normal_y)


class Surroundings(NamedTuple):
    """What rays can hit, with a world axis: bodies, shapes and vertices (None in a scene that has none)."""

    bodies: Any
    body_parameters: Any
    shape_models: Any
    shape_parameters: Any
    vertices: Any


def surroundings(model: Model, parameters: Any, state: Any) -> Surroundings:
    """Return the surroundings of all worlds of a model, parameters and state."""
    vertices = parameters.vertices if model.needs_vertices else None
    arrays = (state.bodies, parameters.bodies, model.shapes, parameters.shapes, vertices)
    return Surroundings(*(as_records(array) for array in arrays))


@njit
def cast_rays_in_world(seen: Any, w: int, vertices: Any, mask: int, exclude: int, rays: Array) -> None:
    """Find the nearest hits of `rays` (ray,) of RAY_DTYPE in world `w` of `seen`; `vertices` are those of `seen`.

    Rays hit enabled shapes of the categories in `mask` on enabled bodies, except sensor shapes and
    those of body `exclude` (-1: none).
    """
    bodies = seen.bodies[w]
    body_parameters = seen.body_parameters[w]
    shape_models = seen.shape_models
    shape_parameters = seen.shape_parameters[w]
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
        intersect_shape(rays, s, model, shape_parameters[s], pose, at(vertices, w), depth)


@njit
def cast_rays(worlds: Array, seen: Any, vertices: Any, mask: int, exclude: int, rays: Array) -> None:
    """Find the nearest hits in several worlds: `rays` (chosen, ray), `worlds` (chosen,) their indices."""
    for k in range(len(worlds)):
        cast_rays_in_world(seen, worlds[k], vertices, mask, exclude, rays[k])
