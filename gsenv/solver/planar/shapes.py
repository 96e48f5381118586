"""Planar shapes: as authored, as compiled records, and their mass properties.

A shape has a frame of its own, placed in its body's frame by `position` and `angle`.  In its frame

- a box is [-hx, hx] x [-hy, hy], a capsule the segment (-half_length, 0) .. (half_length, 0)
  grown by its radius, a circle the origin grown by its radius: all three are boxes with radius;
- a polygon is convex and counter-clockwise;
- a half-plane is y <= 0, its outward normal (0, 1);
- a terrain is a chain of segments with the solid on the right of the direction of travel.

Polygons and terrains have vertices, one flat array `(world, vertex)` of `vertex_dtype()` for all
shapes of a world; `vertices.derive_vertices` computes everything but `position`, again after
each change.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.planar.vertices import linked_vertices, vertex_dtype

Array = NDArray[Any]
Point = tuple[float, float]
Vector = Sequence[float] | NDArray[Any]

__all__ = [
    "BOX", "CAPSULE", "CIRCLE", "HALF_PLANE", "POLYGON", "TERRAIN",
    "Box", "Capsule", "Circle", "CompiledShape", "HalfPlane", "Polygon", "Shape", "ShapeKind", "Terrain",
    "bounding_radius", "chain_vertices", "convex_vertices", "extent", "mass_properties", "polygon_extent",
    "shape_record", "validate", "vertex_dtype",
]  # fmt: skip

ALL_BITS = -1  # every bit of an int64
MAX_POLYGON_VERTICES = 64  # features are numbered in base 64


class ShapeKind(IntEnum):
    CIRCLE = 0
    BOX = 1
    CAPSULE = 2
    POLYGON = 3
    HALF_PLANE = 4
    TERRAIN = 5


# plain ints: numba compares them faster than enum members
CIRCLE, BOX, CAPSULE, POLYGON, HALF_PLANE, TERRAIN = (int(kind) for kind in ShapeKind)


@dataclass(frozen=True, kw_only=True)
class Shape:
    """What all shapes have in common: material, place in the body's frame, filter."""

    kind: ClassVar[ShapeKind]
    solid: ClassVar[bool] = True  # False: unbounded, without mass, for bodies that no force moves

    density: float = 1.0  # kg/m^2
    friction: float = 0.5
    restitution: float = 0.0
    position: Vector = (0.0, 0.0)  # m
    angle: float = 0.0  # rad
    category: int = 1
    mask: int = ALL_BITS
    sensor: bool = False
    name: str | None = None


@dataclass(frozen=True)
class Circle(Shape):
    kind: ClassVar[ShapeKind] = ShapeKind.CIRCLE
    radius: float  # m


@dataclass(frozen=True)
class Box(Shape):
    kind: ClassVar[ShapeKind] = ShapeKind.BOX
    half_extents: Vector  # m


@dataclass(frozen=True)
class Capsule(Shape):
    """A segment along x, grown by a radius."""

    kind: ClassVar[ShapeKind] = ShapeKind.CAPSULE
    half_length: float  # m, of the segment
    radius: float  # m


@dataclass(frozen=True)
class Polygon(Shape):
    """A convex polygon, vertices in either direction."""

    kind: ClassVar[ShapeKind] = ShapeKind.POLYGON
    vertices: Any  # (n, 2) m


@dataclass(frozen=True)
class HalfPlane(Shape):
    """Everything with normal . x <= offset."""

    kind: ClassVar[ShapeKind] = ShapeKind.HALF_PLANE
    solid: ClassVar[bool] = False
    normal: Vector = (0.0, 1.0)
    offset: float = 0.0  # m


@dataclass(frozen=True)
class Terrain(Shape):
    """A chain of segments; walking along it, the solid is on the right hand.

    From left to right the solid lies below.  One-sided: a shape that is wholly behind a segment
    is not touched by it.  `closed` joins the last vertex to the first: counter-clockwise is a
    cave (solid outside), clockwise an island (solid inside).
    """

    kind: ClassVar[ShapeKind] = ShapeKind.TERRAIN
    solid: ClassVar[bool] = False
    vertices: Any  # (n, 2) m
    closed: bool = False


