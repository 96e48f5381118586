"""Contacts of capsules and cylinders with ridges and peaks of a heightfield."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...jit import njit
from ..kinds import CAPSULE
from ..math import Vec, add, along, cross, dot, norm, scaled, sub, unit
from .field_bodies import Body, slack_of
from .fields import TILT, Cell, Fold, Grid, beyond_fold, beyond_peak, closest_on_segment, sample
from .spread import offer

CROSSED = 1e-4  # sine: lines nearer to parallel touch at their ends
ALONG = 1e-3  # sine: a ridge this nearly along a cylinder supports it at both ends
KINK = 1e-9  # sine: both rims are as low
SECTIONS = 40  # steps of the golden-section search: 0.618^40 < 1e-8
GOLDEN = 0.6180339887498949
# feature ids: 0 the side, 1 and 2 its ends, 3 and 4 the rims, from 5 on the flat ends
SIDE, SIDE_END, RIM, END = 0, 1, 3, 5


@njit
def end_of(body: Body, end: int) -> Vec:
    """Return the centre of the rim at -z (0) or +z (1), of a capsule the end of its segment."""
    return along(body.pose.at, body.half_length if end else -body.half_length, body.pose.z)


@njit
def cylinder_on_face(body: Body, n: Vec, end: int) -> tuple[bool, Vec]:
    """Return (found, the rim's lowest point over a face with normal n); not for an end that faces up or lies flat."""
    axis = body.pose.z
    tilt = dot(n, axis)
    middle = end_of(body, end)
    across = along(n, -tilt, axis)
    length = norm(across)
    if (tilt if end else -tilt) > 0.3 or not length > 1e-6:
        return False, middle
    return True, along(middle, -body.radius / length, across)


@njit
def round_on_fold(fold: Fold, body: Body, margin: float, feature: int, scratch: Any, total: int) -> int:
    total = side_on_fold(fold, body, margin, feature + SIDE, scratch, total)
    if body.kind == CAPSULE:
        return total
    for end in range(2):
        total = side_end_on_fold(fold, body, end, margin, feature + SIDE_END + end, scratch, total)
        total = end_on_fold(fold, body, end, margin, feature + END + 2 * end, scratch, total)
    return rim_on_fold(fold, body, margin, feature + RIM, scratch, total)


@njit
def side_on_fold(fold: Fold, body: Body, margin: float, feature: int, scratch: Any, total: int) -> int:
    """Add the contact of the side across a ridge."""
    a = end_of(body, 0)
    u, w = sub(fold.end, fold.start), scaled(body.pose.z, 2.0 * body.half_length)
    d = cross(u, w)
    length = norm(d)
    uu, ww, uw = dot(u, u), dot(w, w), dot(u, w)
    if length * length <= CROSSED * CROSSED * uu * ww:
        return total
    d = scaled(d, 1.0 / length)
    if dot(d, add(fold.normal_a, fold.normal_b)) < 0.0:
        d = scaled(d, -1.0)
    apart = sub(a, fold.start)
    gap = dot(d, apart) - body.radius
    if beyond_fold(fold, d) > slack_of(body, gap):
        return total
    across = uu * ww - uw * uw
    t = (dot(apart, u) * ww - dot(apart, w) * uw) / across
    s = (dot(apart, u) * uw - dot(apart, w) * uu) / across
    if not (gap <= margin and gap >= -2.0 * body.radius and t >= 0.0 and t <= 1.0 and s > 0.0 and s < 1.0):
        return total
    return offer(scratch, total, along(along(fold.start, t, u), 0.5 * gap, d), d, gap, feature)


@njit
def side_end_on_fold(fold: Fold, body: Body, end: int, margin: float, feature: int, scratch: Any, total: int) -> int:
    """Add the contact of an end of a cylinder's side that is along a ridge."""
    p = end_of(body, end)
    way = sub(fold.end, fold.start)
    t = dot(sub(p, fold.start), way)
    d = sub(p, closest_on_segment(p, fold.start, fold.end))
    distance = norm(d)
    if not (t >= 0.0 and t <= dot(way, way) and distance <= body.radius + margin and distance > 0.0):
        return total
    d = scaled(d, 1.0 / distance)
    if beyond_fold(fold, d) > 0.0 or abs(dot(d, body.pose.z)) > ALONG or d[2] < 0.0:
        return total
    gap = distance - body.radius
    return offer(scratch, total, along(p, -body.radius - 0.5 * gap, d), d, gap, feature)


@njit
def end_on_fold(fold: Fold, body: Body, end: int, margin: float, feature: int, scratch: Any, total: int) -> int:
    """Add the contact of a ridge under the flat end of a cylinder, where it leaves the disc."""
    outward = scaled(body.pose.z, 1.0 if end else -1.0)
    d = scaled(outward, -1.0)
    middle = end_of(body, end)
    way, start = sub(fold.end, fold.start), sub(fold.start, middle)
    if d[2] < 0.0 or beyond_fold(fold, d) > TILT or abs(dot(d, way)) > TILT * norm(way):
        return total
    way_out, start_out = dot(way, outward), dot(start, outward)
    w, s = along(way, -way_out, outward), along(start, -start_out, outward)  # in the plane of the disc
    ww, sw = dot(w, w), dot(s, w)
    root = sw * sw - ww * (dot(s, s) - body.radius * body.radius)
    if not (root > 0.0 and ww > 0.0):
        return total
    root = np.sqrt(root)
    first, last = max((-sw - root) / ww, 0.0), min((-sw + root) / ww, 1.0)
    if not last > first:
        return total
    for k in range(2):
        t = last if k else first
        gap = start_out + t * way_out
        if gap <= margin and gap >= -2.0 * body.half_length and gap >= -body.extent:
            on_ridge = along(fold.start, t, way)
            total = offer(scratch, total, along(on_ridge, 0.5 * gap, d), d, gap, feature + k)
    return total


@njit
def rim_gap(fold: Fold, body: Body, d: Vec) -> tuple[float, Vec]:
    """Return (distance m of the cylinder from the ridge along d, its lowest point along d)."""
    axis = body.pose.z
    tilt = dot(d, axis)
    across = along(d, -tilt, axis)
    length = norm(across)
    p = end_of(body, 0 if tilt > 0.0 else 1)
    if length > 0.0:
        p = along(p, -body.radius / length, across)
    return dot(d, sub(p, fold.start)), p


@njit
def peaks_inside(fold: Fold, body: Body, margin: float) -> bool:
    """Whether the gap of the rims may have a maximum within the margin strictly between the two faces' normals.

    Over the angle t of the arc, the gap f of a rim fulfils f'' + f <= 0, and so does the smaller of two.  With a
    maximum at t, f(0) <= f(t) cos t and f(t) <= f(0) cos t + f'(0) sin t (Sturm), so f'(0) >= min(f(0), 0) tan t.
    f' is the slope with the lowest point fixed (envelope theorem).
    """
    a, b = fold.normal_a, fold.normal_b
    share = dot(a, b)
    if share <= KINK:
        return True
    gap_a, p_a = rim_gap(fold, body, a)
    gap_b, p_b = rim_gap(fold, body, b)
    if max(gap_a, gap_b) > margin:
        return False
    most = (1.0 - share * share) / share
    rises = dot(along(b, -share, a), sub(p_a, fold.start)) >= min(gap_a, 0.0) * most
    falls = dot(along(a, -share, b), sub(p_b, fold.start)) >= min(gap_b, 0.0) * most
    return (rises or abs(dot(a, body.pose.z)) < KINK) and (falls or abs(dot(b, body.pose.z)) < KINK)


@njit
def rim_on_fold(fold: Fold, body: Body, margin: float, feature: int, scratch: Any, total: int) -> int:
    """Add the contact of a rim across a ridge, along the direction of largest gap between the two faces' normals.

    At an end of the range a face supports the rim, at a kink the side or the flat end touches the ridge.
    """
    if not peaks_inside(fold, body, margin):
        return total
    low, high = 0.0, 1.0
    x, y = 1.0 - GOLDEN, GOLDEN
    gap_x = rim_gap(fold, body, between(fold, x))[0]
    gap_y = rim_gap(fold, body, between(fold, y))[0]
    for _ in range(SECTIONS):
        if max(gap_x, gap_y) > margin:  # and so is the largest gap
            return total
        if gap_x > gap_y:
            high, y, gap_y = y, x, gap_x
            x = high - GOLDEN * (high - low)
            gap_x = rim_gap(fold, body, between(fold, x))[0]
        else:
            low, x, gap_x = x, y, gap_y
            y = low + GOLDEN * (high - low)
            gap_y = rim_gap(fold, body, between(fold, y))[0]
    best = 0.5 * (low + high)
    d = between(fold, best)
    gap, p = rim_gap(fold, body, d)
    tilt = abs(dot(d, body.pose.z))
    if best < 1e-6 or best > 1.0 - 1e-6 or tilt < 1e-6 or tilt > 1.0 - 1e-12:
        return total
    way = sub(fold.end, fold.start)
    t = dot(sub(p, fold.start), way)
    if not (gap <= margin and gap >= -body.extent and t >= 0.0 and t <= dot(way, way)):
        return total
    end = 0 if dot(d, body.pose.z) > 0.0 else 1
    return offer(scratch, total, along(p, -0.5 * gap, d), d, gap, feature + end)


@njit
def between(fold: Fold, share: float) -> Vec:
    return unit(along(scaled(fold.normal_a, 1.0 - share), share, fold.normal_b))


@njit
def round_on_peak(
    vertices: Any, grid: Grid, body: Body, cell: Cell, margin: float, feature: int, scratch: Any, total: int
) -> int:
    """Add the contact of a peak with the side, or with the flat end that it penetrates less."""
    row, column = cell
    p = sample(vertices, grid, row, column)
    axis = body.pose.z
    apart = sub(body.pose.at, p)
    high = -dot(apart, axis)  # position of the peak along the axis
    out = along(apart, high, axis)
    distance = norm(out)
    side = distance - body.radius
    beside = abs(high) < body.half_length and distance > 0.0
    d = scaled(out, 1.0 / distance) if distance > 0.0 else axis
    beside = beside and beyond_peak(vertices, grid, row, column, d) <= 0.0
    if body.kind != CAPSULE:
        end = 1 if high > 0.0 else 0
        gap = abs(high) - body.half_length
        if side > 0.0 and gap > 0.0:  # beyond the rim
            away = sub(along(end_of(body, end), -body.radius, d), p)
            length = norm(away)
            away = unit(away)
            if length <= margin and beyond_peak(vertices, grid, row, column, away) <= 0.0:
                q = along(p, 0.5 * length, away)
                return offer(scratch, total, q, away, length, feature + RIM + end)
            return total
        push = scaled(axis, -1.0 if end else 1.0)
        if side <= 0.0 and (gap > side or not beside) and gap <= margin and gap >= -body.extent:
            if beyond_peak(vertices, grid, row, column, push) <= TILT:
                return offer(scratch, total, along(p, 0.5 * gap, push), push, gap, feature + END + end)
    if beside and side <= margin and side >= -2.0 * body.radius:
        return offer(scratch, total, along(p, 0.5 * side, d), d, side, feature + SIDE)
    return total
