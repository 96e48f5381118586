"""Rows of a 3D contact: normal, two tangents of the friction disc, torsional and rolling friction where given."""

from __future__ import annotations

from typing import Any

from ..core.rows import DISC, DISC_END, FRICTION
from ..jit import njit
from .math import Vec, along, cross, dot, scaled, sub, tangents, vec
from .rotation import in_frame


@njit
def contact_span(contact: Any) -> Any:
    """Return the number of rows of a contact."""
    span = 1
    if contact.friction > 0.0:
        span += 2
    if contact.torsional_friction > 0.0:
        span += 1
    if contact.rolling_friction > 0.0:
        span += 2
    return span


@njit
def set_jacobian(row: Any, substep_bodies: Any, u: Vec, turn_a: Vec, turn_b: Vec) -> None:
    """Set the Jacobian of J v = u . (v_b - v_a) + turn_a . w_a + turn_b . w_b, directions in the world."""
    a = in_frame(substep_bodies[row.body_a], turn_a)
    b = in_frame(substep_bodies[row.body_b], turn_b)
    for d in range(3):
        row.jacobian_a[d] = -u[d]
        row.jacobian_b[d] = u[d]
        row.jacobian_a[3 + d] = a[d]
        row.jacobian_b[3 + d] = b[d]


@njit
def set_effective_mass(row: Any, substep_bodies: Any) -> None:
    """Set diagonal and effective mass from Jacobian, softness and the masses of the bodies."""
    d = row.softness + coupling_of(row, row, substep_bodies)
    row.diagonal = d
    row.effective_mass = 1.0 / d if d > 0.0 else 0.0


@njit
def coupling_of(row: Any, other: Any, substep_bodies: Any) -> Any:
    """Return J M^-1 J'^T of two rows on the same bodies."""
    a = substep_bodies[row.body_a].inverse
    b = substep_bodies[row.body_b].inverse
    s = 0.0
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * (a[i] * other.jacobian_a[i]) + row.jacobian_b[i] * (b[i] * other.jacobian_b[i])
    return s


@njit
def set_contact_jacobians(rows: Any, row: Any, contact: Any, substep_bodies: Any) -> None:
    """Set Jacobians and effective masses of a contact's rows, in the present frames of its bodies."""
    point = vec(contact.point)
    n = vec(contact.normal)
    t, s = tangents(n)
    zero = (0.0, 0.0, 0.0)
    arm_a = sub(point, vec(substep_bodies[contact.body_a].start_position))
    arm_b = sub(point, vec(substep_bodies[contact.body_b].start_position))
    _set_point(rows[row], substep_bodies, n, arm_a, arm_b)
    k = row + 1
    if contact.friction > 0.0:
        _set_point(rows[k], substep_bodies, t, arm_a, arm_b)
        _set_point(rows[k + 1], substep_bodies, s, arm_a, arm_b)
        k += 2
    if contact.torsional_friction > 0.0:
        set_jacobian(rows[k], substep_bodies, zero, (-n[0], -n[1], -n[2]), n)
        k += 1
    if contact.rolling_friction > 0.0:
        set_jacobian(rows[k], substep_bodies, zero, (-t[0], -t[1], -t[2]), t)
        set_jacobian(rows[k + 1], substep_bodies, zero, (-s[0], -s[1], -s[2]), s)
        k += 2
    for r in range(row, k):
        set_effective_mass(rows[r], substep_bodies)
        if rows[r].kind == DISC:
            rows[r].coupling = coupling_of(rows[r], rows[r + 1], substep_bodies)


@njit
def _set_point(row: Any, substep_bodies: Any, u: Vec, arm_a: Vec, arm_b: Vec) -> None:
    a = cross(arm_a, u)
    set_jacobian(row, substep_bodies, u, (-a[0], -a[1], -a[2]), cross(arm_b, u))


@njit
def set_contact_rows(rows: Any, row: Any, contact: Any, bodies: Any, substep_bodies: Any, scale: Any) -> None:
    """Set Jacobians and frictions of a contact's rows, and ``scale`` times the stored impulses."""
    rows[row].impulse = scale * contact.impulse[0]
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
    set_contact_jacobians(rows, row, contact, substep_bodies)


@njit
def _set_disc(rows: Any, row: Any, place: Any, friction: Any, scale: Any, impulse: Any, slot: Any) -> None:
    for k in range(2):
        made = rows[row + place + k]
        made.kind = DISC if k == 0 else DISC_END
        made.base = place + k
        made.friction = friction
        made.impulse = scale * impulse[slot + k]


@njit
def rotate_contact_rows(world: Any, island: Any) -> None:
    """Rotate the Jacobians of the contact rows to the present frames of the bodies."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    r = island.joint_rows
    while r < island.rows:
        set_contact_jacobians(rows, r, contacts[rows[r].source], substep_bodies)
        r += int(rows[r].span)


@njit
def slot_of(row: Any, contact: Any, place: Any) -> Any:
    """Return the index, among the contact's impulses, of row number ``place`` of its rows."""
    if place == 0:
        return 0
    if contact.friction > 0.0 and place < 3:
        return place
    if row.kind == FRICTION:
        return 3
    return 4 if row.kind == DISC else 5


@njit
def add_total(contact: Any, other: Any) -> None:
    """Add the summed impulse of another contact of the same bodies, along the contact's own directions."""
    m = vec(other.normal)
    u, v = tangents(m)
    n = vec(contact.normal)
    t, s = tangents(n)
    p = other.total_impulse
    total = contact.total_impulse
    for first in (0, 3):  # the impulse, then that of torsional and rolling friction
        whole = along(along(scaled(m, p[first]), p[first + 1], u), p[first + 2], v)
        total[first] += dot(n, whole)
        total[first + 1] += dot(t, whole)
        total[first + 2] += dot(s, whole)
