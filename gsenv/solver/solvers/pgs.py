"""Projected Gauss-Seidel: one pass over all rows after another, each row made true in turn.

Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005; Erleben, "Numerical methods for
linear complementarity problems in physics-based animation", SIGGRAPH 2013 course, section 4.2.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import DISC, EQUATION, FRICTION, push_row
from .disc import sweep_disc
from .tree import solve_equations


@njit
def sweep(
    rows: Any, count: Any, bodies: Any, trees: Any, tree: Any, tree_blocks: Any, enough: Any, push: Any
) -> Any:
    """One sweep. Returns sum d^2 A_rr, d the change of a row's impulse.

    That is the natural-map residual of the sweep in the metric of diag(A), squared, for free.
    ``trees`` = (rows of joints, size of their factor): where there is a factor, the equations are one
    exact block, solved first. ``tree`` is None in scenes that can have none.
    ``push``: None, or (beta, keep): first impulse += beta * direction, direction = beta * direction
    + (change of the last sweep if keep), for which ``previous`` holds the impulses before it.
    """
    change = 0.0
    normal = 0.0
    exact = False
    if tree is not None:
        exact = trees[1] > 0
        if exact:
            change = solve_equations(rows, trees[0], bodies, trees[1], tree, tree_blocks, enough, push)
    for r in range(count):
        row = rows[r]
        if exact and row.kind == EQUATION:
            continue
        if row.kind >= DISC:
            if row.kind == DISC:
                change += sweep_disc(rows, r, bodies, normal, push)
            continue
        if push is not None:
            push_row(row, push)
        a = bodies[row.body_a]
        b = bodies[row.body_b]
        old = row.impulse
        w = row.bias + row.softness * old
        for i in range(len(row.jacobian_a)):
            w += row.jacobian_a[i] * a.velocity[i] + row.jacobian_b[i] * b.velocity[i]
        new = old - row.effective_mass * w
        if row.kind == FRICTION:
            bound = row.friction * normal
            new = min(max(new, -bound), bound)
        else:
            new = min(max(new, row.lower), row.upper)
            normal = new
        d = new - old
        row.impulse = new
        for i in range(len(row.jacobian_a)):
            a.velocity[i] += a.inverse[i] * row.jacobian_a[i] * d
            b.velocity[i] += b.inverse[i] * row.jacobian_b[i] * d
        change += d * d * row.diagonal
    return change


@njit
def solve_pgs(
    rows: Any,
    count: Any,
    bodies: Any,
    max_sweeps: Any,
    tolerance: Any,
    scale: Any,
    trees: Any,
    tree: Any,
    tree_blocks: Any,
) -> Any:
    """Plain sweeps until the residual is below ``tolerance``. Returns (sweeps, residual)."""
    change = 0.0
    goal = tolerance * tolerance * scale
    for k in range(max_sweeps):
        change = sweep(rows, count, bodies, trees, tree, tree_blocks, 0.01 * goal, None)
        if change <= goal:
            return k + 1, (change / scale) ** 0.5
    return max_sweeps, (change / scale) ** 0.5
