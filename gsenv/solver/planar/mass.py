"""Extents, mass and inertia of bodies whose sizes or densities differ from world to world, as arrays."""

from __future__ import annotations

import numpy as np

from ..records.model import Array, Model, solid_dtype
from . import shapes as planar_shapes
from .edit import box_inertia
from .kinds import BOX, CAPSULE, CIRCLE, POLYGON

# size fields of each kind of shape
SIZE_FIELDS: dict[int, tuple[str, ...]] = {
    CIRCLE: ("radius",),
    BOX: ("half_extents",),
    CAPSULE: ("half_length", "radius"),
}
_box_inertia = getattr(box_inertia, "py_func", box_inertia)


def solids(model: Model, shapes: Array, body: int, chosen: Array) -> Array:
    """Return (chosen,) of `solid_dtype`: the extents of a one-shape body, and its mass and inertia by its density.

    The extents of polygons stay at -1, since their size does not change.
    """
    index = int(model.bodies["shape_first"][body])
    record = shapes[chosen, index]
    kind = int(model.shapes["kind"][index])
    x, y, r = record["size"][:, 0], record["size"][:, 1], record["radius"]
    out = np.zeros(len(chosen), solid_dtype(2))
    out["extent"] = out["reach"] = -1.0
    if kind == BOX:
        out["extent"], out["reach"] = np.minimum(x, y), np.sqrt(x * x + y * y)
        area = 4.0 * x * y
        inertia = _box_inertia(x, y, area)
    elif kind == CIRCLE:
        out["extent"], out["reach"] = r, r
        area = np.pi * r**2
        inertia = 0.5 * area * r**2
    elif kind == CAPSULE:
        out["extent"], out["reach"] = r, x + r
        area = 4.0 * x * r + np.pi * r**2
        inertia = 4.0 * x * r * (x**2 + r**2) / 3.0
        inertia += np.pi * r**2 * (0.5 * r**2 + x**2) + 8.0 * x * r**3 / 3.0
    elif kind == POLYGON:
        first = int(model.shapes["vertex_first"][index])
        count = int(model.shapes["vertex_count"][index])
        points = model.nominal_vertices["position"][first : first + count]
        area, _, inertia = planar_shapes.mass_properties(planar_shapes.Polygon(vertices=points))
    else:  # half-planes and terrains have no mass
        return out
    out["mass"] = area * record["density"]
    out["inertia"] = inertia * record["density"]
    return out
