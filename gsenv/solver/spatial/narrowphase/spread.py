"""Selection of contact points: in each group of similar normals the deepest and those with the largest spread.

On flat ground these imply all others. On bumpy ground another one may be deeper than the plane through those chosen,
and a shape would fall onto it when it rocks; such points form further groups.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ...core.faces import NO_FACE
from ...jit import njit
from ..math import Vec, cross, dot, norm, sub, vec

SCRATCH_SIZE = 192  # no hull has more edges: 3 * 64 - 6
AGREE = 0.995  # cosine: normals within 5.7 degrees form one group
MAX_GROUPS = 4  # largest number of groups, deepest first
APART = 0.02  # of the extent: points of one group nearer than this count as one
LEVEL = 1e-5  # of the extent: a point this close to the plane through others is implied by them
FREE, TAKEN, CHOSEN = 0, 1, 2


def field_scratch_dtype() -> np.dtype[Any]:
    """Return the dtype of scratch; entry i: corner, face and edge i of the shape in the field's frame, candidate i."""
    return np.dtype(
        [
            ("point", "f8", (3,)),  # m, corner
            ("normal", "f8", (3,)),  # unit, outward, of the face
            ("offset", "f8"),  # m
            ("start", "i4"),  # corners of the edge
            ("end", "i4"),
            ("left", "i4"),  # faces at the edge
            ("right", "i4"),
            ("spot", "f8", (3,)),  # m, of the candidate, midpoint between the surfaces
            ("push", "f8", (3,)),  # unit, out of the field
            ("gap", "f8"),  # m
            ("feature", "i4"),
            ("face", "i4"),  # see core/faces.py: a corner of the shape on a face of the field, or none
            ("rounding", "f8"),  # m, of this corner
            ("state", "i4"),
        ],
        align=True,
    )


@njit
def offer(scratch: Any, total: int, spot: Vec, push: Vec, gap: float, feature: int) -> int:
    """Add a candidate; where there is no room it replaces the shallowest.  Returns the number of candidates."""
    k = total
    if total >= len(scratch):
        k = int64(0)
        for i in range(total):
            if scratch[i].gap > scratch[k].gap:
                k = int64(i)
        if gap >= scratch[k].gap:
            return total
    entry = scratch[k]
    for i in range(3):
        entry.spot[i] = spot[i]
        entry.push[i] = push[i]
    entry.gap = gap
    entry.feature = feature
    entry.face = NO_FACE
    entry.rounding = 0.0
    entry.state = FREE
    return total + 1 if k == total else total


@njit
def set_face(scratch: Any, total: int, after: int, face: int, radius: float) -> None:
    """Note whose face the candidate number `total` is on, if the offer made it: of the field (a) or the shape (b).

    `after`: number of candidates since then; `radius`: m, around the corner on this face.
    """
    if after > total:
        scratch[total].face = face
        scratch[total].rounding = radius


@njit
def choose(scratch: Any, total: int, extent: float) -> None:
    """Mark candidates as CHOSEN: up to four points of each of up to four groups of normals."""
    for _ in range(MAX_GROUPS):
        first = int64(-1)
        for i in range(total):
            if scratch[i].state == FREE and (first < 0 or scratch[i].gap < scratch[first].gap):
                first = int64(i)
        if first < 0:
            return
        choose_group(scratch, total, first, APART * extent, LEVEL * extent)


@njit
def choose_group(scratch: Any, total: int, first: int, apart: float, level: float) -> None:
    """Choose the deepest, the farthest from it, the farthest from their line, the farthest beyond that triangle.

    The others of the group that these imply are TAKEN.
    """
    n = vec(scratch[first].push)
    a = vec(scratch[first].spot)
    second = farthest(scratch, total, n, a, a, a, 0, apart)
    third = fourth = int64(-1)
    if second >= 0:
        b = vec(scratch[second].spot)
        third = farthest(scratch, total, n, a, b, b, 1, apart)
        if third >= 0:
            fourth = farthest(scratch, total, n, a, b, vec(scratch[third].spot), 2, apart)
    scratch[first].state = CHOSEN
    for k in (second, third, fourth):
        if k >= 0:
            scratch[k].state = CHOSEN
    for i in range(total):
        if scratch[i].state == FREE and dot(vec(scratch[i].push), n) > AGREE:
            if is_implied(scratch, i, n, (first, second, third, fourth), level):
                scratch[i].state = TAKEN


@njit
def is_implied(scratch: Any, i: int, n: Vec, chosen: tuple[int, int, int, int], level: float) -> bool:
    """Whether a candidate keeps its gap, or a larger one, wherever those of the chosen ones stay open.

    Between these it must not be deeper than the plane through them; beyond them it must be in this plane.
    """
    first, second, third, fourth = chosen
    gap = scratch[i].gap
    if second < 0:
        return True
    p = vec(scratch[i].spot)
    if third < 0:
        way = sub(vec(scratch[second].spot), vec(scratch[first].spot))
        t = dot(sub(p, vec(scratch[first].spot)), way) / dot(way, way)
        above = gap - (1.0 - t) * scratch[first].gap - t * scratch[second].gap
        return abs(above) <= level or (above > 0.0 and t >= 0.0 and t <= 1.0)
    inside, plane = gap_between(scratch, n, p, first, second, third)
    above = gap - plane
    if fourth >= 0 and not inside:
        for k in range(3):
            a = second if k == 0 else first
            b = second if k == 2 else third
            inside, plane = gap_between(scratch, n, p, a, b, fourth)
            if inside:
                above = gap - plane
                break
    return abs(above) <= level or (above > 0.0 and inside)


@njit
def gap_between(scratch: Any, n: Vec, p: Vec, i: int, j: int, k: int) -> tuple[bool, float]:
    """Return (whether p is in the triangle of three candidates seen along n, the gap there of the plane of theirs)."""
    a, b, c = vec(scratch[i].spot), vec(scratch[j].spot), vec(scratch[k].spot)
    area = dot(n, cross(sub(b, a), sub(c, a)))
    if area == 0.0:
        return False, np.inf
    u = dot(n, cross(sub(b, p), sub(c, p))) / area
    v = dot(n, cross(sub(c, p), sub(a, p))) / area
    w = 1.0 - u - v
    return u >= 0.0 and v >= 0.0 and w >= 0.0, u * scratch[i].gap + v * scratch[j].gap + w * scratch[k].gap


@njit
def farthest(scratch: Any, total: int, n: Vec, a: Vec, b: Vec, c: Vec, step: int, apart: float) -> int:
    """Return the candidate of a group that is farthest from those chosen so far; -1 if all are near to them."""
    best, most = int64(-1), apart
    for i in range(total):
        if scratch[i].state != FREE or not dot(vec(scratch[i].push), n) > AGREE:
            continue
        p = vec(scratch[i].spot)
        if step == 0:
            far = norm(sub(p, a))
        elif step == 1:
            far = abs(left_of(n, a, b, p))
        else:  # beyond a side of the triangle; the first two in order such that it turns left
            far = -np.inf
            sign = 1.0 if left_of(n, a, b, c) > 0.0 else -1.0
            far = max(far, -sign * left_of(n, a, b, p))
            far = max(far, -sign * left_of(n, b, c, p))
            far = max(far, -sign * left_of(n, c, a, p))
        if far > most:
            best, most = int64(i), far
    return best


@njit
def left_of(n: Vec, a: Vec, b: Vec, p: Vec) -> float:
    """Return the distance of p to the left of the line from a to b, viewed against n."""
    way = sub(b, a)
    return dot(cross(n, way), sub(p, a)) / norm(way)
