"""2D shapes: dataclasses for users, compiled records, and mass properties.

A shape has its own frame, placed in its body's frame by `position` and `angle`.  In its frame

- a box is [-hx, hx] x [-hy, hy], a capsule the segment (-half_length, 0) .. (half_length, 0)
  rounded by its radius, a circle the origin rounded by its radius: all three are rounded boxes;
- a polygon is convex and counter-clockwise;
- a half-plane is y <= 0, its outward normal (0, 1);
- a terrain is a chain of segments with the solid on its right.

Polygons and terrains have vertices, one flat array `(world, vertex)` of `vertex_dtype()` for all
shapes of a world; `vertices.derive_vertices` computes everything but `position`, again after
each change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..records.shapes import (
    Array,
    BaseShape,
    BoxShape,
    CapsuleShape,
    CompiledShape,
    PlaneShape,
    RoundShape,
    Vector,
    check_material,
    check_plane,
    check_sizes,
    checked_points,
    checked_vector,
    compiled_shape,
    is_finite,
)
from .kinds import ShapeKind
from .vertices import linked_vertices, vertex_dtype

Point = tuple[float, float]

MAX_POLYGON_VERTICES = 64  # since feature ids are numbers in base 64


@dataclass(frozen=True, kw_only=True)
class Shape(BaseShape):
    """The arguments that all 2D shapes have: those of ``BaseShape``, and the pose in the body's own frame.

    Args:
        position: m, (2,).
        angle: rad.
    """

    position: Vector = (0.0, 0.0)
    angle: float = 0.0


@dataclass(frozen=True)
class Circle(RoundShape, Shape):
    """A disc around the shape's origin.

    Args:
        radius: m.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.CIRCLE


@dataclass(frozen=True)
class Box(BoxShape, Shape):
    """A rectangle around the shape's origin, with sides along its axes.

    Args:
        half_extents: m, (2,), half of the width and half of the height.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.BOX


@dataclass(frozen=True)
class Capsule(CapsuleShape, Shape):
    """All points within a radius of a segment along the shape's x axis.

    Args:
        half_length: m, half of the length of the segment, so the capsule is 2 (half_length + radius) long.
        radius: m.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.CAPSULE


@dataclass(frozen=True)
class Polygon(Shape):
    """A convex polygon.

    Args:
        vertices: m, (n, 2), 3 to 64 corners in either direction; no three in line.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.POLYGON
    vertices: Any  # (n, 2) m

    def extent(self) -> float:
        return polygon_extent(convex_vertices(self.vertices))


@dataclass(frozen=True)
class HalfPlane(PlaneShape, Shape):
    """All points x with ``normal . x <= offset``, for static and kinematic bodies.

    Args:
        normal: (2,), outward, usually of length 1.
        offset: m, if the normal has length 1.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.HALF_PLANE
    normal: Vector = (0.0, 1.0)


@dataclass(frozen=True)
class Terrain(Shape):
    """A chain of segments with the solid on its right, for static and kinematic bodies.

    If the vertices go from left to right, the solid lies below.  Segments are one-sided: a shape that is
    entirely behind a segment does not touch it.

    Args:
        vertices: m, (n, 2), at least 2, or 3 if closed; neighbours must differ.
        closed: whether to join the last vertex to the first.  A counter-clockwise chain is then a cave (solid
            outside), a clockwise one an island (solid inside).
    """

    kind: ClassVar[ShapeKind] = ShapeKind.TERRAIN
    solid: ClassVar[bool] = False
    vertices: Any  # (n, 2) m
    closed: bool = False


CLASSES: dict[int, type[Shape]] = {int(one.kind): one for one in (Circle, Box, Capsule, Polygon, HalfPlane, Terrain)}


# ---------------------------------------------------------------- checks


def validate(shape: Shape, dim: int = 2) -> None:
    """Raise ValueError, naming shape and value, where an argument of the shape is invalid."""
    title = type(shape).__name__
    if dim != 2:
        raise ValueError(f"{title} of {__name__} is planar, it cannot be used in {dim}D")
    check_material(shape, ("friction",))
    checked_vector(title, "position", shape.position, 2)
    if not is_finite(shape.angle):
        raise ValueError(f"{title} angle must be finite, got {shape.angle!r}")
    check_sizes(shape, 2)
    if isinstance(shape, Polygon):
        convex_vertices(shape.vertices)
    elif isinstance(shape, HalfPlane):
        check_plane(shape, 2)
    elif isinstance(shape, Terrain):
        chain_vertices(shape.vertices, shape.closed)
    elif not isinstance(shape, (Circle, Box, Capsule)):
        raise ValueError(f"{title} is not a planar shape")


