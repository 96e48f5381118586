"""The pair table: which routine handles which two kinds of shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.spatial.kinds import BOX, CYLINDER, PLANE
from gsenv.solver.spatial.math import Pose
from gsenv.solver.spatial.narrowphase.boxes import collide_boxes
from gsenv.solver.spatial.narrowphase.convex import collide_convex
from gsenv.solver.spatial.narrowphase.manifold import clear_manifold, flip_manifold, sort_points
from gsenv.solver.spatial.narrowphase.planes import collide_plane
from gsenv.solver.spatial.narrowphase.rounds import collide_round
from gsenv.solver.spatial.narrowphase.solids import from_origin, solid_of

Array = NDArray[Any]

NONE = 0  # excluded: neither ever moves by itself
ROUND = 1  # rounds.collide_round: closed form
BOXES = 2  # boxes.collide_boxes: separating axes
CONVEX = 3  # convex.collide_convex: faces, then GJK and EPA
PLANES = 4  # planes.collide_plane
FIELDS = 5  # heightfields, elsewhere

# fmt: off
PAIR_TABLE = np.array([
    # SPHERE  BOX     CAPSULE CYLINDER HULL    PLANE   HEIGHTFIELD
    [ROUND,   ROUND,  ROUND,  ROUND,   CONVEX, PLANES, FIELDS],  # SPHERE
    [ROUND,   BOXES,  ROUND,  CONVEX,  CONVEX, PLANES, FIELDS],  # BOX
    [ROUND,   ROUND,  ROUND,  CONVEX,  CONVEX, PLANES, FIELDS],  # CAPSULE
    [ROUND,   CONVEX, CONVEX, CONVEX,  CONVEX, PLANES, FIELDS],  # CYLINDER
    [CONVEX,  CONVEX, CONVEX, CONVEX,  CONVEX, PLANES, FIELDS],  # HULL
    [PLANES,  PLANES, PLANES, PLANES,  PLANES, NONE,   NONE],    # PLANE
    [FIELDS,  FIELDS, FIELDS, FIELDS,  FIELDS, NONE,   NONE],    # HEIGHTFIELD
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
    m: Any,
    scratch: Any,
) -> None:
    """Fill the manifold m of shapes a and b at the given poses in the world; not for FIELDS and NONE.

    `shape_models`, `shape_parameters` (shape,); `vertices` (vertex,) or None in a scene without hulls and
    heightfields; `margin` in m; m a record of `manifold_dtype`, `scratch` one of `scratch_dtype`.
    Points come in ascending order of their features.
    """
    kind_a = int64(shape_models[a].kind)
    kind_b = int64(shape_models[b].kind)
    routine = PAIR_TABLE[kind_a, kind_b]
    # the routines want planes first and round shapes last
    box_first = kind_a == BOX or kind_a == CYLINDER
    swapped = kind_b == PLANE or (routine == ROUND and not box_first and (kind_b == BOX or kind_b == CYLINDER))
    if swapped:
        a, b = b, a
        pose_a, pose_b = pose_b, pose_a
    one = solid_of(shape_models[a], shape_parameters[a])
    other = solid_of(shape_models[b], shape_parameters[b])
    if routine == PLANES:
        collide_plane(pose_a, other, pose_b, vertices, margin, m, scratch)
    else:
        origin = pose_a.at  # the rest counts from here, so that the world's origin may be far away
        here = from_origin(pose_a, origin)
        there = from_origin(pose_b, origin)
        if routine == BOXES:
            collide_boxes(one, here, other, there, vertices, origin, margin, m, scratch)
        elif routine == ROUND:
            collide_round(one, here, other, there, vertices, origin, margin, m, scratch)
        elif routine == CONVEX:
            collide_convex(one, here, other, there, vertices, origin, margin, m, scratch)
        else:
            clear_manifold(m)
    if swapped:
        flip_manifold(m)
    if m.count > 1:
        sort_points(m)
