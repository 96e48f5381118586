"""Ball: two anchors coincide; the bodies rotate freely about them."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from .point import set_point_rows


@njit
def add_ball_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a ball joint. Slots: 0 to 2 the anchor."""
    set_point_rows(rows, row, parameters, bodies, body_parameters, substep_bodies, h)
