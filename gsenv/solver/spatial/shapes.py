"""Spatial shapes: as authored, as compiled records, and their mass properties.

A shape has a frame of its own, placed in its body's frame by `position` and `rotation`, a unit
quaternion (w, x, y, z).  In its frame

- a sphere is the origin grown by its radius, a box [-hx, hx] x [-hy, hy] x [-hz, hz];
- a capsule is the segment (0, 0, -half_length) .. (0, 0, half_length) grown by its radius, a
  cylinder the disc of that radius moved along the same segment;
- a hull is the convex hull of its vertices;
- a plane is z <= 0, its outward normal (0, 0, 1);
- a heightfield is everything under a grid of triangles.

Hulls and heightfields have vertices, one flat array `(world, vertex)` of `vertex_dtype()` for all
shapes of a world.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.spatial.hulls import convex_hull, hull_extent, hull_mass, linked_hull
from gsenv.solver.spatial.kinds import BOX, CAPSULE, CYLINDER, HEIGHTFIELD, HULL, PLANE, SPHERE, ShapeKind
from gsenv.solver.spatial.math import Quaternion, multiply, normalised, pose_of
from gsenv.solver.spatial.vertices import vertex_dtype

Array = NDArray[Any]
Vector = Sequence[float] | NDArray[Any]

__all__ = [
    "BOX", "CAPSULE", "CYLINDER", "HEIGHTFIELD", "HULL", "PLANE", "SPHERE",
    "Box", "Capsule", "CompiledShape", "Cylinder", "Heightfield", "Hull", "Plane", "Shape", "ShapeKind", "Sphere",
    "bounding_radius", "extent", "height_samples", "mass_properties", "rotation_matrix", "shape_record",
    "unit_rotation", "validate", "vertex_dtype",
]  # fmt: skip

ALL_BITS = -1  # every bit of an int64
MAX_SAMPLES = 1_000_000  # of a heightfield: numbers of features have 31 bits

# the kernels' own arithmetic, without compiling it
_pose_of = getattr(pose_of, "py_func", pose_of)
_multiply = getattr(multiply, "py_func", multiply)
_normalised = getattr(normalised, "py_func", normalised)


@dataclass(frozen=True, kw_only=True)
class Shape:
    """What all shapes have in common: material, place in the body's frame, filter."""

    kind: ClassVar[ShapeKind]
    solid: ClassVar[bool] = True  # False: unbounded, without mass, for bodies that no force moves

    density: float = 1.0  # kg/m^3
    friction: float = 0.5
    restitution: float = 0.0
    torsional_friction: float = 0.0  # m, most torque about the normal over the normal force
    rolling_friction: float = 0.0  # m, most torque against rolling over the normal force
    position: Vector = (0.0, 0.0, 0.0)  # m
    rotation: Vector = (1.0, 0.0, 0.0, 0.0)  # quaternion (w, x, y, z)
    category: int = 1
    mask: int = ALL_BITS
    sensor: bool = False
    name: str | None = None


@dataclass(frozen=True)
class Sphere(Shape):
    kind: ClassVar[ShapeKind] = ShapeKind.SPHERE
    radius: float  # m


@dataclass(frozen=True)
class Box(Shape):
    kind: ClassVar[ShapeKind] = ShapeKind.BOX
    half_extents: Vector  # (3,) m


@dataclass(frozen=True)
class Capsule(Shape):
    """A segment along z, grown by a radius."""

    kind: ClassVar[ShapeKind] = ShapeKind.CAPSULE
    half_length: float  # m, of the segment
    radius: float  # m


@dataclass(frozen=True)
class Cylinder(Shape):
    """A disc moved along z."""

    kind: ClassVar[ShapeKind] = ShapeKind.CYLINDER
    half_length: float  # m
    radius: float  # m


@dataclass(frozen=True)
class Hull(Shape):
    """The convex hull of a cloud of points; at most 64 of them may be corners of it."""

    kind: ClassVar[ShapeKind] = ShapeKind.HULL
    vertices: Any  # (n, 3) m


@dataclass(frozen=True)
class Plane(Shape):
    """Everything with normal . x <= offset."""

    kind: ClassVar[ShapeKind] = ShapeKind.PLANE
    solid: ClassVar[bool] = False
    normal: Vector = (0.0, 0.0, 1.0)
    offset: float = 0.0  # m


