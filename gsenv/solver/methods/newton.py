"""Guarded Newton: all rows and friction cones of a small island at once, in body space.

Each pass minimises the convex f(v) = |v - v_free|_M^2 / 2 + sum phi(u), u = J v + bias - R p + lift, where
-phi'(u) is the projection of -u / R on the set of admissible impulses: an interval for a bounded row, all
numbers for an equation, the cone {|t| <= mu n} for a contact.  p are the impulses that the pass starts from:
passes are steps of the proximal point method, so R = epsilon A_rr does not change their limit.

With lift = 0 a contact would obey the convex law of maximum dissipation in (n, t), which couples the normal
velocity to the slip: sliding bodies would separate at mu |u_t|.  De Saxce's lift = mu |u_t|, taken from the velocity at
the start of each pass, makes Coulomb's law the fixed point of the passes.

A pass that has converged removes energy whatever its lift; one that has not may have any energy, and its
impulses are never used.  Accelerated sweeps continue from the last pass that converged, or from the warm
start if none has; they also solve large islands and those whose rows may contradict each other.

Anitescu, "Optimization-based simulation of nonsmooth rigid multibody dynamics", Math. Program. 105 (2006);
Acary, Cadoux, Lemarechal, Malick, "A formulation of the linear discrete Coulomb friction problem via
convex optimization", ZAMM 91 (2011); Rockafellar, "Monotone operators and the proximal point
algorithm", SIAM J. Control Optim. 14 (1976).
"""

from __future__ import annotations

from typing import Any

from ..core.rows import EQUATION, FRICTION, apply_impulse, free_rate, relative_velocity, row_product
from ..jit import njit
from .cholesky import (
    ANY_COST,
    add_force,
    add_product,
    add_stiffness,
    change_of,
    factorise,
    forget_factor,
    load_masses,
    plan_factor,
    substitute,
)
from .nncg import solve_nncg
from .pgs import sweep

EPSILON = 1e-3  # R as a fraction of A_rr; smaller: fewer passes, but more steps in each
EQUATION_EPSILON = 1e-6  # the same of equations, which are always active and cost no step
INNER = 0.01 * EQUATION_EPSILON  # of the tolerance: decrement at which a pass has converged
MOST_BODIES = 30
MOST_STEPS = 30  # largest number of Newton steps of all passes
LINE_STEPS = 12
LINE_TOLERANCE = 0.01  # of the slope at the start of the line search
OPEN = 0
STICKS = 1
SLIDES = 2


@njit
def _is_contact(rows: Any, r: Any, count: Any) -> Any:
    """Whether rows r and r + 1 are one contact with friction."""
    return r + 1 < count and rows[r + 1].kind == FRICTION


@njit
def _regularisation(rows: Any, r: Any, count: Any) -> Any:
    """Return R of a row without its softness, equal for both rows of a contact so that its cone stays round."""
    if _is_contact(rows, r, count):
        return 0.5 * EPSILON * (rows[r].diagonal + rows[r + 1].diagonal)
    epsilon = EQUATION_EPSILON if rows[r].kind == EQUATION else EPSILON
    return epsilon * (rows[r].diagonal - rows[r].softness)


@njit
def _bounded_impulse(rows: Any, r: Any, count: Any, u: Any) -> Any:
    """Return (impulse, its derivative -d/du) of a single row."""
    row = rows[r]
    compliance = _regularisation(rows, r, count) + row.softness
    x = -u / compliance
    if x < row.lower:
        return row.lower, 0.0
    if x > row.upper:
        return row.upper, 0.0
    return x, 1.0 / compliance


@njit
def _contact_impulse(rows: Any, r: Any, count: Any, un: Any, ut: Any) -> Any:
    """Return (normal, tangential, state): the nearest point of the cone to -u / R."""
    mu = rows[r + 1].friction
    compliance = _regularisation(rows, r, count)
    x = -un / compliance
    y = -ut / compliance
    if abs(y) <= mu * x:
        return x, y, STICKS
    if mu * abs(y) <= -x:
        return 0.0, 0.0, OPEN
    n = (x + mu * abs(y)) / (1.0 + mu * mu)
    return n, mu * n if y > 0.0 else -mu * n, SLIDES


