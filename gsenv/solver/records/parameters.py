"""ParameterArrays: the quantities that may differ from world to world, as structured arrays for kernels."""

from __future__ import annotations

import numpy as np

from .model import Array, Model
from .plain import as_bytes, rows


class ParameterArrays:
    """Masses, sizes, materials, gains, gravity and ``enabled`` flags of N worlds.

    The structured arrays ``bodies``, ``shapes``, ``joints``, ``rows`` and ``vertices`` are (world, item),
    ``worlds`` is (world,).
    """

    def __init__(self, model: Model, world_count: int) -> None:
        self._model = model
        self.worlds = _tiled(model.nominal_world[None], world_count)[:, 0]
        self.bodies = _tiled(model.nominal_bodies, world_count)
        self.shapes = _tiled(model.nominal_shapes, world_count)
        self.joints = _tiled(model.nominal_joints, world_count)
        self.rows = _tiled(model.nominal_rows, world_count)
        self.vertices = _tiled(model.nominal_vertices, world_count)

    def reset(self, chosen: Array) -> None:
        """Set the chosen worlds to the nominal values."""
        chosen = rows(chosen)
        model = self._model
        as_bytes(self.worlds)[chosen] = as_bytes(model.nominal_world[None])
        as_bytes(self.bodies)[chosen] = as_bytes(model.nominal_bodies[None])
        as_bytes(self.shapes)[chosen] = as_bytes(model.nominal_shapes[None])
        as_bytes(self.joints)[chosen] = as_bytes(model.nominal_joints[None])
        as_bytes(self.rows)[chosen] = as_bytes(model.nominal_rows[None])
        as_bytes(self.vertices)[chosen] = as_bytes(model.nominal_vertices[None])

    def arrays(self) -> dict[str, Array]:
        """Return all arrays by name."""
        names = ("worlds", "bodies", "shapes", "joints", "rows", "vertices")
        return {name: getattr(self, name) for name in names}


def _tiled(nominal: Array, count: int) -> Array:
    return np.broadcast_to(nominal, (count, *nominal.shape)).copy()
