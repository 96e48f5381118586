"""The parts that joints build rows from: rigid, soft, one-sided and driven rows along a direction."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .dispatch import by_dimension
from .rows import (
    BILATERAL,
    BOUNDED,
    EQUATION,
    GEARED,
    LIMIT_SLOP,
    NO_CORRECTION,
    UNILATERAL,
    free_rate,
    start_rate,
)
from .springs import set_oscillator, set_rotor_spring, set_spring

set_effective_mass = by_dimension("contact_rows", "set_effective_mass")

_INFINITY = float("inf")
_TWO_PI = 6.283185307179586


@njit
def finish_row(row: Any, slot: Any, error: Any, substep_bodies: Any) -> None:
    """Make a row whose Jacobian is set rigid and two-sided; it may be made soft, one-sided or driven afterwards."""
    row.kind = EQUATION
    row.correction = BILATERAL
    row.slot = slot
    row.error = error
    row.lower = -_INFINITY
    row.upper = _INFINITY
    row.bias = 0.0
    row.drive = 0.0
    row.softness = 0.0
    set_effective_mass(row, substep_bodies)


@njit
def has_limit(parameters: Any) -> Any:
    """Whether the coordinate of a joint is limited."""
    return parameters.lower > -_INFINITY or parameters.upper < _INFINITY


@njit
def has_motor(parameters: Any) -> Any:
    """Whether a joint has a motor."""
    return parameters.motor_effort > 0.0


@njit
def runs(parameters: Any, joint: Any) -> Any:
    """Whether a joint has a motor with a speed to reach, so that its island may not fall asleep."""
    return has_motor(parameters) and joint.motor_speed != 0.0


@njit
def has_friction(parameters: Any) -> Any:
    """Whether a joint has dry friction."""
    return parameters.friction_effort > 0.0


@njit
def has_armature(parameters: Any) -> Any:
    """Whether a joint has a rotor with inertia of its own."""
    return parameters.armature > 0.0


@njit
def soften(row: Any, parameters: Any, give: Any, speed: Any, substep_bodies: Any, h: Any) -> None:
    """Turn a rigid row into a spring and damper on its error; ``speed``, m/s or rad/s, is that of the rest point.

    ``give``: 1/kg or 1/(kg m^2), the inverse mass on which a given frequency is that of the spring; 0: the row's own.
    """
    set_spring(row, parameters, give, speed, substep_bodies, h)
    set_effective_mass(row, substep_bodies)


@njit
def bound_row(row: Any, bound: Any) -> None:
    """Limit the impulse of a row: |impulse| <= bound, in N s or N m s."""
    row.kind = BOUNDED
    row.lower = -bound
    row.upper = bound


@njit
def copy_direction(row: Any, other: Any, sign: Any) -> None:
    """Set the Jacobian to that of another row, times ``sign``."""
    for i in range(len(row.jacobian_a)):
        row.jacobian_a[i] = sign * other.jacobian_a[i]
        row.jacobian_b[i] = sign * other.jacobian_b[i]


@njit
def set_spring_row(
    row: Any, slot: Any, error: Any, curve: Any, parameters: Any, give: Any, substep_bodies: Any, h: Any
) -> None:
    """Make a row whose Jacobian is set a spring; ``curve`` as for motors, ``give`` as for ``soften``."""
    finish_row(row, slot, error, substep_bodies)
    row.bias = curve
    if parameters.armature > 0.0:
        row.bias = 0.0
        set_rotor_spring(row, parameters, give, substep_bodies, h)
        set_effective_mass(row, substep_bodies)
    else:
        soften(row, parameters, give, 0.0, substep_bodies, h)
    if parameters.spring_effort < _INFINITY:
        bound_row(row, h * parameters.spring_effort)


@njit
def set_limit_row(
    row: Any, slot: Any, coordinate: Any, curve: Any, parameters: Any, substep_bodies: Any, h: Any, side: Any = 0
) -> None:
    """Make a row whose Jacobian is set one of the two limits of a coordinate.

    ``curve``, m/s or rad/s: the change of J v by the end of the substep, h/2 dJ/dt v.
    ``side``: -1 for the lower limit, 1 for the upper one, 0 for the one that the coordinate comes nearer to.
    """
    below = coordinate - parameters.lower
    above = parameters.upper - coordinate
    if parameters.lower == parameters.upper:
        finish_row(row, slot, below, substep_bodies)
        row.bias = curve
        return
    gap = below
    ahead = h * start_rate(row, substep_bodies)  # a narrow range may be crossed within the substep
    if side > 0 or (side == 0 and above - ahead < below + ahead):
        gap = above
        curve = -curve
        slot = -1 - slot
        copy_direction(row, row, -1.0)
    finish_row(row, slot, gap, substep_bodies)
    row.kind = BOUNDED
    row.correction = UNILATERAL
    row.lower = 0.0
    row.bias = curve + (gap / h if gap > LIMIT_SLOP else 0.0)
    if parameters.limit_restitution > 0.0:
        _rebound(row, gap, parameters.limit_restitution, curve, substep_bodies, h)


@njit
def _rebound(row: Any, gap: Any, restitution: Any, curve: Any, substep_bodies: Any, h: Any) -> None:
    """Let the row of a limit that is reached within the substep ask for the speed after the impact.

    It turns round at the coordinate of the start of the substep, at the speed there, so that no energy is gained.
    """
    rate = start_rate(row, substep_bodies)
    nearest = min(rate, free_rate(row, substep_bodies))
    if rate < 0.0 and gap + h * nearest <= LIMIT_SLOP:
        row.bias = curve + restitution * rate


@njit
def soften_limit(row: Any, parameters: Any, give: Any, substep_bodies: Any, h: Any) -> None:
    """Make the row of a limit with a frequency a spring and damper that only pushes; ``give`` as for ``soften``."""
    if parameters.limit_frequency <= 0.0 or row.correction != UNILATERAL:
        return
    omega = _TWO_PI * parameters.limit_frequency
    share = row.diagonal / give if give > 0.0 else 1.0
    square = omega * omega * share
    rate = parameters.limit_damping_ratio * omega * share
    if row.error > 0.0:  # an implicit Euler step from where it begins to push
        row.softness = row.diagonal / (h * (2.0 * rate + h * square))
    else:
        set_oscillator(row, square, rate, 0.0, substep_bodies, h)
        row.kind = BOUNDED
    set_effective_mass(row, substep_bodies)


@njit
def speeds_within(coordinate: Any, curve: Any, parameters: Any, h: Any) -> Any:
    """Return (slowest, fastest) speed of a motor without a bound, which limits cannot stop; ``curve`` as for limits."""
    if parameters.motor_effort < _INFINITY:
        return -_INFINITY, _INFINITY
    below = max(coordinate - parameters.lower, 0.0)
    above = max(parameters.upper - coordinate, 0.0)
    return -below / h - curve, above / h - curve


@njit
def set_motor_row(row: Any, slot: Any, joint: Any, speeds: Any, curve: Any, substep_bodies: Any, h: Any) -> None:
    """Make a row whose Jacobian is set a motor: one that keeps a speed with a bounded effort, or a given effort.

    ``curve`` as for limits: the speed is that at the end of the substep; 0 for that at the pose of the row.
    """
    effort = joint.parameters.motor_effort
    finish_row(row, slot, 0.0, substep_bodies)
    row.correction = NO_CORRECTION
    speed = min(max(joint.state.motor_speed, speeds[0]), speeds[1])
    if joint.parameters.motor_gain < _INFINITY and not joint.model.effort_controlled:
        row.bias = curve
        set_oscillator(row, 0.0, 0.5 * joint.parameters.motor_gain * row.diagonal, speed, substep_bodies, h)
        set_effective_mass(row, substep_bodies)
    else:
        row.bias = curve - speed
    bound_row(row, h * effort)
    if joint.model.effort_controlled:
        row.lower = h * min(max(joint.state.effort, -effort), effort)
        row.upper = row.lower


@njit
def set_friction_row(row: Any, slot: Any, parameters: Any, curve: Any, substep_bodies: Any, h: Any) -> None:
    """Make a row whose Jacobian is set dry friction of bounded effort; ``curve`` as for motors."""
    finish_row(row, slot, 0.0, substep_bodies)
    row.bias = curve
    row.correction = NO_CORRECTION
    bound_row(row, h * parameters.friction_effort)


@njit
def set_armature_row(row: Any, slot: Any, joint: Any, curve: Any, substep_bodies: Any) -> None:
    """Make a row whose Jacobian is set the inertia of a rotor: its impulse is -armature times the change of the rate.

    ``curve``, as for limits: the rate is J v + curve at the end of the substep, about J v - curve at its start.  In
    smooth motion the rotor keeps the rate at which it ended the last substep, so that errors do not add up.
    """
    finish_row(row, slot, 0.0, substep_bodies)
    row.correction = NO_CORRECTION
    rate = start_rate(row, substep_bodies) - curve
    if abs(joint.state.rate - rate) <= abs(curve):
        rate = joint.state.rate
    joint.state.rate = rate
    row.bias = curve - rate
    row.softness = 1.0 / joint.parameters.armature
    set_effective_mass(row, substep_bodies)


@njit
def gear_rows(rows: Any, first: Any, end: Any, slot: Any) -> None:
    """Let the bounded rows of a joint with an armature be solved together with its rotor, whose row has ``slot``."""
    rotor = first
    while rotor < end and rows[rotor].slot != slot:
        rotor += 1
    for r in range(rotor + 1, end):
        if rows[r].kind == BOUNDED:
            rows[r].kind = GEARED
            rows[r].rotor = r - rotor


@njit
def bound_user_row(row: Any, given: Any, substep_bodies: Any, h: Any) -> None:
    """Set the bounds and the softness of a row of a user constraint."""
    if not (given.lower > -_INFINITY or given.upper < _INFINITY or given.softness > 0.0):
        return
    row.kind = BOUNDED
    row.correction = NO_CORRECTION
    row.lower = h * given.lower
    row.upper = h * given.upper
    row.softness = given.softness
    set_effective_mass(row, substep_bodies)
    if given.lower == 0.0 and given.upper == _INFINITY:
        row.correction = UNILATERAL
    elif given.lower == -_INFINITY and given.upper == 0.0 and given.error != 0.0:
        _reverse(row)


@njit
def _reverse(row: Any) -> None:
    """Reverse the sign of a row that only pulls, so that the position pass corrects it as a unilateral row."""
    copy_direction(row, row, -1.0)
    row.slot = -1 - row.slot
    row.bias = -row.bias
    row.error = -row.error
    row.correction = UNILATERAL
    row.lower = 0.0
    row.upper = _INFINITY
