"""Joints as one exact block: all equations of an island solved at once, in linear time on trees.

With E their Jacobian and s = epsilon diag(E M^-1 E^T), or a softness above that, H = M + E^T s^-1 E is
factorised once per substep; one solve H x = -E^T s^-1 w changes the velocities by x and the impulses by
-(w + E x) / s.  Closed loops and joints given twice make E M^-1 E^T singular, but never H.

Baraff, "Linear-time dynamics using Lagrange multipliers", SIGGRAPH 1996, has the block as L D L^T of the
saddle matrix; eliminating the multipliers first keeps it positive definite with redundant rows.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import EQUATION, push_row
from .cholesky import (
    add_force,
    add_stiffness,
    change_of,
    clear_sides,
    factorise,
    load_masses,
    plan_factor,
    substitute,
)

EPSILON = 1e-7  # softness of a rigid equation, as a part of A_rr


@njit
def give_of(row: Any) -> Any:
    """s of an equation: its own softness, or what makes H regular."""
    return max(row.softness, EPSILON * (row.diagonal - row.softness))


@njit
def factorise_equations(
    rows: Any, end: Any, bodies_of: Any, motions: Any, tree: Any, edges: Any, blocks: Any
) -> Any:
    """Factor of the equations among ``rows[:end]``; its size, 0 if there are none or it does not fit."""
    n = plan_factor(rows, end, True, bodies_of, tree, edges, blocks)
    load_masses(n, tree, blocks, motions)
    for r in range(end):
        if n > 0 and rows[r].kind == EQUATION and rows[r].diagonal > 0.0:
            add_stiffness(rows[r], tree, blocks, 1.0 / give_of(rows[r]))
    return n if factorise(n, tree, blocks) else 0


@njit
def _velocity_of(row: Any, bodies: Any) -> Any:
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    w = row.bias + row.softness * row.impulse
    for i in range(len(row.jacobian_a)):
        w += row.jacobian_a[i] * a.velocity[i] + row.jacobian_b[i] * b.velocity[i]
    return w


@njit
def solve_equations(
    rows: Any, end: Any, bodies: Any, n: Any, tree: Any, blocks: Any, enough: Any, push: Any
) -> Any:
    """Make the equations true; returns sum w^2 / A_rr of before.  Nothing is done at or below ``enough``.

    Springs are always solved: what is little for A_rr may be much of the load of a stiff one.
    ``push`` as in ``sweep``.
    """
    clear_sides(n, tree)
    change = 0.0
    sprung = False
    for r in range(end):
        row = rows[r]
        if push is not None:
            if row.kind == EQUATION:
                push_row(row, push)
        if row.kind == EQUATION and row.diagonal > 0.0:
            w = _velocity_of(row, bodies)
            change += w * w * row.effective_mass
            sprung = sprung or row.softness > 0.0
            add_force(row, tree, -w / give_of(row))
    if change <= enough and not sprung:
        return change
    substitute(n, tree, blocks)
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.diagonal > 0.0:
            w = _velocity_of(row, bodies)
            row.impulse -= (w + change_of(row, tree)) / give_of(row)
    for p in range(n):
        velocity = bodies[tree[p].order].velocity
        for i in range(len(velocity)):
            velocity[i] += tree[p].x[i]
    return change
