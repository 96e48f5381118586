"""The common part of 2D and 3D shapes: material, filter, and the checks of their values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .text import shown

Array = NDArray[Any]
Vector = Sequence[float] | NDArray[Any]

ALL_BITS = -1  # every bit of an int64
_COUNTS = {2: "two", 3: "three", 4: "four"}
_POINTS = {2: "pairs (x, y)", 3: "triples (x, y, z)"}


@dataclass(frozen=True, kw_only=True)
class BaseShape:
    """The arguments that all shapes have; the pose in the body's frame is in the subclasses of 2D and 3D.

    Args:
        density: kg/m^2 in 2D, kg/m^3 in 3D, from which mass, centre of mass and inertia of the body follow.
        friction: coefficient; that of a contact is the geometric mean of the two shapes' coefficients.
        restitution: 0 to 1; that of a contact is the larger of the two.
        category: bits of the categories that the shape belongs to.
        mask: bits of the categories that the shape collides with; both shapes of a pair must accept each other.
        sensor: True reports contacts without forces, and adds no mass.
        name: for ``Parameters.set``; by default "body/0", "body/1" and so on.
    """

    kind: ClassVar[IntEnum]
    solid: ClassVar[bool] = True  # False: unbounded, without mass, for static and kinematic bodies
    sizes: ClassVar[tuple[str, ...]] = ()  # arguments that may differ from world to world

    density: float = 1.0  # kg/m^2 in 2D, kg/m^3 in 3D
    friction: float = 0.5
    restitution: float = 0.0
    category: int = 1
    mask: int = ALL_BITS
    sensor: bool = False
    name: str | None = None

    def extent(self) -> float:
        """Return the smallest half-width in m; infinite for unbounded shapes."""
        return math.inf

    @staticmethod
    def extents(size: Array, radius: Array) -> tuple[Any, Any]:
        """Return (half-width, farthest point from the middle) in m of records' sizes (n, dim) and radii (n,).

        They are -1 for shapes without sizes that may change.
        """
        return -1.0, -1.0


@dataclass(frozen=True)
class RoundShape(BaseShape):
    """A circle or sphere."""

    sizes: ClassVar[tuple[str, ...]] = ("radius",)
    radius: float  # m

    def extent(self) -> float:
        return float(self.radius)

    @staticmethod
    def extents(size: Array, radius: Array) -> tuple[Any, Any]:
        return radius, radius


@dataclass(frozen=True)
class BoxShape(BaseShape):
    """A rectangle or cuboid."""

    sizes: ClassVar[tuple[str, ...]] = ("half_extents",)
    half_extents: Vector  # (dim,) m

    def extent(self) -> float:
        return float(min(self.half_extents))

    @staticmethod
    def extents(size: Array, radius: Array) -> tuple[Any, Any]:
        return size.min(axis=1), np.sqrt((size**2).sum(axis=1))


@dataclass(frozen=True)
class CapsuleShape(BaseShape):
    """A segment rounded by a radius."""

    sizes: ClassVar[tuple[str, ...]] = ("half_length", "radius")
    half_length: float  # m, of the segment
    radius: float  # m

    def extent(self) -> float:
        return float(self.radius)

    @staticmethod
    def extents(size: Array, radius: Array) -> tuple[Any, Any]:
        return radius, size.max(axis=1) + radius


@dataclass(frozen=True)
class PlaneShape(BaseShape):
    """All points with normal . x <= offset."""

    solid: ClassVar[bool] = False
    normal: Vector
    offset: float = 0.0  # m


@dataclass(frozen=True)
class CompiledShape:
    """A shape as records for kernels.

    Attributes:
        record: () of shape_parameter_dtype(dim).
        vertices: (vertex,) of the dimension's vertex dtype.
    """

    record: Array = field(repr=False)
    vertices: Array = field(repr=False)


def is_finite(value: Any) -> bool:
    """Whether a value is a finite number."""
    return isinstance(value, (int, float, np.number)) and math.isfinite(float(value))


def check_positive(title: str, word: str, value: Any) -> None:
    """Raise ValueError unless a number is finite and positive."""
    if not (is_finite(value) and value > 0.0):
        raise ValueError(f"{title} {word} must be positive, got {value!r}")


def checked_vector(title: str, word: str, value: Any, count: int) -> list[float]:
    """Return ``value`` as a list of ``count`` finite numbers; raises ValueError otherwise."""
    try:
        numbers = [float(x) for x in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not all(math.isfinite(x) for x in numbers):
        raise ValueError(f"{title} {word} must be {_COUNTS[count]} finite numbers, got {value!r}")
    return numbers


def checked_points(title: str, vertices: Any, dim: int, least: int) -> Array:
    """Return ``vertices`` as finite points (n, dim), n >= ``least``; raises ValueError otherwise."""
    points = float_array(vertices)
    if points.ndim != 2 or points.shape[1] != dim:
        raise ValueError(f"{title} vertices must be {_POINTS[dim]}, got {shown(vertices)}")
    if not np.isfinite(points).all():
        bad = tuple(points[~np.isfinite(points).all(axis=1)][0].tolist())
        raise ValueError(f"{title} vertices must be finite, got {bad}")
    if len(points) < least:
        raise ValueError(f"{title} needs at least {least} vertices, got {len(points)}")
    return points


def float_array(value: Any) -> Array:
    """Return ``value`` as an array of numbers, an empty one if it is none."""
    try:
        return np.array(value, dtype=float)
    except (TypeError, ValueError):
        return np.empty((0,))


def check_material(shape: Any, frictions: Sequence[str]) -> None:
    """Raise ValueError for a bad coefficient, density or filter; ``frictions``: names of the coefficients."""
    title = type(shape).__name__
    for word in (*frictions, "restitution"):
        value = getattr(shape, word)
        if not (is_finite(value) and value >= 0.0):
            raise ValueError(f"{title} {word} must be finite and not negative, got {value!r}")
    if shape.restitution > 1.0:
        raise ValueError(f"{title} restitution must not exceed 1, got {shape.restitution!r}")
    if shape.solid and not (is_finite(shape.density) and shape.density >= 0.0):
        raise ValueError(f"{title} density must be finite and not negative, got {shape.density!r}")
    if not isinstance(shape.sensor, (bool, np.bool_)):
        raise ValueError(f"{title} sensor must be True or False, got {shape.sensor!r}")
    if not (shape.name is None or isinstance(shape.name, str)):
        raise ValueError(f"{title} name must be text, got {shape.name!r}")
    for word in ("category", "mask"):
        value = getattr(shape, word)
        if not isinstance(value, (int, np.integer)) or not -(2**63) <= int(value) < 2**64:
            raise ValueError(f"{title} {word} must be an integer of 64 bits, got {value!r}")


def check_sizes(shape: Any, dim: int) -> None:
    """Raise ValueError for bad half-extents, half-lengths and radii, where a shape has them."""
    title = type(shape).__name__
    if hasattr(shape, "half_extents"):
        for value in checked_vector(title, "half_extents", shape.half_extents, dim):
            check_positive(title, "half_extents", value)
    for word in ("half_length", "radius"):
        if hasattr(shape, word):
            check_positive(title, word, getattr(shape, word))


def check_plane(shape: Any, dim: int) -> None:
    """Raise ValueError for a bad normal or offset of a half-plane or plane."""
    title = type(shape).__name__
    if not any(checked_vector(title, "normal", shape.normal, dim)):
        raise ValueError(f"{title} normal must not be zero, got {tuple(shape.normal)!r}")
    if not is_finite(shape.offset):
        raise ValueError(f"{title} offset must be finite, got {shape.offset!r}")


def compiled_shape(
    shape: BaseShape, dtype: np.dtype[Any], position: Any, rotation: Any, size: Any, vertices: Array
) -> CompiledShape:
    """Return the records of a shape: its place in the body's frame, sizes, material and vertices.

    Args:
        dtype: shape_parameter_dtype(dim).
        position, rotation, size: the fields of that name.
        vertices: (vertex,) of the dimension's vertex dtype.
    """
    record = np.zeros((), dtype)
    record["local_position"] = position
    record["local_rotation"] = rotation
    record["size"] = size
    record["radius"] = getattr(shape, "radius", 0.0)
    record["extent"] = shape.extent()
    for word in ("friction", "restitution", "torsional_friction", "rolling_friction"):
        if word in (record.dtype.names or ()):
            record[word] = getattr(shape, word)
    record["density"] = shape.density if shape.solid else 0.0
    record["enabled"] = 1
    return CompiledShape(record, vertices)
