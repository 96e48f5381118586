"""Positions and velocities of two bodies' anchors, and the rows that keep them together."""

from __future__ import annotations

from typing import Any

from ...core.joint_rows import finish_row
from ...core.rows import start_rate
from ...core.trig import sin_cos
from ...jit import njit
from ..math import cross, rotate

JUMP = 0.05  # of the speeds of the arms: where anchors separate faster, velocities will jump


@njit
def set_direction(row: Any, ux: Any, uy: Any, turn_a: Any, turn_b: Any) -> None:
    """Set the Jacobian of J v = u . (v_b - v_a) + turn_a w_a + turn_b w_b."""
    row.jacobian_a[0] = -ux
    row.jacobian_a[1] = -uy
    row.jacobian_a[2] = turn_a
    row.jacobian_b[0] = ux
    row.jacobian_b[1] = uy
    row.jacobian_b[2] = turn_b


@njit
def arm(body: Any, parameters: Any, anchor: Any) -> Any:
    """Return the vector from the centre of mass to an anchor, in the world, m."""
    x = anchor[0] - parameters.center[0]
    y = anchor[1] - parameters.center[1]
    return rotate(body.rotation[0], body.rotation[1], x, y)


@njit
def turned(x: Any, y: Any, angle: Any) -> Any:
    c, s = sin_cos(angle)
    return rotate(c, s, x, y)


@njit
def set_point_rows(
    rows: Any, row: Any, parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> None:
    """Write the rows of C = anchor_b - anchor_a in the world, along x and y, in slots 0 and 1.

    Directions are those of the pose half a substep ahead, at the midpoint of the motion, and the bias is
    the change of J v by the rotating arms from there to the end, h/2 dJ/dt v.  Rotating bodies then keep
    their momentum and energy to second order; at the pose of the start they would lose the factor
    cos(w h) in each substep.
    """
    i = rows[row].body_a
    j = rows[row].body_b
    ax, ay = arm(bodies[i], body_parameters[i], parameters.anchor_a)
    bx, by = arm(bodies[j], body_parameters[j], parameters.anchor_b)
    cx = bodies[j].position[0] + bx - bodies[i].position[0] - ax
    cy = bodies[j].position[1] + by - bodies[i].position[1] - ay
    wa = substep_bodies[i].start_velocity[2]
    wb = substep_bodies[j].start_velocity[2]
    begin = ax, ay, bx, by
    ahead = (*turned(ax, ay, 0.5 * h * wa), *turned(bx, by, 0.5 * h * wb))
    # in joint coordinates, the velocities are those of the pose half a substep ahead
    gap = min(
        _parting(substep_bodies[i], substep_bodies[j], begin), _parting(substep_bodies[i], substep_bodies[j], ahead)
    )
    ax, ay, bx, by = ahead
    if gap > JUMP * (abs(wa) * (abs(ax) + abs(ay)) + abs(wb) * (abs(bx) + abs(by))):
        ax, ay, bx, by = begin  # then the pose of the start conserves the momentum
        wa = 0.0
        wb = 0.0
    set_direction(rows[row], 1.0, 0.0, ay, -by)
    set_direction(rows[row + 1], 0.0, 1.0, -ax, bx)
    finish_row(rows[row], 0, cx, substep_bodies)
    finish_row(rows[row + 1], 1, cy, substep_bodies)
    rows[row].bias = 0.5 * h * (wa * wa * ax - wb * wb * bx)
    rows[row + 1].bias = 0.5 * h * (wa * wa * ay - wb * wb * by)


@njit
def _parting(a: Any, b: Any, arms: Any) -> Any:
    """Return the speed at which two anchors part, the sum of the sizes of its components, m/s."""
    ax, ay, bx, by = arms
    va = a.start_velocity
    vb = b.start_velocity
    return abs(vb[0] - vb[2] * by - va[0] + va[2] * ay) + abs(vb[1] + vb[2] * bx - va[1] - va[2] * ax)


@njit
def frame_ahead(bodies: Any, body_parameters: Any, substep_bodies: Any, i: Any, j: Any, parameters: Any, t: Any) -> Any:
    """Return (ax, ay, bx, by, dx, dy): arms and anchor_b - anchor_a, ``t`` s ahead at the velocities of the start."""
    ax, ay = arm(bodies[i], body_parameters[i], parameters.anchor_a)
    bx, by = arm(bodies[j], body_parameters[j], parameters.anchor_b)
    va = substep_bodies[i].start_velocity
    vb = substep_bodies[j].start_velocity
    ax, ay = turned(ax, ay, t * va[2])
    bx, by = turned(bx, by, t * vb[2])
    dx = bodies[j].position[0] + t * vb[0] + bx - bodies[i].position[0] - t * va[0] - ax
    dy = bodies[j].position[1] + t * vb[1] + by - bodies[i].position[1] - t * va[1] - ay
    return ax, ay, bx, by, dx, dy


@njit
def axis_ahead(bodies: Any, substep_bodies: Any, i: Any, parameters: Any, t: Any) -> Any:
    """Return the joint's axis in the world, ``t`` s ahead."""
    body = bodies[i]
    ux, uy = rotate(body.rotation[0], body.rotation[1], parameters.axis[0], parameters.axis[1])
    return turned(ux, uy, t * substep_bodies[i].start_velocity[2])


@njit
def set_frame_direction(row: Any, frame: Any, ux: Any, uy: Any) -> None:
    """Set the Jacobian of u . d, with u fixed in body a: the arm of a then ends at b's anchor."""
    ax, ay, bx, by, dx, dy = frame
    set_direction(row, ux, uy, -cross(ax + dx, ay + dy, ux, uy), cross(bx, by, ux, uy))


@njit
def curve_of(row: Any, frame: Any, ux: Any, uy: Any, substep_bodies: Any) -> Any:
    """Return h/2 dJ/dt v = (J at the end - J of the row) v, for ``frame`` and u at the end of the substep.

    This overwrites the row's direction; set it again from the pose half a substep ahead.
    """
    midpoint_rate = start_rate(row, substep_bodies)
    set_frame_direction(row, frame, ux, uy)
    return start_rate(row, substep_bodies) - midpoint_rate
