"""All contacts of a step, those of secondary impacts included."""

from __future__ import annotations

from typing import Any

from numba import int64

from ..broadphase import find_pairs
from ..jit import njit
from .narrowphase import find_contacts
from .narrowphase.secondary import keep_secondary, widen_boxes

OK = 0
MORE_PAIRS = 1
MORE_CONTACTS = 2
LOOKS = 2


@njit
def detect(
    bodies: Any,
    body_models: Any,
    body_parameters: Any,
    shape_models: Any,
    shape_parameters: Any,
    vertices: Any,
    exclusions: Any,
    gravity: Any,
    dt: Any,
    geometry: Any,
    broadphase: Any,
    pairs: Any,
    found: Any,
    motions: Any,
    manifold: Any,
    clip: Any,
    field: Any,
    convex: Any,
) -> Any:
    """Fill `pairs` and `found`: (status, needed, pair count, contact count).

    What an impact pushes aside may reach shapes far from its way: then all is looked at once more.
    """
    pair_count = int64(0)
    found_count = int64(0)
    for look in range(LOOKS):
        pair_count = find_pairs(geometry, shape_models, exclusions, broadphase, pairs)
        if pair_count > len(pairs):
            return MORE_PAIRS, pair_count, pair_count, found_count
        found_count = find_contacts(
            bodies,
            body_models,
            body_parameters,
            shape_models,
            shape_parameters,
            vertices,
            geometry,
            pairs,
            pair_count,
            gravity,
            dt,
            found,
            manifold,
            clip,
            field,
            convex,
        )
        if found_count > len(found):
            return MORE_CONTACTS, found_count, pair_count, found_count
        found_count, hit = keep_secondary(found, found_count, bodies, body_parameters, motions, dt)
        if look == LOOKS - 1 or not hit:
            break
        if not widen_boxes(shape_models, bodies, body_parameters, motions, dt, geometry):
            break
    return OK, int64(0), pair_count, found_count
