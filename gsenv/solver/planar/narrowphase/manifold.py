"""The contact of two convex 2D shapes: one normal, at most two points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...core.faces import NO_FACE, opposite_face
from ...jit import njit


class Manifold(NamedTuple):
    """Contact of shape a with shape b.

    `separation` is measured along the normal and is a lower bound of the distance even where
    there are no points (corner passes corner); infinite if the shapes are beyond the margin.
    """

    points: int
    normal_x: float  # from a to b
    normal_y: float
    separation: float  # m, smallest of all, negative for an overlap
    x0: float  # m, midpoint between the two surfaces
    y0: float
    separation0: float  # m, at the point
    feature0: int
    x1: float
    y1: float
    separation1: float
    feature1: int
    face: int  # whose face has the normal, NO_FACE, FACE_OF_A or FACE_OF_B: with it the normal turns
    rounding: float  # m, from the surface of the other shape to the points that are fixed on it: its radius


@njit
def no_manifold() -> Manifold:
    return Manifold(0, 0.0, 0.0, np.inf, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0, 0, NO_FACE, 0.0)


@njit
def bare_manifold(normal_x: float, normal_y: float, separation: float) -> Manifold:
    """Return a separating direction without points."""
    return Manifold(0, normal_x, normal_y, separation, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0, 0, NO_FACE, 0.0)


@njit
def point_manifold(
    normal_x: float, normal_y: float, x: float, y: float, separation: float, feature: int, face: int, rounding: float
) -> Manifold:
    return Manifold(1, normal_x, normal_y, separation, x, y, separation, feature, 0.0, 0.0, 0.0, 0, face, rounding)


@njit
def flipped(m: Manifold) -> Manifold:
    """Return the contact with shapes a and b exchanged."""
    return Manifold(
        m.points,
        -m.normal_x,
        -m.normal_y,
        m.separation,
        m.x0,
        m.y0,
        m.separation0,
        m.feature0,
        m.x1,
        m.y1,
        m.separation1,
        m.feature1,
        opposite_face(m.face),
        m.rounding,
    )
