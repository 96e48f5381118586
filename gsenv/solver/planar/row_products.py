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


@njit
def add_responses(one: Any, p: Any, two: Any, q: Any, x_a: Any, inverse_a: Any, x_b: Any, inverse_b: Any) -> None:
    """Add M^-1 (J_1^T p + J_2^T q) of two rows to vectors of their bodies."""
    for i in range(3):
        x_a[i] += inverse_a[i] * (one.jacobian_a[i] * p + two.jacobian_a[i] * q)
        x_b[i] += inverse_b[i] * (one.jacobian_b[i] * p + two.jacobian_b[i] * q)
