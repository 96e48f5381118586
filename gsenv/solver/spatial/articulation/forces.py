"""Forces and inertias of links in 3D, in spatial vectors about one point of each tree.

Featherstone, Rigid Body Dynamics Algorithms, 2008, chapters 2, 5 and 7.
"""

from __future__ import annotations

from typing import Any

from ...jit import inline_njit, njit
from ...records.articulation import SLIDES, LinkKind
from ..math import Vec, add, along, cross, multiply, pose_of, quaternion, scaled, sub, vec
from ..rotation import spin_of
from .places import row_of, set_six

_FREE = int(LinkKind.FREE)
_PIVOT = int(LinkKind.PIVOT)
_AXES = int(LinkKind.AXES)
Wrench = tuple[float, float, float, float, float, float]


@inline_njit
def set_force(links: Any, k: Any, rates: Any, mass: Any, h: Any) -> None:
    """Set the impulse in h s on link k about the origin: of what is applied, less that of its motion without rates.

    The acceleration of a link at constant rates follows from that of its parent.
    """
    link = links[k]
    w = spin_of(link.velocity)
    a = (0.0, 0.0, 0.0)
    turning = (0.0, 0.0, 0.0)
    if link.kind != _FREE:
        arm = vec(link.arm)
        spin = (0.0, 0.0, 0.0)
        if link.parent >= 0:
            parent = links[link.parent]
            spin = spin_of(parent.velocity)
            reach = vec(link.reach)
            turning = spin_of(parent.acceleration)
            a = add(vec(parent.acceleration), cross(turning, reach))
            a = add(a, cross(spin, cross(spin, reach)))
        if link.kind == _AXES:
            bend, slip = _bend(link, spin, rates)
            turning = add(turning, bend)
            a = along(a, 2.0, cross(w if link.flipped else spin, slip))
        a = add(add(a, cross(turning, arm)), cross(w, cross(w, arm)))
    set_six(link.acceleration, a, turning)
    i = link.moment
    momentum = _times(i, w)
    force = scaled(a, -mass)
    torque = sub(cross(momentum, w), _times(i, turning))
    torque = add(torque, cross(vec(link.center), force))
    applied = link.applied
    for d in range(3):
        link.force[d] = h * (applied[d] + force[d])
        link.force[3 + d] = h * (applied[3 + d] + torque[d])


@inline_njit
def _bend(link: Any, spin: Vec, rates: Any) -> tuple[Vec, Vec]:
    """Return the angular acceleration at constant rates relative to the parent, of this spin, and the speed of slides.

    The axis of each turn moves with the turns before it.
    """
    turning = (0.0, 0.0, 0.0)
    slip = (0.0, 0.0, 0.0)
    for n in range(link.count):
        u = row_of(link.directions, n)
        rate = rates[link.first + n]
        if link.numbers[n] < SLIDES:
            slip = along(slip, rate, u)
        else:
            turning = along(turning, rate, cross(spin, u))
            spin = along(spin, rate, u)
    return turning, slip


@inline_njit
def _times(i: Any, w: Vec) -> Vec:
    """Return the product of a symmetric matrix, xx xy xz yy yz zz, and a vector."""
    return (
        i[0] * w[0] + i[1] * w[1] + i[2] * w[2],
        i[1] * w[0] + i[3] * w[1] + i[4] * w[2],
        i[2] * w[0] + i[4] * w[1] + i[5] * w[2],
    )


@njit
def set_applied(link: Any, body: Any, parameters: Any, gravity: Any) -> None:
    """Set gravity, applied force and damping at the present velocity, about the origin."""
    scale = parameters.mass * parameters.gravity_scale
    v, w = vec(link.velocity), spin_of(link.velocity)
    force = along(along(vec(body.force), scale, vec(gravity)), -parameters.linear_damping * parameters.mass, v)
    torque = along(spin_of(body.force), -parameters.angular_damping, _times(link.moment, w))
    torque = add(torque, cross(vec(link.center), force))
    set_six(link.applied, force, torque)


