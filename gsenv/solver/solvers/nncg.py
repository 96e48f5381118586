"""Projected Gauss-Seidel accelerated as a nonsmooth nonlinear conjugate gradient method.

Silcowitz, Niebe, Erleben, "A nonsmooth nonlinear conjugate gradient method for interactive
contact force problems", The Visual Computer 26 (2010): the change that a sweep makes stands in
for the negative gradient, Fletcher-Reeves gives the step, and a growing change restarts.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .pgs import sweep


@njit
def _push(movers: Any, bodies_of: Any, beta: Any, keep: Any) -> Any:
    """Conjugate step of the velocities; that of the rows is left to the next sweep, which reads them anyway.

    velocity += beta * direction, direction = beta * direction + (change of the last sweep if keep).
    """
    for k in range(len(bodies_of)):
        mover = movers[bodies_of[k]]
        for i in range(len(mover.velocity)):
            d = beta * mover.direction[i] if beta > 0.0 else 0.0
            mover.direction[i] = d + mover.velocity[i] - mover.start[i] if keep else d
            mover.velocity[i] += d
            mover.start[i] = mover.velocity[i]
    return beta, keep


@njit
def solve_nncg(
    rows: Any,
    count: Any,
    bodies: Any,
    max_sweeps: Any,
    tolerance: Any,
    scale: Any,
    bodies_of: Any,
    trees: Any,
    tree: Any,
    tree_blocks: Any,
) -> Any:
    """Accelerated sweeps until the residual is below ``tolerance``. Returns (sweeps, residual).

    Ends after a plain sweep always, so the impulses returned are within their bounds.
    """
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
        push = _push(bodies, bodies_of, beta, keep)
        change = sweep(rows, count, bodies, trees, tree, tree_blocks, 0.01 * goal, push)
        if change <= goal:
            return k + 1, (change / scale) ** 0.5
    return max_sweeps, (change / scale) ** 0.5
