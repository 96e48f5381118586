"""Nearest points of points, segments, boxes and cylinders, in closed form."""

from __future__ import annotations

import numpy as np

from ...jit import njit
from ..math import Vec, cross, dot, norm, scaled, tangents, unit


@njit
def point_box(p: Vec, half: Vec) -> tuple[Vec, float]:
    """Return (unit direction from the box to the point, distance); inside, negative and to the nearest face."""
    ex = max(abs(p[0]) - half[0], 0.0)
    ey = max(abs(p[1]) - half[1], 0.0)
    ez = max(abs(p[2]) - half[2], 0.0)
    sx = 1.0 if p[0] >= 0.0 else -1.0
    sy = 1.0 if p[1] >= 0.0 else -1.0
    sz = 1.0 if p[2] >= 0.0 else -1.0
    distance = norm((ex, ey, ez))
    if distance > 0.0:
        return (sx * ex / distance, sy * ey / distance, sz * ez / distance), distance
    x = abs(p[0]) - half[0]
    y = abs(p[1]) - half[1]
    z = abs(p[2]) - half[2]
    if x >= y and x >= z:
        return (sx, 0.0, 0.0), x
    if y >= z:
        return (0.0, sy, 0.0), y
    return (0.0, 0.0, sz), z


@njit
def point_cylinder(p: Vec, radius: float, half: float) -> tuple[Vec, float]:
    """Return the same for a cylinder about z."""
    across = np.sqrt(p[0] * p[0] + p[1] * p[1])
    out = (1.0, 0.0, 0.0)
    if across > 0.0:
        out = (p[0] / across, p[1] / across, 0.0)
    sz = 1.0 if p[2] >= 0.0 else -1.0
    side = across - radius
    cap = abs(p[2]) - half
    if side <= 0.0 or cap <= 0.0:
        if side > cap:
            return out, side
        return (0.0, 0.0, sz), cap
    distance = np.sqrt(side * side + cap * cap)
    k = side / distance
    return (k * out[0], k * out[1], sz * cap / distance), distance


@njit
def segment_segment(d: Vec, a: Vec, half_a: float, b: Vec, half_b: float) -> tuple[float, float]:
    """Return s, t of the nearest points s a and d + t b; |s| <= half_a, |t| <= half_b, a and b unit vectors.

    For parallel segments they are at the midpoint of the common part.
    """
    c = dot(a, b)
    da = dot(d, a)
    db = dot(d, b)
    sine2 = 1.0 - c * c
    if sine2 < 1e-6:  # computed again without the loss of digits
        x = cross(a, b)
        sine2 = dot(x, x)
    if sine2 > 1e-12:
        s = min(max((da - c * db) / sine2, -half_a), half_a)
    else:
        reach = abs(c) * half_b
        low = max(-half_a, da - reach)
        high = min(half_a, da + reach)
        s = min(max(0.5 * (low + high), -half_a), half_a)
    t = c * s - db
    if abs(t) > half_b:
        t = half_b if t > 0.0 else -half_b
    s = min(max(da + c * t, -half_a), half_a)
    return s, t


@njit
def lines_direction(d: Vec, a: Vec, half_a: float, b: Vec, half_b: float) -> tuple[Vec, float, float, float]:
    """Return (unit direction from segment a to segment b, distance, s, t); see segment_segment."""
    s, t = segment_segment(d, a, half_a, b, half_b)
    gap = (d[0] + t * b[0] - s * a[0], d[1] + t * b[1] - s * a[1], d[2] + t * b[2] - s * a[2])
    distance = norm(gap)
    if distance > 1e-12 * (half_a + half_b):
        return scaled(gap, 1.0 / distance), distance, s, t
    # they cross: normal to both, towards b's centre
    x = cross(a, b) if half_b > 0.0 else (0.0, 0.0, 0.0)
    if not dot(x, x) > 1e-12:
        axis = a if half_a > 0.0 else b
        x, _ = tangents(axis)
    x = unit(x)
    return (scaled(x, -1.0) if dot(x, d) < 0.0 else x), 0.0, s, t


@njit
def segment_slope(p: Vec, d: Vec, half: Vec, t: float) -> float:
    """Return half the derivative of the squared distance of p + t d from the box."""
    slope = 0.0
    for i in range(3):
        x = p[i] + t * d[i]
        if x > half[i]:
            slope += d[i] * (x - half[i])
        elif x < -half[i]:
            slope += d[i] * (x + half[i])
    return slope


@njit
def segment_box(p: Vec, d: Vec, half: Vec) -> tuple[float, float]:
    """Return the interval (t0, t1) within [-1, 1] in which p + t d is nearest to the box.

    The slope of the squared distance is piecewise linear and never decreases, with a kink where the line
    crosses the plane of a face: the kinks next to its zero are found, then the zero between them.
    """
    return slope_zero(p, d, half, 0.0), slope_zero(p, d, half, 1.0)


@njit
def slope_zero(p: Vec, d: Vec, half: Vec, last: float) -> float:
    """Return the first (`last` = 0) or last (1) zero of segment_slope in [-1, 1], or the end nearest to one."""
    first = last == 0.0
    low = -1.0
    high = 1.0
    slope_low = segment_slope(p, d, half, low)
    slope_high = segment_slope(p, d, half, high)
    if slope_low > 0.0 or (first and slope_low == 0.0):
        return low
    if slope_high < 0.0 or (not first and slope_high == 0.0):
        return high
    for i in range(6):
        axis = i >> 1
        if d[axis] == 0.0:
            continue
        face = half[axis] if i & 1 else -half[axis]
        t = (face - p[axis]) / d[axis]
        if t > low and t < high:
            slope = segment_slope(p, d, half, t)
            if slope < 0.0 or (not first and slope == 0.0):
                low = t
                slope_low = slope
            else:
                high = t
                slope_high = slope
    if slope_high > slope_low:
        return low - slope_low * (high - low) / (slope_high - slope_low)
    return 0.5 * (low + high)
