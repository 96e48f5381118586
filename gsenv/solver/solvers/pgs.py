"""Projected Gauss-Seidel: one pass over all rows after another, each row made true in turn.

Catto, "Iterative Dynamics with Temporal Coherence", GDC 2005; Erleben, "Numerical methods for
linear complementarity problems in physics-based animation", SIGGRAPH 2013 course, section 4.2.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import FRICTION


@njit
def sweep(rows: Any, count: Any, bodies: Any) -> Any:
    """One sweep. Returns sum d^2 A_rr, d the change of a row's impulse.

    That is the natural-map residual of the sweep in the metric of diag(A), squared, for free.
    """
    change = 0.0
    normal = 0.0
    for r in range(count):
        row = rows[r]
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
        for i in range(len(row.response_a)):
            a.velocity[i] += row.response_a[i] * d
            b.velocity[i] += row.response_b[i] * d
        change += d * d * row.diagonal
    return change


@njit
def solve_pgs(rows: Any, count: Any, bodies: Any, max_sweeps: Any, tolerance: Any, scale: Any) -> Any:
    """Plain sweeps until the residual is below ``tolerance``. Returns (sweeps, residual)."""
    change = 0.0
    for k in range(max_sweeps):
        change = sweep(rows, count, bodies)
        if change <= tolerance * tolerance * scale:
            return k + 1, (change / scale) ** 0.5
    return max_sweeps, (change / scale) ** 0.5
