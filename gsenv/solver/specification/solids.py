"""Mass, inertia and extents that follow from the sizes and densities of shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..dimension import dimension
from ..records.model import Array, Model, solid_dtype
from .specs import BodySpec


def size_fields(dim: int, kind: int) -> Sequence[str]:
    """Return the names of the sizes of a kind of shape."""
    sizes: Sequence[str] = dimension(dim).shapes.CLASSES[kind].sizes
    return sizes


def solid_mass(dim: int, shapes: Sequence[Any]) -> tuple[float, Array, Any, Any]:
    """Return the mass properties of a body from its shapes' densities, without sensors and unbounded shapes.

    Returns:
        (mass kg, centre of mass (dim,) m in the body's frame, inertia kg m^2 about it, quaternion of its axes).
        In 2D the inertia is a number and there are no axes; in 3D it is the three principal moments.
    """
    modules = dimension(dim)
    parts = []
    for shape in shapes:
        if shape.solid and not shape.sensor:
            volume, center, inertia = modules.shapes.mass_properties(shape)
            parts.append((volume * shape.density, np.asarray(center), inertia * shape.density))
    mass = float(sum(m for m, _, _ in parts))
    if mass <= 0.0:
        return 0.0, np.zeros(dim), *modules.mass.NO_INERTIA
    middle = sum((m * c for m, c, _ in parts), np.zeros(dim)) / mass
    return mass, middle, *modules.mass.inertia_about(middle, parts, shapes)


def mass_of(spec: BodySpec) -> tuple[float, Array, Any, Any]:
    """Return (mass, centre of mass, inertia, axes) of a body, as given or else those of `solid_mass`."""
    mass, center, inertia, axes = solid_mass(spec.dim, spec.shapes)
    if spec.mass is not None:
        inertia = inertia * (spec.mass / mass if mass > 0.0 else 0.0)
        mass = spec.mass
    if spec.inertia is not None:
        inertia, axes = dimension(spec.dim).mass.principal_inertia(spec.inertia)
    if spec.center is not None:
        center = spec.center
    return mass, center, inertia, axes


def has_inertia(spec: BodySpec) -> bool:
    """Whether an inertia was given, or that of the shapes is positive about every axis."""
    return spec.inertia is not None or bool(np.all(solid_mass(spec.dim, spec.shapes)[2] > 0.0))


def solids(model: Model, shapes: Array, body: int, chosen: Array) -> Array:
    """Return (chosen,) of `solid_dtype`: the extents of a one-shape body, and its mass and inertia by its density.

    Moments are about the axes that `solid_mass` gives such a body. The extents of shapes of vertices are -1, since
    their sizes do not change; unbounded shapes have no mass.

    Args:
        shapes: (world, shape) parameters, of which the `chosen` worlds are read.
    """
    modules = dimension(model.dim)
    index = int(model.bodies["shape_first"][body])
    kind = int(model.shapes["kind"][index])
    records = shapes[chosen, index]
    out = np.zeros(len(chosen), solid_dtype(model.dim))
    out["extent"], out["reach"] = modules.shapes.CLASSES[kind].extents(records["size"], records["radius"])
    volume, inertia = modules.mass.own_inertia(model, index, kind, records)
    density = records["density"]
    out["mass"] = volume * density
    out["inertia"] = inertia * density.reshape(-1, *(1,) * (model.dim - 2))
    return out
