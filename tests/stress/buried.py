"""How deep bodies start under uneven ground, from their poses alone.

The depth is vertical: a calm separation raises a body by no more, while out of a valley it raises it by more
than the depth of any contact, which is along the normal of one slope.  It also counts for bodies that start
behind the surface, which have no contacts there until they come near it; then a contact is no deeper than
the body is wide, and raises it on the steepest slope by its width over the cosine of that.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.dimension import dimension
from gsenv.solver.planar import Terrain
from gsenv.solver.spatial import Heightfield

from .cases import Array

SAMPLES = 4000  # points of a body; those between the outermost find ridges that enter its faces


def buried(scene: Scene) -> Array:
    """Return the vertical depth of each body under the terrains and height fields, m, (bodies,); at least 0.

    The shapes have no places of their own in their bodies, as in the random scenes with such ground.
    """
    bodies = list(scene.bodies.values())
    depth = np.zeros(len(bodies))
    grounds = [(b, s) for b in bodies for s in b.shapes if isinstance(s, (Terrain, Heightfield))]
    for k, body in enumerate(bodies):
        for shape in body.shapes if body.kind.name == "DYNAMIC" and grounds else ():
            points = body.position + _turned(body, _points(shape, scene.dim), scene.dim)
            for ground, surface in grounds:
                there = points - ground.position
                most = 2.0 * float(np.sqrt(((points - body.position) ** 2).sum(1).max())) * _steepness(surface)
                depth[k] = max(depth[k], min(float((height_at(surface, there) - there[:, -1]).max()), most))
    return depth


def _points(shape: Any, dim: int) -> Array:
    """Points of the shape in its frame, (n, dim): outermost ones along many directions, and some between three."""
    rng = np.random.default_rng(0)
    d = rng.normal(size=(SAMPLES // 4, dim))
    d /= np.sqrt((d * d).sum(1))[:, None]
    signs = np.where(d >= 0.0, 1.0, -1.0)
    kind = type(shape).__name__
    if kind in ("Circle", "Sphere"):
        outer = shape.radius * d
    elif kind == "Box":
        outer = signs * shape.half_extents
    elif kind == "Capsule":
        outer = shape.radius * d
        along = 0 if dim == 2 else 2
        outer[:, along] += shape.half_length * signs[:, along]
    elif kind == "Cylinder":
        around = d[:, :2] / np.hypot(d[:, 0], d[:, 1])[:, None]
        outer = np.column_stack([shape.radius * around, shape.half_length * signs[:, 2]])
    else:
        vertices = np.asarray(shape.vertices, float)
        outer = vertices[np.argmax(d @ vertices.T, axis=1)]
    three = outer[rng.integers(0, len(outer), (SAMPLES, 3))]
    return np.concatenate([outer, np.einsum("nk,nkd->nd", rng.dirichlet((0.5, 0.5, 0.5), SAMPLES), three)])


def _turned(body: Any, points: Array, dim: int) -> Array:
    """Points of the body's frame, in directions of the world."""
    if dim == 3:
        return np.asarray(dimension(3).initial_state.turned_by(body.orientation, points))
    c, s = np.cos(body.angle), np.sin(body.angle)
    return points @ np.array([[c, s], [-s, c]])


def _steepness(surface: Any) -> float:
    """1 over the cosine of the steepest slope."""
    if isinstance(surface, Terrain):
        x, y = np.asarray(surface.vertices, float).T
        return float(np.hypot(1.0, np.diff(y) / np.diff(x)).max())
    heights = np.asarray(surface.heights, float)
    along_x = np.diff(heights, axis=1) * (heights.shape[1] - 1) / surface.size[0]
    along_y = np.diff(heights, axis=0) * (heights.shape[0] - 1) / surface.size[1]
    first = along_x[:-1] ** 2 + along_y[:, 1:] ** 2  # of the two triangles of each cell
    second = along_x[1:] ** 2 + along_y[:, :-1] ** 2
    return float(np.sqrt(1.0 + max(first.max(), second.max())))


def height_at(surface: Any, points: Array) -> Array:
    """The ground's height at the points, -inf beside it."""
    if isinstance(surface, Terrain):
        x, y = np.asarray(surface.vertices, float).T
        return np.interp(points[:, 0], x, y, left=-np.inf, right=-np.inf)
    heights = np.asarray(surface.heights, float)
    rows, columns = heights.shape
    u = (points[:, 0] / surface.size[0] + 0.5) * (columns - 1)
    v = (points[:, 1] / surface.size[1] + 0.5) * (rows - 1)
    i, j = np.clip(v.astype(int), 0, rows - 2), np.clip(u.astype(int), 0, columns - 2)
    du, dv = u - j, v - i
    a, b, c, d = heights[i, j], heights[i, j + 1], heights[i + 1, j], heights[i + 1, j + 1]
    inside = (u >= 0) & (v >= 0) & (u <= columns - 1) & (v <= rows - 1)
    return np.where(inside, a + np.where(du >= dv, du * (b - a) + dv * (d - b), dv * (c - a) + du * (d - c)), -np.inf)
