"""Impulses carried over, sleeping contacts kept."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

from gsenv.solver.core.contact_cache import update_contacts
from gsenv.solver.records.model import Array, contact_dtype
from gsenv.solver.records.scratch_dtypes import shape_geometry_dtype
from gsenv.solver.spatial.narrowphase.clip import WITNESS

SHAPES = 12


class Joined(NamedTuple):
    """What the cache asks of an articulation."""

    links: Any


def random_contacts(rng: np.random.Generator, dim: int, pairs: list[tuple[int, int]]) -> Array:
    rows = []
    for a, b in sorted(pairs):
        rows += [(a, b, int(f)) for f in rng.choice(6, rng.integers(1, 4), replace=False)]
    contacts = np.zeros(len(rows), contact_dtype(dim))
    for contact, (a, b, f) in zip(contacts, rows, strict=True):
        contact["shape_a"], contact["shape_b"], contact["feature"] = a, b, f
    contacts["impulse"] = rng.normal(size=contacts["impulse"].shape)
    return contacts


def random_pairs(rng: np.random.Generator) -> list[tuple[int, int]]:
    every = [(a, b) for a in range(SHAPES) for b in range(a + 1, SHAPES)]
    return [every[k] for k in rng.choice(len(every), 20, replace=False)]


def keys(contacts: Array) -> list[tuple[int, int, int]]:
    return list(zip(*(contacts[name].tolist() for name in ("shape_a", "shape_b", "feature")), strict=True))


def sleepers(rng: np.random.Generator, dim: int) -> Array:
    """Some shapes are awake, some switched off."""
    geometry = np.zeros(SHAPES, shape_geometry_dtype(dim))
    geometry["active"] = rng.random(SHAPES) < 0.9
    geometry["awake"] = (rng.random(SHAPES) < rng.random()) & (geometry["active"] == 1)
    return geometry


def one_awake(dim: int = 2) -> Array:
    geometry = np.zeros(SHAPES, shape_geometry_dtype(dim))
    geometry["active"] = 1
    geometry["awake"][3] = 1
    return geometry


def all_awake(dim: int) -> Array:
    geometry = np.zeros(SHAPES, shape_geometry_dtype(dim))
    geometry["active"] = geometry["awake"] = 1
    return geometry


def searched(contacts: Array, geometry: Array) -> Array:
    """Which of the contacts are of pairs with something awake or switched off."""
    still = (geometry["active"] == 1) & (geometry["awake"] == 0)
    return ~(still[contacts["shape_a"]] & still[contacts["shape_b"]])


def update(
    old: Array, found: Array, geometry: Array, room: int = 100, articulation: Any = None
) -> tuple[int, Array, Array]:
    """(count, contacts, places of the found ones) after an update of the old ones."""
    contacts = np.zeros(max(room, len(old)), old.dtype)
    contacts[: len(old)] = old
    places = np.zeros(room, np.int32)
    count = update_contacts(
        contacts, len(old), found.copy(), len(found), geometry, np.zeros_like(contacts), places, articulation
    )
    return count, contacts, places[: len(found)]


@pytest.mark.parametrize("dim", [2, 3])
def test_impulses_follow_their_feature(dim: int) -> None:
    rng = np.random.default_rng(0)
    matched = 0
    for _ in range(50):
        old = random_contacts(rng, dim, random_pairs(rng))
        new = random_contacts(rng, dim, random_pairs(rng))
        count, contacts, _ = update(old, new, all_awake(dim))
        assert keys(contacts[:count]) == keys(new)
        table = dict(zip(keys(old), old["impulse"], strict=True))
        for key, contact, own in zip(keys(new), contacts, new["impulse"], strict=False):
            assert (contact["impulse"] == table.get(key, own)).all()
            matched += key in table
    assert matched > 100


@pytest.mark.parametrize(("before", "after", "more", "kept"), [
    (WITNESS, 0, False, True), (2, WITNESS, False, True), (0, 2, False, False), (WITNESS, 0, True, False),
])  # fmt: skip
def test_a_single_contact_at_the_nearest_points_is_the_same(before: int, after: int, more: bool, kept: bool) -> None:
    old, new = np.zeros(1, contact_dtype(3)), np.zeros(2 if more else 1, contact_dtype(3))
    for contacts in (old, new):
        contacts["shape_b"] = 1
    old["feature"], old["impulse"] = before, 1.0
    new["feature"] = np.arange(len(new)) + after
    _, contacts, _ = update(old, new, all_awake(3), articulation=Joined(np.zeros(1)))
    assert (contacts[: len(new)]["impulse"] == float(kept)).all()


def corners(dim: int, features: list[int]) -> Array:
    """The contacts of a face: its corners, a metre apart."""
    contacts = np.zeros(len(features), contact_dtype(dim))
    contacts["shape_b"] = 1
    contacts["feature"] = features
    contacts["point"][:, 0] = [0.0, 1.0, 1.0, 0.0][: len(features)]
    contacts["point"][:, -1] = [0.0, 0.0, 1.0, 1.0][: len(features)]
    return contacts


@pytest.mark.parametrize(("dim", "before", "after"), [
    (2, [1, 2], [3, 1]), (2, [1, 2], [3, 4]), (3, [1, 2, 3, 4], [1, 2, 3, 5]), (3, [1, 2, 3, 4], [4, 5, 6, 1]),
    (3, [1, 2, 3, 4], [5, 1, 2]),
])  # fmt: skip
def test_renamed_contacts_inherit_the_impulse_of_their_place(dim: int, before: list[int], after: list[int]) -> None:
    """As corners that coincide with those of another box: rounding decided whose they were, and loads were lost."""
    old, new = corners(dim, before), corners(dim, after)
    old["impulse"] = 1.0 + np.arange(old["impulse"].size).reshape(old["impulse"].shape)
    new["point"] += 1e-3
    _, contacts, _ = update(old, new, all_awake(dim))
    assert (contacts["impulse"][: len(new)] == old["impulse"][: len(new)]).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_contacts_elsewhere_are_new(dim: int) -> None:
    old, new = corners(dim, [1, 2]), corners(dim, [2, 3])
    old["impulse"][:, 0] = [5.0, 7.0]
    new["point"][:, 0] += 0.3
    _, contacts, _ = update(old, new, all_awake(dim))
    assert contacts["impulse"][:2, 0].tolist() == [7.0, 0.0]


def test_only_the_first_count_entries_are_real() -> None:
    rng = np.random.default_rng(1)
    old = random_contacts(rng, 2, [(0, 1)])
    new = old.copy()
    new["impulse"] = 0.0
    places, scratch = np.zeros(10, np.int32), np.zeros_like(old)
    contacts = old.copy()
    assert update_contacts(contacts, 0, new.copy(), len(new), all_awake(2), scratch, places, None) == len(new)
    assert (contacts["impulse"] == 0.0).all()
    contacts = old.copy()
    assert update_contacts(contacts, len(old), new.copy(), 1, all_awake(2), scratch, places, None) == 1
    assert (contacts["impulse"][0] == old["impulse"][0]).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_sleeping_contacts_stay(dim: int) -> None:
    rng = np.random.default_rng(2)
    for _ in range(300):
        geometry = sleepers(rng, dim)
        awake = geometry["awake"] == 1
        old = random_contacts(rng, dim, random_pairs(rng))
        found = random_contacts(rng, dim, [(a, b) for a, b in random_pairs(rng) if awake[a] or awake[b]])
        kept = old[~searched(old, geometry)]
        wanted = np.concatenate([kept, found])
        wanted = wanted[np.lexsort((wanted["shape_b"], wanted["shape_a"]))]
        count, contacts, places = update(old, found, geometry)
        assert keys(contacts[:count]) == keys(wanted)
        assert keys(contacts[places]) == keys(found)
        left = np.setdiff1d(np.arange(count), places)
        assert (contacts[left] == kept).all()
        table = dict(zip(keys(old), old["impulse"], strict=True))
        for contact, own in zip(contacts[places], found, strict=True):
            assert (contact["impulse"] == table.get(keys(own[None])[0], own["impulse"])).all()


def test_contacts_that_do_not_fit_change_nothing() -> None:
    rng = np.random.default_rng(3)
    geometry = one_awake()
    old = random_contacts(rng, 2, random_pairs(rng))
    found = random_contacts(rng, 2, random_pairs(rng))
    count, contacts, _ = update(old, found, geometry, room=0)
    assert count == (~searched(old, geometry)).sum() + len(found) > len(old)
    assert (contacts == old).all()


def test_unmoved_sleepers_are_not_copied() -> None:
    rng = np.random.default_rng(4)
    geometry = one_awake()
    old = random_contacts(rng, 2, random_pairs(rng))
    found = old[searched(old, geometry)]
    assert 0 < len(found) < len(old)
    displaced = np.zeros_like(old)
    contacts = old.copy()
    places = np.zeros(len(old), np.int32)
    assert update_contacts(contacts, len(old), found, len(found), geometry, displaced, places, None) == len(old)
    assert (contacts == old).all()
    assert (places[: len(found)] == np.flatnonzero(searched(old, geometry))).all()
    assert not displaced["shape_b"].any()
