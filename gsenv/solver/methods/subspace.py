"""Subspace step: solve the rows that sweeps found active as equations, directly.

Silcowitz, Niebe, Erleben, "Projected Gauss-Seidel subspace minimization method for interactive
rigid body dynamics" (GRAPP 2010): sweeps find which rows are active, a direct solve on those rows
removes the slow modes (a leaning tower, a light body under a heavy one), sweeps correct the rest.

For the active rows, with w their present velocities and s = epsilon A_rr + softness,
(A + diag(s - softness)) d = -w  is solved for the change d of the impulses in body space:
(M + J^T s^-1 J) x = -J^T s^-1 w,  d = -(w + J x) / s.  epsilon makes redundant rows harmless: it
keeps d small, so repeated steps converge to the exact solution whatever s is.

Sweeps leave the loads of redundant contacts, such as the four corners of a box, as uneven as their order made them,
and a direct step that changes them little then asks corners to pull.  A step in an island that moves therefore solves
(A + diag(s - softness)) d = -(w + c A_rr p), which draws the impulses p towards zero and so shares loads evenly
(Tikhonov, "Solution of incorrectly formulated problems and the regularization method", Soviet Math. Doklady 4 (1963)).
It leaves w = -c A_rr p; c is at most epsilon, and so small that this is about ``UNEVEN`` of the residual before.

Rows whose impulse is near a bound will mostly reach it and hold nothing then, but as equations they may ask for
impulses far beyond it: until the solve ends it is unknown which contacts between bricks side by side carry load.
Their s is larger, by g E / m^2, where m is the distance of the impulse from its bound and E the mean of w^2 / A_rr over
the active rows; so what is near a bound changes little, and the others hold.  This is the scaling of interior methods
(Coleman, Li, "An interior trust region approach for nonlinear minimization subject to bounds", SIAM Journal on
Optimization 6 (1996)).  A step that fails is repeated with a larger g.

Where many contacts slide, steps are taken once, without the draw, and end with the first that does not reduce the
residual: they take the bounds of friction, which follow the loads, as fixed.
A step that raises the energy function that the solve minimises is repeated without the rows that it left inactive,
then shortened, or not taken;
rows that contradict each other (a body between a press and the ground) would keep w = -epsilon A_rr d,
and are left to the sweeps.  In islands without contact with a moving kinematic body the remainder is mostly
a slow mode, which the next step reduces further.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..core.coupled import any_coupled
from ..core.rows import BOUNDED, DISC, EQUATION, FRICTION, apply_impulse, on_disc, row_velocity
from ..jit import njit
from .cholesky import (
    add_force,
    add_stiffness,
    change_of,
    factorise,
    forget_factor,
    load_masses,
    plan_factor,
    substitute,
)
from .nncg import solve_nncg

EPSILON = 1e-6
GIVES = (1e-5, 1.0, 1e4)  # g of a step, and of those after it has failed
MOVING_GIVES = 2  # how many of them where bodies move: in a pile that settles, what fails twice fails again
MOST_GIVE = 1e12  # most that s gains so, over A_rr
UNEVEN = 0.003  # of the residual: error that a step may leave to share loads evenly
CONTRADICTION = 0.05  # remaining fraction of sum w^2 / A_rr above which rows contradict each other
ROUNDS = 5  # direct steps, each on the rows that the one before left active
# Steps are the last that reduce less than NEARER of the rise of the energy function, or with which a share of SLIDING
# of the contacts slides, since the energy function ignores that bounds change:
NEARER = 0.5
SLIDING = 0.1
TRIALS = 2  # step lengths 1/2, 1/4
DRIFT = 0.1  # of the tolerance: root of the energy that bodies at rest may gain in a substep, on the scale of the rows
BACK = 0.05  # share of the stopped velocity with which the next step may start the other way
FIRST_SWEEPS = 4  # least number of sweeps before the first step
SWEEPS_BETWEEN = 4  # most sweeps between steps; also at most half of those that are left
DEAREST = 2.0  # of the most sweeps: islands whose step would cost more are left to the sweeps
DEAREST_SLIDING = 1.0 / 3.0  # the same where more than MANY of the contacts slide, as in a pile that moves:
MANY = 0.2  # such steps fail
SPENT = 4.0  # of the most sweeps: cost of the steps of a solve, after which it is left to the sweeps
TAKEN = 0  # outcomes of a step
FAILED = 1
CONTRADICTORY = 2  # the active rows contradict each other, or have no factor
# Measured cost of a step, in sweeps: that of the rows for each degree of freedom of a body, and that of a product of
# two blocks, in sweeps over one row, for the square of the degrees of freedom.
ROWS_COST = 0.65
PRODUCT_COST = 1.0 / 15.0


@njit
def _is_active(rows: Any, r: Any) -> Any:
    row = rows[r]
    if row.diagonal <= 0.0:
        return False
    if row.kind == FRICTION:
        return abs(row.impulse) < row.friction * rows[r - int64(row.base)].impulse
    if row.kind >= DISC:
        one = r if row.kind == DISC else r - 1
        bound = rows[one].friction * rows[one - int64(rows[one].base)].impulse
        return rows[one].impulse ** 2 + rows[one + 1].impulse ** 2 < bound * bound
    return row.lower < row.impulse < row.upper or row.kind == EQUATION


@njit
def _share_sliding(rows: Any, count: Any) -> Any:
    """Return the share of the loaded contacts that slide."""
    loaded = 0
    sliding = 0
    for r in range(count):
        row = rows[r]
        if (row.kind == FRICTION or row.kind == DISC) and rows[r - int64(row.base)].impulse > 0.0:
            loaded += 1
            if not _is_active(rows, r):
                sliding += 1
    return sliding / loaded if loaded > 0 else 0.0


@njit
def _objective(rows: Any, count: Any, island_bodies: Any, bodies: Any, substep_bodies: Any, carried: Any) -> Any:
    """Return |v|_M^2 / 2 + (bias + J u) . impulse + softness impulse^2 / 2, which the solution minimises.

    v are the velocities of the island's bodies; u is that of the only other body, if the island is ``carried``, else 0:
    between bodies that approach each other the function has no minimum.
    """
    s = 0.0
    for k in range(len(island_bodies)):
        v = bodies[island_bodies[k]].velocity
        mass = substep_bodies[island_bodies[k]].mass_matrix
        for i in range(len(v)):
            for j in range(len(v)):
                s += 0.5 * mass[i, j] * v[i] * v[j]
    for r in range(count):
        row = rows[r]
        given = row.bias
        if carried:
            given += _given_velocity(row.jacobian_a, bodies[row.body_a])
            given += _given_velocity(row.jacobian_b, bodies[row.body_b])
        s += row.impulse * (given + 0.5 * row.softness * row.impulse)
    return s


@njit
def _is_carried(rows: Any, count: Any, bodies: Any) -> Any:
    """Whether all contacts and joints with bodies that no impulse moves are with one and the same."""
    carrier = -1
    for r in range(count):
        for body in (rows[r].body_a, rows[r].body_b):
            fixed = True
            for i in range(len(bodies[body].inverse)):
                fixed = fixed and bodies[body].inverse[i] == 0.0
            if fixed and carrier >= 0 and body != carrier:
                return False
            if fixed:
                carrier = int64(body)
    return True


@njit
def _given_velocity(jacobian: Any, body: Any) -> Any:
    """Return J u of a body that no impulse moves; 0 of any other."""
    w = 0.0
    for i in range(len(jacobian)):
        if body.inverse[i] != 0.0:
            return 0.0
        w += jacobian[i] * body.velocity[i]
    return w


@njit
def _move(rows: Any, count: Any, bodies: Any, length: Any) -> None:
    """Set each impulse to the projection of previous + length * direction, and update the velocities."""
    other = 0.0
    for r in range(count):
        row = rows[r]
        new = row.previous + length * row.direction
        if row.kind == FRICTION:
            bound = row.friction * rows[r - int64(row.base)].impulse
            new = min(max(new, -bound), bound)
        elif row.kind == DISC:
            bound = row.friction * rows[r - int64(row.base)].impulse
            new, other = on_disc(new, rows[r + 1].previous + length * rows[r + 1].direction, bound)
        elif row.kind > DISC:
            new = other
        else:
            new = min(max(new, row.lower), row.upper)
        d = new - row.impulse
        if d != 0.0:
            row.impulse = new
            apply_impulse(row, bodies[row.body_a], bodies[row.body_b], d)


@njit
def _set_velocities(rows: Any, count: Any, bodies: Any) -> Any:
    """Set ``direction`` to w for active rows, else to 0; return E, the mean of their w^2 / A_rr."""
    total = 0.0
    active = 0
    for r in range(count):
        row = rows[r]
        row.direction = 0.0
        if _is_active(rows, r):
            row.direction = row_velocity(row, bodies)
            total += row.direction * row.direction / row.diagonal
            active += 1
    return total / active if active > 0 else 0.0


@njit
def _hold(rows: Any, r: Any, energy: Any) -> Any:
    """Return s - softness of an active row; ``energy`` is g E."""
    row = rows[r]
    rigid = row.diagonal - row.softness
    if energy <= 0.0:
        return EPSILON * rigid
    margin = _margin(rows, r)
    return rigid * (EPSILON + energy / (row.diagonal * margin * margin + energy / MOST_GIVE))


@njit
def _margin(rows: Any, r: Any) -> Any:
    """Return the distance of a row's impulse from the nearest of its bounds, in N s or N m s."""
    row = rows[r]
    if row.kind == FRICTION:
        return row.friction * rows[r - int64(row.base)].impulse - abs(row.impulse)
    if row.kind >= DISC:
        one = r if row.kind == DISC else r - 1
        bound = rows[one].friction * rows[one - int64(rows[one].base)].impulse
        return bound - (rows[one].impulse ** 2 + rows[one + 1].impulse ** 2) ** 0.5
    return min(row.impulse - row.lower, row.upper - row.impulse)


