"""3D shapes: dataclasses for users, compiled records, and mass properties.

A shape has its own frame, placed in its body's frame by `position` and `orientation`, a unit
quaternion (w, x, y, z).  In its frame

- a sphere is the origin rounded by its radius, a box [-hx, hx] x [-hy, hy] x [-hz, hz];
- a capsule is the segment (0, 0, -half_length) .. (0, 0, half_length) rounded by its radius, a
  cylinder the disc of that radius moved along the same segment;
- a hull is the convex hull of its vertices;
- a plane is z <= 0, its outward normal (0, 0, 1);
- a heightfield is the region under a grid of triangles.

Hulls and heightfields have vertices, one flat array `(world, vertex)` of `vertex_dtype()` for all
shapes of a world.
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
    check_positive,
    check_sizes,
    checked_vector,
    compiled_shape,
    float_array,
)
from .edit import box_inertia
from .hulls import convex_hull, hull_extent, hull_mass, linked_hull
from .kinds import BOX, CAPSULE, CYLINDER, SPHERE, ShapeKind
from .math import Quaternion, multiply, normalised, pose_of
from .vertices import vertex_dtype

MAX_SAMPLES = 1_000_000  # of a heightfield: feature ids have 31 bits

# the kernels' arithmetic, as plain Python
_pose_of = getattr(pose_of, "py_func", pose_of)
_multiply = getattr(multiply, "py_func", multiply)
_normalised = getattr(normalised, "py_func", normalised)
_box_inertia = getattr(box_inertia, "py_func", box_inertia)


@dataclass(frozen=True, kw_only=True)
class Shape(BaseShape):
    """The arguments that all 3D shapes have: those of ``BaseShape``, two frictions, and the pose in the body's frame.

    Args:
        torsional_friction: m, largest torque about the normal over the normal force.
        rolling_friction: m, largest torque against rolling over the normal force.
        position: m, (3,).
        orientation: quaternion (w, x, y, z) of any length but 0.

    A contact has the larger torsional and the larger rolling friction of the two shapes.
    """

    torsional_friction: float = 0.0
    rolling_friction: float = 0.0
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Sphere(RoundShape, Shape):
    """A ball around the shape's origin.

    Args:
        radius: m.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.SPHERE


@dataclass(frozen=True)
class Box(BoxShape, Shape):
    """A cuboid around the shape's origin, with edges along its axes.

    Args:
        half_extents: m, (3,), half of the size along x, y and z.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.BOX


@dataclass(frozen=True)
class Capsule(CapsuleShape, Shape):
    """All points within a radius of a segment along the shape's z axis.

    Args:
        half_length: m, half of the length of the segment, so the capsule is 2 (half_length + radius) long.
        radius: m.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.CAPSULE


@dataclass(frozen=True)
class Cylinder(Shape):
    """A cylinder around the shape's z axis.

    Args:
        half_length: m, half of its height.
        radius: m.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.CYLINDER
    sizes: ClassVar[tuple[str, ...]] = ("half_length", "radius")
    half_length: float  # m
    radius: float  # m

    def extent(self) -> float:
        return float(min(self.radius, self.half_length))

    @staticmethod
    def extents(size: Array, radius: Array) -> tuple[Any, Any]:
        return np.minimum(size[:, 2], radius), np.hypot(size[:, 2], radius)


@dataclass(frozen=True)
class Hull(Shape):
    """The convex hull of points.

    Args:
        vertices: m, (n, 3), not all in one plane; at most 64 of them may be corners of the hull.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.HULL
    vertices: Any  # (n, 3) m

    def extent(self) -> float:
        return hull_extent(*convex_hull(self.vertices))


