"""The pair table: the routine for each pair of kinds of shapes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ...core.faces import FACE_OF_A, FACE_OF_B, NO_FACE
from ...core.geometry import PlacedShape
from ...jit import njit
from ...records.model import Array
from ..kinds import BOX, CYLINDER, PLANE
from ..math import Vec, add
from .boxes import boxes_direction, cross_edges, is_axis
from .clip import WITNESS, touch
from .convex import SAME, SHALLOW, core_direction, face_direction
from .manifold import MAX_POINTS, add_point, begin_manifold, clear_manifold, flip_manifold, set_face, sort_points
from .planes import collide_plane
from .rounds import round_direction
from .solids import Solid, from_origin, solid_of

NONE = 0  # excluded: neither shape can belong to a dynamic body
ROUND = 1  # rounds.round_direction: closed form
BOXES = 2  # boxes.boxes_direction: separating axes
CONVEX = 3  # convex.face_direction, core_direction: faces, then GJK and EPA
PLANES = 4  # planes.collide_plane
FIELDS = 5  # heightfields.heightfield_contacts

NEAR = 0.01  # of the extent: a corner this near to the deepest point replaces it

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
def collide(shapes: Any, a: PlacedShape, b: PlacedShape, margin: float, narrowphase: Any) -> None:
    """Fill `narrowphase.manifold` for two shapes, normal from a to b; not for FIELDS and NONE.

    Points are sorted by feature id; `margin` in m.
    """
    models = shapes.models
    m = narrowphase.manifold
    scratch = narrowphase.clip
    kind_a = int64(models[a.number].kind)
    kind_b = int64(models[b.number].kind)
    routine = PAIR_TABLE[kind_a, kind_b]
    # the routines take planes first and round shapes last
    box_first = kind_a == BOX or kind_a == CYLINDER
    swapped = kind_b == PLANE or (routine == ROUND and not box_first and (kind_b == BOX or kind_b == CYLINDER))
    if swapped:
        a, b = b, a
    other = solid_of(models[b.number], shapes.parameters[b.number], b.pose)
    if routine == PLANES:
        collide_plane(a.pose, other, shapes.vertices, margin, m, scratch)
    else:
        one = solid_of(models[a.number], shapes.parameters[a.number], a.pose)
        collide_solids(routine, one, other, shapes.vertices, margin, m, scratch, narrowphase.convex)
    if swapped:
        flip_manifold(m)
    if m.count > 1:
        sort_points(m)


@njit
def collide_solids(
    routine: int, a: Solid, b: Solid, vertices: Array | None, margin: float, m: Any, scratch: Any, convex: Any
) -> None:
    """Find the normal by the routine of the pair, then the points, in the same way for all pairs.

    `vertices`: None in a scene without hulls and heightfields; `convex`: None in one without cylinders and hulls.
    """
    origin = a.pose.at  # all positions are relative to this: the world's origin may be far away
    a = from_origin(a, origin)
    b = from_origin(b, origin)
    extent = min(a.extent, b.extent)
    by_edges, edges, edges_decide = -np.inf, int64(0), False
    n, separation, middle = a.pose.z, np.inf, a.pose.at
    face = NO_FACE
    if routine == BOXES:
        n, separation, by_edges, edges, edges_decide, middle = boxes_direction(a, b, margin)
        face = FACE_OF_A if is_axis(a.pose, n) else FACE_OF_B
    elif routine == ROUND:
        n, separation, middle = round_direction(a, b)
        if (a.kind == BOX or a.kind == CYLINDER) and is_axis(a.pose, n):
            face = FACE_OF_A
    elif convex is not None:
        n, separation, face = face_direction(a, b, vertices)
        middle = n
    if not max(separation, by_edges) <= margin:
        clear_manifold(m)
        return
    least = np.inf
    witness = int64(WITNESS)
    if edges_decide:
        n, crossing, middle, witness = cross_edges(a, b, edges)
        separation, face = by_edges, NO_FACE
        if separation > 0.0 and not crossing:
            begin_manifold(m, n, separation)
            return
    if routine != CONVEX or separation > -SHALLOW * extent:
        begin_manifold(m, n, separation)
        set_face(m, face, b if face == FACE_OF_A else a)
        least = touch(a, b, vertices, origin, margin, m, scratch)
    if routine == BOXES and not edges_decide:
        if least == np.inf:
            if by_edges > separation:
                touch_at_edges(a, b, origin, by_edges, edges, m)
            elif separation <= 0.0:  # deep, and beside the faces
                add_point(m, add(origin, middle), separation, witness)
        return
    if convex is not None:
        if routine == CONVEX:
            if least <= separation + SAME * extent:
                return
            found, separation, middle = core_direction(a, b, vertices, n, separation, margin, scratch)
            face = face if found == n else NO_FACE
            n = found
            if not separation <= margin:
                clear_manifold(m)
                return
            begin_manifold(m, n, separation)
            set_face(m, face, b if face == FACE_OF_A else a)
            least = touch(a, b, vertices, origin, margin, m, scratch)
    if not least <= separation + NEAR * extent:
        m.count = min(m.count, MAX_POINTS - 1)
        add_point(m, add(origin, middle), separation, witness)


@njit
def touch_at_edges(a: Solid, b: Solid, origin: Vec, separation: float, edges: int, m: Any) -> None:
    """Fill m with the contact of two edges along their common normal; no point where they pass each other."""
    n, crossing, middle, witness = cross_edges(a, b, edges)
    begin_manifold(m, n, separation)
    if separation <= 0.0 or crossing:
        add_point(m, add(origin, middle), separation, witness)
