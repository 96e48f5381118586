"""What joints build rows from: a direction made rigid, soft, one-sided or driven."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...motion import LIMIT_SLOP, start_rate
from ...rows import BOUNDED, EQUATION, HELD, HELD_APART, UNHELD
from ...springs import set_spring
from ..contact_rows import set_effective_mass

_INFINITY = float("inf")


@njit
def set_direction(row: Any, ux: Any, uy: Any, turn_a: Any, turn_b: Any) -> None:
    row.jacobian_a[0] = -ux
    row.jacobian_a[1] = -uy
    row.jacobian_a[2] = turn_a
    row.jacobian_b[0] = ux
    row.jacobian_b[1] = uy
    row.jacobian_b[2] = turn_b


@njit
def finish_row(row: Any, slot: Any, error: Any, body_parameters: Any) -> None:
    """A rigid two-sided row; make it soft, one-sided or driven afterwards."""
    row.kind = EQUATION
    row.hold = HELD
    row.slot = slot
    row.error = error
    row.lower = -_INFINITY
    row.upper = _INFINITY
    row.bias = 0.0
    row.drive = 0.0
    row.softness = 0.0
    set_effective_mass(row, body_parameters)


@njit
def has_limit(parameters: Any) -> Any:
    return parameters.lower > -_INFINITY or parameters.upper < _INFINITY


@njit
def has_motor(parameters: Any) -> Any:
    return parameters.motor_effort > 0.0


@njit
def soften(row: Any, parameters: Any, speed: Any, body_parameters: Any, motions: Any, h: Any) -> None:
    """Turn a rigid row into a spring and damper on its error; ``speed`` is that of the resting point."""
    set_spring(row, parameters, speed, motions, h)
    set_effective_mass(row, body_parameters)


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
    rows: Any, row: Any, slot: Any, error: Any, parameters: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """A spring along the direction that ``rows[row]`` has; returns the next row."""
    finish_row(rows[row], slot, error, body_parameters)
    soften(rows[row], parameters, 0.0, body_parameters, motions, h)
    if parameters.spring_effort < _INFINITY:
        bound_row(rows[row], h * parameters.spring_effort)
    return row + 1


@njit
def add_limit(
    rows: Any, row: Any, slot: Any, coordinate: Any, curve: Any, parameters: Any, body_parameters: Any,
    motions: Any, h: Any,
) -> Any:  # fmt: skip
    """The limit that comes first along the direction that ``rows[row]`` has; returns the next row.

    ``curve``, m/s or rad/s: what J v gains to the end of the substep, h/2 dJ/dt v.
    """
    limit = rows[row]
    below = coordinate - parameters.lower
    above = parameters.upper - coordinate
    if parameters.lower == parameters.upper:
        finish_row(limit, slot, below, body_parameters)
        limit.bias = curve
        return row + 1
    gap = below
    ahead = h * start_rate(limit, motions)  # a narrow range may be crossed within the substep
    if above - ahead < below + ahead:
        gap = above
        curve = -curve
        slot = -1 - slot
        copy_direction(limit, limit, -1.0)
    finish_row(limit, slot, gap, body_parameters)
    limit.kind = BOUNDED
    limit.hold = HELD_APART
    limit.lower = 0.0
    limit.bias = curve + (gap / h if gap > LIMIT_SLOP else 0.0)
    return row + 1


@njit
def speeds_within(coordinate: Any, curve: Any, parameters: Any, h: Any) -> Any:
    """(slowest, fastest) of a motor without a bound, which limits could never stop; ``curve`` as for limits."""
    if parameters.motor_effort < _INFINITY:
        return -_INFINITY, _INFINITY
    below = max(coordinate - parameters.lower, 0.0)
    above = max(parameters.upper - coordinate, 0.0)
    return -below / h - curve, above / h - curve


@njit
def add_motor(
    rows: Any, row: Any, slot: Any, model: Any, parameters: Any, state: Any, speeds: Any, body_parameters: Any, h: Any
) -> Any:
    """A motor along the direction that ``rows[row]`` has: to a speed with a bounded effort, or an effort."""
    motor = rows[row]
    finish_row(motor, slot, 0.0, body_parameters)
    motor.hold = UNHELD
    motor.bias = -min(max(state.motor_speed, speeds[0]), speeds[1])
    bound_row(motor, h * parameters.motor_effort)
    if model.torque:
        motor.lower = h * min(max(state.effort, -parameters.motor_effort), parameters.motor_effort)
        motor.upper = motor.lower
    return row + 1
