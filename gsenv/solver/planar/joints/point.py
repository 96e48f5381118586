"""Rows that joints share: two that hold anchors together, one that holds an angle, and softness."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...rows import BOUNDED, set_effective_mass
from ..contact_rows import set_response
from ..math import sin_cos

_INFINITY = float("inf")
_TWO_PI = 6.283185307179586
JUMP = 1e-3  # of the extent: so far the anchors may part in half a substep of smooth motion


@njit
def set_point_rows(rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, h: Any) -> None:
    """C = anchor_b - anchor_a in the world, along x and y.

    Directions are those of the pose half a substep ahead, which the mean velocity moves through, and
    the bias is what the rotating arms add to J v from there to the end, h/2 dJ/dt v.  Then turning
    bodies keep their momentum and energy to second order; at the pose of the start they would lose
    the factor cos(w h) in each substep.
    """
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
    rows[row].error = b.position[0] + bx - a.position[0] - ax
    rows[row + 1].error = b.position[1] + by - a.position[1] - ay
    wa = a.velocity[2]
    wb = b.velocity[2]
    ux = b.velocity[0] - wb * by - a.velocity[0] + wa * ay
    uy = b.velocity[1] + wb * bx - a.velocity[1] - wa * ax
    if 0.5 * h * (abs(ux) + abs(uy)) > JUMP * min(pa.extent, pb.extent):
        wa = 0.0  # velocities that part will jump: the pose of the start keeps the momentum then
        wb = 0.0
    ax, ay = _turned(ax, ay, 0.5 * h * wa)
    bx, by = _turned(bx, by, 0.5 * h * wb)
    set_direction(rows[row], 1.0, 0.0, ay, -by)
    set_direction(rows[row + 1], 0.0, 1.0, -ax, bx)
    for r in range(2):
        finish_row(rows[row + r], body_parameters)
    rows[row].bias = 0.5 * h * (wa * wa * ax - wb * wb * bx)
    rows[row + 1].bias = 0.5 * h * (wa * wa * ay - wb * wb * by)


@njit
def _turned(x: Any, y: Any, angle: Any) -> Any:
    c, s = sin_cos(angle)
    return c * x - s * y, s * x + c * y


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
        row.bias += omega / a * row.error
        row.softness = row.diagonal / (h * omega * a)
        row.error = 0.0
        set_effective_mass(row)
