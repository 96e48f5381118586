"""The deepest overlap of two shapes in each world, measured from their present poses."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.broadphase import find_pairs
from ..core.dispatch import by_dimension
from ..core.geometry import update_geometry
from ..dimension import dimension
from ..jit import is_compiled, njit
from ..records.bundle import Bundle, per_world, select_world
from ..records.kernel_variants import KernelVariant, choose_variant
from ..records.model import Array, Model, contact_dtype
from ..records.options import OPTIONS_DTYPE
from ..records.parameters import ParameterArrays
from ..records.scratch import broadphase_of
from ..records.scratch_dtypes import PAIR_DTYPE, shape_geometry_dtype
from ..records.state import State

overlap_separation = by_dimension("narrowphase.overlap", "overlap_separation")

SUNK = 0.1  # of the extent of the smaller dynamic shape: depth at which a contact has failed


class Overlaps:
    """Measures the overlaps of a World's shapes, with scratch that it keeps from call to call.

    Shapes may touch if their filters and the joints of their bodies allow it, both are enabled, none is a
    sensor and at least one belongs to a dynamic body. Sleeping bodies are measured like others. A body behind
    a terrain or heightfield, which are one-sided, does not overlap it.
    """

    def __init__(self, model: Model, parameters: ParameterArrays, state: State) -> None:
        self._arrays = (model, parameters, state)
        self._capacity = 16 + 4 * len(model.shapes)
        self._variant = choose_variant(model, self._is_compiled)
        self._bundle = _bundle(*self._arrays, self._variant, self._capacity)

    def _is_compiled(self, variant: KernelVariant) -> bool:
        world = _bundle(*self._arrays, variant, 1)
        return is_compiled(_measure, world, np.zeros(1), np.zeros(1, np.int32))

    def measure(self) -> tuple[Array, Array]:
        """Return (m, the depth of the deepest overlap; number of overlaps deeper than ``SUNK``), each (world,)."""
        count = len(self._arrays[2].worlds)
        depths, sunk = np.zeros(count), np.zeros(count, np.int32)
        if len(self._arrays[0].shapes) < 2:  # then nothing is compiled
            return depths, sunk
        while True:
            needed = int(_measure(self._bundle, depths, sunk))
            if needed <= self._capacity:
                return depths, sunk
            self._capacity = 2 * needed
            self._bundle = _bundle(*self._arrays, self._variant, self._capacity)


def _bundle(model: Model, parameters: ParameterArrays, state: State, variant: KernelVariant, capacity: int) -> Bundle:
    """Return the fields of ``kernel_world`` that poses, pairs and the narrowphase need, with scratch of its own.

    The timestep is 0, so that boxes and margins are those of the present.
    """
    dim = model.dim
    vertices = per_world(parameters.vertices) if variant.vertices else None
    narrowphase = dimension(dim).scratch.narrowphase_scratch(variant.fields, variant.convex)
    return Bundle(
        "Overlaps",
        dim,
        options=np.zeros((), OPTIONS_DTYPE),
        model=Bundle("Model", dim, bodies=model.bodies, exclusions=model.exclusions),
        parameters=Bundle("Parameters", dim, world=per_world(parameters.worlds), bodies=per_world(parameters.bodies)),
        state=Bundle("State", dim, bodies=per_world(state.bodies)),
        shapes=Bundle("Shapes", dim, models=model.shapes, parameters=per_world(parameters.shapes), vertices=vertices),
        scratch=Bundle(
            "Scratch",
            dim,
            geometry=np.zeros(len(model.shapes), shape_geometry_dtype(dim)),
            broadphase=broadphase_of(model, variant),
            pairs=np.zeros(capacity, PAIR_DTYPE),
            narrowphase=Bundle("Narrowphase", dim, **{"no_contacts": np.zeros(0, contact_dtype(dim)), **narrowphase}),
        ),
    ).seal()


@njit
def _measure(world: Any, depths: Any, sunk: Any) -> int:
    """Fill ``depths`` and ``sunk`` (world,); returns the largest number of pairs; call again if they do not fit."""
    needed = 0
    for w in range(len(depths)):
        select_world(world, w)
        needed = max(needed, _measure_world(world, depths, sunk, w))
    return needed


@njit
def _measure_world(world: Any, depths: Any, sunk: Any, w: int) -> int:
    shapes = world.shapes
    models = shapes.models
    geometry = world.scratch.geometry
    pairs = world.scratch.pairs
    update_geometry(world)
    for k in range(len(geometry)):
        geometry[k].awake = geometry[k].dynamic
    count = find_pairs(geometry, models, world.model.exclusions, world.scratch.broadphase, pairs)
    deepest = 0.0
    deep = 0
    for p in range(min(count, len(pairs))):
        a = np.int64(pairs[p].shape_a)
        b = np.int64(pairs[p].shape_b)
        if models[a].sensor == 0 and models[b].sensor == 0:
            separation = overlap_separation(shapes, geometry, a, b, world.scratch.narrowphase)
            deepest = max(deepest, -separation)
            if -separation > SUNK * min(geometry[a].extent, geometry[b].extent):
                deep += 1
    depths[w] = deepest
    sunk[w] = deep
    return count
