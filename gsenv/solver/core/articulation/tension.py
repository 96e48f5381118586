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
most_inverse = by_dimension("articulation", "most_inverse")

_AXES = int(LinkKind.AXES)
MARGIN = 1.1  # factor of the stiffness: what tension may gain in a substep without making vibrations grow
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
    scale = 0.25 * MARGIN * island.h**2 * world.options.substeps / world.options.timestep
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


@njit
def damp_taut_joints(island: Any, articulation: Any) -> None:
    """Damp joints by as much as tension stiffens their links: vibrations that no substep resolves end."""
    links = articulation.links
    freedoms = articulation.freedoms
    for k in range(island.body_count):
        link = links[k]
        damping = 0.0
        for d in range(len(link.taut)):
            damping += abs(link.taut[d])
        for f in range(link.first, link.first + link.count):
            freedoms[f].stiffness = 4.0 * damping if link.slides == 0 else 0.0


@njit
def damp_joints(world: Any, island: Any, articulation: Any, scale: Any) -> None:
    """Damp each joint but those on what does not move by ``scale`` times the inertia of its lighter link."""
    links = articulation.links
    freedoms = articulation.freedoms
    body_parameters = world.parameters.bodies
    for k in range(island.body_count):
        link = links[k]
        inertia = 0.0
        if link.parent >= 0:
            own = _inertia_about(body_parameters[link.body], link.arm, link.slides)
            inertia = min(own, _inertia_about(body_parameters[link.holder], link.reach, link.slides))
        for f in range(link.first, link.first + link.count):
            freedoms[f].stiffness = scale * inertia


@njit
def _inertia_about(parameters: Any, arm: Any, slides: Any) -> Any:
    """Return the mass of a link, or its least moment of inertia and that of its mass at the end of ``arm``."""
    if slides > 0:
        return parameters.mass
    inertia = 1.0 / most_inverse(parameters)
    for d in range(len(arm)):
        inertia += parameters.mass * arm[d] ** 2
    return inertia