@dataclass(frozen=True)
class CompiledShape:
    """Numbers of a shape for the kernels."""

    record: Array = field(repr=False)  # () of shape_parameter_dtype(2)
    vertices: Array = field(repr=False)  # (n,) of vertex_dtype(); empty without vertices


# ---------------------------------------------------------------- checks


def validate(shape: Shape, dim: int = 2) -> None:
    """Refuse a shape that makes no sense, with one sentence that names it and the value."""
    title = type(shape).__name__
    if dim != 2:
        raise ValueError(f"{title} of {__name__} is planar, it cannot be used in {dim}D")
    for word in ("friction", "restitution"):
        value = getattr(shape, word)
        if not (_finite(value) and value >= 0.0):
            raise ValueError(f"{title} {word} must be finite and not negative, got {value!r}")
    if shape.restitution > 1.0:
        raise ValueError(f"{title} restitution must not exceed 1, got {shape.restitution!r}")
    if shape.solid and not (_finite(shape.density) and shape.density >= 0.0):
        raise ValueError(f"{title} density must be finite and not negative, got {shape.density!r}")
    _vector(title, "position", shape.position)
    if not _finite(shape.angle):
        raise ValueError(f"{title} angle must be finite, got {shape.angle!r}")
    for word in ("category", "mask"):
        value = getattr(shape, word)
        if not isinstance(value, (int, np.integer)) or not -(2**63) <= int(value) < 2**64:
            raise ValueError(f"{title} {word} must be an integer of 64 bits, got {value!r}")
    _validate_form(shape, title)


def _validate_form(shape: Shape, title: str) -> None:
    if isinstance(shape, Circle):
        _positive(title, "radius", shape.radius)
    elif isinstance(shape, Box):
        for value in _vector(title, "half_extents", shape.half_extents):
            _positive(title, "half_extents", value)
    elif isinstance(shape, Capsule):
        _positive(title, "half_length", shape.half_length)
        _positive(title, "radius", shape.radius)
    elif isinstance(shape, Polygon):
        convex_vertices(shape.vertices)
    elif isinstance(shape, HalfPlane):
        normal = _vector(title, "normal", shape.normal)
        if math.hypot(*normal) == 0.0:
            raise ValueError(f"{title} normal must not be zero, got {tuple(shape.normal)!r}")
        if not _finite(shape.offset):
            raise ValueError(f"{title} offset must be finite, got {shape.offset!r}")
    elif isinstance(shape, Terrain):
        chain_vertices(shape.vertices, shape.closed)
    else:
        raise ValueError(f"{title} is not a planar shape")


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and math.isfinite(float(value))


def _positive(title: str, word: str, value: Any) -> None:
    if not (_finite(value) and value > 0.0):
        raise ValueError(f"{title} {word} must be positive, got {value!r}")


def _vector(title: str, word: str, value: Any) -> Point:
    try:
        numbers = [float(x) for x in value]
    except TypeError:
        numbers = []
    if len(numbers) != 2 or not all(math.isfinite(x) for x in numbers):
        raise ValueError(f"{title} {word} must be two finite numbers, got {value!r}")
    return numbers[0], numbers[1]


def _points(title: str, vertices: Any, least: int) -> Array:
    try:
        points = np.array(vertices, dtype=float)
    except (TypeError, ValueError):
        points = np.empty((0,))
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"{title} vertices must be pairs (x, y), got {vertices!r}")
    if not np.isfinite(points).all():
        bad = tuple(points[~np.isfinite(points).all(axis=1)][0].tolist())
        raise ValueError(f"{title} vertices must be finite, got {bad}")
    if len(points) < least:
        raise ValueError(f"{title} needs at least {least} vertices, got {len(points)}")
    return points


