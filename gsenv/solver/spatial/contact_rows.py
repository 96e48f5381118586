"""Rows of a 3D contact: normal, two tangents of the friction disc, torsional and rolling friction where given."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..core.faces import FACE_OF_A, face_and_other
from ..core.rows import DISC, DISC_END, FRICTION
from ..core.turning import mark_turning, must_turn
from ..jit import njit
from .math import (
    Quaternion,
    Vec,
    add,
    along,
    cross,
    dot,
    quaternion,
    scaled,
    sub,
    tangents,
    turned,
    vec,
)
from .rotation import in_frame, in_world, spin_of


class Arms(NamedTuple):
    """Where a contact acts: arms of its point on both bodies in m, normal and tangents."""

    arm_a: Vec
    arm_b: Vec
    n: Vec
    t: Vec
    s: Vec


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
    point = vec(contact.point)
    n = vec(contact.normal)
    t, s = _tangents(rows, last, n)
    arm_a = sub(point, vec(substep_bodies[contact.body_a].start_position))
    arm_b = sub(point, vec(substep_bodies[contact.body_b].start_position))
    _set_jacobians(rows, row, contact, Arms(arm_a, arm_b, n, t, s), substep_bodies)


@njit
def _set_jacobians(rows: Any, row: Any, contact: Any, arms: Arms, substep_bodies: Any) -> None:
    a = substep_bodies[contact.body_a]
    b = substep_bodies[contact.body_b]
    arm_a, arm_b, n, t, s = arms
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
def turn_contact_rows(rows: Any, row: Any, contact: Any, bodies: Any, substep_bodies: Any, h: Any) -> Any:
    """Set Jacobians and effective masses of a contact's rows for the poses that its bodies have ``h`` / 2 from now.

    ``bias`` becomes the change of J v until then: with it J v is 0 at the end of the substep, and on its mean.
    Returns the present separation, m.
    """
    one, other = face_and_other(contact)
    face, body = substep_bodies[one], substep_bodies[other]
    core = fixed_arm(contact, body)
    directions = _directions(contact)
    way = _way(bodies[one], bodies[other], 0.0)
    arm = turned(quaternion(body.turn), core)
    now = _arms_of(contact, directions, quaternion(face.turn), arm, way)
    separation = _separation(contact, now.n, arm, way, face)
    way = _way(bodies[one], bodies[other], 0.5 * h)
    arm = turned(quaternion(body.mid_turn), core)
    middle = _arms_of(contact, directions, quaternion(face.mid_turn), arm, way)
    _set_jacobians(rows, row, contact, middle, substep_bodies)
    for k in range(contact_span(contact)):
        rows[row + k].bias = 0.0
    a, b = contact.body_a, contact.body_b
    rates = _rates(bodies[a], bodies[b], substep_bodies[a], substep_bodies[b], now)
    later = _rates(bodies[a], bodies[b], substep_bodies[a], substep_bodies[b], middle)
    for k in range(3 if contact.friction > 0.0 else 1):
        rows[row + k].bias = later[k] - rates[k]
    return separation


@njit
def _directions(contact: Any) -> tuple[Vec, Vec, Vec]:
    """Return normal and tangents of a contact at the start of the step."""
    n = vec(contact.normal)
    t, s = tangents(n)
    return n, t, s


@njit
def _arms_of(contact: Any, directions: tuple[Vec, Vec, Vec], turn: Quaternion, core: Vec, way: Vec) -> Arms:
    """Return the arms of a contact after the ``turn`` of the face; ``core``: m, arm of the shape without it.

    ``way``: m, from the centre of mass of the body with the face to that of the other.
    """
    n, t, s = directions
    n, t, s = turned(turn, n), turned(turn, t), turned(turn, s)
    of_a = contact.face == FACE_OF_A
    arm = along(core, -contact.core_distance if of_a else contact.core_distance, n)
    far = add(arm, way)
    return Arms(far, arm, n, t, s) if of_a else Arms(arm, far, n, t, s)


@njit
def _rates(a: Any, b: Any, of_a: Any, of_b: Any, arms: Arms) -> Vec:
    """Return the relative velocity of b's point along normal and tangents; ``of_a``, ``of_b``: the substep bodies."""
    u = sub(vec(b.velocity), vec(a.velocity))
    u = add(u, cross(_spin(b, of_b), arms.arm_b))
    u = sub(u, cross(_spin(a, of_a), arms.arm_a))
    return dot(u, arms.n), dot(u, arms.t), dot(u, arms.s)


@njit
def _spin(body: Any, substep_body: Any) -> Vec:
    """Return the angular velocity of a body in the world, rad/s; within a substep it may be in the body's frame."""
    spin = spin_of(body.velocity)
    return in_world(substep_body, spin) if substep_body.rotated_frame else spin


