"""Position pass: overlap and joint error leave through pseudo-velocities that are then discarded.

Real velocities stay untouched, so no energy is made.  Guendelman, Bridson, Fedkiw,
"Nonconvex rigid bodies with stacking", SIGGRAPH 2003, separate the two solves in the same way.
"""

from __future__ import annotations

from typing import Any

from .jit import njit
from .motion import LIMIT_SLOP, start_rate
from .rows import EQUATION, HELD, HELD_APART, UNHELD
from .solvers.cholesky import add_force, change_of, clear_sides, substitute
from .solvers.tree import give_of

REACH = 0.1  # rad, and of a body's radius: farthest that joints are drawn together in one sweep
SMOOTH = 1e-5  # of the extent: an overlap that the mean of velocities may add
SMOOTH_TURN = 0.05  # of the speed about each other: how fast the mean of velocities may open a joint


@njit
def correct_positions(
    rows: Any,
    count: Any,
    contact_first: Any,
    motions: Any,
    contacts: Any,
    bodies: Any,
    body_parameters: Any,
    options: Any,
    h: Any,
    smooth: Any,
    size: Any,
    tree: Any,
    blocks: Any,
) -> None:
    """Sweeps over the rows with an error; fills ``motion.correction``.

    Where the joints' factor exists (``size`` > 0) they come last in each sweep, as one exact block: what
    pushes overlapping bodies apart can't tear their joints; and the error taken back is that of the end
    of the substep, whose velocities are known.
    """
    exact = False
    if tree is not None:
        exact = size > 0
    apart = False
    for k in range(options.position_sweeps):
        if k == 0:
            busy, apart = _first_sweep(
                rows, count, contact_first, motions, contacts, bodies, options, h, smooth, exact
            )
            if not busy:
                return
        elif exact and not apart:
            break  # nothing but equations, which one solve takes exactly
        else:
            for r in range(count):
                _correct_row(rows[r], motions, exact)
        if tree is not None:
            if exact:
                _correct_equations(rows, contact_first, body_parameters, motions, size, tree, blocks, h)


@njit
def _first_sweep(
    rows: Any, count: Any, contact_first: Any, motions: Any, contacts: Any, bodies: Any, options: Any, h: Any,
    smooth: Any, exact: Any,
) -> Any:  # fmt: skip
    """Sets ``previous`` to the speed at which a row's error is taken back.

    Returns whether any row has one, and whether any of these holds bodies apart.
    """
    rate = options.correction_rate / h
    busy = False
    apart = False
    for r in range(count):
        row = rows[r]
        row.position_impulse = 0.0
        row.previous = 0.0
        if row.hold == HELD:
            row.previous = rate * row.error
            if exact:
                row.previous = row.error / h + _displacement_rate(row, bodies, motions, smooth, h) + row.drive
        elif row.hold == HELD_APART and r < contact_first:
            row.previous = rate * min(row.error, 0.0)
        elif row.hold == HELD_APART:
            extent = contacts[row.source].extent
            depth = row.error + options.slop * extent
            if depth < 0.0:
                row.previous = max(rate * depth, -options.push_speed * extent)
        if row.previous != 0.0:
            busy = True
            apart = apart or row.hold == HELD_APART
        if busy:  # else nothing has moved yet
            _correct_row(row, motions, exact)
    return busy, apart


@njit
def _displacement_rate(row: Any, bodies: Any, motions: Any, smooth: Any, h: Any) -> Any:
    """J times the displacement of the substep to come, over h."""
    s = 0.0
    for side in range(2):
        i = row.body_a if side == 0 else row.body_b
        jacobian = row.jacobian_a if side == 0 else row.jacobian_b
        motion = motions[i]
        for d in range(len(jacobian)):
            v = bodies[i].velocity[d]
            s += jacobian[d] * (v + 0.5 * smooth * (motion.start_velocity[d] - v) + motion.shift[d] / h)
    return s


@njit
def _correct_row(row: Any, motions: Any, exact: Any) -> None:
    if row.hold == UNHELD or (row.hold == HELD_APART and row.error > 0.0) or (row.hold == HELD and exact):
        return
    w = row.previous + _correction_of(row, motions)
    old = row.position_impulse
    new = old - row.effective_mass * w
    if row.hold == HELD_APART:
        new = max(new, 0.0)
    d = new - old
    row.position_impulse = new
    if d != 0.0:
        a = motions[row.body_a]
        b = motions[row.body_b]
        for i in range(len(row.jacobian_a)):
            a.correction[i] += a.inverse[i] * row.jacobian_a[i] * d
            b.correction[i] += b.inverse[i] * row.jacobian_b[i] * d


@njit
def _correction_of(row: Any, motions: Any) -> Any:
    """J times the pseudo-velocities."""
    s = 0.0
    a = motions[row.body_a]
    b = motions[row.body_b]
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * a.correction[i] + row.jacobian_b[i] * b.correction[i]
    return s


