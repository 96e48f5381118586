"""Detection of all 2D contacts of a step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..core.broadphase import find_pairs
from ..core.detection import collide_pairs
from ..core.status import MORE_CONTACTS, MORE_PAIRS, OK
from ..jit import njit
from ..records.model import contact_dtype


def narrowphase_scratch(fields: bool, convex: bool) -> dict[str, Any]:
    """Return the fields of ``world.scratch.narrowphase``."""
    return {"no_contacts": np.zeros(0, contact_dtype(2))}  # for calls that need only the distance


@njit
def find_contacts(world: Any) -> tuple[int, int, int, int]:
    """Fill `world.scratch.pairs` and `found`; returns (status, needed, pair count, contact count)."""
    scratch = world.scratch
    pair_count = find_pairs(
        scratch.geometry, world.shapes.models, world.model.exclusions, scratch.broadphase, scratch.pairs
    )
    if pair_count > len(scratch.pairs):
        return MORE_PAIRS, pair_count, pair_count, int64(0)
    found_count = collide_pairs(world, pair_count)
    if found_count > len(scratch.found):
        return MORE_CONTACTS, found_count, pair_count, found_count
    return OK, int64(0), pair_count, found_count
