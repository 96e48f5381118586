"""Rates of rows at the start of a substep."""

from __future__ import annotations

from typing import Any

from .jit import njit

LIMIT_SLOP = 1e-7  # m or rad: a gap this small counts as closed, or a resting limit would lose load


@njit
def start_rate(row: Any, motions: Any) -> Any:
    """J v at the start of the substep."""
    s = 0.0
    a = motions[row.body_a].start_velocity
    b = motions[row.body_b].start_velocity
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * a[i] + row.jacobian_b[i] * b[i]
    return s
