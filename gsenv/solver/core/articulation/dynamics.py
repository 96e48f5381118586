"""Dynamics of trees of links in linear time, in spatial vectors about one point of each tree.

With A the articulated inertia of a link and s the motion of its last degree of freedom, an impulse p on the
link changes the rate by s.p / D, D = s.A s, and what its parent feels is p - A s (s.p / D), as if it had
the inertia A - A s s.A / D.  Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import LinkKind
from ..dispatch import by_dimension
from .links import move_links, set_base


@njit
def _none(inertia: Any, freedoms: Any, first: Any) -> None:
    """Do nothing: 2D has no pivots."""


@njit
def _eliminate(inertia: Any, freedoms: Any, first: Any, last: Any, more: Any) -> None:
    """Set the factor of freedoms[first : last + 1], last one first; if ``more`` follow, remove them."""
    for f in range(last, first - 1, -1):
        freedom = freedoms[f]
        motion = freedom.motion
        hold = freedom.hold
        size = freedom.stiffness + freedom.armature
        for d in range(len(motion)):
            x = 0.0
            for e in range(len(motion)):
                x += inertia[d, e] * motion[e]
            hold[d] = x
            size += x * motion[d]
        inverse = 1.0 / size if size > 0.0 else 0.0
        freedom.inverse = inverse
        freedom.root = inverse**0.5
        if not more and f == first:
            return
        for d in range(len(motion)):
            x = hold[d] * inverse
            for e in range(len(motion)):
                inertia[d, e] -= x * hold[e]


eliminate_axes = by_dimension("elimination", "eliminate_axes", otherwise=_eliminate)
eliminate_pivot = by_dimension("elimination", "eliminate_pivot", otherwise=_none)
set_moment = by_dimension("articulation", "set_moment")
set_inertia = by_dimension("articulation", "set_inertia")
add_inertia = by_dimension("articulation", "add_inertia")
set_motions = by_dimension("articulation", "set_motions")
set_force = by_dimension("articulation", "set_force")
set_applied = by_dimension("articulation", "set_applied")
reduced = by_dimension("articulation", "reduced")
moved = by_dimension("articulation", "moved")
carried = by_dimension("articulation", "carried")
no_impulse = by_dimension("articulation", "no_impulse")
force_on = by_dimension("articulation", "force_on")
response_of = by_dimension("articulation", "response_of")
set_response = by_dimension("articulation", "set_response")

_FREE = int(LinkKind.FREE)
_PIVOT = int(LinkKind.PIVOT)
FAST_TURN = 0.05  # rad in a substep


@njit
def set_middle(world: Any, island: Any, articulation: Any) -> None:
    """Set the bases of all links, and origin, inertias and motions, at their present pose, half a substep ahead."""
    links = articulation.links
    for k in range(island.body_count):
        for d in range(len(links[k].turn)):
            links[k].half[d] = links[k].turn[d]
        set_base(links[k])
    set_inertias(world, island, articulation)


@njit
def set_inertias(world: Any, island: Any, articulation: Any) -> None:
    """Set origin, inertias and motions of all links at their present pose."""
    links = articulation.links
    freedoms = articulation.freedoms
    body_parameters = world.parameters.bodies
    for k in range(island.body_count):
        link = links[k]
        root = links[link.tree]
        for d in range(len(link.center)):
            link.center[d] = link.position[d] - root.position[d]
            link.anchor[d] = link.pin[d] - root.position[d]
        set_moment(link, body_parameters[link.body])
        set_inertia(link, body_parameters[link.body], island.h)
        set_motions(link, freedoms)


@njit
def factorise_links(links: Any, count: Any, freedoms: Any) -> None:
    """Compute articulated inertias from the leaves inward, and each degree of freedom's part of the factor."""
    for k in range(count - 1, -1, -1):
        inertia = links[k].inertia
        last = links[k].first + links[k].count - 1
        if links[k].kind == _PIVOT or (links[k].kind == _FREE and links[k].count == 6):
            last -= 3
            eliminate_pivot(inertia, freedoms, last + 1)
        if last >= links[k].first:
            eliminate_axes(inertia, freedoms, links[k].first, last, links[k].parent >= 0)
        if links[k].parent >= 0:
            add_inertia(links[links[k].parent], links[k])


