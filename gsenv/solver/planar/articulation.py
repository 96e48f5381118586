"""Links in 2D: poses, velocities, forces and inertias along a tree of joints; spatial/articulation.py explains them."""

from __future__ import annotations

from typing import Any

from ..core.joints import OFF_CENTER
from ..jit import inline_njit, njit
from ..records.articulation import LinkKind
from .joints.angle import unwrapped_angle
from .math import cross, rotate, turn

_FREE = int(LinkKind.FREE)
_TURN = int(LinkKind.TURN)
_SLIDE = int(LinkKind.SLIDE)
Wrench = tuple[float, float, float]


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
def enter_joint(links: Any, k: Any, bodies: Any, body_parameters: Any, joint: Any) -> None:
    """Set the coordinate of a slide from the poses of the bodies."""
    link = links[k]
    if link.kind != _SLIDE:
        return
    ox, oy, ix, iy = _anchors(link, joint, body_parameters)
    p = bodies[link.holder]
    b = bodies[link.body]
    ox, oy = rotate(p.rotation[0], p.rotation[1], ox, oy)
    ix, iy = rotate(b.rotation[0], b.rotation[1], ix, iy)
    own = b if link.flipped else p
    ux, uy = rotate(own.rotation[0], own.rotation[1], joint.axis[0], joint.axis[1])
    apart = ux * (b.position[0] + ix - p.position[0] - ox) + uy * (b.position[1] + iy - p.position[1] - oy)
    link.coordinate = -apart if link.flipped else apart


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
    turned = links[link.parent].turn[0] if link.parent >= 0 else 0.0
    rx, ry = rotate(c, s, ox, oy)
    if link.kind == _TURN:
        link.direction[2] = -1.0 if link.flipped else 1.0
        _turn(link, turned + link.direction[2] * step[i])
    else:
        link.turn[0] = turned
        sine = -joint.reference[1] if link.flipped else joint.reference[1]
        link.rotation[0], link.rotation[1] = rotate(c, s, joint.reference[0], sine)
        link.angle = angle - joint.reference_angle if link.flipped else angle + joint.reference_angle
    if link.kind == _SLIDE:
        if link.flipped:
            c, s = link.rotation[0], link.rotation[1]
        ux, uy = rotate(c, s, joint.axis[0], joint.axis[1])
        sign = -1.0 if link.flipped else 1.0
        link.coordinate = link.base_coordinate + step[i]
        link.direction[0] = sign * ux
        link.direction[1] = sign * uy
        rx += link.coordinate * ux * sign
        ry += link.coordinate * uy * sign
    ax, ay = rotate(link.rotation[0], link.rotation[1], -ix, -iy)
    link.reach[0], link.reach[1] = rx, ry
    link.arm[0], link.arm[1] = ax, ay
    link.pin[0], link.pin[1] = px + rx, py + ry
    link.position[0], link.position[1] = px + rx + ax, py + ry + ay


@njit
def _turn(link: Any, angle: Any) -> None:
    link.turn[0] = angle
    link.angle = link.base_angle + angle
    link.rotation[0], link.rotation[1] = turn(link.base_rotation[0], link.base_rotation[1], angle)


@njit
def start_rates(links: Any, k: Any, bodies: Any, rates: Any) -> None:
    """Set the rates of link k from the velocities of the bodies."""
    link = links[k]
    v = bodies[link.body].velocity
    i = link.first
    if link.kind == _FREE:
        for d in range(3):
            rates[i + d] = v[d]
        return
    u = bodies[link.holder].velocity
    if link.kind == _TURN:
        rates[i] = link.direction[2] * (v[2] - u[2])
    elif link.kind == _SLIDE:
        x = v[0] + v[2] * link.arm[1] - u[0] + u[2] * link.reach[1]
        y = v[1] - v[2] * link.arm[0] - u[1] - u[2] * link.reach[0]
        rates[i] = x * link.direction[0] + y * link.direction[1]


