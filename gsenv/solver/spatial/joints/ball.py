"""Ball: an anchor of b held at an anchor of a; both turn freely about it."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from .point import set_point_rows


@njit
def add_ball_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slots: 0 to 2 the anchor."""
    set_point_rows(rows, row, parameters, bodies, body_parameters, motions, h)
    return row + 3