@njit
def _set_directions(rows: Any, count: Any, bodies: Any, scratch: Any, kinematic_contact: Any, step: Any) -> Any:
    """Set the direct step of the active rows; False where there is none, or where rows contradict each other."""
    draw, give = step
    substep_bodies = scratch.substep_bodies
    entries = scratch.factor.entries
    blocks = scratch.factor.blocks
    n = scratch.factor.plan.size
    load_masses(n, entries, blocks, substep_bodies)
    energy = give * _set_velocities(rows, count, bodies)
    for r in range(count):
        row = rows[r]
        row.previous = row.impulse
        if _is_active(rows, r):
            s = _hold(rows, r, energy) + row.softness
            row.direction += draw * (row.diagonal - row.softness) * row.impulse
            add_stiffness(row, entries, blocks, 1.0 / s)
            add_force(row, entries, -row.direction / s)
    if not factorise(n, entries, blocks):
        return False
    substitute(n, entries, blocks)
    violation = 0.0
    left = 0.0
    for r in range(count):
        row = rows[r]
        if _is_active(rows, r):
            w = row.direction
            hold = _hold(rows, r, energy)
            row.direction = -(w + change_of(row, entries)) / (hold + row.softness)
            violation += w * w / row.diagonal
            left += (hold * row.direction) ** 2 / row.diagonal
    return not (kinematic_contact and left > CONTRADICTION * violation)


