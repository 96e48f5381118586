"""Contacts from step to step: impulses are inherited, contacts of sleeping pairs stay in place.

All lists are sorted by (shape_a, shape_b); the few contacts of a pair are compared each with each.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..jit import inline_njit, njit
from .dispatch import by_dimension, never

Array = NDArray[Any]

NEAR = 0.1  # of a contact's distance to the next of its pair: one that is nearer to an old contact is the same

is_witness = by_dimension("narrowphase.clip", "is_witness", otherwise=never)


@inline_njit
def pair_order(a: Any, b: Any) -> int:
    """Return a negative, zero or positive number as contact a's pair is before, equal to or after b's."""
    if a.shape_a != b.shape_a:
        return a.shape_a - b.shape_a
    return a.shape_b - b.shape_b


@inline_njit
def is_kept(contact: Any, geometry: Array) -> bool:
    """Whether the contact of a pair that was not searched stays: both shapes are active, neither is awake."""
    a = geometry[contact.shape_a]
    b = geometry[contact.shape_b]
    return a.active != 0 and b.active != 0 and a.awake == 0 and b.awake == 0


@njit
def match_pair(old: Array, first: int, last: int, found: Array, start: int, found_count: int, articulation: Any) -> int:
    """Copy `impulse` from the contacts old[first:last] of one pair to found ones of the same feature.

    If one has a new feature, all that are at the place of an old one take its impulse (`match_places`).
    With ``articulation`` that has links, the only contact of a pair is also the same as its only one before where one
    of them is at the nearest points: where an end of a capsule lies on the side of another, rounding decides in each
    step whether a feature touches.
    Searches from found[start] on; returns the index of the first found contact after the pair.
    """
    k = start
    while k < found_count and pair_order(found[k], old[first]) < 0:
        k += 1
    end = k
    while end < found_count and pair_order(found[end], old[first]) == 0:
        end += 1
    same = False
    if articulation is not None:
        trees = len(articulation.links) > 0
        same = trees and last - first == 1 and end - k == 1 and is_witness(old[first], found[k])
    renamed = False
    for j in range(k, end):
        known = False
        for i in range(first, last):
            if same or old[i].feature == found[j].feature:
                copy_impulse(old[i], found[j])
                known = True
                break
        renamed = renamed or not known
    if renamed:
        match_places(old, first, last, found, k, end)
    return end


@inline_njit
def copy_impulse(old: Any, found: Any) -> None:
    """Copy all parts of a contact's impulse."""
    for axis in range(len(found.impulse)):
        found.impulse[axis] = old.impulse[axis]


@njit
def match_places(old: Array, first: int, last: int, found: Array, start: int, end: int) -> None:
    """Copy `impulse` to each of found[start:end] that is where one of old[first:last] was.

    Where edges of two boxes coincide, rounding decides in each step of which of them a point is the corner.
    """
    for k in range(start, end):
        nearest = first
        least = np.inf
        for i in range(first, last):
            distance = square_distance(old[i], found[k])
            if distance < least:
                nearest, least = i, distance
        apart = np.inf
        for j in range(start, end):
            if j != k:
                apart = min(apart, square_distance(found[j], found[k]))
        if apart < np.inf and least < NEAR * NEAR * apart:
            copy_impulse(old[nearest], found[k])


@inline_njit
def square_distance(one: Any, other: Any) -> float:
    """Return the squared distance of the points of two contacts."""
    s = 0.0
    for axis in range(len(one.point)):
        s += (one.point[axis] - other.point[axis]) ** 2
    return s


@njit
def match_until_kept(
    old: Array, start: int, count: int, found: Array, matched: int, found_count: int, geometry: Array, articulation: Any
) -> tuple[int, int]:
    """Call match_pair from old[start] on, up to a contact that is kept; returns (its index, first found after)."""
    while start < count and not is_kept(old[start], geometry):
        last = start + 1
        while last < count and pair_order(old[last], old[start]) == 0:
            last += 1
        matched = match_pair(old, start, last, found, matched, found_count, articulation)
        start = last
    return start, matched


@njit
def update_contacts(
    contacts: Array,
    count: int,
    found: Array,
    found_count: int,
    geometry: Array,
    displaced: Array,
    places: Array,
    articulation: Any,
) -> int:
    """Replace the first `count` contacts by the `found` ones, but leave those of pairs asleep.

    `contacts`, `found` (contact,) of contact_dtype(dim), sorted by pair before and after; found ones
    inherit the impulse of the contact of the same shapes and feature or place (`articulation`: see match_pair).
    Returns the number of contacts; if it exceeds len(contacts), none was changed.  `places` (int,) receives the new
    indices of the found ones.  `displaced` (contact,) is scratch.  A sleeping contact is copied only if its index
    changes, so a few awake contacts among thousands of sleeping ones cost little.
    """
    if count + found_count > len(contacts):
        needed = found_count
        for i in range(count):
            if is_kept(contacts[i], geometry):
                needed += 1
        if needed > len(contacts):
            return needed
    # contacts[i] is the first kept contact that was not read yet; displaced[head:tail] were read, but
    # are not at their new index yet
    i, matched = match_until_kept(contacts, 0, count, found, 0, found_count, geometry, articulation)
    k = 0
    head = 0
    tail = 0
    place = 0
    while k < found_count or i < count or head < tail:
        waiting = head < tail
        take = k < found_count
        if take and waiting:
            take = pair_order(found[k], displaced[head]) < 0
        elif take and i < count:
            take = pair_order(found[k], contacts[i]) < 0
        read = i < count and (i == place or not (take or waiting))
        if take or waiting:
            if read:
                displaced[tail] = contacts[i]
                tail += 1
            if take:
                contacts[place] = found[k]
                places[k] = place
                k += 1
            else:
                contacts[place] = displaced[head]
                head += 1
        elif i != place:
            contacts[place] = contacts[i]
        if read:
            i += 1
            if i < count and not is_kept(contacts[i], geometry):
                i, matched = match_until_kept(contacts, i, count, found, matched, found_count, geometry, articulation)
        place += 1
    return place
