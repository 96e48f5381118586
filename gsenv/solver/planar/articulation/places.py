"""Poses and velocities of links in 2D, along a tree of joints; spatial/articulation/places.py explains them."""

from __future__ import annotations

from typing import Any

from ...core.joints import OFF_CENTER
from ...jit import njit
from ...records.articulation import TURN, LinkKind
from ..math import rotate, turn

_FREE = int(LinkKind.FREE)


@njit
def enter_link(link: Any, body: Any) -> None:
    """Set the pose of a link to that of its body."""
    for d in range(2):
        link.position[d] = body.position[d]
        link.rotation[d] = body.rotation[d]
    link.angle = body.angle


@njit
def _anchors(link: Any, joint: Any, body_parameters: Any) -> Any:
    """Return (x, y) of the anchor from the centre of mass, on the holder and on the link, in their own frames."""
    outer = joint.anchor_b if link.flipped else joint.anchor_a
    inner = joint.anchor_a if link.flipped else joint.anchor_b
    at = body_parameters[link.holder].center
    own = body_parameters[link.body].center
    return outer[0] - at[0], outer[1] - at[1], inner[0] - own[0], inner[1] - own[1]


@njit
def _holder_pose(links: Any, link: Any, bodies: Any) -> Any:
    """Return (x, y, cos, sin, angle) of the body that a link hangs on."""
    if link.parent >= 0:
        p = links[link.parent]
        return p.position[0], p.position[1], p.rotation[0], p.rotation[1], p.angle
    b = bodies[link.holder]
    return b.position[0], b.position[1], b.rotation[0], b.rotation[1], b.angle


@njit
def mismatch(link: Any, body: Any, radius: Any) -> tuple[float, float, float]:
    """Return (m, m/s, m/s): how far pose and velocity of a body are from those of its link, and its speed."""
    c, s = link.rotation[0], link.rotation[1]
    x, y = body.position[0] - link.position[0], body.position[1] - link.position[1]
    gap = (x * x + y * y) ** 0.5 + radius * (abs(body.rotation[0] - c) + abs(body.rotation[1] - s))
    v, u = body.velocity, link.velocity
    slip = abs(v[0] - u[0]) + abs(v[1] - u[1]) + radius * abs(v[2] - u[2])
    return gap, slip, abs(v[0]) + abs(v[1]) + radius * abs(v[2])


@njit
def place_link(links: Any, k: Any, step: Any, bodies: Any, body_parameters: Any, joint: Any) -> None:
    """Move link k from its base by the displacement ``step`` of its degrees of freedom; its parent has moved before."""
    link = links[k]
    i = link.first
    if link.kind == _FREE:
        link.position[0] = link.base_position[0] + step[i]
        link.position[1] = link.base_position[1] + step[i + 1]
        _turn(link, step[i + 2])
        return
    px, py, c, s, angle = _holder_pose(links, link, bodies)
    ox, oy, ix, iy = _anchors(link, joint, body_parameters)
    rx, ry = rotate(c, s, ox, oy)
    ax, ay = 0.0, 0.0
    turned = links[link.parent].turn[0] if link.parent >= 0 else 0.0
    if link.count > link.slides:
        moved = step[i if link.flipped else i + link.slides]
        _turn(link, turned - moved if link.flipped else turned + moved)
    else:
        link.turn[0] = turned
        sine = -joint.reference[1] if link.flipped else joint.reference[1]
        link.rotation[0], link.rotation[1] = rotate(c, s, joint.reference[0], sine)
        link.angle = angle - joint.reference_angle if link.flipped else angle + joint.reference_angle
    if link.slides > 0:
        n = link.count - 1 if link.flipped else 0
        link.coordinates[n] = link.base_coordinates[n] + step[i + n]
        if link.flipped:
            ux, uy = rotate(link.rotation[0], link.rotation[1], -joint.axis[0], -joint.axis[1])
            ax, ay = link.coordinates[n] * ux, link.coordinates[n] * uy
        else:
            ux, uy = rotate(c, s, joint.axis[0], joint.axis[1])
            rx += link.coordinates[n] * ux
            ry += link.coordinates[n] * uy
        link.directions[n, 0], link.directions[n, 1] = ux, uy
    ix, iy = rotate(link.rotation[0], link.rotation[1], ix, iy)
    ax -= ix
    ay -= iy
    link.reach[0], link.reach[1] = rx, ry
    link.arm[0], link.arm[1] = ax, ay
    link.pin[0], link.pin[1] = px + rx, py + ry
    link.position[0], link.position[1] = px + rx + ax, py + ry + ay


