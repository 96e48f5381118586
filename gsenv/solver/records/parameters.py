"""ParameterArrays: the quantities that may differ from world to world, as structured arrays for kernels."""

from __future__ import annotations

import numpy as np

from .model import Array, Model


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
        model = self._model
        self.worlds[chosen] = model.nominal_world
        self.bodies[chosen] = model.nominal_bodies
        self.shapes[chosen] = model.nominal_shapes
        self.joints[chosen] = model.nominal_joints
        self.rows[chosen] = model.nominal_rows
        self.vertices[chosen] = model.nominal_vertices

    def arrays(self) -> dict[str, Array]:
        """Return all arrays by name."""
        names = ("worlds", "bodies", "shapes", "joints", "rows", "vertices")
        return {name: getattr(self, name) for name in names}


def _tiled(nominal: Array, count: int) -> Array:
    return np.broadcast_to(nominal, (count, *nominal.shape)).copy()
