"""Positions and velocities of two bodies' anchors, and the rows that keep them together."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...jit import njit
from ..contact_rows import set_jacobian
from ..free_rotation import rotate_with_velocity
from ..math import (
    Quaternion,
    Vec,
    add,
    along,
    conjugate,
    cross,
    dot,
    multiply,
    norm,
    quaternion,
    scaled,
    sub,
    turn_of,
    turned,
    vec,
)
from ..rotation import in_world, spin_change, spin_of

JUMP = 0.05  # of the speeds of the arms: where anchors separate faster, velocities will jump


@njit
def unit_axis(k: int) -> Vec:
    """Return the x, y or z axis of the world."""
    return 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0


@njit
def arm(body: Any, parameters: Any, anchor: Any) -> Vec:
    """Return the vector from the centre of mass to an anchor, in the world, m."""
    return turned(quaternion(body.rotation), sub(vec(anchor), vec(parameters.center)))


@njit
def start_spin(substep_body: Any) -> Vec:
    """Return the angular velocity at the start of the substep, in the world, rad/s."""
    return in_world(substep_body, spin_of(substep_body.start_velocity))


@njit
def rotation_ahead(body: Any, substep_body: Any, h: Any, t: Any) -> Quaternion:
    """Return the rotation of a body ``t`` s into a substep of h s, if nothing acts on it."""
    w = start_spin(substep_body)
    if substep_body.rotated_frame == 0:
        return multiply(turn_of(scaled(w, t)), quaternion(body.rotation))
    if t == 0.0:
        return quaternion(body.rotation)
    return multiply(turn_of(scaled(w, t - 0.5 * h)), quaternion(substep_body.mid_rotation))


@njit
def rotation_after(body: Any, parameters: Any, substep_body: Any, w: Vec, h: Any, t: Any) -> Quaternion:
    """Return the rotation of a body ``t`` s after the midpoint, if it rotates freely from w, rad/s in the world."""
    middle = rotation_ahead(body, substep_body, h, 0.5 * h)
    if substep_body.rotated_frame == 0:
        return multiply(turn_of(scaled(w, t)), middle)
    axes = quaternion(parameters.axes)
    after, _ = rotate_with_velocity(multiply(middle, axes), vec(parameters.inertia), w, t)
    return multiply(after, conjugate(axes))


@njit
def arm_ahead(body: Any, parameters: Any, substep_body: Any, anchor: Any, h: Any, t: Any) -> Vec:
    """Return the vector from the centre of mass to an anchor, ``t`` s into a substep of h s."""
    return turned(rotation_ahead(body, substep_body, h, t), sub(vec(anchor), vec(parameters.center)))


@njit
def set_point_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of C = anchor_b - anchor_a in the world, along x, y and z, in slots 0 to 2.

    Directions are those of the pose half a substep ahead, at the midpoint of the motion, and the bias is
    the change of J v by the rotating arms from there to the end, h/2 dJ/dt v = h/2 w x (w x r).
    """
    i = rows[row].body_a
    j = rows[row].body_b
    a = arm(bodies[i], body_parameters[i], parameters.anchor_a)
    b = arm(bodies[j], body_parameters[j], parameters.anchor_b)
    c = sub(add(vec(bodies[j].position), b), add(vec(bodies[i].position), a))
    wa = start_spin(substep_bodies[i])
    wb = start_spin(substep_bodies[j])
    a_ahead = arm_ahead(bodies[i], body_parameters[i], substep_bodies[i], parameters.anchor_a, h, 0.5 * h)
    b_ahead = arm_ahead(bodies[j], body_parameters[j], substep_bodies[j], parameters.anchor_b, h, 0.5 * h)
    # in joint coordinates, the velocities are those of the pose half a substep ahead
    gap = min(
        _parting(substep_bodies[i], substep_bodies[j], a, b),
        _parting(substep_bodies[i], substep_bodies[j], a_ahead, b_ahead),
    )
    bend = (0.0, 0.0, 0.0)
    # otherwise the pose of the start conserves the momentum
    if gap <= JUMP * (norm(wa) * norm(a) + norm(wb) * norm(b)):
        a = a_ahead
        b = b_ahead
        bend = sub(bending(substep_bodies[j], body_parameters[j], b), bending(substep_bodies[i], body_parameters[i], a))
    for k in range(3):
        u = unit_axis(k)
        set_point_direction(rows[row + k], substep_bodies, u, a, b)
        finish_row(rows[row + k], k, c[k], substep_bodies)
        rows[row + k].bias = 0.5 * h * bend[k]


