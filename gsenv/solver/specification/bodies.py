"""Checks of a body: its pose, mass and shapes."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from ..dimension import PACKAGES, dimension
from ..records.model import Array, BodyKind
from . import check
from .solids import has_inertia, solid_mass
from .specs import BodySpec

KINDS = {"static": BodyKind.STATIC, "kinematic": BodyKind.KINEMATIC, "dynamic": BodyKind.DYNAMIC}


def angle(value: Any, dim: int, what: str) -> float:
    """Return a checked angle in rad; raises ValueError in 3D unless it is 0."""
    if dim == 3 and not (np.ndim(value) == 0 and value == 0.0):
        raise ValueError(f"{what}: a body in 3D has an orientation (w, x, y, z), not an angle, got angle={value!r}.")
    return check.finite(value, f"{what}: angle")


def orientation(value: Any, dim: int, what: str) -> Array:
    """Return a checked quaternion; raises ValueError in 2D."""
    if value is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    if dim == 2:
        raise ValueError(f"{what}: a body in 2D has an angle, not an orientation, got orientation={value!r}.")
    return check.orientation(value, f"{what}: orientation")


def angular_velocity(value: Any, dim: int, what: str) -> Any:
    """Return a checked angular velocity in rad/s: a float, in 3D (3,)."""
    if dim == 2:
        return check.finite(0.0 if value is None else value, what)
    return check.vector(np.zeros(3) if value is None else value, 3, what)


def inertia(value: Any, dim: int, what: str) -> Any:
    """Return a checked inertia in kg m^2: a float, in 3D (3,) or (3, 3)."""
    return check.positive(value, what) if dim == 2 else check.inertia(value, what)


def color(value: Any, what: str) -> tuple[int, int, int]:
    message = f"{what} must be three whole numbers from 0 to 255, got {value!r}."
    try:
        given = check.vector(value, 3, what)
    except ValueError:
        raise ValueError(message) from None
    red, green, blue = (int(x) for x in given)
    fractions = any(isinstance(x, (float, np.floating)) for x in value) and 0.0 < given.max() <= 1.0
    if fractions or given.min() < 0.0 or given.max() > 255.0 or (given != (red, green, blue)).any():
        raise ValueError(message)
    return red, green, blue


def check_body(spec: BodySpec) -> None:
    """Raise ValueError, naming the body, where its shapes or its mass are invalid."""
    what = f"body {spec.name!r}"
    modules = dimension(spec.dim)
    for shape in spec.shapes:
        if not isinstance(shape, modules.shapes.Shape):
            raise ValueError(f"{what}: {_not_a_shape(shape, spec.dim)}.")
        try:
            modules.shapes.validate(shape, spec.dim)
        except (TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"{what}: {error}.") from None
        _check_range(shape, what)
        if not shape.solid and spec.kind == BodyKind.DYNAMIC:
            name = type(shape).__name__
            raise ValueError(f"{what}: a {name} belongs on a static or kinematic body.")
    if spec.center is not None and (spec.mass is None or spec.inertia is None):
        raise ValueError(f"{what}: a center needs a mass and an inertia.")
    if spec.kind != BodyKind.DYNAMIC:
        return
    if spec.mass is None and not solid_mass(spec.dim, spec.shapes)[0] > 0.0:
        raise ValueError(f"{what} is dynamic and needs a mass or a shape with density.")
    if not has_inertia(spec):
        raise ValueError(f"{what} is dynamic and needs an inertia or a shape with density.")


def _check_range(shape: Any, what: str) -> None:
    """Raise ValueError for a number of a shape whose powers, such as the inertia, would overflow or vanish."""
    for name in (field.name for field in fields(shape)):
        value = getattr(shape, name)
        if name in ("name", "sensor"):
            continue
        if name == "closed":
            check.flag(value, f"{what}: {type(shape).__name__} closed")
            continue
        numbers = check.numbers(value, f"{what}: {type(shape).__name__} {name}")
        if name == "density":
            check.not_negative(value, f"{what}: {type(shape).__name__} density")
        if name in ("half_extents", "radius", "half_length") and numbers.max() > 0.0:
            check.positive(float(numbers[numbers > 0.0].min()), f"{what}: {type(shape).__name__} {name}")


def _not_a_shape(shape: Any, dim: int) -> str:
    if type(shape).__module__ == f"gsenv.solver.{PACKAGES[5 - dim]}.shapes":
        return check.other_dimension(shape, dim)
    return f"{shape!r} is not a shape"
