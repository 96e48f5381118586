"""Impact phase: pairwise Newton impacts at their own times inside the substep, before the solve.

A body in flight meets another at the root t of  gap + u t + a t^2/2 = 0.  There an impulse p makes
the approach speed u + a t into -e times itself.  The impulse acts over the rest of the substep
only, so ``shift`` takes  t M^-1 J^T p  back from the displacement: bounces are exact parabolas at any
timestep.  The earliest impact comes first and may cause the next (Newton's cradle); a simultaneous
solve would share the momentum among all.  Approach speeds are those before gravity of the substep
is added, or each bounce would rise.

Kane, "A dynamics puzzle", Stanford Mechanics Alumni Club 1984: Newton restitution with friction may
create energy; impulses are scaled so that the kinetic energy never grows.
Bounces that would all end within the substep (their times are a geometric series) are left to the
contact solve: the body is at rest.
"""

from __future__ import annotations

from typing import Any

from numba import int64

from ..jit import njit
from ..rows import FRICTION, relative_velocity

_NEVER = 1e300
ORDERED_LIMIT = 48  # contacts up to which impacts are taken in order of time, at n^2 cost
MAX_PASSES = 8


@njit
def _acceleration(row: Any, motions: Any) -> Any:
    s = 0.0
    a = motions[row.body_a]
    b = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * a.acceleration[i] + row.jacobian_b[i] * b.acceleration[i]
    return s


@njit
def _shifted(row: Any, motions: Any) -> Any:
    s = 0.0
    a = motions[row.body_a]
    b = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * a.shift[i] + row.jacobian_b[i] * b.shift[i]
    return s


@njit
def meeting_time(gap: Any, speed: Any, acceleration: Any, start: Any) -> Any:
    """First time >= start at which gap + speed t + acceleration t^2/2 falls to 0, or never."""
    now = gap + start * (speed + 0.5 * acceleration * start)
    v = speed + acceleration * start
    if now <= 0.0:
        if v < 0.0:
            return start
        return start - 2.0 * v / acceleration if acceleration < 0.0 else _NEVER
    root = v * v - 2.0 * acceleration * now
    if root < 0.0:
        return _NEVER
    root = root**0.5
    if v < 0.0:
        return start + 2.0 * now / (root - v)
    if acceleration < 0.0:
        return start + (v + root) / -acceleration
    return _NEVER


@njit
def _comes_to_rest(speed: Any, restitution: Any, acceleration: Any, remaining: Any) -> Any:
    """Whether all further bounces, t_k = 2 e^k speed / acceleration, fit into the rest of h."""
    if restitution >= 1.0:
        return speed <= 0.0
    return 2.0 * restitution * speed <= acceleration * (1.0 - restitution) * remaining


@njit
def _impact_time(rows: Any, r: Any, contacts: Any, bodies: Any, motions: Any, pull: Any, h: Any) -> Any:
    """When in this substep the contact of normal row r has an impact, or never."""
    row = rows[r]
    restitution = contacts[row.source].restitution
    if restitution <= 0.0:
        return _NEVER
    u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
    a = _acceleration(row, motions)
    start = max(motions[row.body_a].event_time, motions[row.body_b].event_time)
    gap = row.error + _shifted(row, motions)
    time = meeting_time(gap, u, a, start)
    if time > h:
        row.flying = 1
        row.flight = a
        return _NEVER
    row.flying = 0
    speed = -(u + a * time)
    if speed <= 1e-12 * (abs(u) + abs(a) * h):
        return _NEVER
    if _comes_to_rest(speed, restitution, max(-a, pull), h - time):
        return _NEVER
    return time


@njit
def _couple(row: Any, other: Any) -> Any:
    """J_row M^-1 J_other^T of two rows on the same pair of bodies."""
    s = 0.0
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * other.response_a[i] + row.jacobian_b[i] * other.response_b[i]
    return s


@njit
def _add(row: Any, bodies: Any, motions: Any, impulse: Any, time: Any) -> None:
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    ma = motions[row.body_a]
    mb = motions[row.body_b]
    for i in range(len(row.response_a)):
        da = row.response_a[i] * impulse
        db = row.response_b[i] * impulse
        a.velocity[i] += da
        b.velocity[i] += db
        ma.shift[i] -= time * da
        mb.shift[i] -= time * db
    if row.response_a[0] != 0.0 or row.response_a[1] != 0.0:  # the ground takes part in many at once
        ma.event_time = time
    if row.response_b[0] != 0.0 or row.response_b[1] != 0.0:
        mb.event_time = time


@njit
def _contact_impulse(normal: Any, tangent: Any, un: Any, ut: Any, restitution: Any) -> Any:
    """(normal, tangential) impulse that turns approach speed un into -restitution un, with friction."""
    knn = normal.diagonal
    ktt = tangent.diagonal
    knt = _couple(normal, tangent)
    target = -(1.0 + restitution) * un
    det = knn * ktt - knt * knt
    pn = -1.0
    pt = 0.0
    if det > 1e-12 * knn * ktt:
        pn = (target * ktt + ut * knt) / det
        pt = (-ut * knn - target * knt) / det
    if pn <= 0.0 or abs(pt) > tangent.friction * pn:
        mu = tangent.friction if pt > 0.0 else -tangent.friction
        slip = knn + mu * knt
        if slip < 0.1 * knn:  # jamming: friction would feed the normal
            mu = 0.0
            slip = knn
        pn = target / slip
        pt = mu * pn
    work = pn * un + pt * ut
    twice = pn * pn * knn + 2.0 * pn * pt * knt + pt * pt * ktt
    if work + 0.5 * twice > 0.0:  # energy guard
        scale = -2.0 * work / twice
        pn *= scale
        pt *= scale
    return pn, pt


