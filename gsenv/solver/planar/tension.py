"""Tension in 2D: what core/articulation/tension.py explains."""

from __future__ import annotations

from typing import Any

from ..jit import njit


@njit
def add_tension(links: Any, k: Any, impulse: Any, scale: Any) -> None:
    """Add the stiffness by the joint of link k, whose force is ``scale`` times ``impulse``, to both of its links."""
    link = links[k]
    f = scale * impulse[0], scale * impulse[1]
    link.taut[0] += max(0.0, -(f[0] * link.arm[0] + f[1] * link.arm[1]))
    if link.parent >= 0:
        links[link.parent].taut[0] += max(0.0, -(f[0] * link.reach[0] + f[1] * link.reach[1]))


@njit
def stiffen(link: Any) -> None:
    """Add the stiffness to the inertia."""
    link.inertia[2, 2] += link.taut[0]


@njit
def resist(link: Any, sign: Any) -> None:
    """Add the impulse by which the stiffness resists the change of the spin, times ``sign``, to ``response``."""
    link.response[2] += sign * link.taut[0] * (link.velocity[2] - link.start_spin[0])
