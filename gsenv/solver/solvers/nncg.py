"""Projected Gauss-Seidel accelerated as a nonsmooth nonlinear conjugate gradient method.

Silcowitz, Niebe, Erleben, "A nonsmooth nonlinear conjugate gradient method for interactive
contact force problems", The Visual Computer 26 (2010): the change that a sweep makes stands in
for the negative gradient, Fletcher-Reeves gives the step, and a growing change restarts.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import apply_impulse
from .pgs import sweep


@njit
def _extrapolate(rows: Any, count: Any, bodies: Any, beta: Any) -> None:
    """impulse += beta * direction, direction = beta * direction + change of the last sweep."""
    for r in range(count):
        row = rows[r]
        d = beta * row.direction
        row.direction = d + row.impulse - row.previous
        if d != 0.0:
            row.impulse += d
            apply_impulse(row, bodies[row.body_a], bodies[row.body_b], d)


@njit
def solve_nncg(rows: Any, count: Any, bodies: Any, max_sweeps: Any, tolerance: Any, scale: Any) -> Any:
    """Accelerated sweeps until the residual is below ``tolerance``. Returns (sweeps, residual).

    Ends after a plain sweep always, so the impulses returned are within their bounds.
    """
    change = 0.0
    last = 0.0
    for r in range(count):
        rows[r].direction = 0.0
        rows[r].previous = rows[r].impulse
    for k in range(max_sweeps):
        if k > 0:
            for r in range(count):
                rows[r].previous = rows[r].impulse
        change = sweep(rows, count, bodies)
        if change <= tolerance * tolerance * scale:
            return k + 1, (change / scale) ** 0.5
        if k == max_sweeps - 1:
            break
        now = change
        if k == 0 or now > last:
            for r in range(count):  # restart: the next direction is the last change alone
                rows[r].direction = 0.0 if k > 0 else rows[r].impulse - rows[r].previous
        else:
            _extrapolate(rows, count, bodies, now / last)
        last = now
    return max_sweeps, (change / scale) ** 0.5
