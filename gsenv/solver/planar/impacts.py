"""One 2D impact: of a contact, or of both contacts of a manifold that are hit at the same time, with friction."""

from __future__ import annotations

from typing import Any

from numba import int64

from ..core.contact_rows import shifted
from ..core.impacts import acceleration_of, apply_impulse_at, couple, speed_at
from ..core.rows import FRICTION, relative_velocity
from ..jit import njit
from ..methods.joint_factor import EPSILON
from .contact_rows import add_pushes


@njit
def _contact_impulse(
    normal: Any, tangent: Any, un: Any, ut: Any, restitution: Any, substep_bodies: Any, joint_factor: Any
) -> Any:
    """Return the (normal, tangential) impulse that changes approach speed un to -restitution un, with friction."""
    knn = couple(normal, normal, substep_bodies, joint_factor)
    ktt = couple(tangent, tangent, substep_bodies, joint_factor)
    knt = couple(normal, tangent, substep_bodies, joint_factor)
    target = -(1.0 + restitution) * un
    det = knn * ktt - knt * knt
    if det <= 10.0 * EPSILON * knn * ktt:  # joints leave one direction of motion: normal and tangent rows are dependent
        return target / knn, 0.0
    pn = (target * ktt + ut * knt) / det
    pt = (-ut * knn - target * knt) / det
    if pn <= 0.0 or abs(pt) > tangent.friction * pn:
        mu = tangent.friction if pt > 0.0 else -tangent.friction
        slip = knn + mu * knt
        if slip < 0.1 * knn:  # jamming: friction would increase the normal impulse
            mu = 0.0
            slip = knn
        pn = target / slip
        pt = mu * pn
    work = pn * un + pt * ut
    twice = pn * pn * knn + 2.0 * pn * pt * knt + pt * pt * ktt
    if work >= 0.0:
        return target / knn, 0.0
    if work + 0.5 * twice > 0.0:  # energy guard
        scale = -2.0 * work / twice
        pn *= scale
        pt *= scale
    return pn, pt


@njit
def _pair_impulses(one: Any, other: Any, u: Any, v: Any, e: Any, substep_bodies: Any, joint_factor: Any) -> Any:
    """Return the normal impulses of two contacts of one manifold, hit at the same time: 2x2 complementarity."""
    a = couple(one, one, substep_bodies, joint_factor)
    d = couple(other, other, substep_bodies, joint_factor)
    c = couple(one, other, substep_bodies, joint_factor)
    p = -(1.0 + e) * u
    s = -(1.0 + e) * v
    det = a * d - c * c
    if det <= 10.0 * EPSILON * a * d:
        return 0.0, 0.0
    x = (p * d - s * c) / det
    y = (s * a - p * c) / det
    if x <= 0.0 or y <= 0.0:
        return 0.0, 0.0
    return x, y


@njit
def _partner(world: Any, island: Any, r: Any, time: Any) -> Any:
    """Return the row of the manifold's other contact if that is hit at the same time, else -1."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    first = island.joint_rows
    here = contacts[rows[r].source]
    before = r - (rows[r - 1].kind == FRICTION) - 1 if r > first else first
    for side in range(2):
        q = before if side == 0 else r + int(rows[r].span)
        if q == r or q < first or q >= island.rows:
            continue
        row = rows[q]
        there = contacts[row.source]
        if there.shape_a == here.shape_a and there.shape_b == here.shape_b:
            u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
            a = acceleration_of(row, substep_bodies)
            gap = row.error + shifted(row, substep_bodies) + time * (u + 0.5 * a * time)
            if gap < 1e-4 * here.extent and u + a * time < 0.0:
                return int64(q)
    return int64(-1)


@njit
def _friction_impulse(tangent: Any, bodies: Any, substep_bodies: Any, time: Any, pn: Any, joint_factor: Any) -> Any:
    u = speed_at(tangent, bodies, substep_bodies, time)
    bound = tangent.friction * pn
    return min(max(-u / couple(tangent, tangent, substep_bodies, joint_factor), -bound), bound)


@njit
def apply_impact(world: Any, island: Any, r: Any, time: Any, joint_factor: Any) -> None:
    """Resolve the impact of normal row r, and of the manifold's other contact if that is hit at the same time."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    normal = rows[r]
    contact = contacts[normal.source]
    un = speed_at(normal, bodies, substep_bodies, time)
    q = _partner(world, island, r, time)
    if q >= 0:
        uq = speed_at(rows[q], bodies, substep_bodies, time)
        x, y = _pair_impulses(normal, rows[q], un, uq, contact.restitution, substep_bodies, joint_factor)
        if x > 0.0:
            apply_impulse_at(normal, bodies, substep_bodies, x, time, joint_factor)
            apply_impulse_at(rows[q], bodies, substep_bodies, y, time, joint_factor)
            _finish_pair(world, r, x, time, joint_factor)
            _finish_pair(world, q, y, time, joint_factor)
            return
    if normal.span == 1:
        pn = -(1.0 + contact.restitution) * un / couple(normal, normal, substep_bodies, joint_factor)
        apply_impulse_at(normal, bodies, substep_bodies, pn, time, joint_factor)
        add_pushes(contact, rows, r, substep_bodies, (pn, 0.0))
        return
    tangent = rows[r + 1]
    ut = speed_at(tangent, bodies, substep_bodies, time)
    pn, pt = _contact_impulse(normal, tangent, un, ut, contact.restitution, substep_bodies, joint_factor)
    apply_impulse_at(normal, bodies, substep_bodies, pn, time, joint_factor)
    apply_impulse_at(tangent, bodies, substep_bodies, pt, time, joint_factor)
    add_pushes(contact, rows, r, substep_bodies, (pn, pt))


@njit
def _finish_pair(world: Any, r: Any, pn: Any, time: Any, joint_factor: Any) -> None:
    """Apply the friction impulse of one contact of a pair, whose normal impulse pn has been applied."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    pt = 0.0
    if rows[r].span == 2:
        pt = _friction_impulse(rows[r + 1], bodies, substep_bodies, time, pn, joint_factor)
        apply_impulse_at(rows[r + 1], bodies, substep_bodies, pt, time, joint_factor)
    add_pushes(world.state.contacts[rows[r].source], rows, r, substep_bodies, (pn, pt))
