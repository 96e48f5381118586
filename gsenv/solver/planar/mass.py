"""Masses and extents of 2D bodies: of one when a scene is compiled, of many worlds when sizes differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..records.model import Array, Model
from . import shapes as planar_shapes
from .edit import box_inertia
from .kinds import BOX, CAPSULE, CIRCLE, POLYGON

NO_INERTIA = (0.0, None)
_box_inertia = getattr(box_inertia, "py_func", box_inertia)


def inertia_about(middle: Array, parts: Sequence[Any], shapes: Sequence[Any]) -> tuple[float, None]:
    """Return (inertia kg m^2 about the centre of mass, None) of parts (mass, centroid, inertia about that)."""
    return float(sum(i + m * float(((c - middle) ** 2).sum()) for m, c, i in parts)), None


def principal_inertia(given: float) -> tuple[float, None]:
    """Return an inertia in kg m^2 as it was given, and no axes; see spatial/mass.py."""
    return given, None


def own_inertia(model: Model, index: int, kind: int, records: Array) -> tuple[Any, Any]:
    """Return (area m^2, inertia m^4 about the centroid) of a shape for density 1, from its records (chosen,)."""
    x, y, r = records["size"][:, 0], records["size"][:, 1], records["radius"]
    if kind == BOX:
        area = 4.0 * x * y
        return area, _box_inertia(x, y, area)
    if kind == CIRCLE:
        area = np.pi * r**2
        return area, 0.5 * area * r**2
    if kind == CAPSULE:
        inertia = 4.0 * x * r * (x**2 + r**2) / 3.0
        inertia += np.pi * r**2 * (0.5 * r**2 + x**2) + 8.0 * x * r**3 / 3.0
        return 4.0 * x * r + np.pi * r**2, inertia
    if kind == POLYGON:
        first = int(model.shapes["vertex_first"][index])
        count = int(model.shapes["vertex_count"][index])
        points = model.nominal_vertices["position"][first : first + count]
        whole, _, about = planar_shapes.mass_properties(planar_shapes.Polygon(vertices=points))
        return whole, about
    return 0.0, 0.0  # half-planes and terrains
