"""Convex hulls of points: polygons, half-edges, volume, width.

The hull is found by gift wrapping (Chand and Kapur 1970), one whole face at a time: a plane with all
points on one side is rotated about an edge until it touches the next points, and all points within the
tolerance of it form one polygon.  So coplanar points never make slivers, and a box of eight points has
six faces.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..records.shapes import checked_points
from .vertices import vertex_dtype

Array = NDArray[Any]
Polygons = list[list[int]]

MAX_HULL_VERTICES = 64
FLATNESS = 1e-6  # of the size: points this near to the plane of a face belong to it
THINNEST = 1e-5  # of the size: thinner sets of points are planes, lines or points


class _TooManyError(Exception):
    """Raised where a hull has more vertices than a shape may have."""


def convex_hull(vertices: Any) -> tuple[Array, Polygons]:
    """Return the convex hull of points (n, 3).

    Returns:
        its corners (m, 3), unchanged and in the given order, and its faces: indices of corners,
        counter-clockwise seen from outside.

    Raises:
        ValueError: not points, all at one point, line or plane, or more than 64 corners.
    """
    cloud = checked_points("Hull", vertices, 3, 4)
    corners, faces = _hull_of(cloud.tobytes())
    return corners.copy(), [list(face) for face in faces]


@lru_cache(maxsize=64)
def _hull_of(numbers: bytes) -> tuple[Array, Polygons]:
    """Compute the hull; cached, since checks, masses and records of a shape all need it."""
    cloud = np.frombuffer(numbers).reshape(-1, 3)
    points = cloud - cloud.mean(axis=0)
    size = float(np.ptp(points, axis=0).max())
    thickness = _thickness(points, size)
    points /= size
    tolerance = min(FLATNESS, 1e-2 * thickness / size)
    kept = _distinct(points, 10.0 * tolerance)
    points = points[kept]
    for _ in range(3):
        try:
            faces = _wrapped(points, tolerance)
        except _TooManyError:
            raise ValueError(
                f"Hull may have {MAX_HULL_VERTICES} corners at most, got {len(cloud)} vertices with more on their hull"
            ) from None
        if _is_closed(faces) and _holds_all(points, faces, tolerance):
            used = sorted({k for face in faces for k in face})
            place = {k: i for i, k in enumerate(used)}
            return cloud[kept[used]], [[place[k] for k in face] for face in faces]
        tolerance *= 10.0
    raise ValueError("Hull vertices are too close to each other to tell faces apart: leave out some of them")


def _distinct(points: Array, apart: float) -> Array:
    """Return indices of points, one of each group of points within a distance."""
    kept = np.sort(np.unique(np.round(points / apart), axis=0, return_index=True)[1])
    if len(kept) > 5000:  # too many pairs to compare: points near a rounding border may stay double
        return kept
    alive = np.ones(len(kept), bool)
    for k in range(len(kept)):
        if alive[k]:
            near = ((points[kept[k + 1 :]] - points[kept[k]]) ** 2).sum(axis=1) <= apart**2
            alive[k + 1 :] &= ~near
    return kept[alive]


def _thickness(points: Array, size: float) -> float:
    """Return the smallest width of the points in m; raises ValueError for points, lines and planes."""
    if not size > 0.0:
        raise ValueError(f"Hull vertices must not all be the same, got {len(points)} at one point")
    far = points[int((points**2).sum(axis=1).argmax())]
    line = far / np.sqrt((far**2).sum())
    across = points - (points * line).sum(axis=1)[:, None] * line
    side = across[int((across**2).sum(axis=1).argmax())]
    width = float(np.sqrt((side**2).sum()))
    if width <= THINNEST * size:
        raise ValueError("Hull vertices must not lie on one line")
    heights = (points * _cross(line, side / width)).sum(axis=1)
    if float(np.ptp(heights)) <= THINNEST * size:
        raise ValueError("Hull vertices must not lie in one plane")
    return float(np.ptp(heights))


# ---------------------------------------------------------------- wrapping


def _wrapped(points: Array, tolerance: float) -> Polygons:
    """Return the faces of the hull of points of unit size; may be invalid where points nearly coincide."""
    start = int(np.lexsort(points.T[::-1])[0])
    normal = _turned_plane(points, start, np.array([0.0, 0.0, 1.0]), np.array([-1.0, 0.0, 0.0]), tolerance)
    first, _ = _face(points, start, normal, tolerance)
    if len(first) == 2:  # only an edge so far
        edge = points[first[1]] - points[first[0]]
        normal = _turned_plane(points, start, edge / np.sqrt((edge**2).sum()), normal, tolerance)
    first, normal = _face(points, start, normal, tolerance)
    faces, seen = [first], set(_sides(first))
    queue = [(side, normal) for side in seen]
    corners = set(first)
    while queue:
        (a, b), normal = queue.pop()
        if (b, a) in seen:
            continue
        edge = points[b] - points[a]
        normal = _turned_plane(points, a, edge / np.sqrt((edge**2).sum()), normal, tolerance)
        face, normal = _face(points, a, normal, tolerance)
        corners |= set(face)
        if len(corners) > MAX_HULL_VERTICES:
            raise _TooManyError
        if len(face) < 3 or (b, a) not in _sides(face) or seen & set(_sides(face)):
            return []  # invalid: the caller uses a larger tolerance
        faces.append(face)
        seen |= set(_sides(face))
        queue += [(side, normal) for side in _sides(face)]
    return faces


def _sides(face: list[int]) -> list[tuple[int, int]]:
    return list(zip(face, face[1:] + face[:1], strict=True))


def _turned_plane(points: Array, at: int, line: Array, normal: Array, tolerance: float) -> Array:
    """Return the normal of a plane rotated about a line through a point until all points are on one side."""
    inward = _cross(normal, line)
    apart = points - points[at]
    x, y = (apart * inward).sum(axis=1), (apart * normal).sum(axis=1)
    off = x**2 + y**2 > (10.0 * tolerance) ** 2  # nearer to the line the angle is inaccurate
    angle = np.where(off, np.arctan2(-np.minimum(y, 0.0), x), -1.0)
    best = int(angle.argmax())
    for _ in range(len(points)):
        turned = _across(x[best], y[best], inward, normal)
        height = (apart * turned).sum(axis=1)
        if height.max() <= 0.5 * tolerance:
            break
        best = int(height.argmax())
    # of the points on the plane, the one farthest from the line determines it best
    on = np.flatnonzero((height >= -0.5 * tolerance) & off)
    best = int(on[(x[on] ** 2 + y[on] ** 2).argmax()])
    return _across(x[best], y[best], inward, normal)


def _across(x: float, y: float, inward: Array, normal: Array) -> Array:
    """Return the outward normal of the plane through the line and a point (x, y) off it, viewed along the line."""
    across = (y * inward - x * normal) / np.sqrt(x * x + y * y)
    return across


def _face(points: Array, at: int, normal: Array, tolerance: float) -> tuple[list[int], Array]:
    """Return the polygon of the points on a plane, counter-clockwise about its normal, and its own normal."""
    height = ((points - points[at]) * normal).sum(axis=1)
    on = np.flatnonzero(abs(height) <= tolerance)
    first = _cross(normal, np.eye(3)[int(abs(normal).argmin())])
    first /= np.sqrt((first**2).sum())
    second = _cross(normal, first)
    flat = np.stack([(points[on] * first).sum(axis=1), (points[on] * second).sum(axis=1)], axis=1)
    face = [int(on[k]) for k in _outline(flat, tolerance)]
    if len(face) < 3:
        return face, normal
    own = _area_vector(points[face])
    return face, own / np.sqrt((own**2).sum())


def _outline(flat: Array, tolerance: float) -> list[int]:
    """Return the convex hull of points (n, 2), counter-clockwise (monotone chain), without points on its sides."""
    order = np.lexsort((flat[:, 1], flat[:, 0])).tolist()
    outline: list[int] = []
    for part in (order, order[::-1]):
        chain: list[int] = []
        for k in part:
            while len(chain) > 1 and _height(flat, chain[-2], chain[-1], k) <= tolerance:
                chain.pop()
            chain.append(k)
        outline += chain[:-1]
    # the points at which the two chains join may lie on a side
    changed = True
    while changed and len(outline) > 3:
        changed = False
        for i in range(len(outline)):
            a, b, c = outline[i - 2], outline[i - 1], outline[i]
            if _height(flat, a, b, c) <= tolerance:
                outline.remove(b)
                changed = True
                break
    return outline


def _height(flat: Array, a: int, b: int, c: int) -> float:
    """Return the distance of b to the right of the line from a to c."""
    x, y = flat[c] - flat[a]
    length = np.sqrt(x * x + y * y)
    if not length > 0.0:
        return 0.0
    u, v = flat[b] - flat[a]
    return float((u * y - v * x) / length)


def _is_closed(faces: Polygons) -> bool:
    """Whether every side has its twin and Euler's formula of a sphere holds."""
    sides = [side for face in faces for side in _sides(face)]
    corners = {k for face in faces for k in face}
    whole = set(sides)
    if len(faces) < 4 or len(whole) != len(sides) or any((b, a) not in whole for a, b in sides):
        return False
    return len(corners) - len(sides) // 2 + len(faces) == 2


