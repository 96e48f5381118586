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
from ..rows import EQUATION, FRICTION, GROUNDED, relative_velocity
from ..solvers.cholesky import add_force, change_of, clear_sides, substitute
from ..solvers.tree import EPSILON, solve_equations

_NEVER = 1e300
ORDERED_LIMIT = 48  # contacts up to which impacts are taken in order of time, at n^2 cost
MAX_PASSES = 8


@njit
def _acceleration(row: Any, motions: Any) -> Any:
    s = 0.0
    a = motions[row.body_a]
    b = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * a.path[i] + row.jacobian_b[i] * b.path[i]
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
        row.flight = a
        return _NEVER
    row.flight = GROUNDED
    speed = -(u + a * time)
    if speed <= 1e-12 * (abs(u) + abs(a) * h):
        return _NEVER
    if _comes_to_rest(speed, restitution, max(-a, pull), h - time):
        return _NEVER
    return time


@njit
def _respond(row: Any, size: Any, tree: Any, blocks: Any, impulse: Any) -> None:
    """x of the tree: the velocities that an impulse on a row gives to the bodies of joints."""
    clear_sides(size, tree)
    add_force(row, tree, impulse)
    substitute(size, tree, blocks)


@njit
def _couple(row: Any, other: Any, motions: Any, size: Any, tree: Any, blocks: Any) -> Any:
    """J_row M^-1 J_other^T of two rows on the same pair of bodies, with the joints of theirs."""
    s = 0.0
    free_a = True
    free_b = True
    if tree is not None:
        if size > 0:
            _respond(other, size, tree, blocks, 1.0)
            s = change_of(row, tree)
            free_a = tree[row.body_a].place < 0
            free_b = tree[row.body_b].place < 0
    inverse_a = motions[row.body_a].inverse
    inverse_b = motions[row.body_b].inverse
    for i in range(len(row.jacobian_a)):
        if free_a:
            s += row.jacobian_a[i] * (inverse_a[i] * other.jacobian_a[i])
        if free_b:
            s += row.jacobian_b[i] * (inverse_b[i] * other.jacobian_b[i])
    return s


@njit
def _kick(row: Any, bodies: Any, motions: Any, impulse: Any, time: Any) -> None:
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    ma = motions[row.body_a]
    mb = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        da = ma.inverse[i] * row.jacobian_a[i] * impulse
        db = mb.inverse[i] * row.jacobian_b[i] * impulse
        a.velocity[i] += da
        b.velocity[i] += db
        ma.shift[i] -= time * da
        mb.shift[i] -= time * db


@njit
def _kick_tree(
    row: Any, bodies: Any, motions: Any, impulse: Any, time: Any, size: Any, tree: Any, blocks: Any
) -> None:
    """``_kick`` felt through joints."""
    _respond(row, size, tree, blocks, impulse)
    for p in range(size):
        body = tree[p].order
        for i in range(len(tree[p].x)):
            bodies[body].velocity[i] += tree[p].x[i]
            motions[body].shift[i] -= time * tree[p].x[i]
    for side in range(2):
        body = row.body_a if side == 0 else row.body_b
        if tree[body].place < 0:
            jacobian = row.jacobian_a if side == 0 else row.jacobian_b
            for i in range(len(jacobian)):
                response = motions[body].inverse[i] * jacobian[i]
                bodies[body].velocity[i] += response * impulse
                motions[body].shift[i] -= time * response * impulse


@njit
def _add(
    row: Any, bodies: Any, motions: Any, impulse: Any, time: Any, size: Any, tree: Any, blocks: Any
) -> None:
    ma = motions[row.body_a]
    mb = motions[row.body_b]
    if tree is None:
        _kick(row, bodies, motions, impulse, time)
    elif size > 0:
        _kick_tree(row, bodies, motions, impulse, time, size, tree, blocks)
    else:
        _kick(row, bodies, motions, impulse, time)
    if ma.inverse[0] > 0.0 and (row.jacobian_a[0] != 0.0 or row.jacobian_a[1] != 0.0):
        ma.event_time = time  # not of the ground, which takes part in many at once
    if mb.inverse[0] > 0.0 and (row.jacobian_b[0] != 0.0 or row.jacobian_b[1] != 0.0):
        mb.event_time = time


