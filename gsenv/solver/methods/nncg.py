"""Projected Gauss-Seidel accelerated as a nonsmooth nonlinear conjugate gradient method.

Silcowitz, Niebe, Erleben, "A nonsmooth nonlinear conjugate gradient method for interactive
contact force problems", The Visual Computer 26 (2010): the change by a sweep takes the
place of the negative gradient, Fletcher-Reeves gives the step, and a growing change causes a restart.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .pgs import sweep


@njit
def _push(solver_bodies: Any, island_bodies: Any, beta: Any, keep: Any) -> Any:
    """Take the conjugate step of the velocities; that of the rows is part of the next sweep, which reads them anyway.

    velocity += beta * direction, direction = beta * direction + (change of the last sweep if keep).
    """
    for k in range(len(island_bodies)):
        solver_body = solver_bodies[island_bodies[k]]
        for i in range(len(solver_body.velocity)):
            d = beta * solver_body.direction[i] if beta > 0.0 else 0.0
            solver_body.direction[i] = d + solver_body.velocity[i] - solver_body.start[i] if keep else d
            solver_body.velocity[i] += d
            solver_body.start[i] = solver_body.velocity[i]
    return beta, keep


@njit
def solve_nncg(rows: Any, count: Any, bodies: Any, island_bodies: Any, joint_factor: Any, limits: Any) -> Any:
    """Take accelerated sweeps until the residual is below the tolerance. Returns (sweeps, residual).

    ``limits`` as for ``solve_pgs``.  The last step is always a plain sweep, so the impulses are within their
    bounds.
    """
    max_sweeps, tolerance, scale = limits
    change = 0.0
    last = 0.0
    goal = tolerance * tolerance * scale
    for k in range(max_sweeps):
        beta = 0.0
        keep = k == 1
        if k > 1 and change <= last:  # else a restart: the next direction is the last change alone
            beta = change / last
            keep = True
        last = change
        push = _push(bodies, island_bodies, beta, keep)
        change = sweep(rows, count, bodies, joint_factor, 0.01 * goal, push)
        if change <= goal:
            return k + 1, (change / scale) ** 0.5
    return max_sweeps, (change / scale) ** 0.5
