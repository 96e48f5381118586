"""Rows of a 2D contact: the normal row, then the friction row, coupled in the same sweep."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..core.faces import FACE_OF_A, face_and_other
from ..core.rows import FRICTION
from ..jit import njit
from .math import rotate

Vector = tuple[float, float]


class Arms(NamedTuple):
    """Where a contact acts: arms of its point on both bodies in m, and its normal."""

    arm_a: Vector
    arm_b: Vector
    n: Vector


@njit
def contact_span(contact: Any) -> Any:
    """Return the number of rows of a contact: the normal row, and a tangent row where there is friction."""
    return 2 if contact.friction > 0.0 else 1


@njit
def set_contact_rows(rows: Any, row: Any, contact: Any, last: Any, substep_bodies: Any, scale: Any) -> None:
    """Set Jacobians and friction of a contact's rows, and ``scale`` times the stored impulses.

    ``last``: first row of the contact before it, or -1.
    """
    a = substep_bodies[contact.body_a].start_position
    b = substep_bodies[contact.body_b].start_position
    arm_a = (contact.point[0] - a[0], contact.point[1] - a[1])
    arm_b = (contact.point[0] - b[0], contact.point[1] - b[1])
    _set_jacobians(rows, row, contact, Arms(arm_a, arm_b, (contact.normal[0], contact.normal[1])), substep_bodies)
    if contact.friction > 0.0:
        rows[row + 1].kind = FRICTION
        rows[row + 1].base = 1
        rows[row + 1].friction = contact.friction
    for r in range(contact_span(contact)):
        rows[row + r].impulse = scale * contact.impulse[r]


@njit
def _set_jacobians(rows: Any, row: Any, contact: Any, arms: Arms, substep_bodies: Any) -> None:
    """Set Jacobians and effective masses of a contact's rows."""
    nx, ny = arms.n
    _set_point_row(rows[row], arms, nx, ny)
    set_effective_mass(rows[row], substep_bodies)
    if contact.friction > 0.0:
        _set_point_row(rows[row + 1], arms, -ny, nx)
        set_effective_mass(rows[row + 1], substep_bodies)


@njit
def _set_point_row(row: Any, arms: Arms, ux: Any, uy: Any) -> None:
    """Set the Jacobian of J v = (velocity of b's point - velocity of a's point) . u."""
    row.jacobian_a[0] = -ux
    row.jacobian_a[1] = -uy
    row.jacobian_a[2] = -(arms.arm_a[0] * uy - arms.arm_a[1] * ux)
    row.jacobian_b[0] = ux
    row.jacobian_b[1] = uy
    row.jacobian_b[2] = arms.arm_b[0] * uy - arms.arm_b[1] * ux


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
def turn_contact_rows(rows: Any, row: Any, contact: Any, bodies: Any, substep_bodies: Any, h: Any) -> Any:
    """Set Jacobians and effective masses of a contact's rows for the poses that its bodies have ``h`` / 2 from now.

    ``bias`` becomes the change of J v until then: with it J v is 0 at the end of the substep, and on its mean.
    Returns the present separation, m.
    """
    one, other = face_and_other(contact)
    face, core = substep_bodies[one], substep_bodies[other]
    sign, start, arm = _at_start(contact, core)
    x, y = _way(bodies[one], bodies[other])
    n, core_arm = _turned(face.turn, start), _turned(core.turn, arm)
    now = _arms_of(contact, sign, n, core_arm, (x, y))
    separation = _separation(contact, start, n, core_arm, (x, y), face)
    u, v = bodies[one].velocity, bodies[other].velocity
    x, y = x + 0.5 * h * (v[0] - u[0]), y + 0.5 * h * (v[1] - u[1])
    middle = _arms_of(contact, sign, _turned(face.mid_turn, start), _turned(core.mid_turn, arm), (x, y))
    _set_jacobians(rows, row, contact, middle, substep_bodies)
    u, v = bodies[contact.body_a].velocity, bodies[contact.body_b].velocity
    rates, later = _rates(u, v, now), _rates(u, v, middle)
    for k in range(contact_span(contact)):
        rows[row + k].bias = later[k] - rates[k]
    return separation


@njit
def present_separation(contact: Any, bodies: Any, substep_bodies: Any) -> Any:
    """Return the separation of a contact in the present poses, m.

    The normal turns with the body that has the face, the point with the other one.
    """
    one, other = face_and_other(contact)
    face, core = substep_bodies[one], substep_bodies[other]
    _, start, arm = _at_start(contact, core)
    way = _way(bodies[one], bodies[other])
    return _separation(contact, start, _turned(face.turn, start), _turned(core.turn, arm), way, face)


