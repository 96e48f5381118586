"""Contact points along a given normal: where the supporting features of two shapes overlap in its projection.

Both features are projected along the normal; the corners of their intersection are the candidates, each with
the gap between the two surfaces there.  At most four are kept: a deep one and those that span the largest
area with it.  Polygons are clipped edge by edge (I. Sutherland, G. Hodgman, "Reentrant polygon
clipping", 1974).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...jit import njit
from ..math import Vec, scaled, vec
from .features import Basis, basis_of, find_feature
from .manifold import MAX_POINTS, add_point
from .scratch import CLIP_MAX
from .solids import Solid

Array = NDArray[Any]

OVERHANG = 1e-6  # of a feature's size: points this little beside the other feature count as on it
PARALLEL = 0.05  # sine: lines nearer to parallel touch in two points
LEVEL = 5e-4  # of the width: flatter contacts need not contain their deepest point
DEEP = 200.0  # m of width that count as much as 1 m of depth in the choice of points
WITNESS = 127  # label of a point that is not a corner of a feature
LABELS = 128
FEATURES = 2048


@njit
def touch(a: Solid, b: Solid, vertices: Array | None, origin: Vec, margin: float, m: Any, scratch: Any) -> float:
    """Write the points of the manifold m along its normal; poses are relative to `origin`.

    Returns the smallest gap in m, infinite without points.
    """
    n = vec(m.normal)
    basis = basis_of(n)
    find_feature(a, vertices, n, basis, int64(0), scratch)
    find_feature(b, vertices, scaled(n, -1.0), basis, int64(1), scratch)
    count_a = scratch.face_count[0]
    count_b = scratch.face_count[1]
    count = int64(0)
    base = ((scratch.face_id[0] & (FEATURES - 1)) * FEATURES + (scratch.face_id[1] & (FEATURES - 1))) * LABELS
    if count_a >= 3 and count_b >= 3:
        count = cut_polygons(margin, scratch)
    elif count_a >= 2 and count_b >= 2:
        if count_a == 2 and count_b == 2:
            count = cross_lines(margin, scratch)
        else:
            count = cut_line(int64(0) if count_a >= 3 else int64(1), margin, scratch)
    if count == 0:
        return np.inf
    least = np.inf
    for i in range(count):
        least = min(least, scratch.spot[i, 3])
    kept = choose_spots(count, least, scratch)
    if count_a >= 3 and count_b >= 3:
        label_spots(kept, scratch)
    for i in range(kept):
        k = scratch.chosen[i]
        add_spot(m, basis, origin, k, base + scratch.spot_label[k], scratch)
    return least


@njit
def add_spot(m: Any, basis: Basis, origin: Vec, k: int, feature: int, scratch: Any) -> None:
    t, s, n = basis
    u = scratch.spot[k, 0]
    v = scratch.spot[k, 1]
    h = scratch.spot[k, 2]
    p = (
        origin[0] + (u * t[0] + v * s[0] + h * n[0]),
        origin[1] + (u * t[1] + v * s[1] + h * n[1]),
        origin[2] + (u * t[2] + v * s[2] + h * n[2]),
    )
    add_point(m, p, max(scratch.spot[k, 3], m.separation), feature)


@njit
def put_spot(u: float, v: float, excess: float, label: int, margin: float, count: int, scratch: Any) -> int:
    """Add a candidate if it is within the margin; `excess` is added to its gap."""
    a = scratch.face_plane[0, 0] + scratch.face_plane[0, 1] * u + scratch.face_plane[0, 2] * v
    b = scratch.face_plane[1, 0] + scratch.face_plane[1, 1] * u + scratch.face_plane[1, 2] * v
    gap = b - a + excess
    if not gap <= margin or count >= CLIP_MAX:
        return count
    scratch.spot[count, 0] = u
    scratch.spot[count, 1] = v
    scratch.spot[count, 2] = 0.5 * (a + b)
    scratch.spot[count, 3] = gap
    scratch.spot_label[count] = label
    return count + 1


@njit
def doubled_area(side: int, scratch: Any) -> float:
    """Return twice the feature's area, positive where its corners are counter-clockwise."""
    n = scratch.face_count[side]
    area = 0.0
    u0 = scratch.face[side, 0, 0]
    v0 = scratch.face[side, 0, 1]
    for i in range(1, n - 1):
        u1 = scratch.face[side, i, 0] - u0
        v1 = scratch.face[side, i, 1] - v0
        u2 = scratch.face[side, i + 1, 0] - u0
        v2 = scratch.face[side, i + 1, 1] - v0
        area += u1 * v2 - v1 * u2
    return area