@njit
def respond(links: Any, count: Any, freedoms: Any, x: Any) -> Any:
    """Replace the impulses x on the degrees of freedom and ``link.force`` by the change x of the rates.

    Returns twice the kinetic energy of that change alone.
    """
    energy = respond_inward(links, count, freedoms, x)
    respond_outward(links, count, freedoms, x)
    return energy


@njit
def respond_inward(links: Any, count: Any, freedoms: Any, x: Any) -> Any:
    """Replace the impulses x and ``link.force`` by the change x of the rates without the motion of the parents.

    Returns twice the kinetic energy of the change of all rates.
    """
    energy = 0.0
    for k in range(count - 1, -1, -1):
        p = force_on(links[k])
        for f in range(links[k].first + links[k].count - 1, links[k].first - 1, -1):
            g, p = reduced(freedoms[f], x[f], p)
            x[f] = g * freedoms[f].inverse
            energy += g * x[f]
        if links[k].parent >= 0:
            outer = links[links[k].parent].force
            for d in range(len(links[k].force)):
                outer[d] += p[d]
    return energy


@njit
def respond_outward(links: Any, count: Any, freedoms: Any, x: Any) -> None:
    """Complete the change x of the rates, of which the part without the motion of the parents is given."""
    for k in range(count):
        parent = links[k].parent
        p = response_of(links[parent]) if parent >= 0 else no_impulse(links[k])
        for f in range(links[k].first, links[k].first + links[k].count):
            x[f], p = moved(freedoms[f], x[f], p)
        set_response(links[k], p)


@njit
def kinetic_energy(links: Any, count: Any, freedoms: Any, x: Any) -> Any:
    """Return twice the kinetic energy of the rates x at the pose of the factor; changes ``link.response``."""
    energy = 0.0
    for k in range(count):
        parent = links[k].parent
        p = response_of(links[parent]) if parent >= 0 else no_impulse(links[k])
        for f in range(links[k].first, links[k].first + links[k].count):
            freedom = freedoms[f]
            if freedom.inverse > 0.0:
                u, p = carried(freedom, x[f], p)
                energy += u * u / freedom.inverse
        set_response(links[k], p)
    return energy


@njit
def set_free_rates(world: Any, island: Any, articulation: Any) -> None:
    """Set ``free``, the rates at the end of the substep without rows.

    The forces that depend on the rates are those at its start, where the links move as they do now.  Whoever needs
    second order corrects them: the balance of momentum, or ``correct_forces``, for which ``contact`` keeps them.  Of
    fast links the balance may fail: for them the forces are those at the mean of old and new rates.
    """
    links = articulation.links
    freedoms = articulation.freedoms
    start = articulation.start
    free = articulation.free
    change = articulation.change
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    for i in range(island.body_count):
        body = links[i].body
        set_applied(links[i], bodies[body], body_parameters[body], gravity)
    for f in range(island.freedoms):
        change[f] = freedoms[f].pull - freedoms[f].stiffness * start[f]
    set_forces(world, island, articulation, start)
    for i in range(island.body_count):
        for d in range(len(links[i].force)):
            links[i].contact[d] = links[i].force[d]
    respond(links, island.body_count, freedoms, change)
    if island.turning > FAST_TURN:
        mean = articulation.mean
        for f in range(island.freedoms):
            mean[f] = start[f] + 0.5 * change[f]
            change[f] = freedoms[f].pull - freedoms[f].stiffness * start[f]
        move_links(island, articulation, mean)
        set_forces(world, island, articulation, mean)
        respond(links, island.body_count, freedoms, change)
    for f in range(island.freedoms):
        free[f] = start[f] + change[f]


@njit
def set_forces(world: Any, island: Any, articulation: Any, rates: Any) -> None:
    """Set ``force`` of all links, which move at these rates: the impulses of what is applied, less those of motion."""
    links = articulation.links
    body_parameters = world.parameters.bodies
    for i in range(island.body_count):
        set_force(links, i, rates, body_parameters[links[i].body].mass, island.h)