@njit
def set_moment(link: Any, parameters: Any) -> None:
    """Set the inertia about the centre of mass in the axes of the world."""
    own = pose_of((0.0, 0.0, 0.0), multiply(quaternion(link.rotation), quaternion(parameters.axes)))
    a, b, c = parameters.inertia[0], parameters.inertia[1], parameters.inertia[2]
    x, y, z = own.x, own.y, own.z
    m = link.moment
    m[0] = a * x[0] * x[0] + b * y[0] * y[0] + c * z[0] * z[0]
    m[1] = a * x[0] * x[1] + b * y[0] * y[1] + c * z[0] * z[1]
    m[2] = a * x[0] * x[2] + b * y[0] * y[2] + c * z[0] * z[2]
    m[3] = a * x[1] * x[1] + b * y[1] * y[1] + c * z[1] * z[1]
    m[4] = a * x[1] * x[2] + b * y[1] * y[2] + c * z[1] * z[2]
    m[5] = a * x[2] * x[2] + b * y[2] * y[2] + c * z[2] * z[2]


@njit
def set_inertia(link: Any, parameters: Any, h: Any) -> None:
    """Set the lower triangle of the inertia about the origin, with the implicit damping of the body."""
    mass = parameters.mass * (1.0 + h * parameters.linear_damping)
    turning = 1.0 + h * parameters.angular_damping
    x, y, z = vec(link.center)
    u, v, w = mass * x, mass * y, mass * z
    n = link.inertia
    i = link.moment
    n[0, 0] = mass
    n[1, 0], n[1, 1] = 0.0, mass
    n[2, 0], n[2, 1], n[2, 2] = 0.0, 0.0, mass
    n[3, 0], n[3, 1], n[3, 2] = 0.0, -w, v
    n[4, 0], n[4, 1], n[4, 2] = w, 0.0, -u
    n[5, 0], n[5, 1], n[5, 2] = -v, u, 0.0
    n[3, 3] = turning * i[0] + (v * y + w * z)
    n[4, 3], n[4, 4] = turning * i[1] - u * y, turning * i[3] + (u * x + w * z)
    n[5, 3], n[5, 4], n[5, 5] = turning * i[2] - u * z, turning * i[4] - v * z, turning * i[5] + (u * x + v * y)


@njit
def add_inertia(link: Any, other: Any) -> None:
    """Add the lower triangle of the inertia of another link."""
    n = link.inertia
    m = other.inertia
    for d in range(6):
        for e in range(d + 1):
            n[d, e] += m[d, e]


@njit
def set_motions(link: Any, freedoms: Any) -> None:
    """Set the motions of the degrees of freedom of a link, at the origin."""
    i = link.first
    pin = vec(link.anchor)
    if link.kind == _AXES:
        for n in range(link.count):
            u = row_of(link.directions, n)
            if link.numbers[n] < SLIDES:
                set_six(freedoms[i + n].motion, u, (0.0, 0.0, 0.0))
            else:
                set_six(freedoms[i + n].motion, cross(pin, u), u)
        return
    if link.kind == _FREE:
        pin = vec(link.center)
        for k in range(3):
            for d in range(6):
                freedoms[i + k].motion[d] = 1.0 if d == k else 0.0
        i += 3
    for k in range(3):
        axis = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
        set_six(freedoms[i + k].motion, cross(pin, axis), axis)


@inline_njit
def force_on(link: Any) -> Wrench:
    p = link.force
    return p[0], p[1], p[2], p[3], p[4], p[5]


@inline_njit
def response_of(link: Any) -> Wrench:
    p = link.response
    return p[0], p[1], p[2], p[3], p[4], p[5]


@inline_njit
def set_response(link: Any, p: Wrench) -> None:
    link.response[0] = p[0]
    link.response[1] = p[1]
    link.response[2] = p[2]
    link.response[3] = p[3]
    link.response[4] = p[4]
    link.response[5] = p[5]


