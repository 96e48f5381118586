"""The rays of ``World.cast_rays`` and their hits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core import rays
from ..records.model import Array, Model
from ..records.parameters import ParameterArrays
from ..records.plain import as_records
from ..records.sensors import ray_dtype
from ..records.state import State


@dataclass(frozen=True)
class RayHits:
    """First hits of rays; arrays (chosen world, ray), of vectors (chosen world, ray, dim).

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


class RayCast:
    """Rays in some worlds, which several calls of ``cast`` may share, each in a thread of its own.

    Args:
        worlds: (chosen,) indices.
        origin: m, (chosen, ray, dim); direction: unit, the same shape; length: m, (chosen, ray).
    """

    def __init__(
        self, model: Model, parameters: ParameterArrays, state: State, worlds: Array,
        origin: Array, direction: Array, length: Array,
    ) -> None:  # fmt: skip
        self._model = model
        self._worlds = worlds
        self._seen = rays.surroundings(model, parameters, state)
        self._fan = np.zeros(length.shape, ray_dtype(model.dim))
        self._fan["origin"], self._fan["direction"], self._fan["distance"] = origin, direction, length

    def cast(self, mask: int, exclude: int, first: int, last: int) -> None:
        """Find the first hits in the chosen worlds first .. last - 1.

        Args:
            mask: category bits; exclude: index of a body, or -1.
        """
        fan = as_records(self._fan[first:last])
        rays.cast_rays(self._worlds[first:last], self._seen, self._seen.vertices, mask, exclude, fan)

    def hits(self) -> RayHits:
        """Return what has been found."""
        fan = self._fan
        shape = fan["shape"]
        body = np.where(shape >= 0, self._model.shapes["body"][shape], -1)
        point = fan["origin"] + fan["distance"][..., None] * fan["direction"]
        return RayHits(fan["distance"].copy(), shape.copy(), body, fan["normal"].copy(), point)
