"""Shapes and heightfields by other means than the kernels': sampled surfaces and distances in numpy."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from gsenv.solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Shape, Sphere

Array = NDArray[Any]
SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


def triangles(field: Heightfield) -> Array:
    """(n, 3, 3) counter-clockwise from above."""
    rows, columns = np.shape(field.heights)
    p = np.empty((rows, columns, 3))
    p[..., 0] = np.linspace(-0.5, 0.5, columns) * field.size[0]
    p[..., 1] = (np.linspace(-0.5, 0.5, rows) * field.size[1])[:, None]
    p[..., 2] = field.heights
    a, b, c, d = p[:-1, :-1], p[:-1, 1:], p[1:, :-1], p[1:, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, d), (a, d, c))])


def distance_to(faces: Array, p: Array) -> float:
    """Of a point from the nearest of triangles."""
    best = np.full(len(faces), np.inf)
    a = faces[:, 0]
    n = np.cross(faces[:, 1] - a, faces[:, 2] - a)
    n /= np.linalg.norm(n, axis=1)[:, None]
    over = np.ones(len(faces), bool)
    for k in range(3):
        start, way = faces[:, k], faces[:, (k + 1) % 3] - faces[:, k]
        t = np.clip(((p - start) * way).sum(1) / (way**2).sum(1), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(p - start - t[:, None] * way, axis=1))
        over &= (np.cross(n, way) * (p - start)).sum(1) >= 0.0
    heights = abs(((p - a) * n).sum(1))
    best[over] = np.minimum(best[over], heights[over])
    return float(best.min())


def ground(field: Heightfield, x: Array, y: Array) -> Array:
    """Height of the surface at points of its rectangle."""
    h = np.asarray(field.heights)
    rows, columns = h.shape
    u = (x / field.size[0] + 0.5) * (columns - 1)
    v = (y / field.size[1] + 0.5) * (rows - 1)
    j, i = np.clip(u.astype(int), 0, columns - 2), np.clip(v.astype(int), 0, rows - 2)
    u, v = u - j, v - i
    a, b, c, d = h[i, j], h[i, j + 1], h[i + 1, j], h[i + 1, j + 1]
    return np.where(u >= v, a + u * (b - a) + v * (d - b), a + v * (c - a) + u * (d - c))


def corners_of(shape: Shape) -> Array:
    return SIGNS * np.asarray(shape.half_extents) if isinstance(shape, Box) else np.asarray(shape.vertices)  # type: ignore[attr-defined]


def surface(shape: Shape, rng: np.random.Generator, n: int = 6000) -> Array:
    """(n, 3) points all over the surface, in the shape's frame."""
    d = rng.normal(size=(n, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    if isinstance(shape, Sphere):
        return d * shape.radius
    turn, end = rng.uniform(0.0, 2.0 * np.pi, n), rng.choice([-1.0, 1.0], n)
    along, share = rng.uniform(-1.0, 1.0, n), rng.integers(0, 3, n)
    if isinstance(shape, Capsule):
        ends = d * shape.radius + np.outer(np.sign(d[:, 2]), [0.0, 0.0, shape.half_length])
        side = np.stack([shape.radius * np.cos(turn), shape.radius * np.sin(turn), shape.half_length * along], 1)
        return np.where((share == 0)[:, None], side, ends)
    if isinstance(shape, Cylinder):  # side, rims, flat ends
        r = shape.radius * np.where(share == 2, np.sqrt(rng.uniform(size=n)), 1.0)
        z = shape.half_length * np.where(share == 0, along, end)
        return np.stack([r * np.cos(turn), r * np.sin(turn), z], 1)
    corners = corners_of(shape)
    hull = ConvexHull(corners)
    picked = corners[hull.simplices][rng.integers(0, len(hull.simplices), n)]
    weights = rng.dirichlet([0.5, 0.5, 0.5], n)
    return np.concatenate([(picked * weights[:, :, None]).sum(1), corners])


def outside_by(shape: Shape, p: Array) -> float:
    """Distance of a point near the surface from it, negative inside; of the shape's frame."""
    if isinstance(shape, Sphere):
        return float(np.linalg.norm(p)) - shape.radius
    if isinstance(shape, Capsule):
        z = np.clip(p[2], -shape.half_length, shape.half_length)
        return float(np.linalg.norm(p - (0.0, 0.0, z))) - shape.radius
    if isinstance(shape, Cylinder):
        across, along = np.hypot(p[0], p[1]) - shape.radius, abs(p[2]) - shape.half_length
        return float(min(max(across, along), 0.0) + np.hypot(max(across, 0.0), max(along, 0.0)))
    planes = _planes(corners_of(shape).tobytes())
    return float((planes[:, :3] @ p + planes[:, 3]).max())


@lru_cache
def _planes(corners: bytes) -> Array:
    return ConvexHull(np.frombuffer(corners).reshape(-1, 3)).equations


def small_hull() -> Hull:
    return Hull(vertices=np.random.default_rng(2).normal(size=(14, 3)) * 0.2)
