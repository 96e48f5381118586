"""Contacts from step to step: impulses carried over, contacts of sleeping pairs kept.

All lists are sorted by (shape_a, shape_b); the few contacts of a pair are compared each with each.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from gsenv.solver.jit import njit

Array = NDArray[Any]


@njit
def pair_order(a: Any, b: Any) -> int:
    """Negative, zero or positive as contact a's pair comes before, with or after b's."""
    if a.shape_a != b.shape_a:
        return a.shape_a - b.shape_a
    return a.shape_b - b.shape_b


@njit
def match_contacts(old: Array, old_count: int, found: Array, found_count: int) -> None:
    """Copy `impulse` from old to found contacts of the same shapes and feature.

    `old`, `found` (contact,) of contact_dtype(dim); a found contact without a match keeps its own.
    """
    start = 0
    for k in range(found_count):
        contact = found[k]
        while start < old_count and pair_order(old[start], contact) < 0:
            start += 1
        i = start
        while i < old_count and pair_order(old[i], contact) == 0:
            if old[i].feature == contact.feature:
                for axis in range(len(contact.impulse)):
                    contact.impulse[axis] = old[i].impulse[axis]
                break
            i += 1


@njit
def is_kept(contact: Any, geometry: Array) -> bool:
    """True if no search was made for the pair: both sides are there, neither is awake."""
    a = geometry[contact.shape_a]
    b = geometry[contact.shape_b]
    return a.active != 0 and b.active != 0 and a.awake == 0 and b.awake == 0


@njit
def merge_sleeping(old: Array, old_count: int, found: Array, found_count: int, geometry: Array, merged: Array) -> int:
    """Contacts of pairs asleep, from `old`, and the `found` ones, sorted by pair, into `merged`.

    Returns how many there are; if more than len(merged), only the first were written.  `merged`
    is neither of the other two.
    """
    count = 0
    k = 0
    for i in range(old_count):
        if not is_kept(old[i], geometry):
            continue
        while k < found_count and pair_order(found[k], old[i]) < 0:
            if count < len(merged):
                merged[count] = found[k]
            count += 1
            k += 1
        if count < len(merged):
            merged[count] = old[i]
        count += 1
    while k < found_count:
        if count < len(merged):
            merged[count] = found[k]
        count += 1
        k += 1
    return count
