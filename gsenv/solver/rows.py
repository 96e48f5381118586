"""Constraint rows: one scalar constraint ``J v`` each, with bounds on its impulse.

A row holds for bodies a and b

    w = J_a v_a + J_b v_b + bias + softness * impulse,    lower <= impulse <= upper,

with the usual complementarity: w = 0 strictly between the bounds, w >= 0 at the lower one,
w <= 0 at the upper one.  A FRICTION row takes its bounds from the normal impulse of the contact
it belongs to, in the same sweep.  Nothing here knows what a row stands for or how many
dimensions there are: ndof is the constant length of the Jacobian fields.

A DISC row and the one after it are the two tangents of a contact in space: their impulses together
stay in the disc |(t, s)| <= friction * normal impulse (Coulomb's cone, not a pyramid).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .jit import njit
from .model import NDOF

BOUNDED = 0  # impulse within [lower, upper]
FRICTION = 1  # |impulse| <= friction * impulse of the row ``base`` before it
EQUATION = 2  # any impulse: a rigid joint's row, which direct solves take exactly
DISC = 3  # first of the two tangents of a contact in space
DISC_END = 4  # the second

# What the position pass does with a row's error.
UNHELD = 0  # nothing: friction, motors, springs
HELD = 1  # takes it back, whatever its sign
HELD_APART = 2  # takes it back where it is negative

GROUNDED = float("inf")  # flight of a contact that is not in flight


def row_dtype(dim: int) -> np.dtype[Any]:
    """Small, since each sweep reads the rows of thousands of bodies from memory.

    M^-1 J^T is made from the bodies' ``inverse`` masses.  Fields that no row has both of share a place:
    a FRICTION row has no bounds of its own, only joints have a drive and only contacts a flight.
    """
    ndof = NDOF[dim]
    base = np.dtype(
        [
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("source", "i4"),  # contact or joint the row comes from
            ("kind", "i1"),
            ("slot", "i1"),  # which impulse of the joint; -1 - slot: with its sign turned
            ("hold", "i1"),  # part in the position pass
            ("span", "i1"),  # rows of the contact that starts here: 1 without friction
            ("jacobian_a", "f8", (ndof,)),
            ("jacobian_b", "f8", (ndof,)),
            ("impulse", "f8"),  # N s
            ("lower", "f8"),
            ("upper", "f8"),
            ("bias", "f8"),  # m/s
            ("softness", "f8"),  # 1/kg
            ("diagonal", "f8"),  # J M^-1 J^T + softness
            ("effective_mass", "f8"),  # its inverse, 0 for a row that can move nothing
            ("previous", "f8"),  # impulse before the sweep
            ("direction", "f8"),  # conjugate direction
            ("error", "f8"),  # m, violation in position: what the position pass corrects
            ("position_impulse", "f8"),
            ("flight", "f8"),  # m/s^2, free acceleration of a contact that the impact phase left in flight, or GROUNDED
        ],
        align=True,
    )
    shared = {
        "friction": "upper",
        "coupling": "lower",  # 1/kg, J_1 M^-1 J_2^T of the two rows of a disc, in the first
        "base": "slot",  # of friction: so many rows before it comes the normal row
        "drive": "flight",  # m/s, what of the bias is commanded motion, which the position pass leaves
    }
    offsets = {name: base.fields[name] for name in base.names or ()} if base.fields else {}
    offsets.update({name: offsets[place] for name, place in shared.items()})
    return np.dtype(
        {
            "names": list(offsets),
            "formats": [field[0] for field in offsets.values()],
            "offsets": [field[1] for field in offsets.values()],
            "itemsize": base.itemsize,
            "aligned": True,
        }
    )


def mover_dtype(dim: int) -> np.dtype[Any]:
    """Scratch of a body within one solve: all that sweeps need of it."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("velocity", "f8", (ndof,)),
            ("inverse", "f8", (ndof,)),  # 1/kg and 1/(kg m^2)
            ("start", "f8", (ndof,)),  # velocity before any impulse, then before the sweep
            ("direction", "f8", (ndof,)),  # what the rows' conjugate directions change of the velocity
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
    """For two records with a ``velocity`` and an ``inverse`` mass."""
    for i in range(len(row.jacobian_a)):
        a.velocity[i] += a.inverse[i] * row.jacobian_a[i] * impulse
        b.velocity[i] += b.inverse[i] * row.jacobian_b[i] * impulse


@njit
def push_row(row: Any, push: Any) -> None:
    """Conjugate step of a row before a sweep, whose movers have taken theirs; ``push`` as in ``sweep``."""
    beta, keep = push
    d = beta * row.direction if beta > 0.0 else 0.0  # never what another solve has left there
    row.direction = d + row.impulse - row.previous if keep else d
    row.impulse += d
    row.previous = row.impulse


@njit
def on_disc(x: Any, y: Any, bound: Any) -> Any:
    """Nearest point of the disc |(x, y)| <= bound."""
    square = x * x + y * y
    if square <= bound * bound:
        return x, y
    scale = bound / square**0.5
    return x * scale, y * scale
