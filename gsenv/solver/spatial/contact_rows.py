"""Rows of a contact: normal, the two tangents of the friction disc, and what resists turning, if asked for."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import BOUNDED, DISC, DISC_END, FRICTION, GROUNDED, HELD_APART, UNHELD
from .frames import in_frame
from .math import Vec, cross, sub, tangents, vec

_INFINITY = float("inf")


@njit
def contact_span(contact: Any) -> Any:
    """How many rows a contact has."""
    span = 1
    if contact.friction > 0.0:
        span += 2
    if contact.torsional_friction > 0.0:
        span += 1
    if contact.rolling_friction > 0.0:
        span += 2
    return span


@njit
def set_jacobian(row: Any, motions: Any, u: Vec, turn_a: Vec, turn_b: Vec) -> None:
    """J v = u . (v_b - v_a) + turn_a . w_a + turn_b . w_b, directions in the world."""
    a = in_frame(motions[row.body_a], turn_a)
    b = in_frame(motions[row.body_b], turn_b)
    for d in range(3):
        row.jacobian_a[d] = -u[d]
        row.jacobian_b[d] = u[d]
        row.jacobian_a[3 + d] = a[d]
        row.jacobian_b[3 + d] = b[d]


@njit
def set_effective_mass(row: Any, motions: Any) -> None:
    """From jacobian, softness and the masses of the bodies."""
    d = row.softness + coupling_of(row, row, motions)
    row.diagonal = d
    row.effective_mass = 1.0 / d if d > 0.0 else 0.0


@njit
def coupling_of(row: Any, other: Any, motions: Any) -> Any:
    """J M^-1 J'^T of two rows on the same bodies."""
    a = motions[row.body_a].inverse
    b = motions[row.body_b].inverse
    s = 0.0
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * (a[i] * other.jacobian_a[i]) + row.jacobian_b[i] * (b[i] * other.jacobian_b[i])
    return s


@njit
def set_contact_jacobians(rows: Any, row: Any, contact: Any, motions: Any) -> None:
    """Directions and masses of a contact's rows, in the frames that its bodies have now."""
    point = vec(contact.point)
    n = vec(contact.normal)
    t, s = tangents(n)
    zero = (0.0, 0.0, 0.0)
    arm_a = sub(point, vec(motions[contact.body_a].start_position))
    arm_b = sub(point, vec(motions[contact.body_b].start_position))
    _set_point(rows[row], motions, n, arm_a, arm_b)
    k = row + 1
    if contact.friction > 0.0:
        _set_point(rows[k], motions, t, arm_a, arm_b)
        _set_point(rows[k + 1], motions, s, arm_a, arm_b)
        k += 2
    if contact.torsional_friction > 0.0:
        set_jacobian(rows[k], motions, zero, (-n[0], -n[1], -n[2]), n)
        k += 1
    if contact.rolling_friction > 0.0:
        set_jacobian(rows[k], motions, zero, (-t[0], -t[1], -t[2]), t)
        set_jacobian(rows[k + 1], motions, zero, (-s[0], -s[1], -s[2]), s)
        k += 2
    for r in range(row, k):
        set_effective_mass(rows[r], motions)
        if rows[r].kind == DISC:
            rows[r].coupling = coupling_of(rows[r], rows[r + 1], motions)


@njit
def _set_point(row: Any, motions: Any, u: Vec, arm_a: Vec, arm_b: Vec) -> None:
    a = cross(arm_a, u)
    set_jacobian(row, motions, u, (-a[0], -a[1], -a[2]), cross(arm_b, u))


@njit
def add_contact_rows(rows: Any, row: Any, contacts: Any, indices: Any, motions: Any, scale: Any) -> Any:
    """One to six rows a contact from ``rows[row]`` on.

    ``scale``: what the stored impulses are multiplied with, 0 for a cold start.
    """
    for k in range(len(indices)):
        contact = contacts[indices[k]]
        normal = rows[row]
        span = contact_span(contact)
        for r in range(span):
            made = rows[row + r]
            made.body_a = contact.body_a
            made.body_b = contact.body_b
            made.source = indices[k]
            made.bias = 0.0
            made.softness = 0.0
            made.hold = UNHELD
        normal.kind = BOUNDED
        normal.hold = HELD_APART
        normal.lower = 0.0
        normal.upper = _INFINITY
        normal.flight = GROUNDED
        normal.span = span
        normal.impulse = scale * contact.impulse[0]
        place = 1
        if contact.friction > 0.0:
            _set_disc(rows, row, place, contact.friction, scale, contact.impulse, 1)
            place += 2
        if contact.torsional_friction > 0.0:
            rows[row + place].kind = FRICTION
            rows[row + place].base = place
            rows[row + place].friction = contact.torsional_friction
            rows[row + place].impulse = scale * contact.impulse[3]
            place += 1
        if contact.rolling_friction > 0.0:
            _set_disc(rows, row, place, contact.rolling_friction, scale, contact.impulse, 4)
        set_contact_jacobians(rows, row, contact, motions)
        for d in range(len(contact.total_impulse)):
            contact.total_impulse[d] = 0.0
        row += span
    return row


@njit
def _set_disc(rows: Any, row: Any, place: Any, friction: Any, scale: Any, impulse: Any, slot: Any) -> None:
    for k in range(2):
        made = rows[row + place + k]
        made.kind = DISC if k == 0 else DISC_END
        made.base = place + k
        made.friction = friction
        made.impulse = scale * impulse[slot + k]


@njit
def turn_contact_rows(rows: Any, first: Any, end: Any, contacts: Any, motions: Any) -> None:
    """Frames have turned: the same directions in the new ones."""
    r = first
    while r < end:
        set_contact_jacobians(rows, r, contacts[rows[r].source], motions)
        r += int(rows[r].span)


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
    """Errors and biases for the substep; see planar/contact_rows.py."""
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
def slot_of(row: Any, contact: Any, place: Any) -> Any:
    """Which of the contact's impulses row ``place`` of its rows has."""
    if place == 0:
        return 0
    if contact.friction > 0.0 and place < 3:
        return place
    if row.kind == FRICTION:
        return 3
    return 4 if row.kind == DISC else 5


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
            slot = slot_of(rows[r + i], contact, i)
            contact.impulse[slot] = scale * rows[r + i].impulse
            contact.total_impulse[slot] += rows[r + i].impulse
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
        contact = contacts[rows[r].source]
        for i in range(span):
            contact.impulse[slot_of(rows[r + i], contact, i)] = 0.0
            rows[r + i].impulse = 0.0
        r += span
