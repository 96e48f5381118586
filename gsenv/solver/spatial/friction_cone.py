"""The 3D friction cone |(t, s)| <= mu n: a contact's normal row and the two tangents after it."""

from __future__ import annotations

from typing import Any

from ..core.rows import DISC, row_velocities
from ..jit import njit
from ..methods.disc import sweep_disc

__all__ = ["cone_residual", "cone_span", "sweep_disc"]


@njit
def cone_span(rows: Any, r: Any) -> Any:
    """Return the number of rows of the cone of the contact that starts at row r: 1, or 3 with friction."""
    return 3 if rows[r].span > 2 and rows[r + 1].kind == DISC else 1


@njit
def cone_residual(rows: Any, r: Any, bodies: Any) -> Any:
    """Return (|e|^2, |q/s|^2, |s r|^2) of a contact with friction; see core/energy.natural_residual."""
    w, q = row_velocities(rows[r], bodies)
    u, p = row_velocities(rows[r + 1], bodies)
    v, o = row_velocities(rows[r + 2], bodies)
    d = (rows[r].diagonal + rows[r + 1].diagonal + rows[r + 2].diagonal) / 3.0
    mass = 1.0 / d
    mu = rows[r + 1].friction
    x = rows[r].impulse
    y = rows[r + 1].impulse
    z = rows[r + 2].impulse
    n, t1, t2 = _nearest(x - mass * (w + mu * (u * u + v * v) ** 0.5), y - mass * u, z - mass * v, mu)
    error = (x - n) ** 2 + (y - t1) ** 2 + (z - t2) ** 2
    return d * error, mass * (q * q + p * p + o * o), d * (x * x + y * y + z * z)


@njit
def _nearest(x: Any, y: Any, z: Any, mu: Any) -> Any:
    """Return the nearest point of {|t| <= mu n} to (n, t) = (x, (y, z))."""
    t = (y * y + z * z) ** 0.5
    if t <= mu * x:
        return x, y, z
    if mu * t <= -x:
        return 0.0, 0.0, 0.0
    n = (x + mu * t) / (1.0 + mu * mu)
    return n, mu * n * y / t, mu * n * z / t
