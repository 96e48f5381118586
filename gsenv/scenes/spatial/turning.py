"""Directions and quaternions (w, x, y, z) that scenes are authored with."""

from __future__ import annotations

import math

Vec = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)


def about(axis: int, degrees: float) -> Quaternion:
    """A turn by ``degrees`` about the world's x (0), y (1) or z (2) axis."""
    half = 0.5 * math.radians(degrees)
    parts = [math.cos(half), 0.0, 0.0, 0.0]
    parts[1 + axis] = math.sin(half)
    return parts[0], parts[1], parts[2], parts[3]


def after(p: Quaternion, q: Quaternion) -> Quaternion:
    """The turn q, then the turn p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def turned(q: Quaternion, v: Vec) -> Vec:
    """The vector v after the turn q."""
    w, x, y, z = q
    _, a, b, c = after(after(q, (0.0, *v)), (w, -x, -y, -z))
    return a, b, c


def lying(degrees: float, heading: float, turn: float = 0.0) -> Quaternion:
    """Of what lies on a plane that falls by ``degrees`` towards ``heading`` (degrees from x), turned on it by ``turn``:
    x points downhill at turn 0, z out of the plane."""
    return after(about(2, heading), after(about(1, degrees), about(2, turn)))


def uphill_normal(degrees: float, heading: float) -> Vec:
    """Outward normal of that plane."""
    a, h = math.radians(degrees), math.radians(heading)
    return math.sin(a) * math.cos(h), math.sin(a) * math.sin(h), math.cos(a)


def level(heading: float) -> Vec:
    """Horizontal unit vector ``heading`` degrees from x."""
    h = math.radians(heading)
    return math.cos(h), math.sin(h), 0.0


def hanging(degrees: float, heading: float = 0.0) -> Vec:
    """Unit vector ``degrees`` from straight down, towards ``heading``."""
    a, (x, y, _) = math.radians(degrees), level(heading)
    return math.sin(a) * x, math.sin(a) * y, -math.cos(a)


def rolling_axle(heading: float) -> Quaternion:
    """Lays a cylinder down so that it rolls towards ``heading``: its z axis level, across that."""
    return after(about(2, heading), about(0, -90.0))


def along(start: Vec, length: float, direction: Vec) -> Vec:
    """The point ``length`` m from ``start`` in a direction."""
    x, y, z = (s + length * d for s, d in zip(start, direction, strict=True))
    return x, y, z
