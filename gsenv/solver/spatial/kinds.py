"""Kinds of 3D shapes."""

from __future__ import annotations

from enum import IntEnum


class ShapeKind(IntEnum):
    SPHERE = 0
    BOX = 1
    CAPSULE = 2
    CYLINDER = 3
    HULL = 4
    PLANE = 5
    HEIGHTFIELD = 6


# plain ints: numba compares them faster than enum members
SPHERE, BOX, CAPSULE, CYLINDER, HULL, PLANE, HEIGHTFIELD = (int(kind) for kind in ShapeKind)
