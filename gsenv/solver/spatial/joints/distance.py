"""Distance joint: the direction between two anchors; its rows are in core/distance_joint.py."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..math import Vec, add, cross, norm, scaled, sub, vec
from .point import arm, frame_ahead, frame_rate, set_frame_direction

SHORT = 1e-9  # m: for smaller distances the direction between the anchors is undefined


@njit
def _direction(d: Vec, u: Vec) -> Vec:
    """Return d / |d|, or u where the anchors coincide."""
    length = norm(d)
    if length < SHORT:
        return u
    return scaled(d, 1.0 / length)


@njit
def set_line_direction(
    row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> Any:
    """Set J of the anchors' distance, half a substep ahead; returns (present distance, h/2 dJ/dt v)."""
    i = row.body_a
    j = row.body_b
    now = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h, 0.0)
    u = _direction(now[2], (0.0, 0.0, 1.0))
    middle = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h, 0.5 * h)
    end = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, h, h)
    v = _direction(middle[2], u)
    w = _direction(end[2], v)
    set_frame_direction(row, substep_bodies, middle, v)
    curve = frame_rate(substep_bodies, i, j, end, w) - frame_rate(substep_bodies, i, j, middle, v)
    return norm(now[2]), curve


@njit
def anchor_distance(body_a: Any, body_b: Any, a: Any, b: Any, parameters: Any) -> Any:
    """Return the distance of the anchors at the present poses, m; ``a``, ``b``: parameters of the bodies."""
    end_a = add(vec(body_a.position), arm(body_a, a, parameters.anchor_a))
    end_b = add(vec(body_b.position), arm(body_b, b, parameters.anchor_b))
    return norm(sub(end_b, end_a))


@njit
def line_speed(body_a: Any, body_b: Any, a: Any, b: Any, parameters: Any, velocity_a: Any, velocity_b: Any) -> Any:
    """Return the speed of anchor b relative to anchor a at given velocities, m/s; bodies without inv_mass stay."""
    turn_a = cross(vec(velocity_a[3:]), arm(body_a, a, parameters.anchor_a))
    turn_b = cross(vec(velocity_b[3:]), arm(body_b, b, parameters.anchor_b))
    u_a = scaled(add(vec(velocity_a[:3]), turn_a), 1.0 if a.inv_mass > 0.0 else 0.0)
    u_b = scaled(add(vec(velocity_b[:3]), turn_b), 1.0 if b.inv_mass > 0.0 else 0.0)
    return norm(sub(u_b, u_a))
