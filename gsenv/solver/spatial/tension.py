"""Tension in 3D: what core/articulation/tension.py explains."""

from __future__ import annotations

from typing import Any

from ..jit import inline_njit, njit
from .math import Vec, dot, scaled, sub, vec
from .rotation import spin_of


@njit
def add_tension(links: Any, k: Any, impulse: Any, scale: Any) -> None:
    """Add the stiffness by the joint of link k, whose force is ``scale`` times ``impulse``, to both of its links."""
    link = links[k]
    pull = scaled(vec(impulse), -scale)
    _add(link.taut, vec(link.arm), pull)
    if link.parent >= 0:
        _add(links[link.parent].taut, vec(link.reach), pull)


@inline_njit
def _add(taut: Any, r: Vec, pull: Vec) -> None:
    """Add the stiffness of a pull along the arm r: against rotation across it."""
    square = dot(r, r)
    s = dot(r, pull)
    if not s > 0.0:
        return
    s /= square
    x, y, z = r
    taut[0] += s * (square - x * x)
    taut[1] -= s * x * y
    taut[2] -= s * x * z
    taut[3] += s * (square - y * y)
    taut[4] -= s * y * z
    taut[5] += s * (square - z * z)


@njit
def stiffen(link: Any) -> None:
    """Add the stiffness to the inertia, to its lower triangle."""
    n = link.inertia
    i = 0
    for d in range(3, 6):
        for e in range(d, 6):
            n[e, d] += link.taut[i]
            i += 1


@njit
def resist(link: Any, sign: Any) -> None:
    """Add the impulse by which the stiffness resists the change of the spin, times ``sign``, to ``response``."""
    x, y, z = scaled(sub(spin_of(link.velocity), vec(link.start_spin)), sign)
    i = link.taut
    link.response[3] += i[0] * x + i[1] * y + i[2] * z
    link.response[4] += i[1] * x + i[3] * y + i[4] * z
    link.response[5] += i[2] * x + i[4] * y + i[5] * z
