"""Gear: couples the coordinates of two joints, q_a + ratio q_b = constant.

The row acts on the joints' second bodies.  Where both joints are on one moving body, that body takes the
reaction torque of -(1 + ratio): as a pair of forces at the two pins, F = -(1 + ratio) perp(d) / |d|^2 for
pins at a distance d, like meshing teeth.  Directions are those of the pose half a substep ahead, as in
``set_point_rows``.  Of other joints on moving bodies the row has two halves, one on the bodies of each joint.
"""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...jit import njit
from ...records.model import JointKind
from ..math import cross
from .angle import set_angle_direction, unwrapped_angle
from .point import arm, axis_ahead, frame_ahead, turned
from .prismatic import set_axis_direction

_PRISMATIC = int(JointKind.PRISMATIC)


@njit
def _coordinate(joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> Any:
    """Return (coordinate, its Jacobian on body b) of a revolute joint, or of a prismatic joint on a static body."""
    i = joint.model.body_a
    j = joint.model.body_b
    parameters = joint.parameters
    if joint.model.kind != _PRISMATIC:
        return unwrapped_angle(bodies[i], bodies[j], parameters), 0.0, 0.0, 1.0
    ux, uy = axis_ahead(bodies, substep_bodies, i, parameters, 0.0)
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.0)
    _, _, bx, by, _, _ = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.5 * h)
    return ux * dx + uy * dy, ux, uy, cross(bx, by, ux, uy)


@njit
def _pin_ahead(body: Any, body_parameters: Any, substep_body: Any, anchor: Any, t: Any) -> Any:
    """Return (arm, position) of a pin ``t`` s ahead at the velocities of the start."""
    v = substep_body.start_velocity
    ax, ay = arm(body, body_parameters, anchor)
    ax, ay = turned(ax, ay, t * v[2])
    return ax, ay, body.position[0] + t * v[0] + ax, body.position[1] + t * v[1] + ay


@njit
def add_gear_rows(
    made: Any, gear: Any, first: Any, second: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the row ``made``, slot 0, of a gear between the joints ``first`` and ``second``."""
    k = gear.parameters.ratio
    p, px, py, pt = _coordinate(first, bodies, body_parameters, substep_bodies, h)
    q, qx, qy, qt = _coordinate(second, bodies, body_parameters, substep_bodies, h)
    fx = 0.0
    fy = 0.0
    i = gear.model.body_a
    j = gear.model.body_b
    ax, ay, x, y = _pin_ahead(bodies[i], body_parameters[i], substep_bodies[i], first.parameters.anchor_b, 0.5 * h)
    bx, by, dx, dy = _pin_ahead(bodies[j], body_parameters[j], substep_bodies[j], second.parameters.anchor_b, 0.5 * h)
    frame = first.model.body_a
    if body_parameters[frame].inv_mass > 0.0 or substep_bodies[frame].start_velocity[2] != 0.0:
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
    finish_row(made, 0, p + k * q - gear.parameters.reference_angle, substep_bodies)


@njit
def set_coordinate(made: Any, joint: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> Any:
    """Set bodies and Jacobian of a row to those of a joint's coordinate; returns (coordinate, h/2 dJ/dt v)."""
    parameters = joint.parameters
    i = joint.model.body_a
    j = joint.model.body_b
    made.body_a = i
    made.body_b = j
    if joint.model.kind != _PRISMATIC:
        set_angle_direction(made)
        return unwrapped_angle(bodies[i], bodies[j], parameters), 0.0
    ux, uy = axis_ahead(bodies, substep_bodies, i, parameters, 0.0)
    _, _, _, _, dx, dy = frame_ahead(bodies, body_parameters, substep_bodies, i, j, parameters, 0.0)
    curve = set_axis_direction(made, parameters, bodies, body_parameters, substep_bodies, h)
    return ux * dx + uy * dy, curve
