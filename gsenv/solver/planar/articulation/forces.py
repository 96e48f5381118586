"""Forces and inertias of links in 2D, in spatial vectors about one point of each tree."""

from __future__ import annotations

from typing import Any

from ...jit import inline_njit, njit
from ...records.articulation import TURN, LinkKind
from ..math import cross

_FREE = int(LinkKind.FREE)
Wrench = tuple[float, float, float]


@njit
def set_force(links: Any, k: Any, rates: Any, mass: Any, h: Any) -> None:
    """Set the impulse in h s on link k about the origin: of what is applied, less that of its motion without rates."""
    link = links[k]
    w = link.velocity[2]
    x = 0.0
    y = 0.0
    if link.kind != _FREE:
        spin = 0.0
        if link.parent >= 0:
            parent = links[link.parent]
            spin = parent.velocity[2]
            x = parent.acceleration[0] - spin * spin * link.reach[0]
            y = parent.acceleration[1] - spin * spin * link.reach[1]
        if link.slides > 0:
            n = link.count - 1 if link.flipped else 0
            bend = 2.0 * rates[link.first + n] * (w if link.flipped else spin)
            x -= bend * link.directions[n, 1]
            y += bend * link.directions[n, 0]
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
def add_inertia(link: Any, other: Any) -> None:
    """Add the inertia of another link."""
    for d in range(3):
        for e in range(3):
            link.inertia[d, e] += other.inertia[d, e]


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
        return
    sign = -1.0 if link.flipped else 1.0
    for n in range(link.count):
        motion = freedoms[i + n].motion
        slides = link.numbers[n] < TURN
        motion[0] = link.directions[n, 0] if slides else sign * link.anchor[1]
        motion[1] = link.directions[n, 1] if slides else -sign * link.anchor[0]
        motion[2] = 0.0 if slides else sign


@inline_njit
def force_on(link: Any) -> Wrench:
    return link.force[0], link.force[1], link.force[2]


@inline_njit
def response_of(link: Any) -> Wrench:
    return link.response[0], link.response[1], link.response[2]


@inline_njit
def set_response(link: Any, p: Wrench) -> None:
    for d in range(3):
        link.response[d] = p[d]


@inline_njit
def _pulled(freedom: Any, p: Wrench) -> Any:
    """Return what a velocity p of the parent adds to the rate of a degree of freedom."""
    hold = freedom.hold
    return (hold[0] * p[0] + hold[1] * p[1] + hold[2] * p[2]) * freedom.inverse


@inline_njit
def _beyond(freedom: Any, x: Any, p: Wrench) -> Wrench:
    """Return p and x times the motion of a degree of freedom."""
    motion = freedom.motion
    return p[0] + x * motion[0], p[1] + x * motion[1], p[2] + x * motion[2]


@inline_njit
def moved(freedom: Any, x: float, p: Wrench) -> tuple[float, Wrench]:
    """Return the change of a rate, x without the change p of the parent's velocity, and the change of the link's."""
    x -= _pulled(freedom, p)
    return x, _beyond(freedom, x, p)


@inline_njit
def carried(freedom: Any, x: float, p: Wrench) -> tuple[float, Wrench]:
    """Return the rate x with what the velocity p of the parent adds to it, and the velocity of the link."""
    return x + _pulled(freedom, p), _beyond(freedom, x, p)


@inline_njit
def reduced(freedom: Any, x: float, p: Wrench) -> tuple[float, Wrench]:
    """Return the impulse on a degree of freedom, x and that of p at the origin, and the impulse on its parent."""
    motion, hold = freedom.motion, freedom.hold
    x += p[0] * motion[0] + p[1] * motion[1] + p[2] * motion[2]
    rate = x * freedom.inverse
    return x, (p[0] - rate * hold[0], p[1] - rate * hold[1], p[2] - rate * hold[2])


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
def add_reaction(link: Any, reaction: Any, idle: bool) -> None:
    """Add the impulse of a joint on its body b, which ``link.force`` has about the origin, about b's anchor.

    ``idle``: no motor, spring, limit or friction acts, so that a pin has no torque but that of rounding and truncation.
    """
    x, y = link.anchor[0], link.anchor[1]
    sign = -1.0 if link.flipped else 1.0
    reaction[0] += sign * link.force[0]
    reaction[1] += sign * link.force[1]
    if idle and link.count > 0 and link.numbers[link.count - 1] == TURN:
        return
    reaction[2] += sign * (link.force[2] - cross(x, y, link.force[0], link.force[1]))


@njit
def keep_momentum(link: Any, parameters: Any) -> None:
    """Set the momentum of a link about its centre of mass."""
    link.momentum[0] = parameters.mass * link.velocity[0]
    link.momentum[1] = parameters.mass * link.velocity[1]
    link.momentum[2] = parameters.inertia * link.velocity[2]
