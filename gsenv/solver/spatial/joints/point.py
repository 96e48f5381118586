"""Where two bodies' anchors are and how they move; the rows that hold them together."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..contact_rows import set_jacobian
from ..frames import in_world, spin_change, spin_of
from ..math import (
    Quaternion,
    Vec,
    add,
    along,
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
from .build import finish_row

JUMP = 0.05  # of the arms' own speeds: where anchors part faster, velocities are about to jump


@njit
def unit_axis(k: int) -> Vec:
    """x, y or z of the world."""
    return 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0


@njit
def arm(body: Any, parameters: Any, anchor: Any) -> Vec:
    """From the centre of mass to an anchor, in the world."""
    return turned(quaternion(body.rotation), sub(vec(anchor), vec(parameters.center)))


@njit
def start_spin(motion: Any) -> Vec:
    """rad/s in the world, before any impulse of the substep."""
    return in_world(motion, spin_of(motion.start_velocity))


@njit
def rotation_ahead(body: Any, motion: Any, h: Any, t: Any) -> Quaternion:
    """Rotation of a body ``t`` s into a substep of h s, if nothing acts on it."""
    w = start_spin(motion)
    if motion.tilted == 0:
        return multiply(turn_of(scaled(w, t)), quaternion(body.rotation))
    if t == 0.0:
        return quaternion(body.rotation)
    return multiply(turn_of(scaled(w, t - 0.5 * h)), quaternion(motion.middle))


@njit
def arm_ahead(body: Any, parameters: Any, motion: Any, anchor: Any, h: Any, t: Any) -> Vec:
    """From the centre of mass to an anchor, ``t`` s into a substep of h s."""
    return turned(rotation_ahead(body, motion, h, t), sub(vec(anchor), vec(parameters.center)))


@njit
def set_point_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> None:
    """C = anchor_b - anchor_a in the world, along x, y and z, in slots 0 to 2.

    Directions are those of the pose half a substep ahead, which the mean velocity moves through, and
    the bias is what the rotating arms add to J v from there to the end, h/2 dJ/dt v = h/2 w x (w x r).
    """
    i = rows[row].body_a
    j = rows[row].body_b
    a = arm(bodies[i], body_parameters[i], parameters.anchor_a)
    b = arm(bodies[j], body_parameters[j], parameters.anchor_b)
    c = sub(add(vec(bodies[j].position), b), add(vec(bodies[i].position), a))
    wa = start_spin(motions[i])
    wb = start_spin(motions[j])
    ua = cross(wa, a)
    ub = cross(wb, b)
    parting = sub(add(vec(motions[j].start_velocity), ub), add(vec(motions[i].start_velocity), ua))
    bend = (0.0, 0.0, 0.0)
    # else the pose of the start keeps the momentum
    if norm(parting) <= JUMP * (norm(wa) * norm(a) + norm(wb) * norm(b)):
        a = arm_ahead(bodies[i], body_parameters[i], motions[i], parameters.anchor_a, h, 0.5 * h)
        b = arm_ahead(bodies[j], body_parameters[j], motions[j], parameters.anchor_b, h, 0.5 * h)
        bend = sub(bending(motions[j], body_parameters[j], b), bending(motions[i], body_parameters[i], a))
    for k in range(3):
        u = unit_axis(k)
        set_point_direction(rows[row + k], motions, u, a, b)
        finish_row(rows[row + k], k, c[k], motions)
        rows[row + k].bias = 0.5 * h * bend[k]


@njit
def bending(motion: Any, parameters: Any, to_anchor: Vec) -> Vec:
    """m/s^2 of an anchor on a body that turns freely: w x (w x r) + w' x r."""
    w = start_spin(motion)
    change = in_world(motion, spin_change(motion, parameters))
    return add(cross(w, cross(w, to_anchor)), cross(change, to_anchor))


@njit
def bend_across(w: Vec, change: Vec, to_anchor: Vec) -> Vec:
    """m/s^2 of an anchor across its arm: how fast the direction changes in which the arm swings."""
    bend = add(cross(w, cross(w, to_anchor)), cross(change, to_anchor))
    square = dot(to_anchor, to_anchor)
    return along(bend, -dot(bend, to_anchor) / square if square > 0.0 else 0.0, to_anchor)


@njit
def set_point_direction(row: Any, motions: Any, u: Vec, arm_a: Vec, arm_b: Vec) -> None:
    """J v = u . (velocity of b's anchor - velocity of a's)."""
    set_jacobian(row, motions, u, cross(u, arm_a), cross(arm_b, u))


@njit
def set_turn_direction(row: Any, motions: Any, u: Vec) -> None:
    """J v = u . (w_b - w_a)."""
    set_jacobian(row, motions, (0.0, 0.0, 0.0), (-u[0], -u[1], -u[2]), u)


@njit
def frame_ahead(
    bodies: Any, body_parameters: Any, motions: Any, i: Any, j: Any, parameters: Any, h: Any, t: Any
) -> tuple[Vec, Vec, Vec]:
    """(arm_a, arm_b, anchor_b - anchor_a), ``t`` s into a substep of h s, if nothing acts."""
    a = arm_ahead(bodies[i], body_parameters[i], motions[i], parameters.anchor_a, h, t)
    b = arm_ahead(bodies[j], body_parameters[j], motions[j], parameters.anchor_b, h, t)
    from_a = add(along(vec(bodies[i].position), t, vec(motions[i].start_velocity)), a)
    to_b = add(along(vec(bodies[j].position), t, vec(motions[j].start_velocity)), b)
    return a, b, sub(to_b, from_a)


@njit
def set_frame_direction(row: Any, motions: Any, frame: tuple[Vec, Vec, Vec], u: Vec) -> None:
    """J of u . d for u that turns with body a: the arm of a reaches to b's anchor."""
    set_point_direction(row, motions, u, add(frame[0], frame[2]), frame[1])


@njit
def frame_rate(motions: Any, i: Any, j: Any, frame: tuple[Vec, Vec, Vec], u: Vec) -> float:
    """J v at the start's velocities of a row that ``set_frame_direction`` would set."""
    va = add(vec(motions[i].start_velocity), cross(start_spin(motions[i]), add(frame[0], frame[2])))
    vb = add(vec(motions[j].start_velocity), cross(start_spin(motions[j]), frame[1]))
    return dot(u, sub(vb, va))
