"""Mass and extent of bodies whose sizes or densities differ from world to world, all at once."""

from __future__ import annotations

import numpy as np

from ..model import Array, Model
from . import shapes as planar_shapes

# which size fields a shape of each kind has
SIZE_FIELDS: dict[int, tuple[str, ...]] = {
    planar_shapes.CIRCLE: ("radius",),
    planar_shapes.BOX: ("half_extents",),
    planar_shapes.CAPSULE: ("half_length", "radius"),
}


def mass_of_body(model: Model, shapes: Array, body: int, chosen: Array) -> tuple[Array, Array]:
    """(mass, inertia about the centre of mass) of a one-shape body in the chosen worlds."""
    index = int(model.bodies["shape_first"][body])
    record = shapes[chosen, index]
    kind = int(model.shapes["kind"][index])
    x, y, r = record["size"][:, 0], record["size"][:, 1], record["radius"]
    if kind == planar_shapes.BOX:
        area = 4.0 * x * y
        inertia = area * (x**2 + y**2) / 3.0
    elif kind == planar_shapes.CIRCLE:
        area = np.pi * r**2
        inertia = 0.5 * area * r**2
    elif kind == planar_shapes.CAPSULE:
        area = 4.0 * x * r + np.pi * r**2
        inertia = 4.0 * x * r * (x**2 + r**2) / 3.0
        inertia += np.pi * r**2 * (0.5 * r**2 + x**2) + 8.0 * x * r**3 / 3.0
    else:
        first = int(model.shapes["vertex_first"][index])
        count = int(model.shapes["vertex_count"][index])
        points = model.nominal_vertices["position"][first : first + count]
        polygon = planar_shapes.Polygon(vertices=points)
        area_one, _, inertia_one = planar_shapes.mass_properties(polygon)
        area = np.full(len(chosen), area_one)
        inertia = np.full(len(chosen), inertia_one)
    return area * record["density"], inertia * record["density"]


def derive_extent(model: Model, shapes: Array, bodies: Array, body: int, chosen: Array) -> None:
    """Extent and bounding radius of a one-shape body after a change of its size."""
    index = int(model.bodies["shape_first"][body])
    kind = int(model.shapes["kind"][index])
    x, y = shapes["size"][chosen, index, 0], shapes["size"][chosen, index, 1]
    r = shapes["radius"][chosen, index]
    if kind == planar_shapes.BOX:
        extent, reach = np.minimum(x, y), np.hypot(x, y)
    elif kind == planar_shapes.CIRCLE:
        extent, reach = r, r
    elif kind == planar_shapes.CAPSULE:
        extent, reach = r, x + r
    else:
        return
    shapes["extent"][chosen, index] = extent
    bodies["extent"][chosen, body] = extent
    offset = shapes["local_position"][chosen, index] - bodies["center"][chosen, body]
    bodies["radius"][chosen, body] = reach + np.hypot(offset[:, 0], offset[:, 1])
