"""Directions and quaternions (w, x, y, z) for building scenes."""

from __future__ import annotations

import math

Vec = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)


def about(axis: int, degrees: float) -> Quaternion:
    """Return the rotation by ``degrees`` about the world's x (0), y (1) or z (2) axis."""
    half = 0.5 * math.radians(degrees)
    parts = [math.cos(half), 0.0, 0.0, 0.0]
    parts[1 + axis] = math.sin(half)
    return parts[0], parts[1], parts[2], parts[3]


def after(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the product p q: the rotation q, followed by p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def turned(q: Quaternion, v: Vec) -> Vec:
    """Rotate the vector v by q."""
    w, x, y, z = q
    _, a, b, c = after(after(q, (0.0, *v)), (w, -x, -y, -z))
    return a, b, c


def lying(degrees: float, heading: float, turn: float = 0.0) -> Quaternion:
    """Return the orientation of a body on a plane that slopes down by ``degrees`` towards ``heading`` (degrees from x).

    The body's z axis is the plane's normal; its x axis is ``turn`` degrees from the downhill direction.
    """
    return after(about(2, heading), after(about(1, degrees), about(2, turn)))


def uphill_normal(degrees: float, heading: float) -> Vec:
    """Return the outward normal of a plane that slopes down by ``degrees`` towards ``heading`` (degrees from x)."""
    a, h = math.radians(degrees), math.radians(heading)
    return math.sin(a) * math.cos(h), math.sin(a) * math.sin(h), math.cos(a)


def level(heading: float) -> Vec:
    """Return the horizontal unit vector ``heading`` degrees from x."""
    h = math.radians(heading)
    return math.cos(h), math.sin(h), 0.0


def hanging(degrees: float, heading: float = 0.0) -> Vec:
    """Return the unit vector ``degrees`` from straight down, towards ``heading``."""
    a, (x, y, _) = math.radians(degrees), level(heading)
    return math.sin(a) * x, math.sin(a) * y, -math.cos(a)


def rolling_axle(heading: float) -> Quaternion:
    """Return the orientation of a cylinder that rolls towards ``heading``: its z axis is horizontal and across it."""
    return after(about(2, heading), about(0, -90.0))


def along(start: Vec, length: float, direction: Vec) -> Vec:
    """Return the point ``length`` m from ``start`` in the given direction."""
    x, y, z = (s + length * d for s, d in zip(start, direction, strict=True))
    return x, y, z
