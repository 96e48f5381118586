"""Projected Gauss-Seidel: repeated sweeps over all rows, in which each row is solved in turn.

Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005; Erleben, "Numerical methods for
linear complementarity problems in physics-based animation", SIGGRAPH 2013 course, section 4.2.
"""

from __future__ import annotations

from typing import Any

from ..core.coupled import solve_coupled
from ..core.dispatch import by_dimension
from ..core.rows import (
    COUPLED,
    DISC,
    EQUATION,
    FRICTION,
    GEARED,
    HALF,
    apply_impulse,
    push_row,
    row_product,
    row_velocity,
)
from ..jit import njit
from .joint_factor import solve_equations


@njit
def _no_disc(rows: Any, r: Any, bodies: Any, normal: Any, push: Any) -> Any:
    """Do nothing: 2D contacts have one tangent."""
    return 0.0


sweep_disc = by_dimension("friction_cone", "sweep_disc", otherwise=_no_disc)


@njit
def sweep(rows: Any, count: Any, bodies: Any, joint_factor: Any, enough: Any, push: Any) -> Any:
    """Take one sweep over ``rows[:count]``. Returns sum d^2 A_rr, d the change of a row's impulse.

    That is the squared natural-map residual of the sweep in the metric of diag(A), at no further cost.
    ``bodies``: the solver bodies. ``joint_factor``: with a factor, the equations are solved directly and
    first; None in scenes that can have none.
    ``push``: None, or (beta, keep): first impulse += beta * direction, direction = beta * direction
    + (change of the last sweep if keep), for which ``previous`` holds the impulses before that sweep.
    """
    change = 0.0
    normal = 0.0
    exact = False
    if joint_factor is not None:
        plan = joint_factor.plan
        exact = plan.size > 0
        if exact:
            change = solve_equations(
                rows, plan.row_end, bodies, plan.size, joint_factor.entries, joint_factor.blocks, enough, push
            )
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
        if joint_factor is not None:
            if row.kind == GEARED:
                change += _solve_geared(rows, r, bodies)
                continue
            if row.kind == COUPLED:
                change += solve_coupled(rows, r, bodies)
                continue
            if row.kind == HALF:
                row.impulse = rows[r - 1].impulse
                continue
        old = row.impulse
        if row.kind == FRICTION and normal == 0.0 and old == 0.0:
            continue
        a = bodies[row.body_a]
        b = bodies[row.body_b]
        w = row.bias + row.softness * old + row_product(row, a.velocity, b.velocity)
        new = old - row.effective_mass * w
        if row.kind == FRICTION:
            bound = row.friction * normal
            new = min(max(new, -bound), bound)
        else:
            new = min(max(new, row.lower), row.upper)
            normal = new
        d = new - old
        row.impulse = new
        apply_impulse(row, a, b, d)
        change += d * d * row.diagonal
    return change


@njit
def _solve_geared(rows: Any, r: Any, bodies: Any) -> Any:
    """Solve a bounded row and the equation of the rotor on its coordinate; returns d^2 A_rr with the rotor in A.

    Alone, the row of a limit on a light limb with a heavy rotor would stop the limb, which the rotor would then move on
    as before: each sweep would find only the share of the limb in the inertia of both.
    """
    row = rows[r]
    rotor = rows[r - row.rotor]
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    w = row_velocity(row, bodies)
    coupling = 0.0
    for i in range(len(row.jacobian_a)):
        coupling += row.jacobian_a[i] * a.inverse[i] * rotor.jacobian_a[i]
        coupling += row.jacobian_b[i] * b.inverse[i] * rotor.jacobian_b[i]
    share = coupling / rotor.diagonal
    size = row.diagonal - share * coupling
    if not size > 0.0:
        return 0.0
    old = row.impulse
    new = min(max(old - w / size, row.lower), row.upper)
    d = new - old
    row.impulse = new
    rotor.impulse -= share * d
    for i in range(len(row.jacobian_a)):
        a.velocity[i] += a.inverse[i] * (row.jacobian_a[i] - share * rotor.jacobian_a[i]) * d
        b.velocity[i] += b.inverse[i] * (row.jacobian_b[i] - share * rotor.jacobian_b[i]) * d
    return d * d * size


@njit
def solve_pgs(rows: Any, count: Any, bodies: Any, joint_factor: Any, limits: Any) -> Any:
    """Take plain sweeps until the residual is below the tolerance. Returns (sweeps, residual).

    ``limits``: (largest number of sweeps, tolerance, scale of the squared residual).
    """
    max_sweeps, tolerance, scale = limits
    change = 0.0
    goal = tolerance * tolerance * scale
    for k in range(max_sweeps):
        change = sweep(rows, count, bodies, joint_factor, 0.01 * goal, None)
        if change <= goal:
            return k + 1, (change / scale) ** 0.5
    return max_sweeps, (change / scale) ** 0.5
