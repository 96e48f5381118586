"""The separation of two overlapping 3D shapes at their present poses, for readings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ...core.geometry import PlacedShape
from ...jit import njit
from ..geometry import pose_in
from ..kinds import HEIGHTFIELD
from .heightfields import heightfield_contacts
from .table import FIELDS, NONE, PAIR_TABLE, collide

Array = NDArray[Any]


@njit
def overlap_separation(shapes: Any, geometry: Any, a: int, b: int, narrowphase: Any) -> float:
    """Return the separation of shapes a and b in m, negative for an overlap; infinite if they are apart."""
    routine = PAIR_TABLE[shapes.models[a].kind, shapes.models[b].kind]
    if routine == NONE:
        return np.inf
    one = PlacedShape(a, pose_in(geometry[a]))
    other = PlacedShape(b, pose_in(geometry[b]))
    if routine != FIELDS:
        collide(shapes, one, other, 0.0, narrowphase)
        return narrowphase.manifold.separation
    if shapes.models[a].kind == HEIGHTFIELD:
        return _under_field(shapes, one, other, narrowphase, narrowphase.field)
    return _under_field(shapes, other, one, narrowphase, narrowphase.field)


@njit
def _under_field(shapes: Any, field: PlacedShape, shape: PlacedShape, narrowphase: Any, scratch: Array | None) -> float:
    if scratch is None:
        return np.inf
    heightfield_contacts(shapes, field, shape, 0.0, 0.0, narrowphase.no_contacts, int64(0), narrowphase)
    return narrowphase.manifold.separation
