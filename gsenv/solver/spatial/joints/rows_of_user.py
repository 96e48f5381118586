"""Rows written by the user: Jacobian, bounds, bias and softness as given, in the world or in body a."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...rows import BOUNDED, HELD_APART, UNHELD
from ..contact_rows import set_effective_mass
from ..frames import in_frame, set_spin, spin_of
from ..math import Quaternion, dot, turned, vec
from .build import finish_row
from .point import rotation_ahead, start_spin

_INFINITY = float("inf")


@njit
def add_user_rows(
    rows: Any, row: Any, model: Any, constraint_rows: Any, bodies: Any, motions: Any, h: Any
) -> Any:
    """Directions that turn with a body are those of the pose half a substep ahead, as in ``set_point_rows``."""
    for r in range(model.row_count):
        given = constraint_rows[model.row_first + r]
        made = rows[row + r]
        middle = (1.0, 0.0, 0.0, 0.0)
        curve = 0.0
        if model.frame:
            body = bodies[model.body_a]
            motion = motions[model.body_a]
            middle = rotation_ahead(body, motion, 0.5 * h)
            end = rotation_ahead(body, motion, h)
            curve = _rate(given, model, motions, end) - _rate(given, model, motions, middle)
        _set_side(made.jacobian_a, given.jacobian_a, middle, motions[model.body_a])
        _set_side(made.jacobian_b, given.jacobian_b, middle, motions[model.body_b])
        finish_row(made, r, given.error, motions)
        made.bias = given.bias + curve
        made.drive = given.bias
        if given.lower > -_INFINITY or given.upper < _INFINITY or given.softness > 0.0:
            made.kind = BOUNDED
            made.hold = UNHELD
            made.lower = h * given.lower
            made.upper = h * given.upper
            made.softness = given.softness
            set_effective_mass(made, motions)
            if given.lower == 0.0 and given.upper == _INFINITY:
                made.hold = HELD_APART
            elif given.lower == -_INFINITY and given.upper == 0.0 and given.error != 0.0:
                _turn_round(made)
    return row + model.row_count


@njit
def _set_side(jacobian: Any, given: Any, q: Quaternion, motion: Any) -> None:
    u = turned(q, vec(given))
    for d in range(3):
        jacobian[d] = u[d]
    set_spin(jacobian, in_frame(motion, turned(q, spin_of(given))))


@njit
def _rate(given: Any, model: Any, motions: Any, q: Quaternion) -> Any:
    """J v at the start's velocities with directions turned by q."""
    a = motions[model.body_a]
    b = motions[model.body_b]
    s = dot(turned(q, vec(given.jacobian_a)), vec(a.start_velocity))
    s += dot(turned(q, spin_of(given.jacobian_a)), start_spin(a))
    s += dot(turned(q, vec(given.jacobian_b)), vec(b.start_velocity))
    return s + dot(turned(q, spin_of(given.jacobian_b)), start_spin(b))


@njit
def _turn_round(row: Any) -> None:
    """A row that pulls becomes one that pushes, which the position pass can hold apart."""
    for d in range(len(row.jacobian_a)):
        row.jacobian_a[d] = -row.jacobian_a[d]
        row.jacobian_b[d] = -row.jacobian_b[d]
    row.slot = -1 - row.slot
    row.bias = -row.bias
    row.error = -row.error
    row.hold = HELD_APART
    row.lower = 0.0
    row.upper = _INFINITY