@njit
def cut_polygons(margin: float, scratch: Any) -> int:
    """Write the corners of the intersection of two polygons as spots; the one with more corners is clipped."""
    knife = int64(0) if scratch.face_count[0] <= scratch.face_count[1] else int64(1)
    area = doubled_area(knife, scratch)
    sign = 1.0 if area >= 0.0 else -1.0
    tolerance = OVERHANG * np.sqrt(min(abs(area), abs(doubled_area(1 - knife, scratch))))
    count = scratch.face_count[1 - knife]
    for i in range(count):
        scratch.clip[0, i, 0] = scratch.face[1 - knife, i, 0]
        scratch.clip[0, i, 1] = scratch.face[1 - knife, i, 1]
    source = int64(0)
    edges = scratch.face_count[knife]
    u0 = scratch.face[knife, edges - 1, 0]
    v0 = scratch.face[knife, edges - 1, 1]
    for i in range(edges):
        u1 = scratch.face[knife, i, 0]
        v1 = scratch.face[knife, i, 1]
        du = sign * (u1 - u0)
        dv = sign * (v1 - v0)
        length = np.sqrt(du * du + dv * dv)
        if length > 0.0:
            # inside: x * u + y * v + c >= 0
            x = -dv / length
            y = du / length
            count = cut_edge(x, y, tolerance - x * u0 - y * v0, tolerance, source, count, scratch)
            source = 1 - source
            if count == 0:
                return count
        u0 = u1
        v0 = v1
    spots = int64(0)
    for i in range(count):
        spots = put_spot(scratch.clip[source, i, 0], scratch.clip[source, i, 1], 0.0, int64(0), margin, spots, scratch)
    return spots


@njit
def cut_edge(x: float, y: float, c: float, tolerance: float, source: int, count: int, scratch: Any) -> int:
    """Clip the polygon clip[source] to x u + y v + c >= 0, into the other one; returns the number of corners."""
    target = 1 - source
    kept = int64(0)
    u0 = scratch.clip[source, count - 1, 0]
    v0 = scratch.clip[source, count - 1, 1]
    inside0 = x * u0 + y * v0 + c
    for i in range(count):
        u1 = scratch.clip[source, i, 0]
        v1 = scratch.clip[source, i, 1]
        inside1 = x * u1 + y * v1 + c
        # a crossing within the tolerance of a kept corner is that corner
        if (inside0 > tolerance and inside1 < 0.0) or (inside0 < 0.0 and inside1 > tolerance):
            part = inside0 / (inside0 - inside1)
            if kept < CLIP_MAX:
                scratch.clip[target, kept, 0] = u0 + part * (u1 - u0)
                scratch.clip[target, kept, 1] = v0 + part * (v1 - v0)
                kept += 1
        if inside1 >= 0.0 and kept < CLIP_MAX:
            scratch.clip[target, kept, 0] = u1
            scratch.clip[target, kept, 1] = v1
            kept += 1
        u0 = u1
        v0 = v1
        inside0 = inside1
    return kept


