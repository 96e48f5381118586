"""Contacts of bodies at rest: they are taken from the last step, without the narrowphase.

After a step the separation of each contact is that of the new poses, to first order in the motion.  So a pair at rest
keeps its contacts until its bodies have moved by a small part of their size since the narrowphase found them.  Catto
("Solver2D", 2024, and Box2D v3) and Bullet keep manifolds in a similar way.  Shapes with a rounding radius (balls,
capsules, cylinders) are searched in each step: a contact that stays behind a rolling ball would push it.
"""

from __future__ import annotations

from typing import Any

from numba import int64
from numpy.typing import NDArray

from ..jit import njit

Array = NDArray[Any]

FARTHEST = 1e-4  # of the extent: motion of both bodies together after which the narrowphase looks again


@njit
def form_of(parameter: Any) -> float:
    """Return a number that changes with size and place of a shape on its body, which may be set between steps."""
    code = parameter.radius
    weight = 1.0
    for d in range(len(parameter.size)):
        weight *= 1.6180339887
        code += weight * parameter.size[d]
        weight *= 1.3247179572
        code += weight * parameter.local_position[d]
    for d in range(len(parameter.local_rotation)):
        weight *= 1.2207440846
        code += weight * parameter.local_rotation[d]
    return code


@njit
def pair_form(geometry: Any, a: int, b: int) -> Any:
    """Return the number that tells whether the shapes of a pair have changed."""
    return geometry[a].form + 1.1892071150 * geometry[b].form


@njit
def recycle_pair(world: Any, a: int, b: int, known: int, count: int) -> tuple[int, int]:
    """Copy the contacts of shapes a and b in the last step to `world.scratch.found`, from entry `count` on.

    `known`: index of a contact of the last step, before or at the first one of the pair.  Returns (index of the first
    contact after the pair, the new count); the count is the old one where the narrowphase has to search the pair.
    """
    contacts = world.state.contacts
    bodies = world.state.bodies
    geometry = world.scratch.geometry
    found = world.scratch.found
    total = int64(world.state.world.contact_count)
    first = known
    while first < total and is_before(contacts[first], a, b):
        first += 1
    last = first
    form = pair_form(geometry, a, b)
    same = True
    while last < total and contacts[last].shape_a == a and contacts[last].shape_b == b:
        contact = contacts[last]
        path = bodies[contact.body_a].travel + bodies[contact.body_b].travel - contact.travel
        same = same and contact.sensor == 0 and contact.form == form and 0.0 <= path <= FARTHEST * contact.extent
        last += 1
    if same:
        for k in range(first, last):
            if count < len(found):
                found[count] = contacts[k]
            count += 1
    return last, count


@njit
def is_before(contact: Any, a: int, b: int) -> bool:
    """Whether a contact's pair is before shapes a and b."""
    return contact.shape_a < a or (contact.shape_a == a and contact.shape_b < b)
