"""The 2D friction cone |t| <= mu n: a contact's normal row and the one tangent after it."""

from __future__ import annotations

from typing import Any

from ..core.rows import row_velocities
from ..jit import njit


@njit
def cone_span(rows: Any, r: Any) -> Any:
    """Return the number of rows of the contact that starts at row r: 1, or 2 with friction."""
    return int(rows[r].span)


@njit
def cone_residual(rows: Any, r: Any, bodies: Any) -> Any:
    """Return (|e|^2, |q/s|^2, |s r|^2) of a contact with friction; see core/energy.natural_residual."""
    row = rows[r]
    tangent = rows[r + 1]
    w, q = row_velocities(row, bodies)
    wt, qt = row_velocities(tangent, bodies)
    d = 0.5 * (row.diagonal + tangent.diagonal)
    mass = 1.0 / d
    x = row.impulse
    y = tangent.impulse
    n, t = _nearest(x - mass * (w + tangent.friction * abs(wt)), y - mass * wt, tangent.friction)
    error = (x - n) * (x - n) + (y - t) * (y - t)
    return d * error, mass * (q * q + qt * qt), d * (x * x + y * y)


@njit
def _nearest(x: Any, y: Any, mu: Any) -> Any:
    """Return the nearest point of {|t| <= mu n} to (n, t) = (x, y)."""
    if abs(y) <= mu * x:
        return x, y
    if mu * abs(y) <= -x:
        return 0.0, 0.0
    n = (x + mu * abs(y)) / (1.0 + mu * mu)
    return n, mu * n if y > 0.0 else -mu * n