@njit
def _separation(contact: Any, start: Vector, n: Vector, arm: Vector, way: Vector, face: Any) -> Any:
    """Return the separation of a contact, m.

    Args:
        contact: record.
        start: normal out of the face at the start of the step.
        n: the same now.
        arm: m, of the core of the other shape, now.
        way: m, from the centre of mass of the body with the face to that of the other.
        face: substep body with the face.
    """
    x, y = contact.point[0] - face.start_position[0], contact.point[1] - face.start_position[1]
    before = start[0] * x + start[1] * y + contact.core_distance
    return contact.start_separation + n[0] * (way[0] + arm[0]) + n[1] * (way[1] + arm[1]) - before


@njit
def _way(one: Any, other: Any) -> Vector:
    """Return the vector from one centre of mass to the other, m."""
    return other.position[0] - one.position[0], other.position[1] - one.position[1]


@njit
def _at_start(contact: Any, core: Any) -> Any:
    """Return (1 where the normal of the contact points out of the face or -1, that normal, arm of the other's core).

    All at the start of the step; ``core``: the substep body without the face.
    """
    sign = 1.0 if contact.face == FACE_OF_A else -1.0
    return sign, (sign * contact.normal[0], sign * contact.normal[1]), fixed_arm(contact, core)


@njit
def fixed_arm(contact: Any, substep_body: Any) -> Vector:
    """Return the arm, at the start of the step, of the point that is fixed on the body without the face, m."""
    inwards = contact.core_distance if contact.face == FACE_OF_A else -contact.core_distance
    x = contact.point[0] + inwards * contact.normal[0] - substep_body.start_position[0]
    y = contact.point[1] + inwards * contact.normal[1] - substep_body.start_position[1]
    return x, y


@njit
def _arms_of(contact: Any, sign: Any, n: Vector, core: Vector, way: Vector) -> Arms:
    """Return the arms of a contact; ``n``: out of the face; ``core``: m, arm of the core of the shape without it.

    ``way``: m, from the centre of mass of the body with the face to that of the other.
    """
    arm = (core[0] - contact.core_distance * n[0], core[1] - contact.core_distance * n[1])
    far = (way[0] + arm[0], way[1] + arm[1])
    normal = (sign * n[0], sign * n[1])
    return Arms(far, arm, normal) if sign > 0.0 else Arms(arm, far, normal)


@njit
def _rates(a: Any, b: Any, arms: Arms) -> Vector:
    """Return the relative velocity of b's point along normal and tangent, from two velocities (3,)."""
    x = b[0] - b[2] * arms.arm_b[1] - a[0] + a[2] * arms.arm_a[1]
    y = b[1] + b[2] * arms.arm_b[0] - a[1] - a[2] * arms.arm_a[0]
    nx, ny = arms.n
    return nx * x + ny * y, nx * y - ny * x


@njit
def _turned(turn: Any, v: Vector) -> Vector:
    """Return a vector that is fixed on a body, from what it was at the start of the step."""
    return rotate(turn[0], turn[1], v[0], v[1])


@njit
def add_impulses(contact: Any, rows: Any, row: Any, substep_bodies: Any, turning: Any) -> None:
    """Add the impulses of a substep to those of the step; ``turning``: whether its rows may have turned."""
    push = rows[row].impulse
    drag = rows[row + 1].impulse if contact.friction > 0.0 else 0.0
    if turning:
        add_pushes(contact, rows, row, substep_bodies, (push, drag))
    else:
        contact.total_impulse[0] += push
        contact.total_impulse[1] += drag


@njit
def add_pushes(contact: Any, rows: Any, row: Any, substep_bodies: Any, pushes: Vector) -> None:
    """Add impulses along the rows of a contact to those along its directions at the start of the step."""
    now = rows[row].jacobian_b
    x, y = now[0] * pushes[0] - now[1] * pushes[1], now[1] * pushes[0] + now[0] * pushes[1]
    n = contact.normal
    contact.total_impulse[0] += n[0] * x + n[1] * y
    contact.total_impulse[1] += n[0] * y - n[1] * x
    a, b = substep_bodies[contact.body_a].start_position, substep_bodies[contact.body_b].start_position
    point = contact.point
    contact.moments[0, 0] -= (point[0] - a[0]) * y - (point[1] - a[1]) * x
    contact.moments[1, 0] -= (point[0] - b[0]) * y - (point[1] - b[1]) * x
    for k in range(contact_span(contact)):
        contact.moments[0, 0] -= rows[row + k].jacobian_a[2] * pushes[k]
        contact.moments[1, 0] += rows[row + k].jacobian_b[2] * pushes[k]


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
    for side in range(2):
        contact.moments[side, 0] += other.moments[side, 0]
