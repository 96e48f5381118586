"""What joints build rows from: a direction made rigid, soft, one-sided or driven."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...motion import LIMIT_SLOP, start_rate
from ...rows import BOUNDED, EQUATION, HELD, HELD_APART, UNHELD
from ...trig import exp_minus, sin_cos
from ..contact_rows import set_effective_mass

_INFINITY = float("inf")
_TWO_PI = 6.283185307179586
EXACT = 0.8  # rad in a substep: slower springs keep their phase, faster ones are implicit


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
def has_spring(parameters: Any) -> Any:
    return parameters.frequency > 0.0 or parameters.stiffness > 0.0 or parameters.damping > 0.0


@njit
def has_motor(parameters: Any) -> Any:
    return parameters.motor_effort > 0.0


@njit
def soften(row: Any, parameters: Any, speed: Any, body_parameters: Any, motions: Any, h: Any) -> None:
    """Turn a rigid row into a spring and damper on its error; ``speed`` is that of the resting point.

    x'' = -2 d x' - w^2 x + g on the mass that the row sees, m = 1/A_rr. For slow springs the discrete
    map of (x, v), x1 = x0 + h (v0 + v1)/2, v1 = a x0 + b v0 + c (v_free - v0), gets the trace and
    determinant of the exact flow, so frequency and decay are exact, and c = -a/(w^2 h) makes the sag
    exact. As a row: softness = gamma A_rr with gamma = c/(1 - c), bias = (gamma - (1 + gamma) b) v0
    - (1 + gamma) a x0.  Fast springs are implicit Euler steps: k = m w^2, softness = 1/(h (damping +
    h k)) (Catto, "Soft constraints", GDC 2011), which damps what the step can't follow.
    """
    row.kind = BOUNDED
    row.hold = UNHELD
    m = row.diagonal
    if m <= 0.0:
        return
    omega = _TWO_PI * parameters.frequency
    square = omega * omega
    rate = parameters.damping_ratio * omega
    if parameters.stiffness > 0.0 or parameters.damping > 0.0:
        square = parameters.stiffness * m
        rate = 0.5 * parameters.damping * m
    if square <= 0.0 and rate <= 0.0:
        return
    x = row.error
    if h * h * square < EXACT * EXACT and h * rate < EXACT:
        a, b, c = _exact_step(square, rate, h)
        gamma = c / (1.0 - c)
        row.bias += (gamma - (1.0 + gamma) * b) * (start_rate(row, motions) - speed) - (1.0 + gamma) * a * x
        row.softness = gamma * m
    else:
        implicit = 2.0 * rate + h * square
        row.bias += square / implicit * x
        row.softness = m / (h * implicit)
    row.bias -= speed
    set_effective_mass(row, body_parameters)


@njit
def _exact_step(square: Any, rate: Any, h: Any) -> Any:
    """(a, b, c) of ``soften``."""
    if h * h * square < 1e-10:  # a damper alone: v1 = b v0 + c h g
        x = 2.0 * h * rate
        b = exp_minus(x)
        c = (1.0 - b) / x if x > 1e-4 else 1.0 - 0.5 * x + x * x / 6.0
        return -square * h * c, b, c
    decay = exp_minus(h * rate)
    inside = square - rate * rate
    if inside >= 0.0:
        cosine, _ = sin_cos(h * inside**0.5)
        trace = 2.0 * decay * cosine
    else:
        e = exp_minus(h * (-inside) ** 0.5)
        trace = decay * (e + 1.0 / e)
    det = decay * decay
    a = (trace - 1.0 - det) / h
    return a, 0.5 * (trace - 1.0 + det), -a / (square * h)


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