@njit
def _parting(a: Any, b: Any, arm_a: Vec, arm_b: Vec) -> Any:
    """Return the speed at which two anchors part, m/s."""
    va = add(vec(a.start_velocity), cross(start_spin(a), arm_a))
    return norm(sub(add(vec(b.start_velocity), cross(start_spin(b), arm_b)), va))


@njit
def bending(substep_body: Any, parameters: Any, to_anchor: Vec) -> Vec:
    """Return the acceleration of an anchor on a freely rotating body, m/s^2: w x (w x r) + w' x r."""
    w = start_spin(substep_body)
    change = in_world(substep_body, spin_change(substep_body, parameters))
    return add(cross(w, cross(w, to_anchor)), cross(change, to_anchor))


@njit
def bend_across(w: Vec, change: Vec, to_anchor: Vec) -> Vec:
    """Return the component of an anchor's acceleration across its arm, m/s^2."""
    bend = add(cross(w, cross(w, to_anchor)), cross(change, to_anchor))
    square = dot(to_anchor, to_anchor)
    return along(bend, -dot(bend, to_anchor) / square if square > 0.0 else 0.0, to_anchor)


@njit
def set_point_direction(row: Any, substep_bodies: Any, u: Vec, arm_a: Vec, arm_b: Vec) -> None:
    """Set the Jacobian of J v = u . (velocity of b's anchor - velocity of a's anchor)."""
    set_jacobian(row, substep_bodies[row.body_a], substep_bodies[row.body_b], u, cross(u, arm_a), cross(arm_b, u))


@njit
def set_turn_direction(row: Any, substep_bodies: Any, u: Vec) -> None:
    """Set the Jacobian of J v = u . (w_b - w_a)."""
    set_jacobian(row, substep_bodies[row.body_a], substep_bodies[row.body_b], (0.0, 0.0, 0.0), (-u[0], -u[1], -u[2]), u)


@njit
def frame_ahead(
    bodies: Any, body_parameters: Any, substep_bodies: Any, i: Any, j: Any, parameters: Any, h: Any, t: Any
) -> tuple[Vec, Vec, Vec]:
    """Return (arm_a, arm_b, anchor_b - anchor_a), ``t`` s into a substep of h s, if nothing acts."""
    a = arm_ahead(bodies[i], body_parameters[i], substep_bodies[i], parameters.anchor_a, h, t)
    b = arm_ahead(bodies[j], body_parameters[j], substep_bodies[j], parameters.anchor_b, h, t)
    from_a = add(along(vec(bodies[i].position), t, vec(substep_bodies[i].start_velocity)), a)
    to_b = add(along(vec(bodies[j].position), t, vec(substep_bodies[j].start_velocity)), b)
    return a, b, sub(to_b, from_a)


@njit
def set_frame_direction(row: Any, substep_bodies: Any, frame: tuple[Vec, Vec, Vec], u: Vec) -> None:
    """Set the Jacobian of u . d, with u fixed in body a: the arm of a then ends at b's anchor."""
    set_point_direction(row, substep_bodies, u, add(frame[0], frame[2]), frame[1])


@njit
def frame_rate(substep_bodies: Any, i: Any, j: Any, frame: tuple[Vec, Vec, Vec], u: Vec) -> float:
    """Return J v at the velocities of the start, for the J that ``set_frame_direction`` would set."""
    va = add(vec(substep_bodies[i].start_velocity), cross(start_spin(substep_bodies[i]), add(frame[0], frame[2])))
    vb = add(vec(substep_bodies[j].start_velocity), cross(start_spin(substep_bodies[j]), frame[1]))
    return dot(u, sub(vb, va))