@njit
def subspace_step(
    rows: Any, count: Any, bodies: Any, island_bodies: Any, scratch: Any, kinematic_contact: Any, step: Any
) -> Any:
    """Take a direct step on the active rows. Returns (outcome, factors it took). Bounds hold before and after.

    ``step``: (c, g), see above.
    A step that raises the energy function is followed by one on the rows that are still active after it, such as
    without the corners of a box that it lifts.  If these do not lower it in the end, a part of the way is tried.
    """
    substep_bodies = scratch.substep_bodies
    carried = kinematic_contact and _is_carried(rows, count, bodies)
    before = _objective(rows, count, island_bodies, bodies, substep_bodies, carried)
    for r in range(count):
        rows[r].position_impulse = rows[r].impulse  # for the way back
    last = np.inf
    straight = False  # whether directions are those of the first step
    factors = 0
    for k in range(ROUNDS):
        factors += 1
        if not _set_directions(rows, count, bodies, scratch, kinematic_contact, step):
            if k == 0:
                return CONTRADICTORY, factors
            break
        _move(rows, count, bodies, 1.0)
        after = _objective(rows, count, island_bodies, bodies, substep_bodies, carried)
        if after <= before:
            return TAKEN, factors
        if after - before > NEARER * (last - before) or _share_sliding(rows, count) > SLIDING:
            straight = k == 0
            break
        last = after
    if not straight:
        for r in range(count):
            rows[r].previous = rows[r].position_impulse
            rows[r].direction = rows[r].impulse - rows[r].previous
    length = 1.0
    for _ in range(TRIALS):
        length *= 0.5
        _move(rows, count, bodies, length)
        if _objective(rows, count, island_bodies, bodies, substep_bodies, carried) <= before:
            return TAKEN, factors
    _move(rows, count, bodies, 0.0)
    return FAILED, factors


