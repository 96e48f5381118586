"""The pair table: which routine handles which two kinds of shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.planar.math import Pose
from gsenv.solver.planar.narrowphase.boxes import box_box
from gsenv.solver.planar.narrowphase.circles import box_circle, circle_circle
from gsenv.solver.planar.narrowphase.half_planes import half_plane_box, half_plane_polygon
from gsenv.solver.planar.narrowphase.manifold import Manifold, flipped, no_manifold
from gsenv.solver.planar.narrowphase.polygons import outline_of, polygon_polygon
from gsenv.solver.planar.shapes import BOX, CIRCLE, HALF_PLANE, POLYGON, TERRAIN

Array = NDArray[Any]

NONE = 0  # excluded: neither ever moves by itself
CIRCLES = 1  # circles.circle_circle
ROUND = 2  # circles.box_circle
BOXES = 3  # boxes.box_box; a capsule is a box with a radius
POLYGONS = 4  # polygons.polygon_polygon
PLANES = 5  # half_planes
CHAINS = 6  # terrains

# fmt: off
PAIR_TABLE = np.array([
    # CIRCLE    BOX       CAPSULE   POLYGON   HALF_PLANE TERRAIN
    [CIRCLES,   ROUND,    BOXES,    POLYGONS, PLANES,    CHAINS],  # CIRCLE
    [ROUND,     BOXES,    BOXES,    POLYGONS, PLANES,    CHAINS],  # BOX
    [BOXES,     BOXES,    BOXES,    POLYGONS, PLANES,    CHAINS],  # CAPSULE
    [POLYGONS,  POLYGONS, POLYGONS, POLYGONS, PLANES,    CHAINS],  # POLYGON
    [PLANES,    PLANES,   PLANES,   PLANES,   NONE,      NONE],    # HALF_PLANE
    [CHAINS,    CHAINS,   CHAINS,   CHAINS,   NONE,      NONE],    # TERRAIN
], dtype=np.int64)
# fmt: on


@njit
def is_after(kind_a: int, kind_b: int) -> bool:
    """True where the routine wants the two the other way round."""
    if kind_b == HALF_PLANE or kind_b == TERRAIN:
        return True
    return kind_a == CIRCLE and kind_b == BOX


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
    if is_after(shape_models[a].kind, shape_models[b].kind):
        return flipped(
            collide_ordered(
                shape_models, shape_parameters, vertices, b, a, pose_b, pose_a, margin
            )
        )
    return collide_ordered(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, margin)


@njit
def collide_ordered(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    margin: float,
) -> Manifold:
    kind_b = shape_models[b].kind
    routine = PAIR_TABLE[shape_models[a].kind, kind_b]
    one = shape_parameters[a]
    other = shape_parameters[b]
    if routine == BOXES:
        return box_box(
            pose_a, one.size[0], one.size[1], one.radius,
            pose_b, other.size[0], other.size[1], other.radius, margin,
        )  # fmt: skip
    if routine == PLANES:
        if vertices is not None:
            if kind_b == POLYGON:
                model = shape_models[b]
                return half_plane_polygon(
                    pose_a, pose_b, vertices, model.vertex_first, model.vertex_count, margin
                )
        return half_plane_box(
            pose_a, pose_b, other.size[0], other.size[1], other.radius, margin
        )
    if routine == ROUND:
        return box_circle(pose_a, one.size[0], one.size[1], pose_b, other.radius, margin)
    if routine == CIRCLES:
        return circle_circle(pose_a, one.radius, pose_b, other.radius, margin)
    if vertices is not None:
        if routine == POLYGONS:
            return polygon_polygon(
                outline_of(shape_models[a], one), pose_a,
                outline_of(shape_models[b], other), pose_b, vertices, margin,
            )  # fmt: skip
    return no_manifold()
