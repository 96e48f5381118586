"""The pair table: which routine handles which two kinds of shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.spatial.kinds import BOX, CYLINDER, PLANE
from gsenv.solver.spatial.math import Pose, add
from gsenv.solver.spatial.narrowphase.boxes import boxes_direction, cross_edges
from gsenv.solver.spatial.narrowphase.clip import WITNESS, touch
from gsenv.solver.spatial.narrowphase.convex import SAME, SHALLOW, core_direction, face_direction
from gsenv.solver.spatial.narrowphase.manifold import MAX_POINTS, add_point, clear_manifold, flip_manifold, sort_points
from gsenv.solver.spatial.narrowphase.planes import collide_plane
from gsenv.solver.spatial.narrowphase.rounds import round_direction
from gsenv.solver.spatial.narrowphase.solids import Solid, from_origin, solid_of

Array = NDArray[Any]

NONE = 0  # excluded: neither ever moves by itself
ROUND = 1  # rounds.round_direction: closed form
BOXES = 2  # boxes.boxes_direction: separating axes
CONVEX = 3  # convex.face_direction, core_direction: faces, then GJK and EPA
PLANES = 4  # planes.collide_plane
FIELDS = 5  # heightfields, elsewhere

NEAR = 0.01  # of the extent: a corner this near to the deepest point stands for it

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
    convex: Any,
) -> None:
    """Fill the manifold m of shapes a and b at the given poses in the world; not for FIELDS and NONE.

    `shape_models`, `shape_parameters` (shape,); `vertices` (vertex,) or None in a scene without hulls and
    heightfields; `margin` in m; m a record of `manifold_dtype`, `scratch` one of `scratch_dtype`.
    Points come in ascending order of their features. `convex`: None in a scene without cylinders and hulls.
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
        collide_solids(routine, one, pose_a, other, pose_b, vertices, margin, m, scratch, convex)
    if swapped:
        flip_manifold(m)
    if m.count > 1:
        sort_points(m)


@njit
def collide_solids(
    routine: int, a: Solid, pose_a: Pose, b: Solid, pose_b: Pose, vertices: Array | None, margin: float,
    m: Any, scratch: Any, convex: Any,
) -> None:  # fmt: skip
    """First the normal, each pair of kinds its own way, then the points, all the same way."""
    origin = pose_a.at  # all counts from here: the world's origin may be far away
    pose_a = from_origin(pose_a, origin)
    pose_b = from_origin(pose_b, origin)
    extent = min(a.extent, b.extent)
    by_edges, edges, edges_decide = -np.inf, int64(0), False
    n, separation, middle = pose_a.z, np.inf, pose_a.at
    if routine == BOXES:
        n, separation, by_edges, edges, edges_decide, middle = boxes_direction(a, pose_a, b, pose_b, margin)
    elif routine == ROUND:
        n, separation, middle = round_direction(a, pose_a, b, pose_b)
    elif convex is not None:
        n, separation = face_direction(a, pose_a, b, pose_b, vertices)
        middle = n
    if not max(separation, by_edges) <= margin:
        clear_manifold(m)
        return
    least = np.inf
    if not edges_decide and (routine != CONVEX or separation > -SHALLOW * extent):
        least = touch(a, pose_a, b, pose_b, vertices, origin, n, separation, margin, m, scratch)
    if routine == BOXES:
        if least == np.inf:
            if by_edges > separation:
                cross_edges(a, pose_a, b, pose_b, origin, by_edges, edges, m)
            elif separation <= 0.0:  # deep and beside the faces
                add_point(m, add(origin, middle), separation, int64(WITNESS))
        return
    if convex is not None:
        if routine == CONVEX:
            if least <= separation + SAME * extent:
                return
            n, separation, middle = core_direction(a, pose_a, b, pose_b, vertices, n, separation, margin, scratch)
            if not separation <= margin:
                clear_manifold(m)
                return
            least = touch(a, pose_a, b, pose_b, vertices, origin, n, separation, margin, m, scratch)
    if not least <= separation + NEAR * extent:
        m.count = min(m.count, MAX_POINTS - 1)
        add_point(m, add(origin, middle), separation, int64(WITNESS))
