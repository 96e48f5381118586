"""Independent answers in plain numpy, double precision: what a pixel's ray hits."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.camera import SpatialCamera
from gsenv.solver.spatial.vertices import vertex_dtype

FloatArray = NDArray[np.float64]
Distance = Callable[[FloatArray], FloatArray]


def find_rays(camera: SpatialCamera) -> FloatArray:
    """(height, width, 3) rays through the pixels' middles, of depth 1."""
    right, up, forward = camera.axes()
    scale = 2.0 * np.tan(0.5 * camera.fov) / camera.height
    x = (np.arange(camera.width) + 0.5 - 0.5 * camera.width) * scale
    y = (0.5 * camera.height - np.arange(camera.height) - 0.5) * scale
    return forward + x[None, :, None] * right + y[:, None, None] * up


def turn_matrix(q: Any) -> FloatArray:
    """Columns are the axes of a unit quaternion (w, x, y, z)."""
    w, x, y, z = np.asarray(q, float) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def box_distance(size: Any) -> Distance:
    def distance(p: FloatArray) -> FloatArray:
        q = np.abs(p) - size
        return np.linalg.norm(np.maximum(q, 0.0), axis=-1) + np.minimum(q.max(axis=-1), 0.0)

    return distance


def capsule_distance(half: float, radius: float) -> Distance:
    def distance(p: FloatArray) -> FloatArray:
        z = p[..., 2] - np.clip(p[..., 2], -half, half)
        return np.sqrt(p[..., 0] ** 2 + p[..., 1] ** 2 + z**2) - radius

    return distance


def cylinder_distance(half: float, radius: float) -> Distance:
    def distance(p: FloatArray) -> FloatArray:
        side, end = np.hypot(p[..., 0], p[..., 1]) - radius, np.abs(p[..., 2]) - half
        return np.hypot(np.maximum(side, 0), np.maximum(end, 0)) + np.minimum(np.maximum(side, end), 0.0)

    return distance


def hull_distance(normals: FloatArray, offsets: FloatArray) -> Distance:
    return lambda p: (p @ normals.T - offsets).max(axis=-1)


def least_distance(
    distance: Distance, origin: FloatArray, rays: FloatArray, at: Any, rotation: Any, reach: float
) -> FloatArray:
    """Least signed distance of a convex shape along rays, by ternary search of what is convex in depth."""
    frame = turn_matrix(rotation)
    o, d = (origin - np.asarray(at)) @ frame, rays @ frame
    low, high = np.zeros(d.shape[:-1]), np.full(d.shape[:-1], reach)
    for _ in range(90):
        a, b = low + (high - low) / 3.0, high - (high - low) / 3.0
        nearer = distance(o + a[..., None] * d) < distance(o + b[..., None] * d)
        high, low = np.where(nearer, b, high), np.where(nearer, low, a)
    return distance(o + (0.5 * (low + high))[..., None] * d)


OCTAHEDRON = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / np.sqrt(3.0)


def make_octahedron(radius: float) -> NDArray[np.void]:
    """Hull entries of an octahedron whose corners are `radius` m from its middle."""
    vertices = np.zeros(8, vertex_dtype())
    vertices["position"][:6] = radius * np.concatenate([np.eye(3), -np.eye(3)])
    vertices["normal"] = OCTAHEDRON
    vertices["offset"] = radius / np.sqrt(3.0)
    vertices["vertex_count"][0], vertices["face_count"][0] = 6, 8
    return vertices


def make_field(columns: int, rows: int, cell: float, height: Callable[[Any, Any], Any]) -> NDArray[np.void]:
    """Entries of a heightfield about the origin, samples along x first."""
    vertices = np.zeros(columns * rows, vertex_dtype())
    x = (np.arange(columns) - 0.5 * (columns - 1)) * cell
    y = (np.arange(rows) - 0.5 * (rows - 1)) * cell
    grid = np.stack([np.tile(x, rows), np.repeat(y, columns)], axis=-1)
    vertices["position"][:, :2] = grid
    vertices["position"][:, 2] = height(grid[:, 0], grid[:, 1])
    vertices["columns"][0], vertices["rows"][0] = columns, rows
    return vertices
