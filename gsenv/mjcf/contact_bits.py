"""Which geoms may touch, written as the categories and masks of shapes.

MuJoCo asks whether the contype of one of two geoms meets the conaffinity of the other, a Scene whether both categories
are in both masks. Geoms with the same partners share a category, and its mask lists the categories of the partners.
"""

from __future__ import annotations

from collections.abc import Sequence

from .errors import Notes
from .model import Geom, MjcfModel

MOST = 62  # categories, one bit each
TOPIC = "more than 62 groups of geoms differ in what they touch; further contact pairs are ignored"

Key = tuple[int, int, int]  # contype, conaffinity, number of a geom named by a pair or -1


def contact_bits(model: MjcfModel, notes: Notes) -> list[tuple[int, int]]:
    """Return (category, mask) of each geom; the mask of a geom that touches nothing is 0."""
    geoms = model.geoms
    if not model.simulation.contacts:
        return [(1, 0)] * len(geoms)
    paired = {name for pair in model.pairs for name in (pair.geom_a, pair.geom_b)}
    plain = {(geom.contype, geom.conaffinity, -1) for geom in geoms if geom.name not in paired}
    if len(plain) + len(paired) > MOST:
        for pair in model.pairs:
            notes.add(TOPIC, f"{pair.place}: pair")
        paired = set()
    keys = [_key(k, geom, paired) for k, geom in enumerate(geoms)]
    classes = sorted(set(keys))[:MOST]
    bits = {key: 1 << n for n, key in enumerate(classes)}
    partners = _partners(geoms, model, paired)
    masks = {one: sum(bits[other] for other in classes if _touch(one, other, partners)) for one in classes}
    return [(bits.get(key, 1), masks.get(key, 0)) for key in keys]


def _key(index: int, geom: Geom, paired: set[str]) -> Key:
    return geom.contype, geom.conaffinity, index if geom.name in paired else -1


def _partners(geoms: Sequence[Geom], model: MjcfModel, paired: set[str]) -> set[tuple[int, int]]:
    """Return the explicit pairs, by the numbers of their geoms."""
    numbers = {geom.name: k for k, geom in enumerate(geoms) if geom.name}
    found = set()
    for pair in model.pairs if paired else ():
        a, b = numbers[pair.geom_a], numbers[pair.geom_b]
        found |= {(a, b), (b, a)}
    return found


def _touch(one: Key, other: Key, partners: set[tuple[int, int]]) -> bool:
    return bool(one[0] & other[1] or other[0] & one[1]) or (one[2], other[2]) in partners