def _holds_all(points: Array, faces: Polygons, tolerance: float) -> bool:
    for face in faces:
        normal = _area_vector(points[face])
        normal /= np.sqrt((normal**2).sum())
        heights = ((points - points[face[0]]) * normal).sum(axis=1)
        if heights.max() > 4.0 * tolerance:
            return False
    return True


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product of single vectors, without the overhead of numpy's."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _area_vector(corners: Array) -> Array:
    """Return the normal of a polygon (n, 3) times twice its area (Newell)."""
    a, b = corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]
    return np.cross(a, b).sum(axis=0)


# ---------------------------------------------------------------- compiled form


def linked_hull(corners: Array, faces: Polygons) -> Array:
    """Return the entries of `vertex_dtype()` of a hull, one for each half-edge."""
    sides = [side for face in faces for side in _sides(face)]
    index = {side: k for k, side in enumerate(sides)}
    entries = np.zeros(len(sides), vertex_dtype())
    entries["position"][: len(corners)] = corners
    first = 0
    for f, face in enumerate(faces):
        normal = _area_vector(corners[face])
        normal /= np.sqrt((normal**2).sum())
        entries["normal"][f] = normal
        entries["offset"][f] = (corners[face] * normal).sum(axis=1).max()
        entries["face_edge"][f] = first
        for i in range(len(face)):
            entries["face"][first + i] = f
            entries["next"][first + i] = first + (i + 1) % len(face)
        first += len(face)
    for k, (a, b) in enumerate(sides):
        entries["origin"][k] = a
        entries["twin"][k] = index[b, a]
        entries["vertex_edge"][a] = k
    entries["vertex_count"][0] = len(corners)
    entries["face_count"][0] = len(faces)
    entries["edge_count"][0] = len(sides)
    return entries