@njit
def set_motion(links: Any, k: Any, rates: Any) -> None:
    """Set the velocity of link k by the rates; that of its parent is set."""
    link = links[k]
    i = link.first
    if link.kind == _FREE:
        for d in range(3):
            link.velocity[d] = rates[i + d]
        return
    x = 0.0
    y = 0.0
    w = 0.0
    if link.parent >= 0:
        u = links[link.parent].velocity
        w = u[2]
        x = u[0] - w * link.reach[1]
        y = u[1] + w * link.reach[0]
    if link.kind == _TURN:
        w += link.direction[2] * rates[i]
    elif link.kind == _SLIDE:
        x += rates[i] * link.direction[0]
        y += rates[i] * link.direction[1]
    link.velocity[0] = x - w * link.arm[1]
    link.velocity[1] = y + w * link.arm[0]
    link.velocity[2] = w


@njit
def set_force(links: Any, k: Any, rates: Any, mass: Any, h: Any) -> None:
    """Set the impulse in h s on link k about the origin: of what is applied, less that of its motion without rates."""
    link = links[k]
    w = link.velocity[2]
    x = 0.0
    y = 0.0
    if link.kind != _FREE:
        if link.parent >= 0:
            parent = links[link.parent]
            spin = parent.velocity[2]
            x = parent.acceleration[0] - spin * spin * link.reach[0]
            y = parent.acceleration[1] - spin * spin * link.reach[1]
            if link.kind == _SLIDE:
                x -= 2.0 * spin * rates[link.first] * link.direction[1]
                y += 2.0 * spin * rates[link.first] * link.direction[0]
        x -= w * w * link.arm[0]
        y -= w * w * link.arm[1]
    link.acceleration[0] = x
    link.acceleration[1] = y
    cx, cy = link.center[0], link.center[1]
    link.force[0] = h * (link.applied[0] - mass * x)
    link.force[1] = h * (link.applied[1] - mass * y)
    link.force[2] = h * (link.applied[2] - mass * cross(cx, cy, x, y))


@njit
def set_applied(link: Any, body: Any, parameters: Any, gravity: Any) -> None:
    """Set gravity, applied force and damping at the present velocity, about the origin."""
    scale = parameters.mass * parameters.gravity_scale
    drag = parameters.linear_damping * parameters.mass
    x = body.force[0] + scale * gravity[0] - drag * link.velocity[0]
    y = body.force[1] + scale * gravity[1] - drag * link.velocity[1]
    torque = body.force[2] - parameters.angular_damping * parameters.inertia * link.velocity[2]
    link.applied[0] = x
    link.applied[1] = y
    link.applied[2] = torque + cross(link.center[0], link.center[1], x, y)


@njit
def set_moment(link: Any, parameters: Any) -> None:
    link.moment[0] = parameters.inertia


@njit
def set_inertia(link: Any, parameters: Any, h: Any) -> None:
    """Set the inertia about the origin, with the implicit damping of the body."""
    mass = parameters.mass * (1.0 + h * parameters.linear_damping)
    x, y = link.center[0], link.center[1]
    n = link.inertia
    n[0, 0] = mass
    n[1, 1] = mass
    n[0, 1] = 0.0
    n[1, 0] = 0.0
    n[0, 2] = -mass * y
    n[2, 0] = -mass * y
    n[1, 2] = mass * x
    n[2, 1] = mass * x
    n[2, 2] = parameters.inertia * (1.0 + h * parameters.angular_damping) + mass * (x * x + y * y)


@njit
def set_motions(link: Any, freedoms: Any) -> None:
    """Set the motions of the degrees of freedom of a link, at the origin."""
    i = link.first
    if link.kind == _FREE:
        for k in range(3):
            for d in range(3):
                freedoms[i + k].motion[d] = 1.0 if d == k else 0.0
        freedoms[i + 2].motion[0] = link.center[1]
        freedoms[i + 2].motion[1] = -link.center[0]
    elif link.kind == _TURN:
        sign = link.direction[2]
        freedoms[i].motion[0] = sign * link.anchor[1]
        freedoms[i].motion[1] = -sign * link.anchor[0]
        freedoms[i].motion[2] = sign
    elif link.kind == _SLIDE:
        freedoms[i].motion[0] = link.direction[0]
        freedoms[i].motion[1] = link.direction[1]
        freedoms[i].motion[2] = 0.0


