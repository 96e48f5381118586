"""Distance joint: the direction between two anchors; its rows are in core/distance_joint.py."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from .point import arm, curve_of, frame_ahead, set_frame_direction

SHORT = 1e-9  # m: for smaller distances the direction between the anchors is undefined


@njit
def _unit(dx: Any, dy: Any, ux: Any, uy: Any) -> Any:
    """Return d / |d|, or u where the anchors coincide."""
    length = (dx * dx + dy * dy) ** 0.5
    if length < SHORT:
        return ux, uy
    return dx / length, dy / length


@njit
def set_line_direction(
    row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> Any:
    """Set J of the anchors' distance, half a substep ahead; returns (present distance, h/2 dJ/dt v)."""
    i = row.body_a
    j = row.body_b
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.0)
    ux, uy = _unit(dx, dy, 0.0, 1.0)
    middle = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.5 * h)
    end = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h)
    vx, vy = _unit(middle[4], middle[5], ux, uy)
    wx, wy = _unit(end[4], end[5], vx, vy)
    set_frame_direction(row, middle, vx, vy)
    curve = curve_of(row, end, wx, wy, substep_bodies)
    set_frame_direction(row, middle, vx, vy)
    return (dx * dx + dy * dy) ** 0.5, curve


@njit
def anchor_distance(body_a: Any, body_b: Any, a: Any, b: Any, parameters: Any) -> Any:
    """Return the distance of the anchors at the present poses, m; ``a``, ``b``: parameters of the bodies."""
    ax, ay = arm(body_a, a, parameters.anchor_a)
    bx, by = arm(body_b, b, parameters.anchor_b)
    dx = body_b.position[0] + bx - body_a.position[0] - ax
    dy = body_b.position[1] + by - body_a.position[1] - ay
    return (dx * dx + dy * dy) ** 0.5


@njit
def line_speed(body_a: Any, body_b: Any, a: Any, b: Any, parameters: Any, velocity_a: Any, velocity_b: Any) -> Any:
    """Return the speed of anchor b relative to anchor a at given velocities, m/s; bodies without inv_mass stay."""
    ax, ay = arm(body_a, a, parameters.anchor_a)
    bx, by = arm(body_b, b, parameters.anchor_b)
    moves_a = 1.0 if a.inv_mass > 0.0 else 0.0
    moves_b = 1.0 if b.inv_mass > 0.0 else 0.0
    ux = moves_b * (velocity_b[0] - by * velocity_b[2]) - moves_a * (velocity_a[0] - ay * velocity_a[2])
    uy = moves_b * (velocity_b[1] + bx * velocity_b[2]) - moves_a * (velocity_a[1] + ax * velocity_a[2])
    return (ux * ux + uy * uy) ** 0.5
