"""What joints build rows from: a direction made rigid, soft, one-sided or driven."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...motion import LIMIT_SLOP, start_rate
from ...rows import BOUNDED, EQUATION, HELD, HELD_APART
from ...springs import set_spring
from ..contact_rows import set_effective_mass

_INFINITY = float("inf")


@njit
def finish_row(row: Any, slot: Any, error: Any, motions: Any) -> None:
    """A rigid two-sided row; make it soft, one-sided or driven afterwards. Its Jacobian is set."""
    row.kind = EQUATION
    row.hold = HELD
    row.slot = slot
    row.error = error
    row.lower = -_INFINITY
    row.upper = _INFINITY
    row.bias = 0.0
    row.drive = 0.0
    row.softness = 0.0
    set_effective_mass(row, motions)


@njit
def has_limit(parameters: Any) -> Any:
    return parameters.lower > -_INFINITY or parameters.upper < _INFINITY


@njit
def has_motor(parameters: Any) -> Any:
    return parameters.motor_effort > 0.0


@njit
def soften(row: Any, parameters: Any, speed: Any, motions: Any, h: Any) -> None:
    """Turn a rigid row into a spring and damper on its error; ``speed`` is that of the resting point."""
    set_spring(row, parameters, speed, motions, h)
    set_effective_mass(row, motions)


@njit
def bound_row(row: Any, bound: Any) -> None:
    """|impulse| <= bound."""
    row.kind = BOUNDED
    row.lower = -bound
    row.upper = bound


@njit
def copy_direction(row: Any, other: Any, sign: Any) -> None:
    for i in range(len(row.jacobian_a)):
        row.jacobian_a[i] = sign * other.jacobian_a[i]
        row.jacobian_b[i] = sign * other.jacobian_b[i]


@njit
def add_spring(
    rows: Any, row: Any, slot: Any, error: Any, parameters: Any, motions: Any, h: Any
) -> Any:
    """A spring along the direction that ``rows[row]`` has; returns the next row."""
    finish_row(rows[row], slot, error, motions)
    soften(rows[row], parameters, 0.0, motions, h)
    if parameters.spring_effort < _INFINITY:
        bound_row(rows[row], h * parameters.spring_effort)
    return row + 1


@njit
def add_limit(
    rows: Any, row: Any, slot: Any, coordinate: Any, curve: Any, parameters: Any, motions: Any, h: Any
) -> Any:
    """The limit that comes first along the direction that ``rows[row]`` has; returns the next row.

    ``curve``, m/s or rad/s: what J v gains to the end of the substep, h/2 dJ/dt v.
    """
    limit = rows[row]
    below = coordinate - parameters.lower
    above = parameters.upper - coordinate
    if parameters.lower == parameters.upper:
        finish_row(limit, slot, below, motions)
        limit.bias = curve
        return row + 1
    gap = below
    ahead = h * start_rate(limit, motions)  # a narrow range may be crossed within the substep
    if above - ahead < below + ahead:
        gap = above
        curve = -curve
        slot = -1 - slot
        copy_direction(limit, limit, -1.0)
    finish_row(limit, slot, gap, motions)
    limit.kind = BOUNDED
    limit.hold = HELD_APART
    limit.lower = 0.0
    limit.bias = curve + (gap / h if gap > LIMIT_SLOP else 0.0)
    return row + 1
