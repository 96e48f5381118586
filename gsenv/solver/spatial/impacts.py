"""Impact phase: Newton impacts at their own times inside the substep, before the solve.

As in planar/impacts.py; the contacts of one manifold that are hit at the same time, a box landing on its
face, share the impact: Gauss-Seidel sweeps over their normals and friction discs until nothing changes.

Kane, "A dynamics puzzle", Stanford Mechanics Alumni Club 1984: Newton restitution with friction may
create energy; impulses are scaled so that the kinetic energy never grows.
"""

from __future__ import annotations

from typing import Any

from numba import int64

from ..jit import njit
from ..rows import DISC, EQUATION, GROUNDED, HELD_APART, relative_velocity
from ..solvers.cholesky import add_force, change_of, clear_sides, substitute
from ..solvers.disc import minimise_on_disc
from ..solvers.tree import EPSILON, solve_equations

_NEVER = 1e300
ORDERED_LIMIT = 48  # contacts up to which impacts are taken in order of time, at n^2 cost
MAX_PASSES = 8
GROUP_SWEEPS = 60  # of the contacts of one manifold, which are hit at once


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
def _pushes(jacobian: Any) -> Any:
    """Whether a row acts on a body's place, and not its turning alone."""
    return jacobian[0] != 0.0 or jacobian[1] != 0.0 or jacobian[2] != 0.0


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
    if ma.inverse[0] > 0.0 and _pushes(row.jacobian_a):
        ma.event_time = time  # not of the ground, which takes part in many at once
    if mb.inverse[0] > 0.0 and _pushes(row.jacobian_b):
        mb.event_time = time


@njit
def _manifold_start(rows: Any, r: Any, first: Any, contacts: Any) -> Any:
    """First row of the contacts that shapes of normal row r have with each other."""
    here = contacts[rows[r].source]
    start = r
    k = r - 1
    while k >= first:
        there = contacts[rows[k].source]
        if there.shape_a != here.shape_a or there.shape_b != here.shape_b:
            break
        if rows[k].hold == HELD_APART:
            start = k
        k -= 1
    return start


@njit
def _speed(row: Any, bodies: Any, motions: Any, time: Any) -> Any:
    u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
    return u + time * _acceleration(row, motions)


@njit
def _join(rows: Any, k: Any, r: Any, contacts: Any, bodies: Any, motions: Any, time: Any) -> None:
    """Whether the contact of row k is hit together with that of row r; speeds before, no impulse yet."""
    row = rows[k]
    u = _speed(row, bodies, motions, time)
    gap = row.error + _shifted(row, motions) + time * (u - 0.5 * _acceleration(row, motions) * time)
    hit = k == r or (gap < 1e-4 * contacts[row.source].extent and u < 0.0)
    for i in range(_sides(row, rows, k)):
        side = rows[k + i]
        side.direction = 1.0 if hit else 0.0
        side.position_impulse = 0.0
        side.previous = _speed(side, bodies, motions, time)


@njit
def _sides(row: Any, rows: Any, k: Any) -> Any:
    """1 for a contact without friction, 3 for one with it."""
    return 3 if row.span > 2 and rows[k + 1].kind == DISC else 1


@njit
def _hit(
    rows: Any, k: Any, restitution: Any, bodies: Any, motions: Any, time: Any, size: Any, tree: Any, blocks: Any
) -> Any:
    """Make one contact's approach -e times itself and stop its slip within friction; m/s that changed."""
    row = rows[k]
    mass = _couple(row, row, motions, size, tree, blocks)
    if mass <= 0.0:
        return 0.0
    lack = _speed(row, bodies, motions, time) + restitution * row.previous
    new = max(row.position_impulse - lack / mass, 0.0)
    d = new - row.position_impulse
    row.position_impulse = new
    _add(row, bodies, motions, d, time, size, tree, blocks)
    change = abs(d) * mass
    if _sides(row, rows, k) == 1:
        return change
    one = rows[k + 1]
    two = rows[k + 2]
    a = _couple(one, one, motions, size, tree, blocks)
    c = _couple(one, two, motions, size, tree, blocks)
    e = _couple(two, two, motions, size, tree, blocks)
    x = one.position_impulse
    y = two.position_impulse
    g = _speed(one, bodies, motions, time) - a * x - c * y
    h = _speed(two, bodies, motions, time) - c * x - e * y
    s, t = minimise_on_disc(a, c, e, g, h, one.friction * new)
    one.position_impulse = s
    two.position_impulse = t
    _add(one, bodies, motions, s - x, time, size, tree, blocks)
    _add(two, bodies, motions, t - y, time, size, tree, blocks)
    return change + abs(s - x) * a + abs(t - y) * e


@njit
def _guard(
    rows: Any, start: Any, stop: Any, bodies: Any, motions: Any, time: Any, size: Any, tree: Any, blocks: Any
) -> None:
    """Scale the impulses back to where they keep the kinetic energy, if they raised it."""
    work = 0.0
    change = 0.0
    for k in range(start, stop):
        p = rows[k].position_impulse
        if rows[k].direction == 1.0 and p != 0.0:
            work += p * rows[k].previous
            change += 0.5 * p * (_speed(rows[k], bodies, motions, time) - rows[k].previous)
    if work + change <= 0.0 or change <= 0.0:
        return
    scale = max(-work / change, 0.0)
    for k in range(start, stop):
        p = rows[k].position_impulse
        if rows[k].direction == 1.0 and p != 0.0:
            _add(rows[k], bodies, motions, (scale - 1.0) * p, time, size, tree, blocks)
            rows[k].position_impulse = scale * p


@njit
def _apply_impact(
    rows: Any, r: Any, first: Any, end: Any, contacts: Any, bodies: Any, motions: Any, time: Any, size: Any,
    tree: Any, blocks: Any,
) -> None:  # fmt: skip
    """The impact of normal row r, and of all contacts of its manifold that are hit at the same time."""
    here = contacts[rows[r].source]
    start = _manifold_start(rows, r, first, contacts)
    stop = start
    while stop < end:
        there = contacts[rows[stop].source]
        if there.shape_a != here.shape_a or there.shape_b != here.shape_b:
            break
        for k in range(stop, stop + int(rows[stop].span)):
            rows[k].direction = 0.0
        _join(rows, stop, r, contacts, bodies, motions, time)
        stop += int(rows[stop].span)
    enough = 1e-13 * abs(rows[r].previous)
    for _ in range(GROUP_SWEEPS):
        change = 0.0
        k = start
        while k < stop:
            if rows[k].direction == 1.0:
                change += _hit(rows, k, here.restitution, bodies, motions, time, size, tree, blocks)
            k += int(rows[k].span)
        if change <= enough:
            break
    _guard(rows, start, stop, bodies, motions, time, size, tree, blocks)
    k = start
    while k < stop:
        if rows[k].direction == 1.0:
            total = contacts[rows[k].source].total_impulse
            for i in range(_sides(rows[k], rows, k)):
                total[i] += rows[k + i].position_impulse
        k += int(rows[k].span)


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
    if end - first > 3 * ORDERED_LIMIT:
        return _impacts_in_passes(rows, first, end, contacts, bodies, motions, pull, h, size, tree, blocks)
    count = 0
    met = tree is None or size == 0
    for _ in range(8 + 2 * (end - first)):
        best = int64(-1)
        earliest = _NEVER
        for r in range(first, end):
            if rows[r].hold != HELD_APART:
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
            if rows[r].hold != HELD_APART:
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
