"""Which geoms may touch, written as the categories and masks of shapes.

MuJoCo asks whether the contype of one of two geoms meets the conaffinity of the other, a Scene whether both categories
are in both masks. Geoms with the same partners share a category, and its mask lists the categories of the partners.
"""

from __future__ import annotations

from .errors import Notes
from .model import MjcfModel

MOST = 62  # categories, one bit each
TOPIC = "more than 62 groups of geoms differ in what they touch; further contact pairs are ignored"

Key = tuple[int, int, int]  # contype, conaffinity, number of a geom that is treated alone or -1
Pairs = set[tuple[int, int]]


def contact_bits(model: MjcfModel, notes: Notes) -> list[tuple[int, int]]:
    """Return (category, mask) of each geom; the mask of a geom that touches nothing is 0."""
    geoms = model.geoms
    if not model.simulation.contacts:
        return [(1, 0)] * len(geoms)
    alone = _named_geoms(model) | _geoms_of(model, overruled(model))
    plain = {(geom.contype, geom.conaffinity, -1) for k, geom in enumerate(geoms) if k not in alone}
    if len(plain) + len(alone) > MOST:
        for pair in model.pairs:
            notes.add(TOPIC, f"{pair.place}: pair")
        alone = set()
    keys = [(geom.contype, geom.conaffinity, k if k in alone else -1) for k, geom in enumerate(geoms)]
    classes = sorted(set(keys))[:MOST]
    bits = {key: 1 << n for n, key in enumerate(classes)}
    partners = _both_ways(_pairs_of_geoms(model)) if alone else set()
    apart = _apart(model) if alone else set()
    masks = {one: sum(bits[other] for other in classes if _touch(one, other, partners, apart)) for one in classes}
    return [(bits.get(key, 1), masks.get(key, 0)) for key in keys]


def overruled(model: MjcfModel) -> Pairs:
    """Return the excluded pairs of bodies, parents with their children too, of which a pair of geoms may touch."""
    named = {_ordered(model.geoms[a].body, model.geoms[b].body) for a, b in _pairs_of_geoms(model)}
    related = {_ordered(body.parent, k) for k, body in enumerate(model.bodies) if body.parent > 0}
    return named & (set(model.excludes) | (related if model.simulation.parent_filter else set()))


def _ordered(a: int, b: int) -> tuple[int, int]:
    return min(a, b), max(a, b)


def _both_ways(pairs: Pairs) -> Pairs:
    return pairs | {(b, a) for a, b in pairs}


def _pairs_of_geoms(model: MjcfModel) -> Pairs:
    """Return the explicit pairs, by the numbers of their geoms."""
    numbers = {geom.name: k for k, geom in enumerate(model.geoms) if geom.name}
    return {(numbers[pair.geom_a], numbers[pair.geom_b]) for pair in model.pairs}


def _named_geoms(model: MjcfModel) -> set[int]:
    return {k for pair in _pairs_of_geoms(model) for k in pair}


def _geoms_of(model: MjcfModel, bodies: Pairs) -> set[int]:
    both = {body for pair in bodies for body in pair}
    return {k for k, geom in enumerate(model.geoms) if geom.body in both}


def _apart(model: MjcfModel) -> Pairs:
    """Return the geoms of overruled pairs of bodies, which touch only if they are a pair themselves."""
    geoms = model.geoms
    found = set()
    for first, second in overruled(model):
        ones = [k for k, geom in enumerate(geoms) if geom.body == first]
        others = [k for k, geom in enumerate(geoms) if geom.body == second]
        found |= {(a, b) for a in ones for b in others}
    return _both_ways(found)


def _touch(one: Key, other: Key, partners: Pairs, apart: Pairs) -> bool:
    pair = (one[2], other[2])
    return pair in partners or (pair not in apart and bool(one[0] & other[1] or other[0] & one[1]))
