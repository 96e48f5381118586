"""Rows of a user constraint: Jacobian, bounds, bias and softness as given, in the world or in body a."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import bound_user_row, finish_row
from ...jit import njit
from ..math import Quaternion, dot, turned, vec
from ..rotation import in_frame, set_spin, spin_of
from .point import rotation_ahead, start_spin


@njit
def add_user_constraint_rows(
    rows: Any, row: Any, model: Any, constraint_rows: Any, bodies: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a user constraint.

    Directions that rotate with a body are those of the pose half a substep ahead, as in ``set_point_rows``.
    """
    for r in range(model.row_count):
        given = constraint_rows[model.row_first + r]
        made = rows[row + r]
        middle = (1.0, 0.0, 0.0, 0.0)
        curve = 0.0
        if model.frame:
            body = bodies[model.body_a]
            motion = substep_bodies[model.body_a]
            middle = rotation_ahead(body, motion, h, 0.5 * h)
            end = rotation_ahead(body, motion, h, h)
            curve = _rate(given, model, substep_bodies, end) - _rate(given, model, substep_bodies, middle)
        _set_side(made.jacobian_a, given.jacobian_a, middle, substep_bodies[model.body_a])
        _set_side(made.jacobian_b, given.jacobian_b, middle, substep_bodies[model.body_b])
        finish_row(made, r, given.error, substep_bodies)
        made.bias = given.bias + curve
        made.drive = given.bias
        bound_user_row(made, given, substep_bodies, h)


@njit
def _set_side(jacobian: Any, given: Any, q: Quaternion, motion: Any) -> None:
    u = turned(q, vec(given))
    for d in range(3):
        jacobian[d] = u[d]
    set_spin(jacobian, in_frame(motion, turned(q, spin_of(given))))


@njit
def _rate(given: Any, model: Any, substep_bodies: Any, q: Quaternion) -> Any:
    """Return J v at the velocities of the start, with directions rotated by q."""
    a = substep_bodies[model.body_a]
    b = substep_bodies[model.body_b]
    s = dot(turned(q, vec(given.jacobian_a)), vec(a.start_velocity))
    s += dot(turned(q, spin_of(given.jacobian_a)), start_spin(a))
    s += dot(turned(q, vec(given.jacobian_b)), vec(b.start_velocity))
    return s + dot(turned(q, spin_of(given.jacobian_b)), start_spin(b))