@njit
def _gain(island_bodies: Any, bodies: Any, substep_bodies: Any) -> Any:
    """Return the gain of twice the kinetic energy in the substep."""
    gain = 0.0
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        v = bodies[i].velocity
        start = substep_bodies[i].start_velocity
        mass = substep_bodies[i].mass_matrix
        for d in range(len(v)):
            gain += mass[d, d] * (v[d] * v[d] - start[d] * start[d])
    return gain


@njit
def _set_stops(rows: Any, count: Any, bodies: Any, island_bodies: Any, scratch: Any, most: Any) -> Any:
    """Set ``direction`` of each row to the part of its impulse that the next step does not start from.

    That is most of what stopped the bodies: nothing is left to stop, and all of it would set them in motion the other
    way.  ``BACK`` of it does so: else a tower would creep to one side.  Returns False where the next step starts from
    all impulses: where the bodies were at rest before, and where to stay within the bounds of all contacts would
    change the impulses by more than the tolerance, ``most`` as the sum d^2 A_rr.
    """
    moved = False
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            bodies[i].start[d] = bodies[i].velocity[d]
            bodies[i].velocity[d] = scratch.substep_bodies[i].start_velocity[d]
            moved = moved or bodies[i].velocity[d] != 0.0
    known = moved and _set_directions(rows, count, bodies, scratch, False, (0.0, 0.0))
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        for d in range(len(bodies[i].velocity)):
            bodies[i].velocity[d] = bodies[i].start[d]
    for r in range(count):
        rows[r].direction *= 1.0 - BACK
    return known and _keep_bounds(rows, count) <= most


@njit
def _keep_bounds(rows: Any, count: Any) -> Any:
    """Reduce ``direction`` to where the contacts' impulses without it are within their bounds.

    The friction of contacts that slide follows their load: else bodies would creep.
    Returns sum d^2 A_rr of what this changed.
    """
    change = 0.0
    for r in range(count):
        row = rows[r]
        if row.kind == BOUNDED and row.direction > row.impulse:
            change += _reduce(row, row.impulse)
        if row.kind == FRICTION or row.kind == DISC:
            normal = rows[r - int64(row.base)]
            wide = row.kind == DISC
            if normal.impulse > 0.0 and not _is_active(rows, r):
                follow = normal.direction / normal.impulse
                change += _reduce(row, follow * row.impulse)
                if wide:
                    change += _reduce(rows[r + 1], follow * rows[r + 1].impulse)
            x = row.impulse - row.direction
            y = rows[r + 1].impulse - rows[r + 1].direction if wide else 0.0
            bound = row.friction * (normal.impulse - normal.direction)
            size = (x * x + y * y) ** 0.5
            part = bound / size if size > bound else 1.0
            change += _reduce(row, row.impulse - part * x)
            if wide:
                change += _reduce(rows[r + 1], rows[r + 1].impulse - part * y)
    return change


@njit
def _reduce(row: Any, direction: Any) -> Any:
    """Set ``direction``; returns d^2 A_rr of its change."""
    change = (row.direction - direction) ** 2 * row.diagonal
    row.direction = direction
    return change


@njit
def _draw(rows: Any, count: Any, residual: Any, scale: Any) -> Any:
    """Return c, with which a step shares loads evenly and leaves less than ``UNEVEN`` of the residual."""
    size = 0.0
    for r in range(count):
        size += (rows[r].diagonal - rows[r].softness) * rows[r].impulse ** 2
    return min(EPSILON, UNEVEN * residual * (scale / size) ** 0.5) if size > 0.0 else 0.0


