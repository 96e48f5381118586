"""Subspace step: solve the rows that sweeps found active as equations, at once and directly.

Silcowitz, Niebe, Erleben, "Projected Gauss-Seidel subspace minimization method for interactive
rigid body dynamics" (GRAPP 2010): sweeps find which rows are active, a direct solve on those rows
removes the slow modes (a leaning tower, a light body under a heavy one), sweeps correct the rest.

For the active rows, with w their present velocities and s = epsilon A_rr + softness,
(A + diag(s - softness)) d = -w  is solved for the change d of the impulses in body space:
(M + J^T s^-1 J) x = -J^T s^-1 w,  d = -(w + J x) / s.  epsilon makes redundant rows harmless: it holds
d near 0, so the step is exact in the limit of repeated steps whatever epsilon is.
The step is taken as far as it lowers the energy function that the solve minimises, or not at all;
rows that contradict each other (a body between a press and the ground) would have -epsilon A_rr d
left of their w, and are left to the sweeps.  Only islands that a moving kinematic body presses can
have such rows; elsewhere what is left over is a slow mode, which the next step goes on with.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import DISC, EQUATION, FRICTION, apply_impulse, on_disc
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
CONTRADICTION = 0.05  # part of sum w^2 / A_rr left over, above which rows cannot all be true
TRIALS = 3  # step lengths 1, 1/2, 1/4
FIRST_SWEEPS = 4  # before the first step
SWEEPS_BETWEEN = 4  # a step costs about as much as two or three sweeps


@njit
def _row_velocity(row: Any, bodies: Any) -> Any:
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    w = row.bias + row.softness * row.impulse
    for i in range(len(row.jacobian_a)):
        w += row.jacobian_a[i] * a.velocity[i] + row.jacobian_b[i] * b.velocity[i]
    return w


@njit
def _is_active(rows: Any, r: Any) -> Any:
    row = rows[r]
    if row.diagonal <= 0.0:
        return False
    if row.kind == FRICTION:
        return abs(row.impulse) < row.friction * rows[r - row.base].impulse
    if row.kind >= DISC:
        one = r if row.kind == DISC else r - 1
        bound = rows[one].friction * rows[one - rows[one].base].impulse
        return rows[one].impulse ** 2 + rows[one + 1].impulse ** 2 < bound * bound
    return row.lower < row.impulse < row.upper or row.kind == EQUATION


@njit
def _objective(rows: Any, count: Any, bodies_of: Any, bodies: Any, motions: Any) -> Any:
    """|v|_M^2 / 2 + bias . impulse + softness impulse^2 / 2: what exact rows minimise."""
    s = 0.0
    for k in range(len(bodies_of)):
        v = bodies[bodies_of[k]].velocity
        mass = motions[bodies_of[k]].mass_matrix
        for i in range(len(v)):
            for j in range(len(v)):
                s += 0.5 * mass[i, j] * v[i] * v[j]
    for r in range(count):
        row = rows[r]
        s += row.impulse * (row.bias + 0.5 * row.softness * row.impulse)
    return s


@njit
def _move(rows: Any, count: Any, bodies: Any, length: Any) -> None:
    """impulse = projection of previous + length * direction; velocities follow."""
    other = 0.0
    for r in range(count):
        row = rows[r]
        new = row.previous + length * row.direction
        if row.kind == FRICTION:
            bound = row.friction * rows[r - row.base].impulse
            new = min(max(new, -bound), bound)
        elif row.kind == DISC:
            bound = row.friction * rows[r - row.base].impulse
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
def subspace_step(
    rows: Any,
    count: Any,
    bodies: Any,
    bodies_of: Any,
    motions: Any,
    n: Any,
    factor: Any,
    blocks: Any,
    pressed: Any,
) -> Any:
    """One direct step on the active rows; True if it was taken. Bounds hold before and after."""
    load_masses(n, factor, blocks, motions)
    for r in range(count):
        row = rows[r]
        row.previous = row.impulse
        row.direction = 0.0
        if _is_active(rows, r):
            s = EPSILON * (row.diagonal - row.softness) + row.softness
            row.direction = _row_velocity(row, bodies)
            add_stiffness(row, factor, blocks, 1.0 / s)
            add_force(row, factor, -row.direction / s)
    if not factorise(n, factor, blocks):
        return False
    substitute(n, factor, blocks)
    violation = 0.0
    left = 0.0
    for r in range(count):
        row = rows[r]
        if _is_active(rows, r):
            w = row.direction
            hold = EPSILON * (row.diagonal - row.softness)
            row.direction = -(w + change_of(row, factor)) / (hold + row.softness)
            violation += w * w / row.diagonal
            left += (hold * row.direction) ** 2 / row.diagonal
    if pressed and left > CONTRADICTION * violation:
        return False
    before = _objective(rows, count, bodies_of, bodies, motions)
    length = 1.0
    for _ in range(TRIALS):
        _move(rows, count, bodies, length)
        if _objective(rows, count, bodies_of, bodies, motions) <= before:
            return True
        length *= 0.5
    _move(rows, count, bodies, 0.0)
    return False


@njit
def solve_subspace(
    rows: Any,
    count: Any,
    bodies: Any,
    max_sweeps: Any,
    tolerance: Any,
    scale: Any,
    bodies_of: Any,
    motions: Any,
    factor: Any,
    edges: Any,
    blocks: Any,
    pressed: Any,
    trees: Any,
    tree: Any,
    tree_blocks: Any,
) -> Any:
    """Accelerated sweeps with a subspace step after every few. Returns (sweeps, residual).

    A warm start that passes costs one sweep and no factor; an island too entangled for the
    factor is solved by sweeps alone.
    """
    first = min(FIRST_SWEEPS, max_sweeps)
    used, residual = solve_nncg(rows, count, bodies, first, tolerance, scale, bodies_of, trees, tree, tree_blocks)
    if residual <= tolerance or used >= max_sweeps:
        return used, residual
    n = plan_factor(rows, count, False, bodies_of, factor, edges, blocks)
    fits = n > 0
    while fits and residual > tolerance and used < max_sweeps:
        fits = subspace_step(rows, count, bodies, bodies_of, motions, n, factor, blocks, pressed)
        sweeps = min(SWEEPS_BETWEEN, max_sweeps - used)
        more, residual = solve_nncg(rows, count, bodies, sweeps, tolerance, scale, bodies_of, trees, tree, tree_blocks)
        used += more
    forget_factor(bodies_of, factor)
    if residual > tolerance and used < max_sweeps:
        rest = max_sweeps - used
        more, residual = solve_nncg(rows, count, bodies, rest, tolerance, scale, bodies_of, trees, tree, tree_blocks)
        used += more
    return used, residual