@njit
def cut_line(polygon: int, margin: float, scratch: Any) -> int:
    """Write the ends of the part of a line over a polygon (feature 0 or 1) as spots."""
    line = 1 - polygon
    u = scratch.face[line, 0, 0]
    v = scratch.face[line, 0, 1]
    du = scratch.face[line, 1, 0] - u
    dv = scratch.face[line, 1, 1] - v
    area = doubled_area(polygon, scratch)
    sign = 1.0 if area >= 0.0 else -1.0
    length = np.sqrt(du * du + dv * dv)
    tolerance = OVERHANG * min(np.sqrt(abs(area)), length)
    low = 0.0
    high = 1.0
    edges = scratch.face_count[polygon]
    u0 = scratch.face[polygon, edges - 1, 0]
    v0 = scratch.face[polygon, edges - 1, 1]
    for i in range(edges):
        u1 = scratch.face[polygon, i, 0]
        v1 = scratch.face[polygon, i, 1]
        eu = sign * (u1 - u0)
        ev = sign * (v1 - v0)
        side = np.sqrt(eu * eu + ev * ev)
        if side > 0.0:
            here = (eu * (v - v0) - ev * (u - u0)) / side + tolerance
            there = here + (eu * dv - ev * du) / side
            if here < 0.0 and there < 0.0:
                return int64(0)
            if here < 0.0:
                low = max(low, here / (here - there))
            elif there < 0.0:
                high = min(high, here / (here - there))
        u0 = u1
        v0 = v1
    if low > high:
        return int64(0)
    count = put_spot(u + low * du, v + low * dv, 0.0, scratch.face_label[line, 0], margin, int64(0), scratch)
    if (high - low) * length > tolerance:
        count = put_spot(u + high * du, v + high * dv, 0.0, scratch.face_label[line, 1], margin, count, scratch)
    return count


@njit
def cross_lines(margin: float, scratch: Any) -> int:
    """Write the crossing of two lines, or of nearly parallel ones both ends of their common part, as spots."""
    au, av = scratch.face[0, 0, 0], scratch.face[0, 0, 1]
    bu, bv = scratch.face[1, 0, 0], scratch.face[1, 0, 1]
    adu, adv = scratch.face[0, 1, 0] - au, scratch.face[0, 1, 1] - av
    bdu, bdv = scratch.face[1, 1, 0] - bu, scratch.face[1, 1, 1] - bv
    length_a = np.sqrt(adu * adu + adv * adv)
    length_b = np.sqrt(bdu * bdu + bdv * bdv)
    x = adu * bdv - adv * bdu
    du = bu - au
    dv = bv - av
    if abs(x) > PARALLEL * length_a * length_b:
        along_a = (du * bdv - dv * bdu) / x
        along_b = (du * adv - dv * adu) / x
        slack = 0.5 + OVERHANG
        if abs(along_a - 0.5) > slack or abs(along_b - 0.5) > slack:
            return int64(0)
        return put_spot(au + along_a * adu, av + along_a * adv, 0.0, int64(2), margin, int64(0), scratch)
    au0, av0 = adu / length_a, adv / length_a
    start = du * au0 + dv * av0
    end = start + bdu * au0 + bdv * av0
    low = max(0.0, min(start, end))
    high = min(length_a, max(start, end))
    if not high >= low:
        return int64(0)
    bend = scratch.face_bend[0] + scratch.face_bend[1]
    narrow = OVERHANG * min(length_a, length_b)
    count = line_spot(low, (start, end), bend, narrow, int64(0), margin, int64(0), scratch)
    if high - low > narrow:
        count = line_spot(high, (start, end), bend, narrow, int64(1), margin, count, scratch)
    return count


@njit
def line_spot(
    x: float, line: tuple[float, float], bend: float, narrow: float, label: int, margin: float, count: int, scratch: Any
) -> int:
    """Write the spot at x along line 0, at the midpoint to line 1, whose ends are beside positions `line` of line 0."""
    start, end = line
    part = (x - start) / (end - start)
    au, av = scratch.face[0, 0, 0], scratch.face[0, 0, 1]
    adu, adv = scratch.face[0, 1, 0] - au, scratch.face[0, 1, 1] - av
    length = np.sqrt(adu * adu + adv * adv)
    u = au + x / length * adu
    v = av + x / length * adv
    wide_u = scratch.face[1, 0, 0] + part * (scratch.face[1, 1, 0] - scratch.face[1, 0, 0]) - u
    wide_v = scratch.face[1, 0, 1] + part * (scratch.face[1, 1, 1] - scratch.face[1, 0, 1]) - v
    wide2 = wide_u * wide_u + wide_v * wide_v
    excess = 0.0
    if bend > 0.0:
        excess = 0.5 * wide2 / bend  # curved sides separate from each other
    elif wide2 > (100.0 * narrow) * (100.0 * narrow):
        return count  # sharp edges pass each other
    return put_spot(u + 0.5 * wide_u, v + 0.5 * wide_v, excess, label, margin, count, scratch)


