"""Weld: two anchors and the angle between two bodies held, rigidly or by a spring."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..math import atan2
from .point import set_angle_row, set_point_rows, soften


@njit
def relative_angle(a: Any, b: Any, reference: Any) -> Any:
    """Rotation of record b in a, less ``reference`` (cos, sin), in (-pi, pi]."""
    c = a.rotation[0] * b.rotation[0] + a.rotation[1] * b.rotation[1]
    s = a.rotation[0] * b.rotation[1] - a.rotation[1] * b.rotation[0]
    return atan2(s * reference[0] - c * reference[1], c * reference[0] + s * reference[1])


@njit
def set_weld_rows(rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, h: Any) -> None:
    set_point_rows(rows, row, parameters, bodies, body_parameters, h)
    angle = rows[row + 2]
    error = relative_angle(bodies[angle.body_a], bodies[angle.body_b], parameters.reference)
    set_angle_row(angle, error, body_parameters)
    if parameters.frequency > 0.0:
        for r in range(3):
            soften(rows[row + r], parameters.frequency, parameters.damping_ratio, h)
