"""Distance: a rod, a rope or a spring between two anchors."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from .build import add_limit, add_spring, copy_direction, finish_row, has_limit
from .point import curve_of, frame_ahead, set_frame_direction

SHORT = 1e-9  # m: below it the direction between the anchors is not defined


@njit
def _unit(dx: Any, dy: Any, ux: Any, uy: Any) -> Any:
    """d / |d|, or u where the anchors meet."""
    length = (dx * dx + dy * dy) ** 0.5
    if length < SHORT:
        return ux, uy
    return dx / length, dy / length


@njit
def set_line_direction(row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any) -> Any:
    """J of the distance between the anchors, half a substep ahead; (distance now, h/2 dJ/dt v)."""
    i = row.body_a
    j = row.body_b
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.0)
    ux, uy = _unit(dx, dy, 0.0, 1.0)
    middle = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.5 * h)
    end = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h)
    vx, vy = _unit(middle[4], middle[5], ux, uy)
    wx, wy = _unit(end[4], end[5], vx, vy)
    set_frame_direction(row, middle, vx, vy)
    curve = curve_of(row, end, wx, wy, motions)
    set_frame_direction(row, middle, vx, vy)
    return (dx * dx + dy * dy) ** 0.5, curve


@njit
def add_distance_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Slots: 0 rod or spring, 1 limit."""
    if not (parameters.rigid or has_limit(parameters) or has_spring(parameters)):
        return row
    first = row
    length, curve = set_line_direction(rows[first], parameters, bodies, body_parameters, motions, h)
    if parameters.rigid:
        finish_row(rows[row], 0, length - parameters.length, body_parameters)
        rows[row].bias = curve
        row += 1
    elif has_spring(parameters):
        row = add_spring(rows, row, 0, length - parameters.length, parameters, body_parameters, motions, h)
    if has_limit(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        row = add_limit(rows, row, 1, length, curve, parameters, body_parameters, motions, h)
    return row
