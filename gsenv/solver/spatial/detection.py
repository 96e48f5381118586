"""Detection of all 3D contacts of a step, those of secondary impacts included."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..core.broadphase import find_pairs
from ..core.detection import collide_pairs
from ..core.status import MORE_CONTACTS, MORE_PAIRS, OK
from ..jit import njit
from .narrowphase.manifold import manifold_dtype
from .narrowphase.scratch import scratch_dtype
from .narrowphase.secondary import keep_secondary, widen_boxes
from .narrowphase.spread import SCRATCH_SIZE, field_scratch_dtype

LOOKS = 2


def narrowphase_scratch(fields: bool, convex: bool) -> dict[str, Any]:
    """Return the fields of ``world.scratch.narrowphase``: the manifold, and scratch of its computation."""
    return {
        "manifold": np.zeros((), manifold_dtype()),
        "clip": np.zeros((), scratch_dtype()),
        "field": np.zeros(SCRATCH_SIZE, field_scratch_dtype()) if fields else None,  # of heightfields
        "convex": np.ones(1) if convex else None,  # any value but None: GJK and EPA are needed
    }


@njit
def find_contacts(world: Any) -> tuple[int, int, int, int]:
    """Fill `world.scratch.pairs` and `found`; returns (status, needed, pair count, contact count).

    A body may be pushed by an impact towards shapes far from its path: then the search is repeated once.
    """
    scratch = world.scratch
    models = world.shapes.models
    bodies = world.state.bodies
    parameters = world.parameters.bodies
    substep_bodies = scratch.substep_bodies
    timestep = world.options.timestep
    pair_count = int64(0)
    count = int64(0)
    for look in range(LOOKS):
        pair_count = find_pairs(scratch.geometry, models, world.model.exclusions, scratch.broadphase, scratch.pairs)
        if pair_count > len(scratch.pairs):
            return MORE_PAIRS, pair_count, pair_count, count
        count = collide_pairs(world, pair_count)
        if count > len(scratch.found):
            return MORE_CONTACTS, count, pair_count, count
        count, hit = keep_secondary(scratch.found, count, bodies, parameters, substep_bodies, timestep)
        if look == LOOKS - 1 or not hit:
            break
        if not widen_boxes(models, bodies, parameters, substep_bodies, timestep, scratch.geometry):
            break
    return OK, int64(0), pair_count, count