@njit
def _contact_impulse(
    normal: Any, tangent: Any, un: Any, ut: Any, restitution: Any, motions: Any, size: Any, tree: Any, blocks: Any
) -> Any:
    """(normal, tangential) impulse that turns approach speed un into -restitution un, with friction."""
    knn = _couple(normal, normal, motions, size, tree, blocks)
    ktt = _couple(tangent, tangent, motions, size, tree, blocks)
    knt = _couple(normal, tangent, motions, size, tree, blocks)
    target = -(1.0 + restitution) * un
    det = knn * ktt - knt * knt
    if det <= 10.0 * EPSILON * knn * ktt:  # joints leave one way to go: normal and tangent are one
        return target / knn, 0.0
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
    if work >= 0.0:
        return target / knn, 0.0
    if work + 0.5 * twice > 0.0:  # energy guard
        scale = -2.0 * work / twice
        pn *= scale
        pt *= scale
    return pn, pt


@njit
def _pair_impulses(
    rows: Any, r: Any, q: Any, u: Any, v: Any, e: Any, motions: Any, size: Any, tree: Any, blocks: Any
) -> Any:
    """Normal impulses of the two contacts of one manifold, hit at once: 2x2 complementarity."""
    a = _couple(rows[r], rows[r], motions, size, tree, blocks)
    d = _couple(rows[q], rows[q], motions, size, tree, blocks)
    c = _couple(rows[r], rows[q], motions, size, tree, blocks)
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
def _partner(rows: Any, r: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, time: Any) -> Any:
    """Row of the manifold's other contact if it is hit at the same time, else -1."""
    here = contacts[rows[r].source]
    before = r - (rows[r - 1].kind == FRICTION) - 1 if r > first else first
    for side in range(2):
        q = before if side == 0 else r + int(rows[r].span)
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
def _friction_impulse(
    tangent: Any, bodies: Any, motions: Any, time: Any, pn: Any, size: Any, tree: Any, blocks: Any
) -> Any:
    u = relative_velocity(tangent, bodies[tangent.body_a], bodies[tangent.body_b])
    u += time * _acceleration(tangent, motions)
    bound = tangent.friction * pn
    return min(max(-u / _couple(tangent, tangent, motions, size, tree, blocks), -bound), bound)


@njit
def _apply_impact(
    rows: Any, r: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, time: Any, size: Any,
    tree: Any, blocks: Any,
) -> None:  # fmt: skip
    normal = rows[r]
    contact = contacts[normal.source]
    un = relative_velocity(normal, bodies[normal.body_a], bodies[normal.body_b])
    un += time * _acceleration(normal, motions)
    q = _partner(rows, r, first, end, contacts, bodies, motions, time)
    if q >= 0:
        other = rows[q]
        uq = relative_velocity(other, bodies[other.body_a], bodies[other.body_b])
        uq += time * _acceleration(other, motions)
        x, y = _pair_impulses(rows, r, q, un, uq, contact.restitution, motions, size, tree, blocks)
        if x > 0.0:
            _add(normal, bodies, motions, x, time, size, tree, blocks)
            _add(other, bodies, motions, y, time, size, tree, blocks)
            for k in range(2):
                n = r if k == 0 else q
                pn = x if k == 0 else y
                total = contacts[rows[n].source].total_impulse
                total[0] += pn
                if rows[n].span == 2:
                    pt = _friction_impulse(rows[n + 1], bodies, motions, time, pn, size, tree, blocks)
                    _add(rows[n + 1], bodies, motions, pt, time, size, tree, blocks)
                    total[1] += pt
            return
    if normal.span == 1:
        pn = -(1.0 + contact.restitution) * un / _couple(normal, normal, motions, size, tree, blocks)
        _add(normal, bodies, motions, pn, time, size, tree, blocks)
        contact.total_impulse[0] += pn
        return
    tangent = rows[r + 1]
    ut = relative_velocity(tangent, bodies[tangent.body_a], bodies[tangent.body_b])
    ut += time * _acceleration(tangent, motions)
    pn, pt = _contact_impulse(normal, tangent, un, ut, contact.restitution, motions, size, tree, blocks)
    _add(normal, bodies, motions, pn, time, size, tree, blocks)
    _add(tangent, bodies, motions, pt, time, size, tree, blocks)
    contact.total_impulse[0] += pn
    contact.total_impulse[1] += pt