@inline_njit
def moved(freedom: Any, x: float, p: Wrench) -> tuple[float, Wrench]:
    """Return the change of a rate, x without the change p of the parent's velocity, and the change of the link's."""
    s = freedom.motion
    u = freedom.hold
    x -= ((p[0] * u[0] + p[1] * u[1]) + (p[2] * u[2] + p[3] * u[3]) + (p[4] * u[4] + p[5] * u[5])) * freedom.inverse
    return x, (p[0] + x * s[0], p[1] + x * s[1], p[2] + x * s[2], p[3] + x * s[3], p[4] + x * s[4], p[5] + x * s[5])


@inline_njit
def carried(freedom: Any, x: float, p: Wrench) -> tuple[float, Wrench]:
    """Return the rate x with what the velocity p of the parent adds to it, and the velocity of the link."""
    s = freedom.motion
    u = freedom.hold
    rate = (
        x + ((p[0] * u[0] + p[1] * u[1]) + (p[2] * u[2] + p[3] * u[3]) + (p[4] * u[4] + p[5] * u[5])) * freedom.inverse
    )
    return rate, (p[0] + x * s[0], p[1] + x * s[1], p[2] + x * s[2], p[3] + x * s[3], p[4] + x * s[4], p[5] + x * s[5])


@inline_njit
def reduced(freedom: Any, x: float, p: Wrench) -> tuple[float, Wrench]:
    """Return the impulse on a degree of freedom, x and that of p at the origin, and the impulse on its parent."""
    s = freedom.motion
    u = freedom.hold
    g = x + (p[0] * s[0] + p[1] * s[1]) + (p[2] * s[2] + p[3] * s[3]) + (p[4] * s[4] + p[5] * s[5])
    x = g * freedom.inverse
    return g, (
        p[0] - x * u[0],
        p[1] - x * u[1],
        p[2] - x * u[2],
        p[3] - x * u[3],
        p[4] - x * u[4],
        p[5] - x * u[5],
    )


@inline_njit
def added(freedom: Any, p: Wrench, q: Wrench) -> Wrench:
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3], p[4] + q[4], p[5] + q[5]


@inline_njit
def no_impulse(link: Any) -> Wrench:
    return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@inline_njit
def impulse_at_origin(link: Any, jacobian: Any) -> Wrench:
    """Return the impulse at the origin that a unit impulse of a row is on a link."""
    x, y, z = link.center[0], link.center[1], link.center[2]
    a, b, c = jacobian[0], jacobian[1], jacobian[2]
    return a, b, c, jacobian[3] + y * c - z * b, jacobian[4] + z * a - x * c, jacobian[5] + x * b - y * a


@njit
def carry(link: Any) -> None:
    """Set ``force`` to the impulse ``response`` about the centre of mass, taken about the origin."""
    p = impulse_at_origin(link, link.response)
    for d in range(6):
        link.force[d] = p[d]


@njit
def add_reaction(link: Any, reaction: Any, idle: bool) -> None:
    """Add the impulse of a joint on its body b, which ``link.force`` has about the origin, about b's anchor.

    ``idle``: no motor, spring, limit or friction acts, so that a ball has no torque but that of truncation.
    """
    sign = -1.0 if link.flipped else 1.0
    force, torque = scaled(vec(link.force), sign), scaled(spin_of(link.force), sign)
    torque = sub(torque, cross(vec(link.anchor), force))
    for d in range(3):
        reaction[d] += force[d]
        if not (idle and link.kind == _PIVOT):
            reaction[3 + d] += torque[d]


@njit
def keep_momentum(link: Any, parameters: Any) -> None:
    """Set the momentum of a link about its centre of mass."""
    set_moment(link, parameters)
    set_six(link.momentum, scaled(vec(link.velocity), parameters.mass), _times(link.moment, spin_of(link.velocity)))
