"""Rows written by the user: Jacobian, bounds, bias and softness as given, in the world or in body a."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...motion import start_rate
from ...rows import BOUNDED, HELD_APART, UNHELD
from ...trig import sin_cos
from ..contact_rows import set_effective_mass
from ..math import rotate
from .build import finish_row

_INFINITY = float("inf")


@njit
def add_user_rows(
    rows: Any, row: Any, model: Any, constraint_rows: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Directions that turn with a body are those of the pose half a substep ahead, as in ``set_point_rows``."""
    for r in range(model.row_count):
        given = constraint_rows[model.row_first + r]
        made = rows[row + r]
        for d in range(3):
            made.jacobian_a[d] = given.jacobian_a[d]
            made.jacobian_b[d] = given.jacobian_b[d]
        curve = 0.0
        if model.frame:
            rotation = bodies[model.body_a].rotation
            c, s = sin_cos(0.5 * h * motions[model.body_a].start_velocity[2])
            _turn_directions(made, rotation[0], rotation[1])
            _turn_directions(made, c, s)
            middle = start_rate(made, motions)
            _turn_directions(made, c, s)
            curve = start_rate(made, motions) - middle
            _turn_directions(made, c, -s)
        finish_row(made, r, given.error, body_parameters)
        made.bias = given.bias + curve
        made.drive = given.bias
        if given.lower > -_INFINITY or given.upper < _INFINITY or given.softness > 0.0:
            made.kind = BOUNDED
            made.hold = UNHELD
            made.lower = h * given.lower
            made.upper = h * given.upper
            made.softness = given.softness
            set_effective_mass(made, body_parameters)
            if given.lower == 0.0 and given.upper == _INFINITY:
                made.hold = HELD_APART
            elif given.lower == -_INFINITY and given.upper == 0.0 and given.error != 0.0:
                _turn_round(made)
    return row + model.row_count


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


@njit
def _turn_directions(row: Any, c: Any, s: Any) -> None:
    for side in range(2):
        jacobian = row.jacobian_a if side == 0 else row.jacobian_b
        x, y = rotate(c, s, jacobian[0], jacobian[1])
        jacobian[0] = x
        jacobian[1] = y
