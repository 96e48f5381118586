"""Velocities of bodies that the joints of their trees do not allow, made true as by an inelastic impact.

Bodies have such velocities after a step by the rows of their joints, or after a user has set them.  The new rates are
those with the least kinetic energy of the change: impulses in the joints bring them about, so that the momenta of free
trees are kept.  One pass through the factor of the tree finds them, at the pose at the start of the step.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..dispatch import by_dimension
from .dynamics import factorise_links, respond, set_inertias
from .links import move_links
from .reactions import add_reactions

keep_momentum = by_dimension("articulation", "keep_momentum")
carry = by_dimension("articulation", "carry")

EQUAL = 1e-12  # of the velocity: difference by rounding
ROUNDING = 1e-20  # of the kinetic energy: energy of differences by rounding


@njit
def join_velocities(world: Any, island: Any, articulation: Any, joints: Any) -> None:
    """Add to the rates ``start`` what the momenta of the bodies ask for beyond those of the links.

    The impulses in the joints that bring this about are added to their reactions.
    """
    links = articulation.links
    freedoms = articulation.freedoms
    change = articulation.change
    if not (_any_differs(world, island, articulation) and _set_differences(world, island, articulation)):
        return
    h = island.h
    island.h = 0.0  # no implicit damping
    set_inertias(world, island, articulation)
    island.h = h
    factorise_links(links, island.body_count, freedoms)
    for k in range(island.body_count):
        carry(links[k])
    for f in range(island.freedoms):
        change[f] = 0.0
    respond(links, island.body_count, freedoms, change)
    for f in range(island.freedoms):
        articulation.start[f] += change[f]
    move_links(island, articulation, articulation.start)
    _set_differences(world, island, articulation)
    for k in range(island.body_count):
        for d in range(len(links[k].response)):
            links[k].response[d] = -links[k].response[d]
        carry(links[k])
    add_reactions(island, articulation, joints, True)


@njit
def _any_differs(world: Any, island: Any, articulation: Any) -> Any:
    """Whether the velocity of a body is not that of its link to rounding; where none differs, momenta are spared."""
    links = articulation.links
    bodies = world.state.bodies
    for k in range(island.body_count):
        velocity = bodies[links[k].body].velocity
        size = 0.0
        difference = 0.0
        for d in range(len(velocity)):
            size += abs(velocity[d])
            difference += abs(velocity[d] - links[k].velocity[d])
        if difference > EQUAL * size:
            return True
    return False


@njit
def _set_differences(world: Any, island: Any, articulation: Any) -> Any:
    """Set ``response`` to the momenta of the bodies less those of their links; False where these are equal."""
    links = articulation.links
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    energy = 0.0
    difference = 0.0
    for k in range(island.body_count):
        link = links[k]
        parameters = body_parameters[link.body]
        velocity = bodies[link.body].velocity
        keep_momentum(link, parameters)
        for d in range(len(velocity)):
            energy += link.momentum[d] * link.velocity[d]
            link.velocity[d] = velocity[d] - link.velocity[d]
        keep_momentum(link, parameters)
        for d in range(len(velocity)):
            link.response[d] = link.momentum[d]
            difference += link.momentum[d] * link.velocity[d]
            link.velocity[d] = velocity[d] - link.velocity[d]
    return difference > ROUNDING * energy
