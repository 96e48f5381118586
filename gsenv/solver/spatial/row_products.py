"""Products of a 3D row's Jacobian with vectors of its two bodies, (6,) each.

Loops would do, but LLVM computes several numbers at once only where all are read before one is written.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit


@njit
def row_product(row: Any, x_a: Any, x_b: Any) -> Any:
    """Return J x of a row, for vectors of its bodies."""
    j = row.jacobian_a
    k = row.jacobian_b
    s = (j[0] * x_a[0] + k[0] * x_b[0]) + (j[3] * x_a[3] + k[3] * x_b[3])
    t = (j[1] * x_a[1] + k[1] * x_b[1]) + (j[4] * x_a[4] + k[4] * x_b[4])
    u = (j[2] * x_a[2] + k[2] * x_b[2]) + (j[5] * x_a[5] + k[5] * x_b[5])
    return (s + t) + u


@njit
def add_response(row: Any, impulse: Any, x_a: Any, inverse_a: Any, x_b: Any, inverse_b: Any) -> None:
    """Add M^-1 J^T impulse to vectors of its bodies, which are two."""
    a = _response(row.jacobian_a, impulse, x_a, inverse_a)
    b = _response(row.jacobian_b, impulse, x_b, inverse_b)
    _set_six(x_a, a)
    _set_six(x_b, b)


@njit
def _response(j: Any, impulse: Any, x: Any, m: Any) -> Any:
    return (
        x[0] + m[0] * j[0] * impulse,
        x[1] + m[1] * j[1] * impulse,
        x[2] + m[2] * j[2] * impulse,
        x[3] + m[3] * j[3] * impulse,
        x[4] + m[4] * j[4] * impulse,
        x[5] + m[5] * j[5] * impulse,
    )


@njit
def add_responses(one: Any, p: Any, two: Any, q: Any, x_a: Any, inverse_a: Any, x_b: Any, inverse_b: Any) -> None:
    """Add M^-1 (J_1^T p + J_2^T q) of two rows to vectors of their bodies, which are two."""
    a = _responses(one.jacobian_a, p, two.jacobian_a, q, x_a, inverse_a)
    b = _responses(one.jacobian_b, p, two.jacobian_b, q, x_b, inverse_b)
    _set_six(x_a, a)
    _set_six(x_b, b)


@njit
def _responses(j: Any, p: Any, k: Any, q: Any, x: Any, m: Any) -> Any:
    return (
        x[0] + m[0] * (j[0] * p + k[0] * q),
        x[1] + m[1] * (j[1] * p + k[1] * q),
        x[2] + m[2] * (j[2] * p + k[2] * q),
        x[3] + m[3] * (j[3] * p + k[3] * q),
        x[4] + m[4] * (j[4] * p + k[4] * q),
        x[5] + m[5] * (j[5] * p + k[5] * q),
    )


@njit
def _set_six(x: Any, values: Any) -> None:
    x[0], x[1], x[2], x[3], x[4], x[5] = values
