"""Constraint rows: one scalar constraint ``J v`` each, with bounds on its impulse.

A row holds for bodies a and b

    w = J_a v_a + J_b v_b + bias + softness * impulse,    lower <= impulse <= upper,

with the usual complementarity: w = 0 strictly between the bounds, w >= 0 at the lower one,
w <= 0 at the upper one.  A FRICTION row takes its bounds from the normal impulse of the contact
it belongs to, in the same sweep.  Nothing here knows what a row stands for or how many
dimensions there are: ndof is the constant length of the Jacobian fields.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import njit
from .model import NDOF

BOUNDED = 0  # impulse within [lower, upper]
FRICTION = 1  # |impulse| <= friction * impulse of the row before it


def row_dtype(dim: int) -> np.dtype[Any]:
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("kind", "i4"),
            ("source", "i4"),  # contact or joint the row comes from
            ("span", "i4"),  # rows of the contact that starts here: 1 without friction
            ("flying", "i4"),  # 1: the impact phase left this contact in flight
            ("jacobian_a", "f8", (ndof,)),
            ("jacobian_b", "f8", (ndof,)),
            ("response_a", "f8", (ndof,)),  # M^-1 J^T: velocity change per unit impulse
            ("response_b", "f8", (ndof,)),
            ("impulse", "f8"),  # N s
            ("lower", "f8"),
            ("upper", "f8"),
            ("friction", "f8"),
            ("bias", "f8"),  # m/s
            ("softness", "f8"),  # 1/kg
            ("diagonal", "f8"),  # J M^-1 J^T + softness
            ("effective_mass", "f8"),  # its inverse, 0 for a row that can move nothing
            ("previous", "f8"),  # impulse before the sweep
            ("direction", "f8"),  # conjugate direction
            ("error", "f8"),  # m, violation in position: what the position pass corrects
            ("position_impulse", "f8"),
            ("flight", "f8"),  # m/s^2, its free acceleration then
        ],
        align=True,
    )


@njit
def relative_velocity(row: Any, a: Any, b: Any) -> Any:
    """J v of a row for two records with a ``velocity``."""
    s = 0.0
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * a.velocity[i] + row.jacobian_b[i] * b.velocity[i]
    return s


@njit
def apply_impulse(row: Any, a: Any, b: Any, impulse: Any) -> None:
    for i in range(len(row.response_a)):
        a.velocity[i] += row.response_a[i] * impulse
        b.velocity[i] += row.response_b[i] * impulse


@njit
def set_effective_mass(row: Any) -> None:
    """From jacobian, response and softness."""
    d = row.softness
    for i in range(len(row.jacobian_a)):
        d += row.jacobian_a[i] * row.response_a[i] + row.jacobian_b[i] * row.response_b[i]
    row.diagonal = d
    row.effective_mass = 1.0 / d if d > 0.0 else 0.0


@njit
def clamp_impulse(rows: Any, r: Any, impulse: Any) -> Any:
    row = rows[r]
    if row.kind == FRICTION:
        bound = row.friction * rows[r - 1].impulse
        return min(max(impulse, -bound), bound)
    return min(max(impulse, row.lower), row.upper)


@njit
def apply_warm_start(rows: Any, count: Any, bodies: Any) -> None:
    """Bring the velocities in line with the impulses that the rows start from."""
    for r in range(count):
        row = rows[r]
        if row.impulse != 0.0:
            apply_impulse(row, bodies[row.body_a], bodies[row.body_b], row.impulse)
