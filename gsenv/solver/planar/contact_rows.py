"""Rows of a 2D contact: the normal row, then the friction row, coupled in the same sweep."""

from __future__ import annotations

from typing import Any

from ..core.rows import FRICTION
from ..jit import njit


@njit
def contact_span(contact: Any) -> Any:
    """Return the number of rows of a contact: the normal row, and a tangent row where there is friction."""
    return 2 if contact.friction > 0.0 else 1


@njit
def set_contact_rows(rows: Any, row: Any, contact: Any, last: Any, substep_bodies: Any, scale: Any) -> None:
    """Set Jacobians and friction of a contact's rows, and ``scale`` times the stored impulses.

    The Jacobians are constant in the step. ``last``: first row of the contact before it, or -1.
    """
    nx = contact.normal[0]
    ny = contact.normal[1]
    _set_point_row(rows[row], contact, substep_bodies, nx, ny)
    if contact.friction > 0.0:
        tangent = rows[row + 1]
        _set_point_row(tangent, contact, substep_bodies, -ny, nx)
        tangent.kind = FRICTION
        tangent.base = 1
        tangent.friction = contact.friction
    for r in range(contact_span(contact)):
        rows[row + r].impulse = scale * contact.impulse[r]
        set_effective_mass(rows[row + r], substep_bodies)


@njit
def _set_point_row(row: Any, contact: Any, substep_bodies: Any, ux: Any, uy: Any) -> None:
    """Set the Jacobian of J v = (velocity of b's point - velocity of a's point) . u at the contact's point."""
    px = contact.point[0]
    py = contact.point[1]
    a = substep_bodies[row.body_a].start_position
    b = substep_bodies[row.body_b].start_position
    row.jacobian_a[0] = -ux
    row.jacobian_a[1] = -uy
    row.jacobian_a[2] = -((px - a[0]) * uy - (py - a[1]) * ux)
    row.jacobian_b[0] = ux
    row.jacobian_b[1] = uy
    row.jacobian_b[2] = (px - b[0]) * uy - (py - b[1]) * ux


@njit
def set_effective_mass(row: Any, substep_bodies: Any) -> None:
    """Set diagonal and effective mass from Jacobian, softness and the masses of the bodies."""
    a = substep_bodies[row.body_a].inverse
    b = substep_bodies[row.body_b].inverse
    d = row.softness
    for i in range(len(row.jacobian_a)):
        d += row.jacobian_a[i] * (a[i] * row.jacobian_a[i]) + row.jacobian_b[i] * (b[i] * row.jacobian_b[i])
    row.diagonal = d
    row.effective_mass = 1.0 / d if d > 0.0 else 0.0


@njit
def slot_of(row: Any, contact: Any, place: Any) -> Any:
    """Return the index, among the contact's impulses, of row number ``place`` of its rows."""
    return place


@njit
def add_total(contact: Any, other: Any) -> None:
    """Add the summed impulse of another contact of the same bodies, along the contact's own directions."""
    n, m = contact.normal, other.normal
    cosine = n[0] * m[0] + n[1] * m[1]
    sine = n[0] * m[1] - n[1] * m[0]
    push, drag = other.total_impulse[0], other.total_impulse[1]
    contact.total_impulse[0] += cosine * push - sine * drag
    contact.total_impulse[1] += sine * push + cosine * drag