@inline_njit
def reduced(freedom: Any, p: Wrench) -> tuple[float, Wrench]:
    """Return the force on a degree of freedom by an impulse p at the origin, and the impulse on its parent."""
    s = freedom.motion
    u = freedom.hold
    g = p[0] * s[0] + p[1] * s[1] + p[2] * s[2]
    x = g * freedom.inverse
    return g, (p[0] - x * u[0], p[1] - x * u[1], p[2] - x * u[2])


@inline_njit
def added(freedom: Any, p: Wrench, q: Wrench) -> Wrench:
    return p[0] + q[0], p[1] + q[1], p[2] + q[2]


@inline_njit
def no_impulse(link: Any) -> Wrench:
    return 0.0, 0.0, 0.0


@inline_njit
def impulse_at_origin(link: Any, jacobian: Any) -> Wrench:
    """Return the impulse at the origin that a unit impulse of a row is on a link."""
    x, y = link.center[0], link.center[1]
    return jacobian[0], jacobian[1], jacobian[2] + x * jacobian[1] - y * jacobian[0]


@njit
def carry(link: Any) -> None:
    """Set ``force`` to the impulse ``response`` about the centre of mass, taken about the origin."""
    p = impulse_at_origin(link, link.response)
    link.force[0] = p[0]
    link.force[1] = p[1]
    link.force[2] = p[2]


@njit
def coordinate_of(link: Any, a: Any, b: Any, joint: Any) -> Any:
    """Return the coordinate of a turn or slide, rad or m."""
    if link.kind == _TURN:
        return unwrapped_angle(a, b, joint.parameters)
    return link.coordinate


@njit
def turning_rate(link: Any, parameters: Any) -> Any:
    """Return the rate in rad/s at which forces on a link change direction."""
    off_center = abs(link.arm[0]) + abs(link.arm[1]) > OFF_CENTER * parameters.radius
    return abs(link.velocity[2]) if link.kind != _FREE and off_center else 0.0


@njit
def most_inverse(parameters: Any) -> Any:
    """Return the largest inverse moment of inertia, 1/(kg m^2)."""
    return parameters.inv_inertia


@njit
def set_servo_direction(row: Any, links: Any, k: Any, bodies: Any, body_parameters: Any, substep_bodies: Any) -> None:
    """Set the Jacobian of J v = rate of a turn or slide."""
    link = links[k]
    inner = row.jacobian_a if link.flipped else row.jacobian_b
    outer = row.jacobian_b if link.flipped else row.jacobian_a
    x, y = link.direction[0], link.direction[1]
    turns = link.kind == _TURN
    inner[0] = 0.0 if turns else x
    inner[1] = 0.0 if turns else y
    inner[2] = link.direction[2] if turns else cross(x, y, link.arm[0], link.arm[1])
    outer[0] = -inner[0]
    outer[1] = -inner[1]
    outer[2] = -link.direction[2] if turns else cross(x, y, link.reach[0], link.reach[1])


@njit
def add_reaction(link: Any, reaction: Any) -> None:
    """Add the impulse of a joint on its body b, which ``link.force`` has about the origin, about b's anchor."""
    x, y = link.anchor[0], link.anchor[1]
    sign = 1.0
    if link.flipped:
        sign = -1.0
        if link.kind == _SLIDE:
            x -= link.coordinate * link.direction[0]
            y -= link.coordinate * link.direction[1]
    reaction[0] += sign * link.force[0]
    reaction[1] += sign * link.force[1]
    reaction[2] += sign * (link.force[2] - cross(x, y, link.force[0], link.force[1]))


@njit
def keep_momentum(link: Any, parameters: Any) -> None:
    """Set the momentum of a link about its centre of mass."""
    link.momentum[0] = parameters.mass * link.velocity[0]
    link.momentum[1] = parameters.mass * link.velocity[1]
    link.momentum[2] = parameters.inertia * link.velocity[2]


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
