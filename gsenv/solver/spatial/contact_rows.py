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
def set_jacobian(row: Any, a: Any, b: Any, u: Vec, turn_a: Vec, turn_b: Vec) -> Any:
    """Set the Jacobian of J v = u . (v_b - v_a) + turn_a . w_a + turn_b . w_b, directions in the world.

    ``a``, ``b``: the two substep bodies. Returns the turns in their frames.
    """
    x = in_frame(a, turn_a)
    y = in_frame(b, turn_b)
    for d in range(3):
        row.jacobian_a[d] = -u[d]
        row.jacobian_b[d] = u[d]
        row.jacobian_a[3 + d] = x[d]
        row.jacobian_b[3 + d] = y[d]
    return x, y


@njit
def set_effective_mass(row: Any, substep_bodies: Any) -> None:
    """Set diagonal and effective mass from Jacobian, softness and the masses of the bodies."""
    a = substep_bodies[row.body_a].inverse
    b = substep_bodies[row.body_b].inverse
    j = row.jacobian_a
    k = row.jacobian_b
    d = row.softness
    for i in range(6):
        d += j[i] * (a[i] * j[i]) + k[i] * (b[i] * k[i])
    _set_diagonal(row, d)


@njit
def _set_diagonal(row: Any, d: Any) -> None:
    row.diagonal = d
    row.effective_mass = 1.0 / d if d > 0.0 else 0.0


@njit
def set_contact_jacobians(rows: Any, row: Any, contact: Any, last: Any, substep_bodies: Any) -> None:
    """Set Jacobians and effective masses of a contact's rows, in the present frames of its bodies.

    ``last``: first row of the contact before it, or -1.
    """
    a = substep_bodies[contact.body_a]
    b = substep_bodies[contact.body_b]
    point = vec(contact.point)
    n = vec(contact.normal)
    t, s = _tangents(rows, last, n)
    arm_a = sub(point, vec(a.start_position))
    arm_b = sub(point, vec(b.start_position))
    zero = (0.0, 0.0, 0.0)
    _set_row(rows[row], a, b, n, cross(n, arm_a), cross(arm_b, n))
    k = row + 1
    if contact.friction > 0.0:
        _set_row(rows[k], a, b, t, cross(t, arm_a), cross(arm_b, t))
        _set_row(rows[k + 1], a, b, s, cross(s, arm_a), cross(arm_b, s))
        _set_coupling(rows[k], rows[k + 1], a.inverse, b.inverse)
        k += 2
    if contact.torsional_friction > 0.0:
        _set_row(rows[k], a, b, zero, (-n[0], -n[1], -n[2]), n)
        k += 1
    if contact.rolling_friction > 0.0:
        _set_row(rows[k], a, b, zero, (-t[0], -t[1], -t[2]), t)
        _set_row(rows[k + 1], a, b, zero, (-s[0], -s[1], -s[2]), s)
        _set_coupling(rows[k], rows[k + 1], a.inverse, b.inverse)


@njit
def _set_row(row: Any, a: Any, b: Any, u: Vec, turn_a: Vec, turn_b: Vec) -> None:
    """Set the Jacobian of a contact's row, whose ``u`` is a unit vector or zero, and its effective mass."""
    x, y = set_jacobian(row, a, b, u, turn_a, turn_b)
    moves = (a.inverse[0] + b.inverse[0]) * dot(u, u)
    turns = _dot_over(x, a.inverse) + _dot_over(y, b.inverse)
    _set_diagonal(row, row.softness + moves + turns)


@njit
def _dot_over(x: Vec, m: Any) -> Any:
    return x[0] * (m[3] * x[0]) + x[1] * (m[4] * x[1]) + x[2] * (m[5] * x[2])


@njit
def _set_coupling(one: Any, two: Any, inverse_a: Any, inverse_b: Any) -> None:
    """Set J_1 M^-1 J_2^T of the two rows of a disc, to which their linear parts, perpendicular or 0, add nothing."""
    c = 0.0
    for d in range(3, 6):
        c += one.jacobian_a[d] * (inverse_a[d] * two.jacobian_a[d])
        c += one.jacobian_b[d] * (inverse_b[d] * two.jacobian_b[d])
    one.coupling = c


@njit
def _tangents(rows: Any, last: Any, n: Vec) -> Any:
    """Return the tangents to a normal.

    Contacts of the same two boxes have one normal: to look the tangents up saves a root and a division for each.
    """
    if last >= 0:
        if rows[last].span > 2 and rows[last + 1].kind == DISC and n == vec(rows[last].jacobian_b):
            return vec(rows[last + 1].jacobian_b), vec(rows[last + 2].jacobian_b)
    return tangents(n)


@njit
def set_contact_rows(rows: Any, row: Any, contact: Any, last: Any, substep_bodies: Any, scale: Any) -> None:
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
    set_contact_jacobians(rows, row, contact, last, substep_bodies)


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
    last = -1
    while r < island.rows:
        set_contact_jacobians(rows, r, contacts[rows[r].source], last, substep_bodies)
        last = r
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