@njit
def _plan_step(rows: Any, count: Any, island_bodies: Any, factor: Any, max_sweeps: Any) -> Any:
    """Lay out the factor of a step; returns how many sweeps a step costs, infinity where it would not pay."""
    ndof = len(rows[0].jacobian_a)
    fixed = ROWS_COST * ndof
    per_product = PRODUCT_COST * ndof * ndof / count
    most = int64(max((DEAREST * max_sweeps - fixed) / per_product, 0.0))
    factor.plan.size, products = plan_factor(
        rows, count, False, island_bodies, factor.entries, factor.graph, factor.blocks, most
    )
    return fixed + per_product * products if factor.plan.size > 0 else np.inf


@njit
def solve_subspace(
    rows: Any,
    count: Any,
    bodies: Any,
    island_bodies: Any,
    scratch: Any,
    kinematic_contact: Any,
    joint_factor: Any,
    limits: Any,
) -> Any:
    """Take accelerated sweeps, with a subspace step after every few. Returns (sweeps, residual).

    ``limits`` as for ``solve_pgs``.  A warm start within the tolerance costs one sweep and no factor.  The first step
    is taken when the sweeps have cost as much as it does: so a solve costs at most about twice as much as the cheaper
    of both ways (the ski-rental problem), or ``SPENT`` where steps do not settle it.  An island whose factor has too
    much fill-in is solved by sweeps alone.
    """
    max_sweeps, tolerance, scale = limits
    first = (min(FIRST_SWEEPS, max_sweeps), tolerance, scale)
    used, residual = solve_nncg(rows, count, bodies, island_bodies, joint_factor, first)
    most = (DRIFT * tolerance) ** 2 * scale
    drifts = scratch.island.calm and _gain(island_bodies, bodies, scratch.substep_bodies) > most
    if (residual <= tolerance and not drifts) or used >= max_sweeps:
        return used, residual
    factor = scratch.factor
    entries = factor.entries
    cost = _plan_step(rows, count, island_bodies, factor, max_sweeps)
    fits = cost < np.inf
    if joint_factor is not None:
        fits = fits and not any_coupled(rows, count)
    worth = int64(min(cost, max_sweeps - SWEEPS_BETWEEN))  # sweeps before the first step
    if fits and residual > tolerance and used < worth:
        more, residual = solve_nncg(rows, count, bodies, island_bodies, joint_factor, (worth - used, tolerance, scale))
        used += more
    left = SPENT * max_sweeps
    taken = False
    while fits and (residual > tolerance or drifts) and used < max_sweeps:
        drifts = False
        share = _share_sliding(rows, count)
        sliding = share > SLIDING
        if share > MANY and cost > DEAREST_SLIDING * max_sweeps:
            break
        # at rest, loads that are shared anew at each step would never keep
        draw = 0.0 if scratch.island.calm or sliding else _draw(rows, count, residual, scale)
        outcome = FAILED
        for k in range(len(GIVES) if scratch.island.calm else MOVING_GIVES):
            step = (draw, GIVES[k])
            outcome, factors = subspace_step(rows, count, bodies, island_bodies, scratch, kinematic_contact, step)
            left -= factors * cost
            draw = 0.0
            if outcome != FAILED or sliding or left <= 0.0:
                break
        next_few = (min(SWEEPS_BETWEEN, (max_sweeps - used + 1) // 2), tolerance, scale)
        before = residual
        more, residual = solve_nncg(rows, count, bodies, island_bodies, joint_factor, next_few)
        used += more
        taken = outcome == TAKEN
        fits = taken and left > 0.0 and (not sliding or residual < before)  # else sweeps do the rest
    if taken and scratch.island.calm and residual <= tolerance:
        scratch.island.stopped = _set_stops(rows, count, bodies, island_bodies, scratch, tolerance * tolerance * scale)
    forget_factor(island_bodies, entries)
    if residual > tolerance and used < max_sweeps:
        rest = (max_sweeps - used, tolerance, scale)
        more, residual = solve_nncg(rows, count, bodies, island_bodies, joint_factor, rest)
        used += more
    return used, residual
