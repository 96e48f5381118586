"""Constraint rows: one scalar constraint ``J v`` each, with bounds on its impulse.

A row is the equation of bodies a and b

    w = J_a v_a + J_b v_b + bias + softness * impulse,    lower <= impulse <= upper,

with the usual complementarity: w = 0 strictly between the bounds, w >= 0 at the lower one,
w <= 0 at the upper one.  A FRICTION row takes its bounds from the normal impulse of the contact
that it belongs to, in the same sweep.  Nothing in this file depends on what a row means or on the
dimension: ndof is the constant length of the Jacobian fields.

A DISC row and the one after it are the two tangents of a 3D contact: their impulses together
stay in the disc |(t, s)| <= friction * normal impulse (Coulomb's cone, not a pyramid).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..jit import njit
from ..records.model import NDOF
from .dispatch import by_dimension

row_product = by_dimension("row_products", "row_product")
add_response = by_dimension("row_products", "add_response")
add_responses = by_dimension("row_products", "add_responses")

BOUNDED = 0  # impulse within [lower, upper]
FRICTION = 1  # |impulse| <= friction * impulse of the row ``base`` before it
EQUATION = 2  # any impulse: a row of a rigid joint, which direct methods solve exactly
DISC = 3  # first of the two tangents of a 3D contact
DISC_END = 4  # the second
GEARED = -1  # as BOUNDED, on a coordinate with an armature: solved together with the row of the rotor
IDLE = -2  # no impulse: of a limit out of reach, in joint coordinates
HALF = -3  # second half of the row before it, whose impulse it has; see coupled.py
COUPLED = -4  # a row with a second half, in body space

# What the position pass does with a row's error.
NO_CORRECTION = 0  # nothing: friction, motors, springs
BILATERAL = 1  # reduces it, whatever its sign
UNILATERAL = 2  # reduces it where it is negative

LIMIT_SLOP = 1e-7  # m or rad: smaller gaps count as closed, or a limit under load would lose part of its impulse
GROUNDED = float("inf")  # flight of a contact that is not in flight
CLOSED = 1e300  # m/s^2, flight of a contact that lands now: whatever its gap, it counts as closed
OPEN = -1e9  # m/s^2, of one that lands at the end of this part of the substep: it does not act before


def row_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a row; it is small, since each sweep reads all rows from memory.

    M^-1 J^T is computed from the bodies' ``inverse`` masses.  Fields that no row uses both share memory:
    a FRICTION row has no own bounds, only joints have a drive and only contacts a flight.
    """
    ndof = NDOF[dim]
    base = np.dtype(
        [
            ("body_a", "i4"),
            ("body_b", "i4"),
            ("source", "i4"),  # index of the contact or joint of the row
            ("kind", "i1"),
            ("slot", "i1"),  # index of the impulse in the joint; -1 - index: with its sign reversed
            ("correction", "i1"),  # what the position pass does with the error
            ("span", "i1"),  # rows of the contact that starts here: 1 without friction
            ("jacobian_a", "f8", (ndof,)),
            ("jacobian_b", "f8", (ndof,)),
            ("impulse", "f8"),  # N s
            ("lower", "f8"),  # N s, bounds of the impulse
            ("upper", "f8"),
            ("bias", "f8"),  # m/s
            ("softness", "f8"),  # 1/kg
            ("diagonal", "f8"),  # 1/kg, J M^-1 J^T + softness
            ("effective_mass", "f8"),  # kg, its inverse; 0 for a row that can move nothing
            ("previous", "f8"),  # N s, impulse before the sweep
            ("direction", "f8"),  # N s, conjugate direction
            ("error", "f8"),  # m or rad, position error, which the position pass corrects
            ("position_impulse", "f8"),  # N s, of the position pass
            ("free", "f8"),  # m/s, J v before all impulses of the substep
            ("flight", "f8"),  # m/s^2, acceleration of a contact that is in flight after the impact phase, or GROUNDED
        ],
        align=True,
    )
    shared = {
        "friction": "upper",
        "coupling": "lower",  # 1/kg, J_1 M^-1 J_2^T of the two rows of a disc, in the first
        "base": "slot",  # of friction: distance to the normal row before it, in rows
        "turned": "slot",  # of a contact's normal: 1 where its rows are not those of the start of the step
        "rotor": "span",  # of GEARED: distance to the row of the rotor before it, in rows
        "drive": "flight",  # m/s, commanded part of the bias, which the position pass does not correct
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


def solver_body_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a body's scratch within one solve: all that sweeps need of a body."""
    ndof = NDOF[dim]
    return np.dtype(
        [
            ("velocity", "f8", (ndof,)),  # m/s and rad/s
            ("inverse", "f8", (ndof,)),  # 1/kg and 1/(kg m^2)
            ("start", "f8", (ndof,)),  # velocity before any impulse, then before the sweep
            ("direction", "f8", (ndof,)),  # change of the velocity by the rows' conjugate directions
        ],
        align=True,
    )


@njit
def relative_velocity(row: Any, a: Any, b: Any) -> Any:
    """Return J v of a row for two records with a ``velocity``."""
    return row_product(row, a.velocity, b.velocity)


@njit
def start_rate(row: Any, substep_bodies: Any) -> Any:
    """Return J v at the start of the substep."""
    return row_product(row, substep_bodies[row.body_a].start_velocity, substep_bodies[row.body_b].start_velocity)


@njit
def free_rate(row: Any, substep_bodies: Any) -> Any:
    """Return J v after forces and before all impulses of the substep."""
    return row_product(row, substep_bodies[row.body_a].free_velocity, substep_bodies[row.body_b].free_velocity)


@njit
def row_velocity(row: Any, bodies: Any) -> Any:
    """Return w = J v + bias + softness * impulse of a row."""
    return row.bias + row.softness * row.impulse + relative_velocity(row, bodies[row.body_a], bodies[row.body_b])


@njit
def row_velocities(row: Any, bodies: Any) -> Any:
    """Return (w, q): the velocity J v + bias + softness * impulse of a row after and before the impulses."""
    return row_velocity(row, bodies), row.bias + row.free


@njit
def apply_impulse(row: Any, a: Any, b: Any, impulse: Any) -> None:
    """Apply an impulse to two records with a ``velocity`` and an ``inverse`` mass: v += M^-1 J^T impulse."""
    add_response(row, impulse, a.velocity, a.inverse, b.velocity, b.inverse)


@njit
def apply_impulses(one: Any, p: Any, two: Any, q: Any, a: Any, b: Any) -> None:
    """Apply the impulses of two rows of the same bodies: v += M^-1 (J_1^T p + J_2^T q)."""
    add_responses(one, p, two, q, a.velocity, a.inverse, b.velocity, b.inverse)


@njit
def push_row(row: Any, push: Any) -> None:
    """Take the conjugate step of a row; the solver bodies have taken theirs before; ``push`` as in ``sweep``."""
    beta, keep = push
    d = beta * row.direction if beta > 0.0 else 0.0  # the field may hold a value of another solve
    row.direction = d + row.impulse - row.previous if keep else d
    row.impulse += d
    row.previous = row.impulse


@njit
def on_disc(x: Any, y: Any, bound: Any) -> Any:
    """Return the nearest point to (x, y) of the disc |(x, y)| <= bound."""
    square = x * x + y * y
    if square <= bound * bound:
        return x, y
    scale = bound / square**0.5
    return x * scale, y * scale