# ---------------------------------------------------------------- mass and size


def hull_mass(corners: Array, faces: Polygons) -> tuple[float, Array, Array]:
    """Return (volume m^3, centroid (3,) m, inertia (3, 3) m^5 about the centroid), for density 1.

    It sums over tetrahedra of the first corner and the faces' triangles, accurate far from the origin, too.
    """
    volume, moment, second = 0.0, np.zeros(3), np.zeros((3, 3))
    points = corners - corners[0]
    for face in faces:
        for i, j in pairwise(face[1:]):
            a, b, c = points[face[0]], points[i], points[j]
            part = float((a * _cross(b, c)).sum()) / 6.0
            middle = a + b + c
            volume += part
            moment += part * middle / 4.0
            # tetrahedron with one corner at the origin: V/20 (sum of outer products of corners and of their sum)
            for v in (a, b, c, middle):
                second += part / 20.0 * v[:, None] * v[None, :]
    center = moment / volume
    second -= volume * center[:, None] * center[None, :]
    inertia = np.trace(second) * np.eye(3) - second
    return float(volume), corners[0] + center, inertia


def hull_extent(corners: Array, faces: Polygons) -> float:
    """Return half of the smallest width in m, which is across a face or between two edges."""
    sides = [side for face in faces for side in _sides(face) if side[0] < side[1]]
    edges = np.array([corners[b] - corners[a] for a, b in sides])
    edges /= np.sqrt((edges**2).sum(axis=1))[:, None]
    i, j = np.triu_indices(len(edges), 1)
    crossed = np.cross(edges[i], edges[j])
    lengths = np.sqrt((crossed**2).sum(axis=1))
    crossed = crossed[lengths > 1e-6] / lengths[lengths > 1e-6][:, None]
    normals = [_area_vector(corners[face]) for face in faces]
    directions = np.concatenate([[n / np.sqrt((n**2).sum()) for n in normals], crossed])
    heights = directions @ (corners - corners[0]).T
    return 0.5 * float(np.ptp(heights, axis=1).min())