@njit
def choose_spots(count: int, least: float, scratch: Any) -> int:
    """Write at most four spots to `chosen`: a deep one, the farthest from it, the largest areas on both sides."""
    if count <= MAX_POINTS:
        for i in range(count):
            scratch.chosen[i] = i
        return count
    best = -np.inf
    first = int64(0)
    lowest = int64(0)
    for i in range(count):
        # the position along a fixed generic direction decides ties, which rounding would decide otherwise
        score = 0.9063 * scratch.spot[i, 0] + 0.4226 * scratch.spot[i, 1] - DEEP * (scratch.spot[i, 3] - least)
        if score > best:
            best = score
            first = int64(i)
        if scratch.spot[i, 3] < scratch.spot[lowest, 3]:
            lowest = int64(i)
    second, width = farthest_spot(count, first, scratch)
    if scratch.spot[first, 3] - least > LEVEL * width:
        first = lowest
        second, width = farthest_spot(count, first, scratch)
    u0, v0 = scratch.spot[first, 0], scratch.spot[first, 1]
    du, dv = scratch.spot[second, 0] - u0, scratch.spot[second, 1] - v0
    left = first
    right = first
    most = 0.0
    least_area = 0.0
    slack = 1e-9 * width * width  # of equal areas the first
    for i in range(count):
        area = du * (scratch.spot[i, 1] - v0) - dv * (scratch.spot[i, 0] - u0)
        if area > most + slack:
            most = area
            left = int64(i)
        elif area < least_area - slack:
            least_area = area
            right = int64(i)
    scratch.chosen[0] = first
    scratch.chosen[1] = second
    kept = int64(2)
    if left != first:
        scratch.chosen[kept] = left
        kept += 1
    if right != first:
        scratch.chosen[kept] = right
        kept += 1
    return kept


@njit
def farthest_spot(count: int, start: int, scratch: Any) -> tuple[int, float]:
    """Return (number, distance in m) of the spot farthest from another; of equal ones the first."""
    u, v = scratch.spot[start, 0], scratch.spot[start, 1]
    far = 0.0
    index = start
    for i in range(count):
        du, dv = scratch.spot[i, 0] - u, scratch.spot[i, 1] - v
        distance = du * du + dv * dv
        if distance > far * (1.0 + 1e-9):
            far = distance
            index = int64(i)
    return index, np.sqrt(far)


@njit
def label_spots(kept: int, scratch: Any) -> None:
    """Label each spot with the nearest corner of the smaller polygon, which does not change in small motions."""
    area_a = abs(doubled_area(int64(0), scratch))
    side = 0 if area_a < 0.9 * abs(doubled_area(int64(1), scratch)) else 1
    for i in range(kept):
        k = scratch.chosen[i]
        near = np.inf
        label = int64(0)
        for j in range(scratch.face_count[side]):
            du = scratch.face[side, j, 0] - scratch.spot[k, 0]
            dv = scratch.face[side, j, 1] - scratch.spot[k, 1]
            distance = du * du + dv * dv
            if distance < near:
                near = distance
                label = scratch.face_label[side, j]
        for j in range(i):
            if scratch.spot_label[scratch.chosen[j]] % 32 == label % 32:
                label += 32
        scratch.spot_label[k] = label


@njit
def is_witness(one: Any, other: Any) -> bool:
    """Whether one of two contacts is at the nearest points of its shapes, not at a corner of a feature."""
    return one.feature % LABELS == WITNESS or other.feature % LABELS == WITNESS
