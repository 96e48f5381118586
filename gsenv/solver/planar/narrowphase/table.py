"""The pair table: which routine handles which two kinds of shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose
from gsenv.solver.planar.narrowphase.boxes import box_box
from gsenv.solver.planar.narrowphase.circles import box_circle
from gsenv.solver.planar.narrowphase.half_planes import half_plane_box, half_plane_polygon
from gsenv.solver.planar.narrowphase.manifold import Manifold, flipped, no_manifold
from gsenv.solver.planar.narrowphase.polygons import outline_of, polygon_polygon
from gsenv.solver.planar.shapes import CIRCLE, HALF_PLANE, POLYGON

Array = NDArray[Any]

NONE = 0  # excluded: neither ever moves by itself
ROUND = 1  # circles.box_circle: a circle, a capsule is a box with a radius
BOXES = 2  # boxes.box_box, the same
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
def collide(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    margin: float,
) -> Manifold:
    """Manifold of shapes a and b at the given poses, normal from a to b; not for terrains."""
    kind_a = shape_models[a].kind
    kind_b = shape_models[b].kind
    routine = PAIR_TABLE[kind_a, kind_b]
    # the routines want half-planes first and circles last
    swapped = kind_b == HALF_PLANE or (routine == ROUND and kind_a == CIRCLE)
    if swapped:
        a, b = b, a
        pose_a, pose_b = pose_b, pose_a
    one = shape_parameters[a]
    other = shape_parameters[b]
    m = no_manifold()
    if routine == BOXES:
        m = box_box(
            pose_a, one.size[0], one.size[1], one.radius,
            pose_b, other.size[0], other.size[1], other.radius, margin,
        )  # fmt: skip
    elif routine == ROUND:
        m = box_circle(
            pose_a, one.size[0], one.size[1], one.radius, pose_b, other.radius, margin
        )
    elif routine == PLANES and shape_models[b].kind != POLYGON:
        m = half_plane_box(pose_a, pose_b, other.size[0], other.size[1], other.radius, margin)
    elif vertices is not None:
        outline_b = outline_of(shape_models[b], other)
        if routine == PLANES:
            m = half_plane_polygon(pose_a, pose_b, outline_b, vertices, margin)
        elif routine == POLYGONS:
            outline_a = outline_of(shape_models[a], one)
            m = polygon_polygon(outline_a, pose_a, outline_b, pose_b, vertices, margin)
    return flipped(m) if swapped else m
