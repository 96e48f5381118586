"""Direct solve of joints: all equations of an island at once, in linear time if the joints form trees.

With E their Jacobian and s = epsilon diag(E M^-1 E^T), or a softness above that, H = M + E^T s^-1 E is
factorised once per substep; one solve H x = -E^T s^-1 w changes the velocities by x and the impulses by
-(w + E x) / s.  Closed loops and redundant joints make E M^-1 E^T singular, but never H.

Baraff, "Linear-time dynamics using Lagrange multipliers", SIGGRAPH 1996, factorises the saddle matrix
as L D L^T; eliminating the multipliers first keeps H positive definite with redundant rows.
"""

from __future__ import annotations

from typing import Any

from ..core.rows import EQUATION, push_row, row_velocity
from ..jit import njit
from .cholesky import (
    ANY_COST,
    add_force,
    add_stiffness,
    change_of,
    clear_sides,
    factorise,
    load_masses,
    plan_factor,
    substitute,
)

EPSILON = 1e-7  # softness of a rigid equation, as a fraction of A_rr
UNSOLVED = 0.25  # of sum w^2 / A_rr: left by a solve of equations that contradict each other
SELF_STRESS = 1e-12  # of sum A_rr q^2: q^T A q of impulses q that move no body; of a load of 1e9 it is 1e-10


@njit
def compliance(row: Any) -> Any:
    """Return s of an equation: its own softness, or the value that makes H regular."""
    return max(row.softness, EPSILON * (row.diagonal - row.softness))


@njit
def factorise_equations(
    rows: Any, end: Any, island_bodies: Any, substep_bodies: Any, entries: Any, graph: Any, blocks: Any
) -> Any:
    """Factorise the equations among ``rows[:end]``; returns the size, 0 if there are none or it does not fit."""
    n, _ = plan_factor(rows, end, True, island_bodies, entries, graph, blocks, ANY_COST)
    load_masses(n, entries, blocks, substep_bodies)
    for r in range(end):
        if n > 0 and rows[r].kind == EQUATION and rows[r].diagonal > 0.0:
            add_stiffness(rows[r], entries, blocks, 1.0 / compliance(rows[r]))
    return n if factorise(n, entries, blocks) else 0


@njit
def solve_equations(rows: Any, end: Any, bodies: Any, n: Any, entries: Any, blocks: Any, enough: Any, push: Any) -> Any:
    """Solve the equations; returns sum w^2 / A_rr before.  Does nothing where that is at most ``enough``.

    Springs are always solved: a residual that is small for A_rr may be large for the load of a stiff spring.
    ``push`` as in ``sweep``.
    """
    clear_sides(n, entries)
    change = 0.0
    sprung = False
    for r in range(end):
        row = rows[r]
        if push is not None:
            if row.kind == EQUATION:
                push_row(row, push)
        if row.kind == EQUATION and row.diagonal > 0.0:
            w = row_velocity(row, bodies)
            change += w * w * row.effective_mass
            sprung = sprung or row.softness > 0.0
            add_force(row, entries, -w / compliance(row))
    if change <= enough and not sprung:
        return change
    substitute(n, entries, blocks)
    if change > enough and _left_of(rows, end, bodies, entries) > UNSOLVED * change:
        share = _remove_self_stress(rows, end, bodies, entries)
    else:
        share = 1.0
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.diagonal > 0.0:
            w = row_velocity(row, bodies) + change_of(row, entries)
            row.impulse -= share * w / compliance(row)
            if share != 1.0 and row.softness == 0.0:
                row.bias -= w
    for p in range(n):
        velocity = bodies[entries[p].order].velocity
        for i in range(len(velocity)):
            velocity[i] += share * entries[p].x[i]
    return change


@njit
def _left_of(rows: Any, end: Any, bodies: Any, entries: Any) -> Any:
    """Return sum w^2 / A_rr that the solve leaves of rigid equations."""
    left = 0.0
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.softness == 0.0 and row.diagonal > 0.0:
            w = row_velocity(row, bodies) + change_of(row, entries)
            left += w * w * row.effective_mass
    return left


@njit
def _remove_self_stress(rows: Any, end: Any, bodies: Any, entries: Any) -> Any:
    """Return the share of a solve that may be applied: 1, or a small one if the equations contradict each other.

    Then the change -q of the impulses is almost a self-stress: E^T q = 0, so that it moves no body, and solved again in
    each sweep it would add up without limit.  The returned share of it removes the part of the impulses along q; that
    of the last sweep's change is removed here.  What the solve leaves of w must be taken out of the biases: no velocity
    makes that part true.
    """
    work = 0.0
    size = 0.0
    along = 0.0
    of_direction = 0.0
    of_previous = 0.0
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.softness == 0.0 and row.diagonal > 0.0:
            change = change_of(row, entries)
            q = (row_velocity(row, bodies) + change) / compliance(row)
            work -= q * change
            size += row.diagonal * q * q
            along += row.diagonal * q * row.impulse
            of_direction += row.diagonal * q * row.direction
            of_previous += row.diagonal * q * row.previous
    if abs(work) > SELF_STRESS * size:
        return 1.0
    for r in range(end):
        row = rows[r]
        if row.kind == EQUATION and row.softness == 0.0 and row.diagonal > 0.0:
            q = (row_velocity(row, bodies) + change_of(row, entries)) / compliance(row)
            row.direction -= of_direction / size * q
            row.previous -= of_previous / size * q
    return along / size
