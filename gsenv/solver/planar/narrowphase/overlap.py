"""The separation of two overlapping 2D shapes at their present poses, for readings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...core.geometry import MovingShape, PlacedShape
from ...jit import njit
from ..geometry import pose_in
from ..kinds import TERRAIN
from .find import chain_contacts
from .motion import Motion
from .table import CHAINS, NONE, PAIR_TABLE, collide

Array = NDArray[Any]


@njit
def overlap_separation(shapes: Any, geometry: Any, a: int, b: int, narrowphase: Any) -> float:
    """Return the separation of shapes a and b in m, negative for an overlap; infinite if they are apart."""
    routine = PAIR_TABLE[shapes.models[a].kind, shapes.models[b].kind]
    if routine == NONE:
        return np.inf
    one = PlacedShape(a, pose_in(geometry[a]))
    other = PlacedShape(b, pose_in(geometry[b]))
    if routine != CHAINS:
        return collide(shapes, shapes.vertices, one, other, 0.0).separation
    if shapes.models[a].kind == TERRAIN:
        return _under_terrain(shapes, shapes.vertices, one, other, narrowphase.no_contacts)
    return _under_terrain(shapes, shapes.vertices, other, one, narrowphase.no_contacts)


@njit
def _under_terrain(
    shapes: Any, vertices: Array | None, terrain: PlacedShape, shape: PlacedShape, contacts: Array
) -> float:
    if vertices is None:
        return np.inf
    still = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    ground = MovingShape(terrain.number, terrain.pose, still, 0.0)
    body = MovingShape(shape.number, shape.pose, still, 0.0)
    return chain_contacts(shapes, vertices, ground, body, 0.0, 0.0, contacts, int64(0)).separation