@njit
def set_paths(rows: Any, end: Any, motions: Any, size: Any, tree: Any, blocks: Any, h: Any) -> None:
    """Accelerations along the joints: (M + E^T s^-1 E) x = M a - E^T s^-1 dE/dt v; a row's bias is h/2 dE/dt v."""
    clear_sides(size, tree)
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.diagonal > 0.0:
            add_force(row, tree, -2.0 * row.bias / (h * EPSILON * row.diagonal))
    for p in range(size):
        motion = motions[tree[p].order]
        for i in range(len(motion.path)):
            for j in range(len(motion.path)):
                tree[p].x[i] += motion.mass_matrix[i, j] * motion.acceleration[j]
    substitute(size, tree, blocks)
    for p in range(size):
        motion = motions[tree[p].order]
        for i in range(len(motion.path)):
            motion.path[i] = tree[p].x[i]


@njit
def _meet_joints(rows: Any, end: Any, bodies: Any, size: Any, tree: Any, blocks: Any) -> Any:
    """Take from the velocities what breaks the joints: an impact would feel it as approach."""
    for r in range(end):
        rows[r].bias *= -1.0  # seen from the substep's start
    solve_equations(rows, end, bodies, size, tree, blocks, 0.0, None)


@njit
def resolve_impacts(
    rows: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, indices: Any, pull: Any, h: Any,
    size: Any, tree: Any, blocks: Any,
) -> Any:  # fmt: skip
    """All impacts of one island within the substep. Returns how many there were.

    ``rows[first:end]`` are its contact rows with fresh errors; ``pull`` = |gravity|, m/s^2; ``size``,
    ``tree``, ``blocks``: the factor of the island's joints, which share an impact at once.
    """
    for k in range(len(indices)):
        motions[indices[k]].event_time = 0.0
    for r in range(first, end):
        motions[rows[r].body_a].event_time = 0.0
        motions[rows[r].body_b].event_time = 0.0
    if end - first > 2 * ORDERED_LIMIT:
        return _impacts_in_passes(rows, first, end, contacts, bodies, motions, pull, h, size, tree, blocks)
    count = 0
    met = tree is None or size == 0
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
        if tree is not None:
            if not met:
                _meet_joints(rows, first, bodies, size, tree, blocks)
                met = True
                continue
        _apply_impact(rows, best, first, end, contacts, bodies, motions, earliest, size, tree, blocks)
        count += 1
    return count


@njit
def _impacts_in_passes(
    rows: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, pull: Any, h: Any, size: Any,
    tree: Any, blocks: Any,
) -> Any:  # fmt: skip
    """Many contacts: in the order of the rows, pass after pass, at linear cost."""
    count = 0
    met = tree is None or size == 0
    for _ in range(MAX_PASSES):
        before = count
        for r in range(first, end):
            if rows[r].kind == FRICTION:
                continue
            time = _impact_time(rows, r, contacts, bodies, motions, pull, h)
            if time > h:
                continue
            if tree is not None:
                if not met:
                    _meet_joints(rows, first, bodies, size, tree, blocks)
                    met = True
                    time = _impact_time(rows, r, contacts, bodies, motions, pull, h)
            if time <= h:
                _apply_impact(rows, r, first, end, contacts, bodies, motions, time, size, tree, blocks)
                count += 1
        if count == before:
            break
    return count
