"""Rows of a user constraint: Jacobian, bounds, bias and softness as given, in the world or in body a."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import bound_user_row, finish_row
from ...core.rows import start_rate
from ...core.trig import sin_cos
from ...jit import njit
from ..math import rotate


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
        for d in range(3):
            made.jacobian_a[d] = given.jacobian_a[d]
            made.jacobian_b[d] = given.jacobian_b[d]
        curve = 0.0
        if model.frame:
            rotation = bodies[model.body_a].rotation
            c, s = sin_cos(0.5 * h * substep_bodies[model.body_a].start_velocity[2])
            _rotate_directions(made, rotation[0], rotation[1])
            _rotate_directions(made, c, s)
            midpoint_rate = start_rate(made, substep_bodies)
            _rotate_directions(made, c, s)
            curve = start_rate(made, substep_bodies) - midpoint_rate
            _rotate_directions(made, c, -s)
        finish_row(made, r, given.error, substep_bodies)
        made.bias = given.bias + curve
        made.drive = given.bias
        bound_user_row(made, given, substep_bodies, h)


@njit
def _rotate_directions(row: Any, c: Any, s: Any) -> None:
    for side in range(2):
        jacobian = row.jacobian_a if side == 0 else row.jacobian_b
        x, y = rotate(c, s, jacobian[0], jacobian[1])
        jacobian[0] = x
        jacobian[1] = y