@dataclass(frozen=True)
class Plane(PlaneShape, Shape):
    """All points x with ``normal . x <= offset``, for static and kinematic bodies.

    Args:
        normal: (3,), outward, usually of length 1.
        offset: m, if the normal has length 1.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.PLANE
    normal: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Heightfield(Shape):
    """Ground of given heights over a rectangle around the shape's origin, for static and kinematic bodies.

    `heights[r, c]` is the height at x = (c / (columns - 1) - 1/2) size_x, y = (r / (rows - 1) - 1/2) size_y.
    Each cell consists of two triangles; their common edge joins the cell's corners of lowest and of highest
    (x, y).  The field is one-sided: there are no contacts from below, nor outside the rectangle.

    Args:
        heights: m, (rows, columns), at least 2 x 2 and at most a million.
        size: m, (2,), full extents along x and y.
    """

    kind: ClassVar[ShapeKind] = ShapeKind.HEIGHTFIELD
    solid: ClassVar[bool] = False
    heights: Any  # (rows, columns) m
    size: Vector  # (2,) m, full extents along x and y


CLASSES: dict[int, type[Shape]] = {
    int(one.kind): one for one in (Sphere, Box, Capsule, Cylinder, Hull, Plane, Heightfield)
}


# ---------------------------------------------------------------- checks


def validate(shape: Shape, dim: int = 3) -> None:
    """Raise ValueError, naming shape and value, where an argument of the shape is invalid."""
    title = type(shape).__name__
    if dim != 3:
        raise ValueError(f"{title} of {__name__} is spatial, it cannot be used in {dim}D")
    check_material(shape, ("friction", "torsional_friction", "rolling_friction"))
    checked_vector(title, "position", shape.position, 3)
    unit_rotation(shape)
    check_sizes(shape, 3)
    if isinstance(shape, Hull):
        convex_hull(shape.vertices)
    elif isinstance(shape, Plane):
        check_plane(shape, 3)
    elif isinstance(shape, Heightfield):
        height_samples(shape)
    elif not isinstance(shape, (Sphere, Box, Capsule, Cylinder)):
        raise ValueError(f"{title} is not a spatial shape")


def unit_rotation(shape: Shape) -> Quaternion:
    """Return the rotation of the shape in its body as a unit quaternion (w, x, y, z)."""
    title = type(shape).__name__
    numbers = checked_vector(title, "orientation", shape.orientation, 4)
    largest = max(abs(x) for x in numbers)
    if largest == 0.0:
        raise ValueError(f"{title} orientation must not be zero, got {shape.orientation!r}; unrotated is (1, 0, 0, 0)")
    if numbers[0] == largest and not any(numbers[1:]):
        return 1.0, 0.0, 0.0, 0.0
    w, x, y, z = (n / largest for n in numbers)
    w, x, y, z = _normalised((w, x, y, z))
    return float(w), float(x), float(y), float(z)


def height_samples(shape: Heightfield) -> Array:
    """Return the samples (rows, columns, 3) of a heightfield in its frame, m; raises ValueError for bad arguments."""
    width, depth = checked_vector("Heightfield", "size", shape.size, 2)
    check_positive("Heightfield", "size", width)
    check_positive("Heightfield", "size", depth)
    heights = float_array(shape.heights)
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


# ---------------------------------------------------------------- mass and size


def rotation_matrix(rotation: Quaternion) -> Array:
    """Return the matrix (3, 3) whose columns are the axes of the rotated frame."""
    pose = _pose_of((0.0, 0.0, 0.0), rotation)
    return np.array([pose.x, pose.y, pose.z]).T


def mass_properties(shape: Shape) -> tuple[float, Array, Array]:
    """Return (volume m^3, centroid (3,) m, inertia (3, 3) m^5 about the centroid), for density 1.

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
    """Return (volume, moments about the shape's axes) of shapes with closed forms, for density 1.

    `size` (..., 3), `radius` (...): as in a record, for one shape or for many at once.
    """
    x, y, z, r = size[..., 0], size[..., 1], size[..., 2], radius
    if kind == SPHERE:
        volume = 4.0 / 3.0 * np.pi * r**3
        moment = 0.4 * volume * r**2
        return volume, (moment, moment, moment)
    if kind == BOX:
        volume = 8.0 * x * y * z
        return volume, _box_inertia(x, y, z, volume)
    if kind not in (CAPSULE, CYLINDER):
        raise ValueError(f"own_moments: a {ShapeKind(kind).name.lower()} has no closed form")
    tube = 2.0 * np.pi * r**2 * z
    about = 0.5 * tube * r**2
    across = tube * (0.25 * r**2 + z**2 / 3.0)
    if kind == CYLINDER:
        return tube, (across, across, about)
    # two half balls: 2/5 m r^2 about the centres of their flat faces, centroids at 3/8 r from them
    ball = 4.0 / 3.0 * np.pi * r**3
    across = across + ball * (0.4 * r**2 + z**2 + 0.75 * z * r)
    return tube + ball, (across, across, about + 0.4 * ball * r**2)


def _size_of(shape: Shape) -> tuple[float, float, float]:
    """Return the `size` of a shape's record."""
    if isinstance(shape, Box):
        hx, hy, hz = (float(h) for h in shape.half_extents)
        return hx, hy, hz
    if isinstance(shape, (Capsule, Cylinder)):
        return 0.0, 0.0, float(shape.half_length)
    return 0.0, 0.0, 0.0


def _placed(shape: Shape, point: Array) -> Array:
    """Return a point of the shape's frame, or many (..., 3), in the body's frame."""
    axes = rotation_matrix(unit_rotation(shape))
    return np.array([float(x) for x in shape.position]) + (point[..., None, :] * axes).sum(axis=-1)


def bounding_radius(shape: Shape, about: Vector = (0.0, 0.0, 0.0)) -> float:
    """Return the distance in m of the farthest point from `about`, a point of the body's frame."""
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
    """Return a shape's parameter record (`dtype` = shape_parameter_dtype(3)) and its derived vertices."""
    validate(shape)
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
    return compiled_shape(shape, dtype, position, rotation, _size_of(shape), vertices)


def _from_z(x: float, y: float, z: float) -> Quaternion:
    """Return the shortest rotation of (0, 0, 1) to a unit vector; to the opposite, half a turn about x."""
    level = x * x + y * y
    if level < 1e-200:  # the direction of smaller vectors is lost
        return (1.0, 0.0, 0.0, 0.0) if z > 0.0 else (0.0, 1.0, 0.0, 0.0)
    w = 1.0 + z if z > 0.0 else level / (1.0 - z)  # the same without cancellation
    return _normalised((w, -y, x, 0.0))


def _grid(samples: Array) -> Array:
    """Return the entries of `vertex_dtype()` of a heightfield, one for each sample, row after row."""
    rows, columns = samples.shape[:2]
    entries = np.zeros(rows * columns, vertex_dtype())
    entries["position"] = samples.reshape(-1, 3)
    entries["vertex_count"][0] = rows * columns
    entries["normal"][0] = (samples[..., 2].min(), samples[..., 2].max(), 0.0)  # of a field: lowest and highest height
    entries["columns"][0] = columns
    entries["rows"][0] = rows
    return entries