def convex_vertices(vertices: Any) -> Array:
    """(n, 2) vertices of a convex polygon, counter-clockwise; anything else is refused."""
    points = _points("Polygon", vertices, 3)
    if len(points) > MAX_POLYGON_VERTICES:
        raise ValueError(f"Polygon may have {MAX_POLYGON_VERTICES} vertices at most, got {len(points)}")
    size = float(np.ptp(points, axis=0).max())
    edges = np.roll(points, -1, axis=0) - points
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    if lengths.min() <= 1e-9 * size:
        k = int(lengths.argmin())
        raise ValueError(f"Polygon vertices must differ, got {tuple(points[k].tolist())} twice")
    after = np.roll(edges, -1, axis=0)
    sines = (edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]) / (lengths * np.roll(lengths, -1))
    if (abs(sines) <= 1e-9).any():
        k = (int(abs(sines).argmin()) + 1) % len(points)
        raise ValueError(
            f"Polygon must have no three vertices in line, got {tuple(points[k].tolist())} between its neighbours"
        )
    # one direction of turning and one full turn: convex and not crossing itself
    cosines = (edges * after).sum(axis=1) / (lengths * np.roll(lengths, -1))
    winding = np.arctan2(sines, cosines).sum() / (2.0 * np.pi)
    if not ((sines > 0.0).all() or (sines < 0.0).all()) or abs(abs(winding) - 1.0) > 0.5:
        k = (int((sines * np.sign(sines.sum() or 1.0)).argmin()) + 1) % len(points)
        raise ValueError(f"Polygon must be convex, got a turn back at {tuple(points[k].tolist())}")
    return points if winding > 0.0 else points[::-1].copy()


def chain_vertices(vertices: Any, closed: bool) -> Array:
    """(n, 2) vertices of a terrain; repeated neighbours are refused."""
    points = _points("Terrain", vertices, 3 if closed else 2)
    edges = np.roll(points, -1, axis=0) - points
    lengths = np.hypot(edges[:, 0], edges[:, 1])[: None if closed else -1]
    size = float(np.ptp(points, axis=0).max())
    if lengths.min() <= 1e-12 * size:
        k = int(lengths.argmin())
        raise ValueError(f"Terrain neighbours must differ, got {tuple(points[k].tolist())} twice in a row")
    return points


# ---------------------------------------------------------------- measures


def mass_properties(shape: Shape) -> tuple[float, Point, float]:
    """(area m^2, centroid m in the body's frame, inertia m^4 about the centroid), density 1."""
    if isinstance(shape, Circle):
        r = shape.radius
        area, center, inertia = math.pi * r**2, (0.0, 0.0), 0.5 * math.pi * r**4
    elif isinstance(shape, Box):
        hx, hy = shape.half_extents
        area, center = 4.0 * hx * hy, (0.0, 0.0)
        inertia = area * (hx**2 + hy**2) / 3.0
    elif isinstance(shape, Capsule):
        # rectangle and two half discs; a half disc's centroid is 4r/(3 pi) off its diameter
        h, r = shape.half_length, shape.radius
        area, center = 4.0 * h * r + math.pi * r**2, (0.0, 0.0)
        inertia = 4.0 * h * r * (h**2 + r**2) / 3.0
        inertia += math.pi * r**2 * (0.5 * r**2 + h**2) + 8.0 * h * r**3 / 3.0
    elif isinstance(shape, Polygon):
        area, center, inertia = _polygon_mass(convex_vertices(shape.vertices))
    else:
        return 0.0, (0.0, 0.0), 0.0
    return area, _placed(shape, center), inertia


def _polygon_mass(points: Array) -> tuple[float, Point, float]:
    """By triangles from the first vertex, which keeps far-away polygons accurate."""
    area, sum_x, sum_y, inertia = 0.0, 0.0, 0.0, 0.0
    for (ax, ay), (bx, by) in zip(points[1:-1] - points[0], points[2:] - points[0], strict=True):
        triangle = 0.5 * (ax * by - ay * bx)
        area += triangle
        sum_x += triangle * (ax + bx) / 3.0
        sum_y += triangle * (ay + by) / 3.0
        inertia += triangle * (ax**2 + ax * bx + bx**2 + ay**2 + ay * by + by**2) / 6.0
    x, y = sum_x / area, sum_y / area
    inertia -= area * (x**2 + y**2)
    return float(area), (float(points[0, 0] + x), float(points[0, 1] + y)), float(inertia)


