"""Gear: couples the coordinates of two joints, q_a + ratio q_b = constant.

The row works on the joints' second bodies.  Where both joints sit on one moving body, that one has to
feel -(1 + ratio) of the torque: it gets it as a pair of forces through the two pins,
F = -(1 + ratio) perp(d) / |d|^2 for pins that are d apart, which is what meshing teeth do.  Directions
are those of the pose half a substep ahead, as in ``set_point_rows``.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..math import cross
from .angle import unwrapped_angle
from .build import finish_row
from .point import arm, axis_ahead, frame_ahead, turned


@njit
def _coordinate(
    model: Any, parameters: Any, prismatic: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """(coordinate, its Jacobian on the joint's body b) of a revolute joint, or of a prismatic one on a static body."""
    i = model.body_a
    j = model.body_b
    if not prismatic:
        return unwrapped_angle(bodies[i], bodies[j], parameters), 0.0, 0.0, 1.0
    ux, uy = axis_ahead(bodies, motions, i, parameters, 0.0)
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.0)
    _, _, bx, by, _, _ = frame_ahead(bodies, body_parameters, motions, i, j, parameters, 0.5 * h)
    return ux * dx + uy * dy, ux, uy, cross(bx, by, ux, uy)


@njit
def _pin_ahead(body: Any, body_parameters: Any, motion: Any, anchor: Any, t: Any) -> Any:
    """(arm, place) of a pin, ``t`` s ahead at the start's velocities."""
    v = motion.start_velocity
    ax, ay = arm(body, body_parameters, anchor)
    ax, ay = turned(ax, ay, t * v[2])
    return ax, ay, body.position[0] + t * v[0] + ax, body.position[1] + t * v[1] + ay


@njit
def add_gear_rows(
    rows: Any, row: Any, model: Any, parameters: Any, first: Any, first_parameters: Any, first_prismatic: Any,
    second: Any, second_parameters: Any, second_prismatic: Any, bodies: Any, body_parameters: Any, motions: Any,
    h: Any,
) -> Any:  # fmt: skip
    """Slot 0, of the joints ``first`` and ``second``."""
    made = rows[row]
    k = parameters.ratio
    p, px, py, pt = _coordinate(first, first_parameters, first_prismatic, bodies, body_parameters, motions, h)
    q, qx, qy, qt = _coordinate(second, second_parameters, second_prismatic, bodies, body_parameters, motions, h)
    fx = 0.0
    fy = 0.0
    i = model.body_a
    j = model.body_b
    ax, ay, x, y = _pin_ahead(bodies[i], body_parameters[i], motions[i], first_parameters.anchor_b, 0.5 * h)
    bx, by, dx, dy = _pin_ahead(bodies[j], body_parameters[j], motions[j], second_parameters.anchor_b, 0.5 * h)
    frame = first.body_a
    if body_parameters[frame].inv_mass > 0.0 or motions[frame].start_velocity[2] != 0.0:
        dx -= x
        dy -= y
        square = max(dx * dx + dy * dy, 1e-300)
        fx = (1.0 + k) * dy / square
        fy = -(1.0 + k) * dx / square
    made.jacobian_a[0] = px - fx
    made.jacobian_a[1] = py - fy
    made.jacobian_a[2] = pt - cross(ax, ay, fx, fy)
    made.jacobian_b[0] = k * qx + fx
    made.jacobian_b[1] = k * qy + fy
    made.jacobian_b[2] = k * qt + cross(bx, by, fx, fy)
    finish_row(made, 0, p + k * q - parameters.reference_angle, body_parameters)
    return row + 1
