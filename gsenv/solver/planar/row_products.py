"""Products of a 2D row's Jacobian with vectors of its two bodies, (3,) each."""

from __future__ import annotations

from typing import Any

from ..jit import njit


@njit
def row_product(row: Any, x_a: Any, x_b: Any) -> Any:
    """Return J x of a row, for vectors of its bodies."""
    j = row.jacobian_a
    k = row.jacobian_b
    s = 0.0
    for i in range(3):
        s += j[i] * x_a[i] + k[i] * x_b[i]
    return s


@njit
def add_response(row: Any, impulse: Any, x_a: Any, inverse_a: Any, x_b: Any, inverse_b: Any) -> None:
    """Add M^-1 J^T impulse to vectors of its bodies."""
    j = row.jacobian_a
    k = row.jacobian_b
    for i in range(3):
        x_a[i] += inverse_a[i] * j[i] * impulse
        x_b[i] += inverse_b[i] * k[i] * impulse
