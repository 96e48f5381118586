"""Paths of pivots: the rotation of a link since the start of a step as a vector, and the rate at which it grows.

With the vector c, R = exp(c) R_0 has the spin w if c grows by w - c x w / 2 + c x (c x w) / 12 + ...  Hairer, Lubich,
Wanner, Geometric Numerical Integration, 2006, section IV.8.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..records.articulation import LinkKind
from .math import along, cross, dot
from .rotation import spin_of

_PIVOT = int(LinkKind.PIVOT)


@njit
def set_pivot_slope(links: Any, k: Any, path: Any, slope: Any) -> None:
    """Set the rate at which the path of a pivot grows, from the link's spin."""
    link = links[k]
    if link.kind != _PIVOT:
        return
    i = link.first
    c = (path[i], path[i + 1], path[i + 2])
    w = spin_of(link.velocity)
    once = cross(c, w)
    twice = cross(c, once)
    w = along(along(w, -0.5, once), (1.0 + dot(c, c) / 60.0) / 12.0, twice)
    for d in range(3):
        slope[i + d] = w[d]


@njit
def set_pivot_step(links: Any, k: Any, path: Any, step: Any) -> None:
    """Set the displacement of a pivot relative to its parent, which has moved, from the path of the link."""
    link = links[k]
    if link.kind == _PIVOT and link.parent >= 0:
        for d in range(3):
            step[link.first + d] = path[link.first + d] - links[link.parent].turn[d]