@njit
def _start_pass(rows: Any, count: Any, bodies: Any) -> None:
    """Set the constant part of u in ``position_impulse``, which is unused before the position pass."""
    for r in range(count):
        row = rows[r]
        if row.kind == FRICTION:
            compliance = _regularisation(rows, r - 1, count)
        else:
            compliance = _regularisation(rows, r, count)
        slip = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
        row.position_impulse = slip + row.bias - compliance * row.impulse
        if row.kind == FRICTION:
            rows[r - 1].position_impulse += row.friction * abs(slip)


@njit
def _finish_pass(rows: Any, count: Any) -> None:
    """Set the impulses of the pass."""
    for r in range(count):
        row = rows[r]
        if row.kind == FRICTION or row.diagonal <= 0.0:
            continue
        u = row.position_impulse
        if _is_contact(rows, r, count):
            row.impulse, rows[r + 1].impulse, _ = _contact_impulse(rows, r, count, u, rows[r + 1].position_impulse)
        else:
            row.impulse, _ = _bounded_impulse(rows, r, count, u)


@njit
def apply_impulses(rows: Any, count: Any, island_bodies: Any, bodies: Any, substep_bodies: Any) -> None:
    """Set v = v_free + M^-1 J^T impulses."""
    for k in range(len(island_bodies)):
        velocity = bodies[island_bodies[k]].velocity
        for i in range(len(velocity)):
            velocity[i] = substep_bodies[island_bodies[k]].free_velocity[i]
    for r in range(count):
        row = rows[r]
        if row.impulse != 0.0:
            apply_impulse(row, bodies[row.body_a], bodies[row.body_b], row.impulse)


@njit
def _potential(rows: Any, count: Any, length: Any) -> Any:
    """Return sum phi(u + length * direction)."""
    s = 0.0
    for r in range(count):
        row = rows[r]
        if row.kind == FRICTION or row.diagonal <= 0.0:
            continue
        u = row.position_impulse + length * row.direction
        compliance = _regularisation(rows, r, count)
        if _is_contact(rows, r, count):
            ut = rows[r + 1].position_impulse + length * rows[r + 1].direction
            n, t, _ = _contact_impulse(rows, r, count, u, ut)
            s -= n * u + t * ut + 0.5 * compliance * (n * n + t * t)
        else:
            x, _ = _bounded_impulse(rows, r, count, u)
            s -= x * (u + 0.5 * (compliance + row.softness) * x)
    return s


@njit
def _start_cheaper(rows: Any, count: Any, island_bodies: Any, bodies: Any, substep_bodies: Any) -> None:
    """Start from the warm-started or the free velocity, whichever has the smaller f."""
    cost = 0.0
    for k in range(len(island_bodies)):
        motion = substep_bodies[island_bodies[k]]
        v = bodies[island_bodies[k]].velocity
        free = motion.free_velocity
        for i in range(len(v)):
            for j in range(len(v)):
                cost += 0.5 * motion.mass_matrix[i, j] * (v[i] - free[i]) * (v[j] - free[j])
    for r in range(count):
        row = rows[r]
        a = bodies[row.body_a].velocity
        b = bodies[row.body_b].velocity
        row.direction = free_rate(row, substep_bodies) - row_product(row, a, b)
    if _potential(rows, count, 1.0) < cost + _potential(rows, count, 0.0):
        for r in range(count):
            rows[r].position_impulse += rows[r].direction
        for k in range(len(island_bodies)):
            v = bodies[island_bodies[k]].velocity
            for i in range(len(v)):
                v[i] = substep_bodies[island_bodies[k]].free_velocity[i]


