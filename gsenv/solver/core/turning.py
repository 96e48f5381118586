"""How far bodies have turned since the start of the step, for contact rows that turn with them.

Computed once for each body in a substep, not for each of its contacts.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .dispatch import by_dimension
from .faces import NO_FACE, face_and_other
from .islands import is_kinematic
from .slices import part

path_of_turn = by_dimension("rotation", "path_of_turn")
set_turn = by_dimension("rotation", "set_turn")
clear_turn = by_dimension("rotation", "clear_turn")
fixed_arm = by_dimension("contact_rows", "fixed_arm")

LEAST_TURN = 1e-4  # rad in a step, from which on contact rows turn with the bodies
CENTRED = 1e-6  # of a shape's radius: a ball whose centre is this near to that of its body looks the same at any turn


@njit
def mark_turning(world: Any, island: Any, h: Any) -> Any:
    """Set which bodies turn so far, from the start of the step to ``h`` from now, that contact rows follow.

    Returns whether any does.  How far is set where a contact asks: ``set_turns``.
    """
    bodies = world.state.bodies
    body_models = world.model.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    any_turning = False
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        any_turning |= _mark(bodies[i], substep_bodies[i], h)
    if island.kinematic:
        for i in range(len(bodies)):
            if is_kinematic(body_models[i], body_parameters[i]):
                any_turning |= _mark(bodies[i], substep_bodies[i], h)
    return any_turning


@njit
def set_turns(contact: Any, bodies: Any, substep_bodies: Any, h: Any) -> None:
    """Set the rotations of a contact's two bodies since the start of the step, now and ``h`` / 2 from now."""
    for side in range(2):
        i = contact.body_a if side == 0 else contact.body_b
        substep_body = substep_bodies[i]
        if substep_body.turn_known == 0:
            set_turn(bodies[i], substep_body, h)
            substep_body.turn_known = 1


@njit
def must_turn(contact: Any, substep_bodies: Any) -> Any:
    """Whether the rows of a contact must follow the rotation of its bodies."""
    if contact.face == NO_FACE:
        return False
    one, other = face_and_other(contact)
    if substep_bodies[one].turning:
        return True
    if not substep_bodies[other].turning:
        return False
    return substep_bodies[one].inverse[0] > 0.0 or not _is_centred(contact, substep_bodies[other])


@njit
def forget_turn(substep_body: Any) -> None:
    """Set that a body has not turned."""
    substep_body.turning = 0
    substep_body.turn_known = 1
    clear_turn(substep_body)


@njit
def _mark(body: Any, substep_body: Any, h: Any) -> Any:
    substep_body.turning = 1 if path_of_turn(body, substep_body, h) > LEAST_TURN else 0
    substep_body.turn_known = 0
    return substep_body.turning != 0


@njit
def _is_centred(contact: Any, substep_body: Any) -> Any:
    """Whether the point that is fixed on the body without the face is its centre, as that of a ball or a wheel."""
    arm = fixed_arm(contact, substep_body)
    square = 0.0
    for d in range(len(arm)):
        square += arm[d] ** 2
    return square <= (CENTRED * contact.core_distance) ** 2
