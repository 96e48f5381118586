"""Tension made implicit: taut links that swing slowly take one substep, however fast they could vibrate.

A force f that pulls at the end r of a link resists its rotation: turned by a small angle a, the torque changes by
-f.r (a - r r.a / r.r).  With h^2/4 times this stiffness on the inertia, and its work on the change of the spin in the
balance of momentum, the substep is the implicit midpoint rule for vibrations, which is stable at any tension and
keeps their energy.  The forces are those of the last substep.  Tournier, Nesme, Gilles, Faure, Stable constrained
dynamics, ACM Transactions on Graphics 34(4), 2015.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import SLIDES, LinkKind
from ..dispatch import by_dimension
from .links import LEAST_SWING

add_tension = by_dimension("tension", "add_tension")
stiffen = by_dimension("tension", "stiffen")

_AXES = int(LinkKind.AXES)
SLOW = 5.0  # rad in a substep, times the square root of the tolerance: largest rotation in this mode


@njit
def is_taut(world: Any, island: Any) -> Any:
    """Whether the links of a tree that nothing touches could vibrate fast, and turn slowly."""
    h = world.options.timestep / world.options.substeps
    return h * island.swing**0.5 > LEAST_SWING and h * island.spin < SLOW * world.options.tolerance**0.5


@njit
def set_tension(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Add the stiffness by tension to the inertias of all links at their present pose."""
    links = articulation.links
    scale = 0.25 * island.h**2 * world.options.substeps / world.options.timestep
    for k in range(island.body_count):
        for d in range(len(links[k].taut)):
            links[k].taut[d] = 0.0
    for k in range(island.body_count):
        link = links[k]
        slides = link.kind == _AXES and link.count > 0 and link.numbers[0] < SLIDES
        if link.joint >= 0 and not slides:
            sign = -scale if link.flipped else scale
            add_tension(links, k, joints[link.joint].impulse, sign)
    for k in range(island.body_count):
        stiffen(links[k])
