"""The pair table: the routine for each pair of kinds of shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.geometry import PlacedShape
from ...jit import njit
from ...records.model import Array
from ..kinds import CIRCLE, HALF_PLANE, POLYGON
from .boxes import box_box, box_of
from .circles import box_circle
from .half_planes import half_plane_box, half_plane_polygon
from .manifold import Manifold, flipped, no_manifold
from .polygons import outline_of, polygon_polygon

NONE = 0  # excluded: neither shape can belong to a dynamic body
ROUND = 1  # circles.box_circle: circles and capsules are rounded boxes
BOXES = 2  # boxes.box_box, likewise
POLYGONS = 3  # polygons.polygon_polygon
PLANES = 4  # half_planes.half_plane_box and half_plane_polygon
CHAINS = 5  # terrains.terrain_contacts

# fmt: off
PAIR_TABLE = np.array([
    # CIRCLE    BOX       CAPSULE   POLYGON   HALF_PLANE TERRAIN
    [ROUND,     ROUND,    ROUND,    POLYGONS, PLANES,    CHAINS],  # CIRCLE
    [ROUND,     BOXES,    BOXES,    POLYGONS, PLANES,    CHAINS],  # BOX
    [ROUND,     BOXES,    BOXES,    POLYGONS, PLANES,    CHAINS],  # CAPSULE
    [POLYGONS,  POLYGONS, POLYGONS, POLYGONS, PLANES,    CHAINS],  # POLYGON
    [PLANES,    PLANES,   PLANES,   PLANES,   NONE,      NONE],    # HALF_PLANE
    [CHAINS,    CHAINS,   CHAINS,   CHAINS,   NONE,      NONE],    # TERRAIN
], dtype=np.int64)
# fmt: on


@njit
def collide(shapes: Any, vertices: Array | None, a: PlacedShape, b: PlacedShape, margin: float) -> Manifold:
    """Return the manifold of two shapes, normal from a to b; not for terrains.

    `vertices` are those of the shapes, None in a scene without polygons and terrains; `margin` in m.
    """
    models = shapes.models
    kind_a = models[a.number].kind
    kind_b = models[b.number].kind
    routine = PAIR_TABLE[kind_a, kind_b]
    # the routines take half-planes first and circles last
    swapped = kind_b == HALF_PLANE or (routine == ROUND and kind_a == CIRCLE)
    if swapped:
        a, b = b, a
    one = box_of(shapes.parameters[a.number])
    other = box_of(shapes.parameters[b.number])
    m = no_manifold()
    if routine == BOXES:
        m = box_box(a.pose, one, b.pose, other, margin)
    elif routine == ROUND:
        m = box_circle(a.pose, one, b.pose, other.radius, margin)
    elif routine == PLANES and models[b.number].kind != POLYGON:
        m = half_plane_box(a.pose, b.pose, other, margin)
    elif vertices is not None:
        outline_b = outline_of(models[b.number], shapes.parameters[b.number])
        if routine == PLANES:
            m = half_plane_polygon(a.pose, b.pose, outline_b, vertices, margin)
        elif routine == POLYGONS:
            outline_a = outline_of(models[a.number], shapes.parameters[a.number])
            m = polygon_polygon(outline_a, a.pose, outline_b, b.pose, vertices, margin)
    return flipped(m) if swapped else m
