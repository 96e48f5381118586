"""Contact rows in a substep: their errors and biases, and their impulses from substep to substep.

The rows of a contact, their Jacobians and how these turn with the bodies are in planar/contact_rows.py and
spatial/contact_rows.py.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .detection import clear_moments
from .dispatch import by_dimension
from .rows import BOUNDED, GROUNDED, NO_CORRECTION, UNILATERAL, row_product
from .slices import part
from .turning import mark_turning, must_turn, set_turns

set_contact_rows = by_dimension("contact_rows", "set_contact_rows")
contact_span = by_dimension("contact_rows", "contact_span")
slot_of = by_dimension("contact_rows", "slot_of")
present_separation = by_dimension("contact_rows", "present_separation")
turn_contact_rows = by_dimension("contact_rows", "turn_contact_rows")
add_impulses = by_dimension("contact_rows", "add_impulses")

_INFINITY = float("inf")


@njit
def any_restitution(world: Any, island: Any) -> Any:
    """Whether a contact of the island has a restitution."""
    contacts = world.state.contacts
    island_contacts = part(world.scratch.island_contacts, island.contact_first, island.contact_count)
    for k in range(len(island_contacts)):
        if contacts[island_contacts[k]].restitution > 0.0:
            return True
    return False


@njit
def add_contact_rows(world: Any, island: Any) -> Any:
    """Write the rows of the island's contacts after those of its joints, for its first substep.

    Returns the number of all rows.
    """
    slop = world.options.slop
    rows = world.scratch.rows
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    island_contacts = part(world.scratch.island_contacts, island.contact_first, island.contact_count)
    row = island.joint_rows
    last = -1
    for k in range(len(island_contacts)):
        contact = contacts[island_contacts[k]]
        span = contact_span(contact)
        for r in range(row, row + span):
            rows[r].body_a = contact.body_a
            rows[r].body_b = contact.body_b
            rows[r].source = island_contacts[k]
            rows[r].correction = NO_CORRECTION
            rows[r].bias = 0.0
            rows[r].softness = 0.0
        normal = rows[row]
        normal.kind = BOUNDED
        normal.correction = UNILATERAL
        normal.lower = 0.0
        normal.upper = _INFINITY
        normal.flight = GROUNDED
        normal.span = span
        normal.turned = 0
        normal.error = contact.separation
        contact.start_separation = contact.separation
        normal.bias = _closing_bias(contact, contact.separation, slop, island.h)
        set_contact_rows(rows, row, contact, last, substep_bodies, island.warm_start)
        for d in range(len(contact.total_impulse)):
            contact.total_impulse[d] = 0.0
        clear_moments(contact)
        last = row
        row += span
    return row


@njit
def moved(row: Any, substep_bodies: Any) -> Any:
    """Return the change of a row's error by the displacements of this step so far, J dx."""
    return displaced(row, substep_bodies) + shifted(row, substep_bodies)


@njit
def displaced(row: Any, substep_bodies: Any) -> Any:
    """Return J times the displacements of this step so far, without those of impacts in this substep."""
    return row_product(row, substep_bodies[row.body_a].displacement, substep_bodies[row.body_b].displacement)


@njit
def shifted(row: Any, substep_bodies: Any) -> Any:
    """Return J times the displacement by which impacts of this substep shift the bodies."""
    a = substep_bodies[row.body_a]
    b = substep_bodies[row.body_b]
    return row_product(row, a.impact_displacement, b.impact_displacement)


@njit
def refresh_contact_rows(world: Any, island: Any) -> None:
    """Set errors and biases for the substep: a gap may close within it, an overlap may not grow.

    A gap within the slop counts as closed: falling through a micrometre within h would remove
    1e-6 / (g h^2) of the load of a resting contact, in every step again.
    A contact that is in flight after the impact phase gets the exact bound of the parabola,
    separation + h v - h^2/2 a >= 0, so that it slows nothing down before its impact.

    Where bodies turn, the rows of contacts on faces turn with them: they are those of the middle of the substep, so
    that J dx is the change of the separation to second order.  ``separation`` of a contact is then its value where
    all displacements of the step are 0, by the present Jacobian.
    """
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    slop = world.options.slop
    h = island.h
    any_turning = mark_turning(world, island, h)
    r = island.joint_rows
    while r < island.rows:
        first = r
        row = rows[r]
        r += int(row.span)
        contact = contacts[row.source]
        turning = any_turning and must_turn(contact, substep_bodies)
        if turning:
            set_turns(contact, bodies, substep_bodies, h)
            separation = turn_contact_rows(rows, first, contact, bodies, substep_bodies, h)
            contact.separation = separation - displaced(row, substep_bodies)
            row.turned = 1
        if not (turning and row.impulse > 0.0 and row.flight == GROUNDED):
            for i in range(first, r):
                rows[i].bias = 0.0
        error = contact.separation + moved(row, substep_bodies)
        row.error = error
        if row.flight != GROUNDED:
            row.bias = max(error - 0.5 * h * h * row.flight, 0.0) / h
            row.error = max(error, 0.0)  # a bounce within the substep may start below the surface
        else:
            row.bias += _closing_bias(contact, error, slop, h)


@njit
def _closing_bias(contact: Any, error: Any, slop: Any, h: Any) -> Any:
    """Return the bias that lets a gap close within h, m/s."""
    gap = error - slop * contact.extent
    return gap / h if gap > 0.0 else 0.0


@njit
def store_contact_impulses(world: Any, island: Any, last: Any) -> None:
    """Store the impulses of a substep for the next one, less what has stopped bodies at rest, and add up the step's.

    After the ``last`` substep, set the separations to those at the end of the step.
    """
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    scale = island.stored_scale
    any_turning = mark_turning(world, island, 0.0) if last else False
    r = island.joint_rows
    while r < island.rows:
        span = int(rows[r].span)
        contact = contacts[rows[r].source]
        for i in range(span):
            slot = slot_of(rows[r + i], contact, i)
            if scale > 0.0:
                contact.impulse[slot] = scale * rows[r + i].impulse
                if island.stopped:
                    contact.impulse[slot] -= scale * rows[r + i].direction
        add_impulses(contact, rows, r, substep_bodies, rows[r].turned != 0)
        if last:
            if any_turning and must_turn(contact, substep_bodies):
                set_turns(contact, bodies, substep_bodies, 0.0)
                contact.separation = present_separation(contact, bodies, substep_bodies)
            else:
                contact.separation += displaced(rows[r], substep_bodies)
        r += span


@njit
def start_contact_impulses(world: Any, island: Any, scale: Any) -> None:
    """Set the impulses of the contact rows to ``scale`` times the stored ones."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    r = island.joint_rows
    while r < island.rows:
        span = int(rows[r].span)
        contact = contacts[rows[r].source]
        for i in range(span):
            rows[r + i].impulse = scale * contact.impulse[slot_of(rows[r + i], contact, i)]
        r += span


@njit
def forget_contact_impulses(world: Any, island: Any) -> None:
    """Set the impulses of a solve that did not converge to 0, so that they start no other.

    Between a press and the ground no impulse is large enough; with warm starts it would grow in each step.
    """
    rows = world.scratch.rows
    contacts = world.state.contacts
    r = island.joint_rows
    while r < island.rows:
        span = int(rows[r].span)
        contact = contacts[rows[r].source]
        for i in range(span):
            contact.impulse[slot_of(rows[r + i], contact, i)] = 0.0
            rows[r + i].impulse = 0.0
        r += span
