"""Kinds of 2D shapes."""

from __future__ import annotations

from enum import IntEnum


class ShapeKind(IntEnum):
    CIRCLE = 0
    BOX = 1
    CAPSULE = 2
    POLYGON = 3
    HALF_PLANE = 4
    TERRAIN = 5


# plain ints: numba compares them faster than enum members
CIRCLE, BOX, CAPSULE, POLYGON, HALF_PLANE, TERRAIN = (int(kind) for kind in ShapeKind)
