"""Rows of a contact: the normal row, then the friction row, coupled in the same sweep."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import BOUNDED, FRICTION, GROUNDED, HELD_APART, UNHELD

_INFINITY = float("inf")


@njit
def set_point_row(
    row: Any, bodies: Any, body_a: Any, body_b: Any, px: Any, py: Any, ux: Any, uy: Any
) -> None:
    """J v = (velocity of b's point - velocity of a's point) . u, both points at (px, py)."""
    row.body_a = body_a
    row.body_b = body_b
    a = bodies[body_a]
    b = bodies[body_b]
    ja = -((px - a.position[0]) * uy - (py - a.position[1]) * ux)
    jb = (px - b.position[0]) * uy - (py - b.position[1]) * ux
    row.jacobian_a[0] = -ux
    row.jacobian_a[1] = -uy
    row.jacobian_a[2] = ja
    row.jacobian_b[0] = ux
    row.jacobian_b[1] = uy
    row.jacobian_b[2] = jb


@njit
def set_effective_mass(row: Any, body_parameters: Any) -> None:
    """From jacobian, softness and the masses of the bodies."""
    a = body_parameters[row.body_a]
    b = body_parameters[row.body_b]
    d = row.softness
    for i in range(len(row.jacobian_a)):
        inverse_a = a.inv_mass if i < 2 else a.inv_inertia
        inverse_b = b.inv_mass if i < 2 else b.inv_inertia
        d += row.jacobian_a[i] * (inverse_a * row.jacobian_a[i]) + row.jacobian_b[i] * (inverse_b * row.jacobian_b[i])
    row.diagonal = d
    row.effective_mass = 1.0 / d if d > 0.0 else 0.0


@njit
def add_contact_rows(
    rows: Any, row: Any, contacts: Any, indices: Any, bodies: Any, body_parameters: Any, scale: Any
) -> Any:
    """One or two rows a contact from ``rows[row]`` on; they keep their Jacobians for the step.

    ``scale``: what the stored impulses are multiplied with, 0 for a cold start.
    """
    for k in range(len(indices)):
        contact = contacts[indices[k]]
        a = contact.body_a
        b = contact.body_b
        px = contact.point[0]
        py = contact.point[1]
        nx = contact.normal[0]
        ny = contact.normal[1]
        span = 2 if contact.friction > 0.0 else 1
        normal = rows[row]
        set_point_row(normal, bodies, a, b, px, py, nx, ny)
        normal.kind = BOUNDED
        normal.hold = HELD_APART
        normal.lower = 0.0
        normal.upper = _INFINITY
        normal.flight = GROUNDED
        normal.span = span
        if span == 2:
            tangent = rows[row + 1]
            set_point_row(tangent, bodies, a, b, px, py, -ny, nx)
            tangent.kind = FRICTION
            tangent.base = 1
            tangent.hold = UNHELD
            tangent.friction = contact.friction
        for r in range(span):
            rows[row + r].source = indices[k]
            rows[row + r].bias = 0.0
            rows[row + r].softness = 0.0
            rows[row + r].impulse = scale * contact.impulse[r]
            set_effective_mass(rows[row + r], body_parameters)
        contact.total_impulse[0] = 0.0
        contact.total_impulse[1] = 0.0
        row += span
    return row


@njit
def moved(row: Any, motions: Any) -> Any:
    """Change of a row's error by the displacements of this step so far, J dx."""
    s = 0.0
    a = motions[row.body_a]
    b = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * (a.displacement[i] + a.shift[i])
        s += row.jacobian_b[i] * (b.displacement[i] + b.shift[i])
    return s


@njit
def refresh_contact_rows(rows: Any, first: Any, end: Any, contacts: Any, motions: Any, options: Any, h: Any) -> None:
    """Errors and biases for the substep: a gap may close within it, an overlap may not grow.

    A gap within the slop counts as closed: falling through a micrometre within h would take
    1e-6 / (g h^2) of the load off a resting contact, in every step anew.
    A contact that the impact phase left flying gets the exact bound for the parabola,
    separation + h v - h^2/2 a >= 0, so that it slows nothing down before its impact.
    """
    r = first
    while r < end:
        row = rows[r]
        r += int(row.span)
        error = contacts[row.source].separation + moved(row, motions)
        row.error = error
        if row.flight != GROUNDED:
            row.bias = max(error - 0.5 * h * h * row.flight, 0.0) / h
            row.error = max(error, 0.0)  # a bounce inside the substep starts from below
        else:
            gap = error - options.slop * contacts[row.source].extent
            row.bias = gap / h if gap > 0.0 else 0.0


@njit
def store_contacts(
    rows: Any, first: Any, end: Any, contacts: Any, motions: Any, scale: Any, last: Any
) -> None:
    """Impulses of a substep: ``scale`` times them start the next step; the sum of the step grows.

    After the ``last`` one separations become those at the end of the step.
    """
    r = first
    while r < end:
        span = int(rows[r].span)
        contact = contacts[rows[r].source]
        for i in range(span):
            contact.impulse[i] = scale * rows[r + i].impulse
            contact.total_impulse[i] += rows[r + i].impulse
        if last:
            contact.separation += moved(rows[r], motions)
        r += span


@njit
def forget_impulses(rows: Any, first: Any, end: Any, contacts: Any) -> None:
    """No warm start from a solve that did not end.

    Between a press and the ground no impulse is enough; carried on, it would grow in each step.
    """
    r = first
    while r < end:
        span = int(rows[r].span)
        for i in range(span):
            contacts[rows[r].source].impulse[i] = 0.0
            rows[r + i].impulse = 0.0
        r += span