def _placed(shape: Shape, point: Point) -> Point:
    c, s = math.cos(shape.angle), math.sin(shape.angle)
    x, y = point
    return (
        float(shape.position[0]) + c * x - s * y,
        float(shape.position[1]) + s * x + c * y,
    )


def extent(shape: Shape) -> float:
    """Smallest half-width in m; infinite for half-planes and terrains."""
    if isinstance(shape, Circle):
        return float(shape.radius)
    if isinstance(shape, Box):
        return float(min(shape.half_extents))
    if isinstance(shape, Capsule):
        return float(shape.radius)
    if isinstance(shape, Polygon):
        return polygon_extent(convex_vertices(shape.vertices))
    return math.inf


def polygon_extent(points: Array) -> float:
    """Half of the smallest width of a convex polygon; some edge is flush with that strip."""
    edges = np.roll(points, -1, axis=0) - points
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    normals /= np.hypot(normals[:, 0], normals[:, 1])[:, None]
    heights = points @ normals.T
    return 0.5 * float((heights.max(axis=0) - heights.min(axis=0)).min())


def bounding_radius(shape: Shape, about: Vector = (0.0, 0.0)) -> float:
    """Distance in m of the farthest point from `about`, a point of the body's frame."""
    if isinstance(shape, Polygon):
        corners, radius = convex_vertices(shape.vertices), 0.0
    elif isinstance(shape, Box):
        hx, hy = shape.half_extents
        corners, radius = np.array([(-hx, -hy), (hx, -hy), (hx, hy), (-hx, hy)]), 0.0
    elif isinstance(shape, Capsule):
        h = shape.half_length
        corners, radius = np.array([(-h, 0.0), (h, 0.0)]), shape.radius
    elif isinstance(shape, Circle):
        corners, radius = np.zeros((1, 2)), shape.radius
    else:
        return math.inf
    placed = [_placed(shape, (float(x), float(y))) for x, y in corners]
    return float(radius) + max(math.hypot(x - about[0], y - about[1]) for x, y in placed)


# ---------------------------------------------------------------- compiled form


def shape_record(shape: Shape, dtype: np.dtype[Any]) -> CompiledShape:
    """A shape's parameter record (`dtype` = shape_parameter_dtype(2)) and its derived vertices."""
    validate(shape)
    record = np.zeros((), dtype)
    x, y, angle = float(shape.position[0]), float(shape.position[1]), float(shape.angle)
    vertices = np.zeros(0, vertex_dtype())
    if isinstance(shape, HalfPlane):  # its frame has y along the normal and y = 0 on the surface
        length = math.hypot(*shape.normal)
        nx, ny = shape.normal[0] / length, shape.normal[1] / length
        x, y = _placed(shape, (nx * shape.offset / length, ny * shape.offset / length))
        c, s = math.cos(angle), math.sin(angle)
        record["local_rotation"] = (c * ny + s * nx, s * ny - c * nx)
    else:
        record["local_rotation"] = (math.cos(angle), math.sin(angle))
    record["local_position"] = (x, y)
    if isinstance(shape, Box):
        record["size"] = shape.half_extents
    elif isinstance(shape, Capsule):
        record["size"] = (shape.half_length, 0.0)
    elif isinstance(shape, Polygon):
        vertices = linked_vertices(convex_vertices(shape.vertices), closed=True, outside=1.0)
    elif isinstance(shape, Terrain):
        points = chain_vertices(shape.vertices, shape.closed)
        vertices = linked_vertices(points, shape.closed, outside=-1.0)
    if isinstance(shape, (Circle, Capsule)):
        record["radius"] = shape.radius
    record["extent"] = extent(shape)
    record["friction"] = shape.friction
    record["restitution"] = shape.restitution
    record["density"] = shape.density if shape.solid else 0.0
    record["enabled"] = 1
    return CompiledShape(record, vertices)
