"""The contact of two convex 3D shapes: one normal and up to four points, in a record that is reused."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.faces import NO_FACE, opposite_face
from ...jit import njit
from ..kinds import CYLINDER
from ..math import Vec
from .solids import Solid

MAX_POINTS = 4


def manifold_dtype() -> np.dtype[Any]:
    """Return the dtype of the contact of shape a with shape b.

    ``separation`` is measured along the normal and is a lower bound of the distance even where there
    are no points; infinite if the shapes are beyond the margin.
    """
    return np.dtype(
        [
            ("count", "i8"),
            ("normal", "f8", (3,)),  # unit, from a to b
            ("separation", "f8"),  # m, smallest of all, negative for an overlap
            ("point", "f8", (MAX_POINTS, 3)),  # m, midpoint between the two surfaces
            ("gap", "f8", (MAX_POINTS,)),  # m, separation at the point
            ("feature", "i8", (MAX_POINTS,)),  # feature ids
            ("face", "i8"),  # whose face has the normal, which turns with it; see core/faces.py
            ("rounding", "f8"),  # m, from the surface of the other shape to the points that are fixed on it
        ],
        align=True,
    )


@njit
def begin_manifold(m: Any, n: Vec, separation: float) -> None:
    """Start a manifold along the unit normal n, which belongs to no face, without points."""
    m.count = 0
    m.face = NO_FACE
    m.rounding = 0.0
    m.separation = separation
    set_normal(m, n)


@njit
def set_face(m: Any, face: int, other: Solid) -> None:
    """Note whose face has the normal; `other`: the shape that touches it.

    A cylinder counts as one without: what touches is not fixed on it while it rolls.
    """
    if face != NO_FACE and other.kind != CYLINDER:
        m.face = face
        m.rounding = other.grown


@njit
def clear_manifold(m: Any) -> None:
    """Set a manifold to that of shapes beyond the margin."""
    begin_manifold(m, (0.0, 0.0, 1.0), np.inf)


@njit
def set_normal(m: Any, n: Vec) -> None:
    m.normal[0] = n[0]
    m.normal[1] = n[1]
    m.normal[2] = n[2]


@njit
def add_point(m: Any, p: Vec, gap: float, feature: int) -> None:
    k = m.count
    m.point[k, 0] = p[0]
    m.point[k, 1] = p[1]
    m.point[k, 2] = p[2]
    m.gap[k] = gap
    m.feature[k] = feature
    m.count = k + 1


@njit
def flip_manifold(m: Any) -> None:
    """Exchange shapes a and b."""
    for i in range(3):
        m.normal[i] = -m.normal[i]
    m.face = opposite_face(m.face)


@njit
def sort_points(m: Any) -> None:
    """Sort the points by feature id."""
    for i in range(1, m.count):
        k = i
        while k > 0 and m.feature[k - 1] > m.feature[k]:
            swap_points(m, k - 1, k)
            k -= 1


@njit
def swap_points(m: Any, i: int, k: int) -> None:
    for axis in range(3):
        x = m.point[i, axis]
        m.point[i, axis] = m.point[k, axis]
        m.point[k, axis] = x
    gap = m.gap[i]
    m.gap[i] = m.gap[k]
    m.gap[k] = gap
    feature = m.feature[i]
    m.feature[i] = m.feature[k]
    m.feature[k] = feature