@njit
def present_separation(contact: Any, bodies: Any, substep_bodies: Any) -> Any:
    """Return the separation of a contact in the present poses, m.

    The normal turns with the body that has the face, the point with the other one.
    """
    one, other = face_and_other(contact)
    face, body = substep_bodies[one], substep_bodies[other]
    arm = turned(quaternion(body.turn), fixed_arm(contact, body))
    n = turned(quaternion(face.turn), vec(contact.normal))
    return _separation(contact, n, arm, _way(bodies[one], bodies[other], 0.0), face)


@njit
def _separation(contact: Any, n: Vec, arm: Vec, way: Vec, face: Any) -> Any:
    """Return the separation of a contact, m.

    Args:
        contact: record.
        n: its present normal.
        arm: m, of what is fixed on the shape without the face, now.
        way: m, from the centre of mass of the body with the face to that of the other.
        face: substep body with the face.
    """
    sign = 1.0 if contact.face == FACE_OF_A else -1.0
    before = dot(vec(contact.normal), sub(vec(contact.point), vec(face.start_position)))
    return contact.start_separation + sign * (dot(n, add(arm, way)) - before) - contact.core_distance


@njit
def fixed_arm(contact: Any, substep_body: Any) -> Vec:
    """Return the arm, at the start of the step, of the point that is fixed on the body without the face, m."""
    inwards = contact.core_distance if contact.face == FACE_OF_A else -contact.core_distance
    return sub(along(vec(contact.point), inwards, vec(contact.normal)), vec(substep_body.start_position))


@njit
def _way(one: Any, other: Any, time: Any) -> Vec:
    """Return the way from one centre of mass to the other, ``time`` s from now, m."""
    x = along(vec(other.position), time, vec(other.velocity))
    return sub(x, along(vec(one.position), time, vec(one.velocity)))


@njit
def add_impulses(contact: Any, rows: Any, row: Any, substep_bodies: Any, turning: Any) -> None:
    """Add the impulses of a substep to those of the step; ``turning``: whether its rows may have turned."""
    span = contact_span(contact)
    total = contact.total_impulse
    if not turning:
        for i in range(span):
            total[slot_of(rows[row + i], contact, i)] += rows[row + i].impulse
        return
    cone = 3 if contact.friction > 0.0 else 1
    pushes = (rows[row].impulse, 0.0, 0.0)
    if cone == 3:
        pushes = (rows[row].impulse, rows[row + 1].impulse, rows[row + 2].impulse)
    add_pushes(contact, rows, row, substep_bodies, pushes)
    if span == cone:
        return
    twist = (0.0, 0.0, 0.0)
    for i in range(cone, span):
        axis = in_world(substep_bodies[contact.body_b], spin_of(rows[row + i].jacobian_b))
        twist = along(twist, rows[row + i].impulse, axis)
    n = vec(contact.normal)
    t, s = tangents(n)
    total[3] += dot(n, twist)
    total[4] += dot(t, twist)
    total[5] += dot(s, twist)


@njit
def add_pushes(contact: Any, rows: Any, row: Any, substep_bodies: Any, pushes: Vec) -> None:
    """Add impulses along normal and tangents of a contact's rows to those along its directions before the step."""
    of_a, of_b = substep_bodies[contact.body_a], substep_bodies[contact.body_b]
    push, on_a, on_b = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(3 if contact.friction > 0.0 else 1):
        made = rows[row + i]
        push = along(push, pushes[i], vec(made.jacobian_b))
        on_a = along(on_a, -pushes[i], in_world(of_a, spin_of(made.jacobian_a)))
        on_b = along(on_b, pushes[i], in_world(of_b, spin_of(made.jacobian_b)))
    n = vec(contact.normal)
    t, s = tangents(n)
    contact.total_impulse[0] += dot(n, push)
    contact.total_impulse[1] += dot(t, push)
    contact.total_impulse[2] += dot(s, push)
    point = vec(contact.point)
    on_a = sub(on_a, cross(sub(point, vec(of_a.start_position)), push))
    on_b = sub(on_b, cross(sub(point, vec(of_b.start_position)), push))
    for d in range(3):
        contact.moments[0, d] += on_a[d]
        contact.moments[1, d] += on_b[d]


@njit
def rotate_contact_rows(world: Any, island: Any) -> None:
    """Rotate the Jacobians of the contact rows that do not turn to the present frames of the bodies."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    mark_turning(world, island, island.h)
    r = island.joint_rows
    last = -1
    while r < island.rows:
        contact = contacts[rows[r].source]
        if not must_turn(contact, substep_bodies):
            set_contact_jacobians(rows, r, contact, last, substep_bodies)
            rows[r].turned = 0
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
    for side in range(2):
        for d in range(3):
            contact.moments[side, d] += other.moments[side, d]