@njit
def _build(rows: Any, count: Any, bodies: Any, substep_bodies: Any, n: Any, factor: Any, blocks: Any) -> None:
    """Set H to the Hessian of f and x to its negative gradient."""
    load_masses(n, factor, blocks, substep_bodies)
    for p in range(n):
        motion = substep_bodies[factor[p].order]
        v = bodies[factor[p].order].velocity
        for i in range(len(v)):
            for j in range(len(v)):
                factor[p].x[i] -= motion.mass_matrix[i, j] * (v[j] - motion.free_velocity[j])
    for r in range(count):
        row = rows[r]
        if row.kind == FRICTION or row.diagonal <= 0.0:
            continue
        if not _is_contact(rows, r, count):
            x, slope = _bounded_impulse(rows, r, count, row.position_impulse)
            add_force(row, factor, x)
            if slope > 0.0:
                add_stiffness(row, factor, blocks, slope)
            continue
        tangent = rows[r + 1]
        x, y, state = _contact_impulse(rows, r, count, row.position_impulse, tangent.position_impulse)
        if state == OPEN:
            continue
        add_force(row, factor, x)
        add_force(tangent, factor, y)
        slope = 1.0 / _regularisation(rows, r, count)
        if state == STICKS:
            add_stiffness(row, factor, blocks, slope)
            add_stiffness(tangent, factor, blocks, slope)
        else:  # only along the edge (1, +-mu) of the cone
            mu = tangent.friction if y > 0.0 else -tangent.friction
            slope /= 1.0 + mu * mu
            add_stiffness(row, factor, blocks, slope)
            add_product(row, tangent, factor, blocks, mu * slope)
            add_product(tangent, row, factor, blocks, mu * slope)
            add_stiffness(tangent, factor, blocks, mu * mu * slope)


@njit
def _slope_and_curve(rows: Any, count: Any, length: Any) -> Any:
    """Return the first and second derivative of sum phi along ``direction``."""
    slope = 0.0
    curve = 0.0
    for r in range(count):
        row = rows[r]
        if row.kind == FRICTION or row.diagonal <= 0.0:
            continue
        s = row.direction
        u = row.position_impulse + length * s
        if not _is_contact(rows, r, count):
            x, k = _bounded_impulse(rows, r, count, u)
            slope -= x * s
            curve += k * s * s
            continue
        st = rows[r + 1].direction
        x, y, state = _contact_impulse(rows, r, count, u, rows[r + 1].position_impulse + length * st)
        slope -= x * s + y * st
        k = 1.0 / _regularisation(rows, r, count)
        if state == STICKS:
            curve += k * (s * s + st * st)
        elif state == SLIDES:
            mu = rows[r + 1].friction if y > 0.0 else -rows[r + 1].friction
            curve += k * (s + mu * st) ** 2 / (1.0 + mu * mu)
    return slope, curve


@njit
def _kinetic_derivatives(bodies: Any, substep_bodies: Any, n: Any, factor: Any) -> Any:
    """Return x . M (v - v_free) and x . M x."""
    slope = 0.0
    curve = 0.0
    for p in range(n):
        motion = substep_bodies[factor[p].order]
        v = bodies[factor[p].order].velocity
        x = factor[p].x
        for i in range(len(x)):
            for j in range(len(x)):
                slope += x[i] * motion.mass_matrix[i, j] * (v[j] - motion.free_velocity[j])
                curve += x[i] * motion.mass_matrix[i, j] * x[j]
    return slope, curve


@njit
def _is_exact(rows: Any, count: Any) -> Any:
    """Whether f is one quadratic function over the whole step of length 1."""
    for r in range(count):
        row = rows[r]
        if row.kind == FRICTION or row.diagonal <= 0.0:
            continue
        u = row.position_impulse
        if _is_contact(rows, r, count):
            ut = rows[r + 1].position_impulse
            _, y, state = _contact_impulse(rows, r, count, u, ut)
            _, z, after = _contact_impulse(rows, r, count, u + row.direction, ut + rows[r + 1].direction)
            if state != after or (state == SLIDES and y * z < 0.0):
                return False
        else:
            x, slope = _bounded_impulse(rows, r, count, u)
            y, after = _bounded_impulse(rows, r, count, u + row.direction)
            if slope != after or (slope == 0.0 and x != y):
                return False
    return True


