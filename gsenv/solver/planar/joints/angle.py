"""Rows on the angle between two bodies."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...core.trig import atan2
from ...jit import njit
from .point import set_direction


@njit
def relative_angle(a: Any, b: Any, reference: Any) -> Any:
    """Return the angle of record b relative to a minus ``reference`` (cos, sin), in (-pi, pi] rad."""
    c = a.rotation[0] * b.rotation[0] + a.rotation[1] * b.rotation[1]
    s = a.rotation[0] * b.rotation[1] - a.rotation[1] * b.rotation[0]
    return atan2(s * reference[0] - c * reference[1], c * reference[0] + s * reference[1])


@njit
def unwrapped_angle(a: Any, b: Any, parameters: Any) -> Any:
    """Return angle_b - angle_a since the initial pose in rad, unwrapped."""
    return b.angle - a.angle - parameters.reference_angle


@njit
def set_angle_direction(row: Any) -> None:
    set_direction(row, 0.0, 0.0, -1.0, 1.0)


@njit
def set_angle_row(row: Any, slot: Any, error: Any, substep_bodies: Any) -> None:
    """Make a rigid row of C = angle_b - angle_a - reference, given as ``error`` in rad."""
    set_angle_direction(row)
    finish_row(row, slot, error, substep_bodies)
