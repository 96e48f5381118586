"""Rays against all shapes of a world; planar/rays.py and spatial/rays.py intersect them with one shape.

Solids are open sets: a ray that only touches one, or runs along its face, passes. A ray that starts
inside has its hit at distance 0, with the normal opposite to its direction. A terrain or heightfield is hit
only from its outside, as it is by bodies: from behind it is open. But a start that lies behind it by at most
`depth` (the extent of the body that the rays start from) is inside, again as for bodies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import njit
from ..records.model import Model
from ..records.plain import as_records
from .dispatch import by_dimension
from .optional import at

Array = NDArray[Any]

pose_of_shape = by_dimension("rays", "pose_of_shape")
box_of_shape = by_dimension("rays", "box_of_shape")
hit_in_world = by_dimension("rays", "hit_in_world")

SLACK = 1e-12  # relative enlargement of boxes, for rounding


class Ray(NamedTuple):
    """A ray in the world or in a shape's frame; `at` and `way` have as many numbers as there are dimensions."""

    at: Any  # m, its start
    way: Any  # unit direction
    length: float  # m


class Hit(NamedTuple):
    """The point at which a ray enters a solid, in the ray's frame."""

    distance: float  # m, infinite without a hit
    normal: Any  # unit, outward


@njit
def clip_interval(enter: float, leave: float, side: int, k: int, height: float, speed: float) -> Any:
    """Clip the times at which a ray is in a convex shape by side k; returns (enter, leave, side at which it enters).

    `height` is that of the ray's origin above the side in m, `speed` its rate of change in m/s.
    """
    if speed < 0.0:
        time = -height / speed
        if time > enter:
            return time, leave, k
    elif speed > 0.0:
        return enter, min(leave, -height / speed), side
    elif height >= 0.0:
        return enter, -np.inf, side
    return enter, leave, side


@njit
def slab(place: float, speed: float, half: float) -> tuple[float, float]:
    """Return the interval of t in which |place + t speed| < half."""
    if speed == 0.0:
        if abs(place) < half:
            return -np.inf, np.inf
        return np.inf, -np.inf
    far = half if speed > 0.0 else -half
    return (-far - place) / speed, (far - place) / speed


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
def intersect_shape(rays: Array, s: int, model: Any, parameter: Any, pose: Any, vertices: Any, depth: float) -> None:
    """Shorten the rays that hit shape `s`; of shapes at the same distance the first one counts."""
    box = box_of_shape(model, parameter, vertices, pose, depth)
    for r in range(len(rays)):
        entry = rays[r]
        hit = hit_in_world(entry, model, parameter, pose, box, vertices, depth)
        if hit.distance < entry.distance or (hit.distance == entry.distance and entry.shape < 0):
            entry.distance = hit.distance
            entry.shape = s
            for d in range(len(entry.normal)):
                entry.normal[d] = hit.normal[d]


@njit
def cast_rays_in_world(seen: Any, w: int, vertices: Any, mask: int, exclude: int, rays: Array) -> None:
    """Find the nearest hits of `rays` (ray,) of ray_dtype in world `w` of `seen`; `vertices` are those of `seen`.

    Rays hit enabled shapes of the categories in `mask` on enabled bodies, except sensor shapes and
    those of body `exclude` (-1: none).
    """
    bodies = seen.bodies[w]
    body_parameters = seen.body_parameters[w]
    shape_models = seen.shape_models
    shape_parameters = seen.shape_parameters[w]
    for r in range(len(rays)):
        rays[r].shape = -1
        for d in range(len(rays[r].normal)):
            rays[r].normal[d] = 0.0
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
        pose = pose_of_shape(bodies[b], body_parameters[b], shape_parameters[s])
        intersect_shape(rays, s, model, shape_parameters[s], pose, at(vertices, w), depth)


@njit
def cast_rays(worlds: Array, seen: Any, vertices: Any, mask: int, exclude: int, rays: Array) -> None:
    """Find the nearest hits in several worlds: `rays` (chosen, ray), `worlds` (chosen,) their indices."""
    for k in range(len(worlds)):
        cast_rays_in_world(seen, worlds[k], vertices, mask, exclude, rays[k])