@njit
def _pair_impulses(rows: Any, r: Any, q: Any, u: Any, v: Any, e: Any) -> Any:
    """Normal impulses of the two contacts of one manifold, hit at once: 2x2 complementarity."""
    a = rows[r].diagonal
    d = rows[q].diagonal
    c = _couple(rows[r], rows[q])
    p = -(1.0 + e) * u
    s = -(1.0 + e) * v
    det = a * d - c * c
    if det <= 1e-9 * a * d:
        return 0.0, 0.0
    x = (p * d - s * c) / det
    y = (s * a - p * c) / det
    if x <= 0.0 or y <= 0.0:
        return 0.0, 0.0
    return x, y


@njit
def _partner(rows: Any, r: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, time: Any) -> Any:
    """Row of the manifold's other contact if it is hit at the same time, else -1."""
    here = contacts[rows[r].source]
    before = r - (rows[r - 1].kind == FRICTION) - 1 if r > first else first
    for side in range(2):
        q = before if side == 0 else r + rows[r].span
        if q == r or q < first or q >= end:
            continue
        row = rows[q]
        there = contacts[row.source]
        if there.shape_a == here.shape_a and there.shape_b == here.shape_b:
            u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
            a = _acceleration(row, motions)
            gap = row.error + _shifted(row, motions) + time * (u + 0.5 * a * time)
            if gap < 1e-4 * here.extent and u + a * time < 0.0:
                return q
    return -1


@njit
def _friction_impulse(tangent: Any, bodies: Any, motions: Any, time: Any, pn: Any) -> Any:
    u = relative_velocity(tangent, bodies[tangent.body_a], bodies[tangent.body_b])
    u += time * _acceleration(tangent, motions)
    bound = tangent.friction * pn
    return min(max(-u * tangent.effective_mass, -bound), bound)


@njit
def _apply_impact(rows: Any, r: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, time: Any) -> None:
    normal = rows[r]
    contact = contacts[normal.source]
    un = relative_velocity(normal, bodies[normal.body_a], bodies[normal.body_b])
    un += time * _acceleration(normal, motions)
    q = _partner(rows, r, first, end, contacts, bodies, motions, time)
    if q >= 0:
        other = rows[q]
        uq = relative_velocity(other, bodies[other.body_a], bodies[other.body_b])
        uq += time * _acceleration(other, motions)
        x, y = _pair_impulses(rows, r, q, un, uq, contact.restitution)
        if x > 0.0:
            _add(normal, bodies, motions, x, time)
            _add(other, bodies, motions, y, time)
            for k in range(2):
                n = r if k == 0 else q
                pn = x if k == 0 else y
                total = contacts[rows[n].source].total_impulse
                total[0] += pn
                if rows[n].span == 2:
                    pt = _friction_impulse(rows[n + 1], bodies, motions, time, pn)
                    _add(rows[n + 1], bodies, motions, pt, time)
                    total[1] += pt
            return
    if normal.span == 1:
        pn = -(1.0 + contact.restitution) * un * normal.effective_mass
        _add(normal, bodies, motions, pn, time)
        contact.total_impulse[0] += pn
        return
    tangent = rows[r + 1]
    ut = relative_velocity(tangent, bodies[tangent.body_a], bodies[tangent.body_b])
    ut += time * _acceleration(tangent, motions)
    pn, pt = _contact_impulse(normal, tangent, un, ut, contact.restitution)
    _add(normal, bodies, motions, pn, time)
    _add(tangent, bodies, motions, pt, time)
    contact.total_impulse[0] += pn
    contact.total_impulse[1] += pt


@njit
def resolve_impacts(
    rows: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, indices: Any, pull: Any, h: Any
) -> Any:
    """All impacts of one island within the substep. Returns how many there were.

    ``rows[first:end]`` are its contact rows with fresh errors; ``pull`` = |gravity|, m/s^2.
    """
    for k in range(len(indices)):
        motions[indices[k]].event_time = 0.0
    for r in range(first, end):
        motions[rows[r].body_a].event_time = 0.0
        motions[rows[r].body_b].event_time = 0.0
    if end - first > 2 * ORDERED_LIMIT:
        return _impacts_in_passes(rows, first, end, contacts, bodies, motions, pull, h)
    count = 0
    for _ in range(8 + 2 * (end - first)):
        best = int64(-1)
        earliest = _NEVER
        for r in range(first, end):
            if rows[r].kind == FRICTION:
                continue
            time = _impact_time(rows, r, contacts, bodies, motions, pull, h)
            if time < earliest:
                earliest = time
                best = r
        if best < 0:
            break
        _apply_impact(rows, best, first, end, contacts, bodies, motions, earliest)
        count += 1
    return count


@njit
def _impacts_in_passes(
    rows: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, pull: Any, h: Any
) -> Any:
    """Many contacts: in the order of the rows, pass after pass, at linear cost."""
    count = 0
    for _ in range(MAX_PASSES):
        before = count
        for r in range(first, end):
            if rows[r].kind == FRICTION:
                continue
            time = _impact_time(rows, r, contacts, bodies, motions, pull, h)
            if time <= h:
                _apply_impact(rows, r, first, end, contacts, bodies, motions, time)
                count += 1
        if count == before:
            break
    return count