def convex_vertices(vertices: Any) -> Array:
    """Return the (n, 2) vertices of a convex polygon, counter-clockwise; raises ValueError for others."""
    points = checked_points("Polygon", vertices, 2, 3)
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
    # all turns in one direction and one full turn: convex and without self-intersection
    cosines = (edges * after).sum(axis=1) / (lengths * np.roll(lengths, -1))
    winding = np.arctan2(sines, cosines).sum() / (2.0 * np.pi)
    if not ((sines > 0.0).all() or (sines < 0.0).all()) or abs(abs(winding) - 1.0) > 0.5:
        k = (int((sines * np.sign(sines.sum() or 1.0)).argmin()) + 1) % len(points)
        raise ValueError(f"Polygon must be convex, got a turn back at {tuple(points[k].tolist())}")
    return points if winding > 0.0 else points[::-1].copy()


def chain_vertices(vertices: Any, closed: bool) -> Array:
    """Return the (n, 2) vertices of a terrain; raises ValueError for repeated neighbours."""
    points = checked_points("Terrain", vertices, 2, 3 if closed else 2)
    edges = np.roll(points, -1, axis=0) - points
    lengths = np.hypot(edges[:, 0], edges[:, 1])[: None if closed else -1]
    size = float(np.ptp(points, axis=0).max())
    if lengths.min() <= 1e-12 * size:
        k = int(lengths.argmin())
        raise ValueError(f"Terrain neighbours must differ, got {tuple(points[k].tolist())} twice in a row")
    return points


def terrain_vertices(vertices: Any, closed: bool) -> Array:
    """Return the entries of `vertex_dtype()` of a terrain; raises ValueError as `chain_vertices` does."""
    return linked_vertices(chain_vertices(vertices, closed), closed, outside=-1.0)


# ---------------------------------------------------------------- mass and size


def mass_properties(shape: Shape) -> tuple[float, Point, float]:
    """Return (area m^2, centroid m in the body's frame, inertia m^4 about the centroid), for density 1."""
    if isinstance(shape, Circle):
        r = shape.radius
        area, center, inertia = math.pi * r**2, (0.0, 0.0), 0.5 * math.pi * r**4
    elif isinstance(shape, Box):
        hx, hy = shape.half_extents
        area, center = 4.0 * hx * hy, (0.0, 0.0)
        inertia = area * (hx**2 + hy**2) / 3.0
    elif isinstance(shape, Capsule):
        # rectangle and two half discs; the centroid of a half disc is 4r/(3 pi) from its diameter
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
    """Sum over triangles from the first vertex, which is accurate for polygons far from the origin, too."""
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


def polygon_extent(points: Array) -> float:
    """Return half of the smallest width of a convex polygon, which is across one of its edges."""
    edges = np.roll(points, -1, axis=0) - points
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    normals /= np.hypot(normals[:, 0], normals[:, 1])[:, None]
    heights = points @ normals.T
    return 0.5 * float((heights.max(axis=0) - heights.min(axis=0)).min())


def bounding_radius(shape: Shape, about: Vector = (0.0, 0.0)) -> float:
    """Return the distance in m of the farthest point from `about`, a point of the body's frame."""
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
    """Return a shape's parameter record (`dtype` = shape_parameter_dtype(2)) and its derived vertices."""
    validate(shape)
    x, y, angle = float(shape.position[0]), float(shape.position[1]), float(shape.angle)
    rotation = (math.cos(angle), math.sin(angle))
    size = (0.0, 0.0)
    vertices = np.zeros(0, vertex_dtype())
    if isinstance(shape, HalfPlane):  # its frame has y along the normal and y = 0 on the surface
        length = math.hypot(*shape.normal)
        nx, ny = shape.normal[0] / length, shape.normal[1] / length
        x, y = _placed(shape, (nx * shape.offset / length, ny * shape.offset / length))
        c, s = rotation
        rotation = (c * ny + s * nx, s * ny - c * nx)
    elif isinstance(shape, Box):
        size = (shape.half_extents[0], shape.half_extents[1])
    elif isinstance(shape, Capsule):
        size = (shape.half_length, 0.0)
    elif isinstance(shape, Polygon):
        vertices = linked_vertices(convex_vertices(shape.vertices), closed=True, outside=1.0)
    elif isinstance(shape, Terrain):
        vertices = terrain_vertices(shape.vertices, shape.closed)
    return compiled_shape(shape, dtype, (x, y), rotation, size, vertices)
