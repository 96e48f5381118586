"""The hits of ``World.cast_rays``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..dimension import dimension
from ..records.model import Array, Model
from ..records.parameters import ParameterArrays
from ..records.plain import as_records
from ..records.state import State


@dataclass(frozen=True)
class RayHits:
    """First hits of rays; arrays (chosen world, ray), of vectors (chosen world, ray, 2).

    Attributes:
        distance: m from the start; the ray's length where nothing is hit.
        shape, body: indices, -1 where nothing is hit.
        normal: unit, outward of the surface; opposite to the ray where it starts inside a shape (at
            distance 0), zero where nothing is hit.
        point: m, of the hit, or the end of the ray.
    """

    distance: Array
    shape: Array
    body: Array
    normal: Array
    point: Array

    @property
    def hit(self) -> Array:
        """Whether each ray hits a shape, (chosen world, ray) bool."""
        return self.shape >= 0


def cast_rays(
    model: Model, parameters: ParameterArrays, state: State, worlds: Array,
    origin: Array, direction: Array, length: Array, mask: int, exclude: int,
) -> RayHits:  # fmt: skip
    """Return the first hits of 2D rays in the worlds of these indices.

    Args:
        origin: m, (world, ray, 2); direction: unit, the same shape; length: m, (world, ray).
        mask: category bits; exclude: index of a body, or -1.
    """
    rays = dimension(model.dim).rays
    fan = np.zeros(length.shape, rays.RAY_DTYPE)
    fan["origin"], fan["direction"], fan["distance"] = origin, direction, length
    seen = rays.surroundings(model, parameters, state)
    rays.cast_rays(worlds, seen, seen.vertices, mask, exclude, as_records(fan))
    shape = fan["shape"]
    body = np.where(shape >= 0, model.shapes["body"][shape], -1)
    point = fan["origin"] + fan["distance"][..., None] * fan["direction"]
    return RayHits(fan["distance"].copy(), shape.copy(), body, fan["normal"].copy(), point)