@njit
def keep_axes(link: Any) -> None:
    """Count displacements of a link on axes from its present coordinates."""
    for i in range(link.count):
        link.base_coordinates[i] = link.coordinates[i]


@njit
def _turn(link: Any, angle: Any) -> None:
    link.turn[0] = angle
    link.angle = link.base_angle + angle
    link.rotation[0], link.rotation[1] = turn(link.base_rotation[0], link.base_rotation[1], angle)


@njit
def enter_joint(links: Any, k: Any, bodies: Any, body_parameters: Any, joint: Any) -> bool:
    """Set the coordinate of a slide from the poses of the bodies; False where coordinates are singular: never."""
    link = links[k]
    if link.kind == _FREE:
        return True
    ox, oy, ix, iy = _anchors(link, joint, body_parameters)
    p = bodies[link.holder]
    b = bodies[link.body]
    ox, oy = rotate(p.rotation[0], p.rotation[1], ox, oy)
    ix, iy = rotate(b.rotation[0], b.rotation[1], ix, iy)
    own = b if link.flipped else p
    ux, uy = rotate(own.rotation[0], own.rotation[1], joint.axis[0], joint.axis[1])
    apart = ux * (b.position[0] + ix - p.position[0] - ox) + uy * (b.position[1] + iy - p.position[1] - oy)
    for i in range(link.count):
        link.coordinates[i] = 0.0
        if link.numbers[i] < TURN:
            link.coordinates[i] = -apart if link.flipped else apart
    return True


@njit
def start_joint_rates(links: Any, k: Any, bodies: Any, rates: Any) -> None:
    """Set the rates of link k, which is on a joint, from the velocities of the bodies."""
    link = links[k]
    v = bodies[link.body].velocity
    i = link.first
    u = bodies[link.holder].velocity
    x = v[0] + v[2] * link.arm[1] - u[0] + u[2] * link.reach[1]
    y = v[1] - v[2] * link.arm[0] - u[1] - u[2] * link.reach[0]
    for n in range(link.count):
        if link.numbers[n] < TURN:
            rates[i + n] = x * link.directions[n, 0] + y * link.directions[n, 1]
        else:
            rates[i + n] = u[2] - v[2] if link.flipped else v[2] - u[2]


@njit
def set_joint_motion(links: Any, k: Any, rates: Any) -> None:
    """Set the velocity of link k, which is on a joint, by the rates; that of its parent is set."""
    link = links[k]
    i = link.first
    x = 0.0
    y = 0.0
    w = 0.0
    if link.parent >= 0:
        u = links[link.parent].velocity
        w = u[2]
        x = u[0] - w * link.reach[1]
        y = u[1] + w * link.reach[0]
    for n in range(link.count):
        if link.numbers[n] < TURN:
            x += rates[i + n] * link.directions[n, 0]
            y += rates[i + n] * link.directions[n, 1]
        else:
            w += -rates[i + n] if link.flipped else rates[i + n]
    link.velocity[0] = x - w * link.arm[1]
    link.velocity[1] = y + w * link.arm[0]
    link.velocity[2] = w


@njit
def squared_turning(links: Any, k: Any, body_parameters: Any) -> Any:
    """Return the squared rate in rad/s at which forces on a link and on its joint change direction."""
    link = links[k]
    rate = 0.0
    if link.kind == _FREE:
        return rate * rate
    if abs(link.arm[0]) + abs(link.arm[1]) > OFF_CENTER * body_parameters[link.body].radius:
        rate = abs(link.velocity[2])
    if link.parent >= 0 and abs(link.reach[0]) + abs(link.reach[1]) > OFF_CENTER * body_parameters[link.holder].radius:
        rate = max(rate, abs(links[link.parent].velocity[2]))
    return rate * rate


@njit
def most_inverse(parameters: Any) -> Any:
    """Return the largest inverse moment of inertia, 1/(kg m^2)."""
    return parameters.inv_inertia


@njit
def leave_link(link: Any, body: Any, substep_body: Any) -> None:
    """Set the pose and velocity of the link's body, and add to its displacement."""
    for d in range(2):
        substep_body.displacement[d] += link.position[d] - link.start[d]
        body.position[d] = link.position[d]
        body.rotation[d] = link.rotation[d]
    substep_body.displacement[2] += link.half[0] + link.turn[0]
    body.angle = link.angle
    for d in range(3):
        body.velocity[d] = link.velocity[d]
