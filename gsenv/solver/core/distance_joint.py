"""Rows of a distance joint: a rod, a rope or a spring between two anchors, in 2D and 3D."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .dispatch import by_dimension
from .joint_rows import copy_direction, finish_row, has_limit, set_limit_row, set_spring_row
from .springs import has_spring

anchor_give = by_dimension("joints.reference", "anchor_give")
set_line_direction = by_dimension("joints.distance", "set_line_direction")


@njit
def add_distance_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of a distance joint. Slots of its impulses: 0 rod or spring, 1 limit."""
    if not (parameters.rigid or has_limit(parameters) or has_spring(parameters)):
        return
    first = row
    length, curve = set_line_direction(rows[first], parameters, bodies, body_parameters, substep_bodies, h)
    if parameters.rigid:
        finish_row(rows[row], 0, length - parameters.length, substep_bodies)
        rows[row].bias = curve
        row += 1
    elif has_spring(parameters):
        a, b = body_parameters[rows[row].body_a], body_parameters[rows[row].body_b]
        give = anchor_give(parameters, a, b)
        set_spring_row(rows[row], 0, length - parameters.length, 0.0, parameters, give, substep_bodies, h)
        row += 1
    if has_limit(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        set_limit_row(rows[row], 1, length, curve, parameters, substep_bodies, h)
