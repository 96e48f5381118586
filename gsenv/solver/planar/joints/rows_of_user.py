"""Rows written by the user: Jacobian, bounds, bias and softness as given, in the world frame."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...rows import set_effective_mass
from .point import finish_row


@njit
def set_user_rows(
    rows: Any, row: Any, model: Any, constraint_rows: Any, bodies: Any, body_parameters: Any, h: Any
) -> None:
    for r in range(model.row_count):
        given = constraint_rows[model.row_first + r]
        made = rows[row + r]
        for d in range(3):
            made.jacobian_a[d] = given.jacobian_a[d]
            made.jacobian_b[d] = given.jacobian_b[d]
        made.error = 0.0
        finish_row(made, body_parameters)
        made.lower = h * given.lower
        made.upper = h * given.upper
        made.bias = given.bias
        made.softness = given.softness
        set_effective_mass(made)
