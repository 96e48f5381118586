"""Distance: a rod, a rope or a spring between two anchors."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...springs import has_spring
from ..math import Vec, norm, scaled
from .build import add_limit, add_spring, copy_direction, finish_row, has_limit
from .point import frame_ahead, frame_rate, set_frame_direction

SHORT = 1e-9  # m: below it the direction between the anchors is not defined


@njit
def _direction(d: Vec, u: Vec) -> Vec:
    """d / |d|, or u where the anchors meet."""
    length = norm(d)
    if length < SHORT:
        return u
    return scaled(d, 1.0 / length)


@njit
def set_line_direction(row: Any, parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any) -> Any:
    """J of the distance between the anchors, half a substep ahead; (distance now, h/2 dJ/dt v)."""
    i = row.body_a
    j = row.body_b
    now = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h, 0.0)
    u = _direction(now[2], (0.0, 0.0, 1.0))
    middle = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h, 0.5 * h)
    end = frame_ahead(bodies, body_parameters, motions, i, j, parameters, h, h)
    v = _direction(middle[2], u)
    w = _direction(end[2], v)
    set_frame_direction(row, motions, middle, v)
    curve = frame_rate(motions, i, j, end, w) - frame_rate(motions, i, j, middle, v)
    return norm(now[2]), curve


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
        finish_row(rows[row], 0, length - parameters.length, motions)
        rows[row].bias = curve
        row += 1
    elif has_spring(parameters):
        row = add_spring(rows, row, 0, length - parameters.length, parameters, motions, h)
    if has_limit(parameters):
        copy_direction(rows[row], rows[first], 1.0)
        row = add_limit(rows, row, 1, length, curve, parameters, motions, h)
    return row