@njit
def _lengths(x: Any) -> Any:
    """Sums of the sizes of a vector's linear and angular numbers: (2, 1) of the plane, (3, 3) of space."""
    linear = 0.0
    angular = 0.0
    for d in range(len(x)):
        if d < (len(x) + 1) // 2:
            linear += abs(x[d])
        else:
            angular += abs(x[d])
    return linear, angular


@njit
def _correct_equations(
    rows: Any, end: Any, body_parameters: Any, motions: Any, size: Any, tree: Any, blocks: Any, h: Any
) -> None:
    """One Gauss-Newton step on the joints' errors, no longer than their linear model reaches."""
    clear_sides(size, tree)
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.diagonal > 0.0:
            add_force(row, tree, -_error_rate(row, motions) / give_of(row))
    substitute(size, tree, blocks)
    farthest = 1.0
    for p in range(size):
        x = tree[p].x
        radius = body_parameters[tree[p].order].radius
        linear, angular = _lengths(x)
        farthest = max(farthest, h * angular / REACH)
        if radius > 0.0:
            farthest = max(farthest, h * linear / (REACH * radius))
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.softness > 0.0:
            row.position_impulse -= (_error_rate(row, motions) + change_of(row, tree)) / (give_of(row) * farthest)
    for p in range(size):
        motion = motions[tree[p].order]
        for i in range(len(motion.correction)):
            motion.correction[i] += tree[p].x[i] / farthest


@njit
def _error_rate(row: Any, motions: Any) -> Any:
    """What the equation still lacks; a spring gives way."""
    return row.previous + _correction_of(row, motions) + row.softness * row.position_impulse


@njit
def _nothing_jumped(body_list: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any) -> Any:
    """Whether the change of velocity moves no point by more than the tolerance."""
    for k in range(len(body_list)):
        i = body_list[k]
        v = bodies[i].velocity
        u = motions[i].start_velocity
        jump = 0.0
        for d in range(len(v)):
            jump += abs(v[d] - u[d]) * (1.0 if d < (len(v) + 1) // 2 else body_parameters[i].radius)
        if 0.25 * h * jump > SMOOTH * body_parameters[i].extent:
            return False
    return True


@njit
def _mean_velocity(row: Any, bodies: Any, motions: Any) -> Any:
    """J (v_old + v_new) / 2."""
    s = 0.0
    a = bodies[row.body_a].velocity
    b = bodies[row.body_b].velocity
    start_a = motions[row.body_a].start_velocity
    start_b = motions[row.body_b].start_velocity
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * (a[i] + start_a[i]) + row.jacobian_b[i] * (b[i] + start_b[i])
    return 0.5 * s


@njit
def _turning(row: Any, bodies: Any, body_parameters: Any) -> Any:
    """How fast two bodies move about each other, which a smooth turn makes and takes."""
    a = bodies[row.body_a].velocity
    b = bodies[row.body_b].velocity
    speed = 0.0
    for d in range((len(a) + 1) // 2):
        speed += abs(b[d] - a[d])
    _, spin_a = _lengths(a)
    _, spin_b = _lengths(b)
    return speed + spin_a * body_parameters[row.body_a].radius + spin_b * body_parameters[row.body_b].radius


@njit
def smooth_fraction(
    rows: Any,
    contact_first: Any,
    count: Any,
    body_list: Any,
    bodies: Any,
    body_parameters: Any,
    motions: Any,
    contacts: Any,
    h: Any,
) -> Any:
    """1.0 if the mean of old and new velocity keeps every contact of the island apart, else 0.0.

    Where bodies slide, roll or fly, both velocities obey the contacts and their mean is second
    order.  Where one lands, the old velocity points into the other body: the new one alone counts.
    """
    if contact_first == 0 and _nothing_jumped(body_list, bodies, body_parameters, motions, h):
        return 1.0
    for r in range(contact_first):
        row = rows[r]
        if row.hold == UNHELD:
            continue
        opened = h * _mean_velocity(row, bodies, motions)
        turning = SMOOTH_TURN * _turning(row, bodies, body_parameters)
        bend = h * (turning + abs(row.bias))  # a row's bias is what it turns by
        if row.hold == HELD and abs(opened) > SMOOTH * body_parameters[row.body_b].extent + bend:
            return 0.0
        if row.hold == HELD_APART:
            taut = abs(start_rate(row, motions)) <= turning  # and not just arriving at the limit
            tolerance = LIMIT_SLOP + (h * turning if taut else 0.0)
            if row.error + opened < min(row.error, 0.0) - tolerance:
                return 0.0
    r = contact_first
    while r < count:
        row = rows[r]
        r += int(row.span)
        extent = contacts[row.source].extent
        after = row.error + h * _mean_velocity(row, bodies, motions)  # impacts' shift is in error
        if after < min(row.error, 0.0) - SMOOTH * extent:
            return 0.0
    return 1.0