@dataclass(frozen=True)
class Heightfield(Shape):
    """Ground of given heights over a rectangle, centred on the shape's origin, solid below.

    `heights[r, c]` is that at x = (c / (columns - 1) - 1/2) size_x, y = (r / (rows - 1) - 1/2) size_y.
    Each cell is two triangles, cut from its corner of lowest (x, y) to that of highest.  One-sided:
    nothing is touched from below, nor beyond the rectangle.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.HEIGHTFIELD
    solid: ClassVar[bool] = False
    heights: Any  # (rows, columns) m
    size: Vector  # (2,) m, full extents along x and y


@dataclass(frozen=True)
class CompiledShape:
    """Numbers of a shape for the kernels."""

    record: Array = field(repr=False)  # () of shape_parameter_dtype(3)
    vertices: Array = field(repr=False)  # (n,) of vertex_dtype(); empty without vertices


# ---------------------------------------------------------------- checks


def validate(shape: Shape, dim: int = 3) -> None:
    """Refuse a shape that makes no sense, with one sentence that names it and the value."""
    title = type(shape).__name__
    if dim != 3:
        raise ValueError(f"{title} of {__name__} is spatial, it cannot be used in {dim}D")
    for word in ("friction", "restitution", "torsional_friction", "rolling_friction"):
        value = getattr(shape, word)
        if not (_finite(value) and value >= 0.0):
            raise ValueError(f"{title} {word} must be finite and not negative, got {value!r}")
    if shape.restitution > 1.0:
        raise ValueError(f"{title} restitution must not exceed 1, got {shape.restitution!r}")
    if shape.solid and not (_finite(shape.density) and shape.density >= 0.0):
        raise ValueError(f"{title} density must be finite and not negative, got {shape.density!r}")
    _vector(title, "position", shape.position)
    unit_rotation(shape)
    for word in ("category", "mask"):
        value = getattr(shape, word)
        if not isinstance(value, (int, np.integer)) or not -(2**63) <= int(value) < 2**64:
            raise ValueError(f"{title} {word} must be an integer of 64 bits, got {value!r}")
    _validate_form(shape, title)


def _validate_form(shape: Shape, title: str) -> None:
    if isinstance(shape, Sphere):
        _positive(title, "radius", shape.radius)
    elif isinstance(shape, Box):
        for value in _vector(title, "half_extents", shape.half_extents):
            _positive(title, "half_extents", value)
    elif isinstance(shape, (Capsule, Cylinder)):
        _positive(title, "half_length", shape.half_length)
        _positive(title, "radius", shape.radius)
    elif isinstance(shape, Hull):
        convex_hull(shape.vertices)
    elif isinstance(shape, Plane):
        if not any(_vector(title, "normal", shape.normal)):
            raise ValueError(f"{title} normal must not be zero, got {tuple(shape.normal)!r}")
        if not _finite(shape.offset):
            raise ValueError(f"{title} offset must be finite, got {shape.offset!r}")
    elif isinstance(shape, Heightfield):
        height_samples(shape)
    else:
        raise ValueError(f"{title} is not a spatial shape")


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and math.isfinite(float(value))


def _positive(title: str, word: str, value: Any) -> None:
    if not (_finite(value) and value > 0.0):
        raise ValueError(f"{title} {word} must be positive, got {value!r}")


_COUNTS = {2: "two", 3: "three", 4: "four"}


def _vector(title: str, word: str, value: Any, count: int = 3) -> list[float]:
    try:
        numbers = [float(x) for x in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not all(math.isfinite(x) for x in numbers):
        raise ValueError(f"{title} {word} must be {_COUNTS[count]} finite numbers, got {value!r}")
    return numbers


def unit_rotation(shape: Shape) -> Quaternion:
    """Rotation of the shape in its body as a unit quaternion (w, x, y, z)."""
    title = type(shape).__name__
    numbers = _vector(title, "rotation", shape.rotation, 4)
    largest = max(abs(x) for x in numbers)
    if largest == 0.0:
        raise ValueError(f"{title} rotation must not be zero, got {shape.rotation!r}; no rotation is (1, 0, 0, 0)")
    if numbers[0] == largest and not any(numbers[1:]):
        return 1.0, 0.0, 0.0, 0.0
    w, x, y, z = (n / largest for n in numbers)
    w, x, y, z = _normalised((w, x, y, z))
    return float(w), float(x), float(y), float(z)


def height_samples(shape: Heightfield) -> Array:
    """(rows, columns, 3) samples of a heightfield in its frame, m; bad heights and sizes are refused."""
    width, depth = _vector("Heightfield", "size", shape.size, 2)
    _positive("Heightfield", "size", width)
    _positive("Heightfield", "size", depth)
    try:
        heights = np.array(shape.heights, dtype=float)
    except (TypeError, ValueError):
        heights = np.empty((0,))
    if heights.ndim != 2 or min(heights.shape) < 2:
        got = f"shape {heights.shape}" if heights.size else "something else"
        raise ValueError(f"Heightfield heights must be an array (rows, columns) of at least 2 x 2, got {got}")
    if heights.size > MAX_SAMPLES:
        got = f"{heights.shape[0]} x {heights.shape[1]}"
        raise ValueError(f"Heightfield may have {MAX_SAMPLES} heights at most, got {got}")
    if not np.isfinite(heights).all():
        row, column = np.argwhere(~np.isfinite(heights))[0].tolist()
        raise ValueError(f"Heightfield heights must be finite, got {heights[row, column]} at [{row}, {column}]")
    rows, columns = heights.shape
    samples = np.empty((rows, columns, 3))
    samples[..., 0] = (np.arange(columns) / (columns - 1) - 0.5) * width
    samples[..., 1] = ((np.arange(rows) / (rows - 1) - 0.5) * depth)[:, None]
    samples[..., 2] = heights
    return samples


# ---------------------------------------------------------------- measures


def rotation_matrix(rotation: Quaternion) -> Array:
    """(3, 3), its columns the axes of the rotated frame."""
    pose = _pose_of((0.0, 0.0, 0.0), rotation)
    return np.array([pose.x, pose.y, pose.z]).T


def mass_properties(shape: Shape) -> tuple[float, Array, Array]:
    """(volume m^3, centroid (3,) m, inertia (3, 3) m^5 about the centroid), density 1.

    Centroid and inertia are in the body's frame and axes.
    """
    if isinstance(shape, Hull):
        volume, center, inertia = hull_mass(*convex_hull(shape.vertices))
    elif shape.solid:
        volume, moments = own_moments(shape.kind, np.array(_size_of(shape)), float(getattr(shape, "radius", 0.0)))
        center, inertia = np.zeros(3), np.diag([float(x) for x in moments])
        volume = float(volume)
    else:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    axes = rotation_matrix(unit_rotation(shape))
    turned = (axes[:, None, :, None] * axes[None, :, None, :] * inertia).sum(axis=(2, 3))
    return volume, _placed(shape, center), 0.5 * (turned + turned.T)


def own_moments(kind: int, size: Array, radius: Any) -> tuple[Any, tuple[Any, Any, Any]]:
    """(volume, moments of inertia about the shape's axes), density 1, of shapes with closed forms.

    `size` (..., 3), `radius` (...): as in a record, for one shape or for many at once.
    """
    x, y, z, r = size[..., 0], size[..., 1], size[..., 2], radius
    if kind == SPHERE:
        volume = 4.0 / 3.0 * np.pi * r**3
        moment = 0.4 * volume * r**2
        return volume, (moment, moment, moment)
    if kind == BOX:
        volume = 8.0 * x * y * z
        third = volume / 3.0
        return volume, (third * (y**2 + z**2), third * (z**2 + x**2), third * (x**2 + y**2))
    if kind not in (CAPSULE, CYLINDER):
        raise ValueError(f"own_moments: a {ShapeKind(kind).name.lower()} has no closed form")
    tube = 2.0 * np.pi * r**2 * z
    about = 0.5 * tube * r**2
    across = tube * (0.25 * r**2 + z**2 / 3.0)
    if kind == CYLINDER:
        return tube, (across, across, about)
    # two half balls: 2/5 m r^2 about their flat faces' centres, centroids 3/8 r beyond them
    ball = 4.0 / 3.0 * np.pi * r**3
    across = across + ball * (0.4 * r**2 + z**2 + 0.75 * z * r)
    return tube + ball, (across, across, about + 0.4 * ball * r**2)


def _size_of(shape: Shape) -> tuple[float, float, float]:
    """What a record keeps as `size`."""
    if isinstance(shape, Box):
        hx, hy, hz = (float(h) for h in shape.half_extents)
        return hx, hy, hz
    if isinstance(shape, (Capsule, Cylinder)):
        return 0.0, 0.0, float(shape.half_length)
    return 0.0, 0.0, 0.0


def _placed(shape: Shape, point: Array) -> Array:
    """A point of the shape's frame, or many (..., 3), in the body's."""
    axes = rotation_matrix(unit_rotation(shape))
    return np.array([float(x) for x in shape.position]) + (point[..., None, :] * axes).sum(axis=-1)


def extent(shape: Shape) -> float:
    """Smallest half-width in m; infinite for planes and heightfields."""
    if isinstance(shape, (Sphere, Capsule)):
        return float(shape.radius)
    if isinstance(shape, Box):
        return float(min(shape.half_extents))
    if isinstance(shape, Cylinder):
        return float(min(shape.radius, shape.half_length))
    if isinstance(shape, Hull):
        return hull_extent(*convex_hull(shape.vertices))
    return math.inf


def bounding_radius(shape: Shape, about: Vector = (0.0, 0.0, 0.0)) -> float:
    """Distance in m of the farthest point from `about`, a point of the body's frame."""
    if not shape.solid:
        return math.inf
    axes = rotation_matrix(unit_rotation(shape))
    apart = np.array([float(a) for a in about]) - np.array([float(x) for x in shape.position])
    x, y, z = abs((apart[:, None] * axes).sum(axis=0)).tolist()
    if isinstance(shape, Hull):
        corners = _placed(shape, convex_hull(shape.vertices)[0])
        return float(np.sqrt(((corners - np.asarray(about, float)) ** 2).sum(axis=1)).max())
    if isinstance(shape, Cylinder):
        return math.hypot(math.hypot(x, y) + shape.radius, z + shape.half_length)
    hx, hy, hz = _size_of(shape)
    return math.hypot(x + hx, y + hy, z + hz) + float(getattr(shape, "radius", 0.0))


# ---------------------------------------------------------------- compiled form


def shape_record(shape: Shape, dtype: np.dtype[Any]) -> CompiledShape:
    """A shape's parameter record (`dtype` = shape_parameter_dtype(3)) and its derived vertices."""
    validate(shape)
    record = np.zeros((), dtype)
    rotation = unit_rotation(shape)
    position = np.array([float(x) for x in shape.position])
    vertices = np.zeros(0, vertex_dtype())
    if isinstance(shape, Plane):  # its frame has z along the normal and z = 0 on the surface
        length = math.hypot(*shape.normal)
        normal = np.array([float(x) / length for x in shape.normal])
        position = _placed(shape, normal * (float(shape.offset) / length))
        rotation = _multiply(rotation, _from_z(*normal.tolist()))
    elif isinstance(shape, Hull):
        vertices = linked_hull(*convex_hull(shape.vertices))
    elif isinstance(shape, Heightfield):
        vertices = _grid(height_samples(shape))
    record["local_position"] = position
    record["local_rotation"] = rotation
    record["size"] = _size_of(shape)
    if isinstance(shape, (Sphere, Capsule, Cylinder)):
        record["radius"] = shape.radius
    record["extent"] = extent(shape)
    for word in ("friction", "restitution", "torsional_friction", "rolling_friction"):
        if word in (dtype.names or ()):
            record[word] = getattr(shape, word)
    record["density"] = shape.density if shape.solid else 0.0
    record["enabled"] = 1
    return CompiledShape(record, vertices)


def _from_z(x: float, y: float, z: float) -> Quaternion:
    """The shortest rotation of (0, 0, 1) to a unit vector; of the opposite, half a turn about x."""
    level = x * x + y * y
    if level < 1e-200:  # below that its digits are lost
        return (1.0, 0.0, 0.0, 0.0) if z > 0.0 else (0.0, 1.0, 0.0, 0.0)
    w = 1.0 + z if z > 0.0 else level / (1.0 - z)  # the same without cancellation
    return _normalised((w, -y, x, 0.0))


def _grid(samples: Array) -> Array:
    """Entries of `vertex_dtype()` of a heightfield: as many as it has samples, row after row."""
    rows, columns = samples.shape[:2]
    entries = np.zeros(rows * columns, vertex_dtype())
    entries["position"] = samples.reshape(-1, 3)
    entries["vertex_count"][0] = rows * columns
    entries["normal"][0] = (samples[..., 2].min(), samples[..., 2].max(), 0.0)  # of a field: its lowest and highest
    entries["columns"][0] = columns
    entries["rows"][0] = rows
    return entries
