"""Whether a ray meets the volume of a site, for touch sensors."""

from __future__ import annotations

import math

import numpy as np

from ..solver.records.model import Array

Span = tuple[float, float]  # distances along a ray between which it is inside; empty where the second is smaller
NOWHERE: Span = (math.inf, -math.inf)


def ray_meets(kind: str, size: Array, start: Array, direction: Array) -> bool:
    """Whether a ray, in the site's own frame, starts in the site's volume or meets it ahead.

    Args:
        kind: sphere, capsule, ellipsoid, cylinder or box; size: (3,) m, as MuJoCo's.
    """
    for enter, leave in _spans(kind, size, start, direction):
        if enter <= leave and leave >= 0.0:
            return True
    return False


def _spans(kind: str, size: Array, start: Array, direction: Array) -> list[Span]:
    if kind == "box":
        return [_common(*(_slab(float(size[k]), start[k], direction[k]) for k in range(3)))]
    if kind == "ellipsoid":
        return [_ball(1.0, start / size, direction / size)]
    if kind == "sphere":
        return [_ball(float(size[0]), start, direction)]
    radius, half = float(size[0]), float(size[1])
    tube = _common(_ball(radius, start[:2], direction[:2]), _slab(half, start[2], direction[2]))
    if kind == "cylinder":
        return [tube]
    ends = [_ball(radius, start - np.array([0.0, 0.0, z]), direction) for z in (-half, half)]
    return [tube, *ends]


def _common(*spans: Span) -> Span:
    return max(span[0] for span in spans), min(span[1] for span in spans)


def _slab(half: float, start: float, direction: float) -> Span:
    if direction == 0.0:
        return (-math.inf, math.inf) if abs(start) <= half else NOWHERE
    ends = sorted(((-half - start) / direction, (half - start) / direction))
    return ends[0], ends[1]


def _ball(radius: float, start: Array, direction: Array) -> Span:
    """Return where a line is within a radius of the origin, in as many dimensions as it has."""
    a, b, c = float(direction @ direction), float(start @ direction), float(start @ start) - radius**2
    if a == 0.0:
        return (-math.inf, math.inf) if c <= 0.0 else NOWHERE
    root = b * b - a * c
    if root < 0.0:
        return NOWHERE
    return (-b - math.sqrt(root)) / a, (-b + math.sqrt(root)) / a
