"""Impulses carried over, sleeping contacts kept."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.contact_cache import match_contacts, merge_sleeping
from gsenv.solver.model import Array, contact_dtype, shape_geometry_dtype

SHAPES = 12


def random_contacts(rng: np.random.Generator, dim: int, pairs: list[tuple[int, int]]) -> Array:
    rows = []
    for a, b in sorted(pairs):
        rows += [(a, b, int(f)) for f in rng.choice(6, rng.integers(1, 4), replace=False)]
    contacts = np.zeros(len(rows), contact_dtype(dim))
    for contact, (a, b, f) in zip(contacts, rows, strict=True):
        contact["shape_a"], contact["shape_b"], contact["feature"] = a, b, f
    contacts["impulse"] = rng.normal(size=(len(rows), dim))
    return contacts


def random_pairs(rng: np.random.Generator) -> list[tuple[int, int]]:
    every = [(a, b) for a in range(SHAPES) for b in range(a + 1, SHAPES)]
    return [every[k] for k in rng.choice(len(every), 20, replace=False)]


def keys(contacts: Array) -> list[tuple[int, int, int]]:
    return list(zip(*(contacts[name].tolist() for name in ("shape_a", "shape_b", "feature")), strict=True))


@pytest.mark.parametrize("dim", [2, 3])
def test_impulses_follow_their_feature(dim: int) -> None:
    rng = np.random.default_rng(0)
    matched = 0
    for _ in range(50):
        old = random_contacts(rng, dim, random_pairs(rng))
        new = random_contacts(rng, dim, random_pairs(rng))
        before = new["impulse"].copy()
        match_contacts(old, len(old), new, len(new))
        table = dict(zip(keys(old), old["impulse"], strict=True))
        for key, contact, own in zip(keys(new), new, before, strict=True):
            assert (contact["impulse"] == table.get(key, own)).all()
            matched += key in table
    assert matched > 100


def test_only_the_first_count_entries_are_real() -> None:
    rng = np.random.default_rng(1)
    old = random_contacts(rng, 2, [(0, 1)])
    new = old.copy()
    new["impulse"] = 0.0
    match_contacts(old, 0, new, len(new))
    assert (new["impulse"] == 0.0).all()
    match_contacts(old, len(old), new, 1)
    assert (new["impulse"][0] == old["impulse"][0]).all()
    assert (new["impulse"][1:] == 0.0).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_sleeping_contacts_stay(dim: int) -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        geometry = np.zeros(SHAPES, shape_geometry_dtype(dim))
        geometry["active"] = rng.random(SHAPES) < 0.9
        geometry["awake"] = (rng.random(SHAPES) < 0.4) & (geometry["active"] == 1)
        on, awake = geometry["active"] == 1, geometry["awake"] == 1
        old = random_contacts(rng, dim, random_pairs(rng))
        found = random_contacts(rng, dim, [(a, b) for a, b in random_pairs(rng) if awake[a] or awake[b]])
        a, b = old["shape_a"], old["shape_b"]
        kept = old[on[a] & on[b] & ~awake[a] & ~awake[b]]
        merged = np.zeros(100, old.dtype)
        count = merge_sleeping(old, len(old), found, len(found), geometry, merged)
        wanted = np.concatenate([kept, found])
        wanted = wanted[np.lexsort((wanted["shape_b"], wanted["shape_a"]))]
        assert count == len(wanted)
        assert (merged[:count] == wanted).all()
        few = np.zeros(3, old.dtype)
        assert merge_sleeping(old, len(old), found, len(found), geometry, few) == count
        assert (few[: min(3, count)] == wanted[:3]).all()