@njit
def newton_step(rows: Any, count: Any, bodies: Any, scratch: Any) -> Any:
    """Take one step to the minimum of f along the Newton direction.

    Returns the decrement -x . grad f, 0 where the step was exact, NaN where none could be taken.
    """
    substep_bodies = scratch.substep_bodies
    factor = scratch.factor.entries
    blocks = scratch.factor.blocks
    n = scratch.factor.plan.size
    _build(rows, count, bodies, substep_bodies, n, factor, blocks)
    if not factorise(n, factor, blocks):
        return float("nan")
    substitute(n, factor, blocks)
    for r in range(count):
        rows[r].direction = change_of(rows[r], factor)
    first, second = _kinetic_derivatives(bodies, substep_bodies, n, factor)
    start, _ = _slope_and_curve(rows, count, 0.0)
    start += first
    low = 0.0
    high = float("inf")
    length = 1.0
    for _ in range(LINE_STEPS):
        slope, curve = _slope_and_curve(rows, count, length)
        slope += first + length * second
        if abs(slope) <= LINE_TOLERANCE * abs(start):
            break
        if slope < 0.0:
            low = length
        else:
            high = length
        length -= slope / (curve + second)
        if not low < length < high:
            length = 0.5 * (low + high)
    exact = length == 1.0 and _is_exact(rows, count)
    for p in range(n):
        v = bodies[factor[p].order].velocity
        for i in range(len(v)):
            v[i] += length * factor[p].x[i]
    for r in range(count):
        rows[r].position_impulse += length * rows[r].direction
    return 0.0 if exact else -start


@njit
def _solve_pass(rows: Any, count: Any, bodies: Any, most: Any, goal: Any, scratch: Any) -> Any:
    """Take at most ``most`` steps; returns (steps, whether the pass converged)."""
    for k in range(most):
        decrement = newton_step(rows, count, bodies, scratch)
        if decrement <= INNER * goal:
            return k + 1, True
        if not decrement > 0.0:  # NaN
            break
    return most, False


@njit
def solve_newton(
    rows: Any,
    count: Any,
    bodies: Any,
    island_bodies: Any,
    scratch: Any,
    kinematic_contact: Any,
    joint_factor: Any,
    limits: Any,
) -> Any:
    """Take passes until a plain sweep changes less than the tolerance. Returns (steps and sweeps, residual).

    A warm start within the tolerance costs one sweep and no factor.  ``limits`` as for ``solve_pgs``; the
    number of sweeps applies to islands that are solved by sweeps.
    """
    _, tolerance, scale = limits
    if kinematic_contact or len(island_bodies) > MOST_BODIES:
        return solve_nncg(rows, count, bodies, island_bodies, joint_factor, limits)
    goal = tolerance * tolerance * scale
    change = sweep(rows, count, bodies, joint_factor, 0.01 * goal, None)
    if change <= goal:
        return 1, (change / scale) ** 0.5
    substep_bodies = scratch.substep_bodies
    factor = scratch.factor
    entries = factor.entries
    factor.plan.size, _ = plan_factor(rows, count, False, island_bodies, entries, factor.graph, factor.blocks, ANY_COST)
    left = MOST_STEPS
    used = 1
    converged = factor.plan.size > 0
    while converged and left > 0 and change > goal:
        for r in range(count):
            rows[r].previous = rows[r].impulse
        _start_pass(rows, count, bodies)
        if left == MOST_STEPS:
            _start_cheaper(rows, count, island_bodies, bodies, substep_bodies)
        steps, converged = _solve_pass(rows, count, bodies, left, goal, scratch)
        left -= steps
        used += steps + 1
        if converged:
            _finish_pass(rows, count)
        else:
            for r in range(count):
                rows[r].impulse = rows[r].previous
        apply_impulses(rows, count, island_bodies, bodies, substep_bodies)
        change = sweep(rows, count, bodies, joint_factor, 0.01 * goal, None)
    forget_factor(island_bodies, entries)
    if change <= goal:
        return used, (change / scale) ** 0.5
    sweeps, residual = solve_nncg(rows, count, bodies, island_bodies, joint_factor, limits)
    return used + sweeps, residual
