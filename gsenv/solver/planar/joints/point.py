"""Rows that joints share: two that hold anchors together, one that holds an angle, and softness."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...rows import BOUNDED, set_effective_mass
from ..contact_rows import set_response

_INFINITY = float("inf")
_TWO_PI = 6.283185307179586


@njit
def set_point_rows(rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any) -> None:
    """C = anchor_b - anchor_a in the world, along x and y."""
    a = bodies[rows[row].body_a]
    b = bodies[rows[row].body_b]
    pa = body_parameters[rows[row].body_a]
    pb = body_parameters[rows[row].body_b]
    lax = parameters.anchor_a[0] - pa.center[0]
    lay = parameters.anchor_a[1] - pa.center[1]
    lbx = parameters.anchor_b[0] - pb.center[0]
    lby = parameters.anchor_b[1] - pb.center[1]
    ax = a.rotation[0] * lax - a.rotation[1] * lay
    ay = a.rotation[1] * lax + a.rotation[0] * lay
    bx = b.rotation[0] * lbx - b.rotation[1] * lby
    by = b.rotation[1] * lbx + b.rotation[0] * lby
    set_direction(rows[row], 1.0, 0.0, ay, -by)
    set_direction(rows[row + 1], 0.0, 1.0, -ax, bx)
    rows[row].error = b.position[0] + bx - a.position[0] - ax
    rows[row + 1].error = b.position[1] + by - a.position[1] - ay
    for r in range(2):
        finish_row(rows[row + r], body_parameters)


@njit
def set_direction(row: Any, ux: Any, uy: Any, turn_a: Any, turn_b: Any) -> None:
    row.jacobian_a[0] = -ux
    row.jacobian_a[1] = -uy
    row.jacobian_a[2] = turn_a
    row.jacobian_b[0] = ux
    row.jacobian_b[1] = uy
    row.jacobian_b[2] = turn_b


@njit
def set_angle_row(row: Any, error: Any, body_parameters: Any) -> None:
    """C = angle_b - angle_a - reference, given as ``error`` in rad."""
    set_direction(row, 0.0, 0.0, -1.0, 1.0)
    row.error = error
    finish_row(row, body_parameters)


@njit
def finish_row(row: Any, body_parameters: Any) -> None:
    """A rigid two-sided row; make it soft or bounded afterwards."""
    row.kind = BOUNDED
    row.lower = -_INFINITY
    row.upper = _INFINITY
    row.bias = 0.0
    row.softness = 0.0
    set_response(row, body_parameters)
    set_effective_mass(row)


@njit
def soften(row: Any, frequency: Any, damping_ratio: Any, h: Any) -> None:
    """Turn a rigid row into an implicit spring on the mass that the row sees.

    k = m omega^2, c = 2 m zeta omega; softness = 1 / (h (c + h k)), bias = C k / (c + h k).
    Catto, "Soft constraints", GDC 2011.
    """
    omega = _TWO_PI * frequency
    a = 2.0 * damping_ratio + h * omega
    if row.diagonal > 0.0 and a > 0.0:
        row.bias = omega / a * row.error
        row.softness = row.diagonal / (h * omega * a)
        row.error = 0.0
        set_effective_mass(row)
