"""Links in 3D: poses, velocities, forces and inertias along a tree of joints.

A link is placed from its parent outward, so that joints hold by construction.  The rates of a pivot are the
components, in the axes of the world, of the spin of the link relative to its parent; those of a free link are
its velocity and spin.  Featherstone, Rigid Body Dynamics Algorithms, 2008, chapters 2, 5 and 7.
"""

from __future__ import annotations

from typing import Any

from ..core.joints import OFF_CENTER
from ..core.slices import part
from ..core.trig import atan2
from ..jit import inline_njit, njit
from ..records.articulation import LinkKind
from .joints.axes import unwrapped
from .math import (
    Quaternion,
    Vec,
    add,
    along,
    conjugate,
    cross,
    dot,
    multiply,
    near_turn_of,
    near_unit,
    norm,
    pose_of,
    quaternion,
    scaled,
    sub,
    turn_of,
    turned,
    vec,
)
from .rotation import is_round, set_spin, spin_of

_FREE = int(LinkKind.FREE)
_FIXED = int(LinkKind.FIXED)
_SLIDE = int(LinkKind.SLIDE)
_PIVOT = int(LinkKind.PIVOT)
_TURN = int(LinkKind.TURN)
Wrench = tuple[float, float, float, float, float, float]


@njit
def _set(field: Any, v: Vec) -> None:
    field[0] = v[0]
    field[1] = v[1]
    field[2] = v[2]


@njit
def _six(field: Any, v: Vec, w: Vec) -> None:
    _set(field, v)
    set_spin(field, w)


@njit
def enter_link(link: Any, body: Any) -> None:
    """Set the pose of a link to that of its body."""
    _set(link.position, vec(body.position))
    for d in range(4):
        link.rotation[d] = body.rotation[d]


@njit
def _holder(links: Any, link: Any, bodies: Any) -> tuple[Vec, Quaternion]:
    """Return position and rotation of the body that a link hangs on."""
    if link.parent >= 0:
        parent = links[link.parent]
        return vec(parent.position), quaternion(parent.rotation)
    holder = bodies[link.holder]
    return vec(holder.position), quaternion(holder.rotation)


@njit
def _arms(link: Any, joint: Any, body_parameters: Any) -> tuple[Vec, Vec]:
    """Return the anchor relative to the centre of mass on the holder and on the link, in their own frames."""
    on_a, on_b = vec(joint.anchor_a), vec(joint.anchor_b)
    outer, inner = (on_b, on_a) if link.flipped else (on_a, on_b)
    return sub(outer, vec(body_parameters[link.holder].center)), sub(inner, vec(body_parameters[link.body].center))


@njit
def mismatch(link: Any, body: Any, radius: Any) -> tuple[float, float, float]:
    """Return (m, m/s, m/s): how far pose and velocity of a body are from those of its link, and its speed."""
    e = multiply(quaternion(body.rotation), conjugate(quaternion(link.rotation)))  # its length is that of half the turn
    gap = norm(sub(vec(body.position), vec(link.position))) + 2.0 * radius * norm((e[1], e[2], e[3]))
    v, w = vec(body.velocity), spin_of(body.velocity)
    slip = norm(sub(v, vec(link.velocity))) + radius * norm(sub(w, spin_of(link.velocity)))
    return gap, slip, norm(v) + radius * norm(w)


@njit
def place_link(links: Any, k: Any, step: Any, bodies: Any, body_parameters: Any, joint: Any) -> None:
    """Move link k from its base by the displacement ``step`` of its degrees of freedom; its parent has moved before.

    ``joint``: parameters of its joint, of any joint for a free link.
    """
    link = links[k]
    i = link.first
    if link.kind == _FREE:
        turn = (step[i + 3], step[i + 4], step[i + 5])
        _set(link.turn, turn)
        _set(link.position, add(vec(link.base_position), (step[i], step[i + 1], step[i + 2])))
        _set_rotation(link, multiply(near_turn_of(turn), quaternion(link.base_rotation)))
        return
    at, rotation = _holder(links, link, bodies)
    turn = (0.0, 0.0, 0.0)
    if link.parent >= 0:
        turn = vec(links[link.parent].turn)
    outer, inner = _arms(link, joint, body_parameters)
    reach = turned(rotation, outer)
    if link.kind == _PIVOT:
        turn = add(turn, (step[i], step[i + 1], step[i + 2]))
        _set_rotation(link, multiply(near_turn_of(turn), quaternion(link.base_rotation)))
    else:
        _follow(link, rotation, step[i] if link.count > 0 else 0.0, joint)
    if link.kind == _TURN:
        turn = along(turn, step[i], vec(link.direction))
    if link.kind == _SLIDE:
        reach = along(reach, link.coordinate, vec(link.direction))
    arm = turned(quaternion(link.rotation), scaled(inner, -1.0))
    pin = add(at, reach)
    _set(link.turn, turn)
    _set(link.reach, reach)
    _set(link.arm, arm)
    _set(link.pin, pin)
    _set(link.position, add(pin, arm))


@njit
def _follow(link: Any, rotation: Quaternion, step: Any, joint: Any) -> None:
    """Set rotation, coordinate and direction of a link with a turn, a slide or no freedom."""
    rest = quaternion(joint.reference)
    axis = vec(joint.axis)
    sign = -1.0 if link.flipped else 1.0
    relative = conjugate(rest) if link.flipped else rest
    link.coordinate = link.base_coordinate + step
    if link.kind == _TURN:
        turn = turn_of(scaled(axis, sign * link.coordinate))
        relative = multiply(relative, turn) if link.flipped else multiply(turn, relative)
    _set_rotation(link, multiply(rotation, relative))
    if link.kind != _FIXED:
        own = quaternion(link.rotation) if link.flipped else rotation
        _set(link.direction, scaled(turned(own, axis), sign))


@njit
def enter_joint(links: Any, k: Any, bodies: Any, body_parameters: Any, joint: Any) -> None:
    """Set the coordinate of a turn or slide from the poses of the bodies."""
    link = links[k]
    link.coordinate = 0.0
    if link.kind < _TURN:
        return
    a = bodies[link.body if link.flipped else link.holder]
    b = bodies[link.holder if link.flipped else link.body]
    axis = vec(joint.axis)
    if link.kind == _TURN:
        e = multiply(
            multiply(conjugate(quaternion(a.rotation)), quaternion(b.rotation)), conjugate(quaternion(joint.reference))
        )
        link.coordinate = 2.0 * atan2(dot(axis, (e[1], e[2], e[3])), e[0])
        return
    outer, inner = _arms(link, joint, body_parameters)
    on_a, on_b = (inner, outer) if link.flipped else (outer, inner)
    own = quaternion(a.rotation)
    apart = sub(add(vec(b.position), turned(quaternion(b.rotation), on_b)), add(vec(a.position), turned(own, on_a)))
    link.coordinate = dot(apart, turned(own, axis))


@njit
def _set_rotation(link: Any, q: Quaternion) -> None:
    q = near_unit(q)
    for d in range(4):
        link.rotation[d] = q[d]


@njit
def start_rates(links: Any, k: Any, bodies: Any, rates: Any) -> None:
    """Set the rates of link k from the velocities of the bodies."""
    link = links[k]
    v = bodies[link.body].velocity
    i = link.first
    if link.kind == _FREE:
        for d in range(6):
            rates[i + d] = v[d]
    elif link.kind == _PIVOT:
        u = bodies[link.holder].velocity
        for d in range(3):
            rates[i + d] = v[3 + d] - u[3 + d]
    elif link.kind == _TURN:
        rates[i] = dot(vec(link.direction), sub(spin_of(v), spin_of(bodies[link.holder].velocity)))
    elif link.kind == _SLIDE:
        u = bodies[link.holder].velocity
        at_pin = sub(vec(v), cross(spin_of(v), vec(link.arm)))
        rates[i] = dot(vec(link.direction), sub(at_pin, add(vec(u), cross(spin_of(u), vec(link.reach)))))


@njit
def _holder_motion(links: Any, link: Any) -> tuple[Vec, Vec]:
    if link.parent < 0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    parent = links[link.parent]
    return vec(parent.velocity), spin_of(parent.velocity)


@njit
def set_motion(links: Any, k: Any, rates: Any) -> None:
    """Set the velocity of link k by the rates; that of its parent is set."""
    link = links[k]
    i = link.first
    if link.kind == _FREE:
        for d in range(6):
            link.velocity[d] = rates[i + d]
        return
    v, w = _holder_motion(links, link)
    v = add(v, cross(w, vec(link.reach)))
    if link.kind == _PIVOT:
        w = add(w, (rates[i], rates[i + 1], rates[i + 2]))
    elif link.kind == _TURN:
        w = along(w, rates[i], vec(link.direction))
    elif link.kind == _SLIDE:
        v = along(v, rates[i], vec(link.direction))
    _six(link.velocity, add(v, cross(w, vec(link.arm))), w)


@njit
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
        if link.parent >= 0:
            parent = links[link.parent]
            spin = spin_of(parent.velocity)
            reach = vec(link.reach)
            turning = spin_of(parent.acceleration)
            a = add(vec(parent.acceleration), cross(turning, reach))
            a = add(a, cross(spin, cross(spin, reach)))
            if link.kind == _TURN:
                turning = along(turning, rates[link.first], cross(spin, vec(link.direction)))
            elif link.kind == _SLIDE:
                a = along(a, 2.0 * rates[link.first], cross(spin, vec(link.direction)))
        a = add(add(a, cross(turning, arm)), cross(w, cross(w, arm)))
    _six(link.acceleration, a, turning)
    i = link.moment
    momentum = _times(i, w)
    force = scaled(a, -mass)
    torque = sub(cross(momentum, w), _times(i, turning))
    torque = add(torque, cross(vec(link.center), force))
    applied = link.applied
    for d in range(3):
        link.force[d] = h * (applied[d] + force[d])
        link.force[3 + d] = h * (applied[3 + d] + torque[d])


@njit
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
    _six(link.applied, force, torque)


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
    """Set the inertia about the origin, with the implicit damping of the body."""
    mass = parameters.mass * (1.0 + h * parameters.linear_damping)
    turning = 1.0 + h * parameters.angular_damping
    r = vec(link.center)
    square = dot(r, r)
    n = link.inertia
    i = link.moment
    for d in range(3):
        for e in range(3):
            n[d, e] = mass if d == e else 0.0
            n[3 + d, 3 + e] = turning * i[_place(d, e)] - mass * r[d] * r[e] + (mass * square if d == e else 0.0)
            n[d, 3 + e] = 0.0
    n[0, 4] = mass * r[2]
    n[0, 5] = -mass * r[1]
    n[1, 3] = -mass * r[2]
    n[1, 5] = mass * r[0]
    n[2, 3] = mass * r[1]
    n[2, 4] = -mass * r[0]
    for d in range(3):
        for e in range(3):
            n[3 + e, d] = n[d, 3 + e]


@njit
def _place(d: int, e: int) -> int:
    """Return the place of an entry of a symmetric matrix among xx xy xz yy yz zz."""
    low = min(d, e)
    high = max(d, e)
    return high if low == 0 else high + 2 if low == 1 else 5


@njit
def set_motions(link: Any, freedoms: Any) -> None:
    """Set the motions of the degrees of freedom of a link, at the origin."""
    i = link.first
    pin = vec(link.anchor)
    if link.kind == _FREE:
        pin = vec(link.center)
        for k in range(3):
            for d in range(6):
                freedoms[i + k].motion[d] = 1.0 if d == k else 0.0
        i += 3
    if link.kind == _FREE or link.kind == _PIVOT:
        for k in range(3):
            axis = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
            _six(freedoms[i + k].motion, cross(pin, axis), axis)
    elif link.kind == _TURN:
        _six(freedoms[i].motion, cross(pin, vec(link.direction)), vec(link.direction))
    elif link.kind == _SLIDE:
        _six(freedoms[i].motion, vec(link.direction), (0.0, 0.0, 0.0))


@inline_njit
def reduced(freedom: Any, p: Wrench) -> tuple[float, Wrench]:
    """Return the force on a degree of freedom by an impulse p at the origin, and the impulse on its parent."""
    s = freedom.motion
    u = freedom.hold
    g = (p[0] * s[0] + p[1] * s[1]) + (p[2] * s[2] + p[3] * s[3]) + (p[4] * s[4] + p[5] * s[5])
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
def coordinate_of(link: Any, a: Any, b: Any, joint: Any) -> Any:
    """Return the coordinate of a turn or slide, rad or m; counts the turns of a turn."""
    if link.kind != _TURN:
        return link.coordinate
    joint.state.angle = unwrapped(link.coordinate, joint.state.angle)
    return joint.state.angle


@njit
def most_inverse(parameters: Any) -> Any:
    """Return the largest inverse moment of inertia, 1/(kg m^2)."""
    return max(parameters.inv_inertia[0], parameters.inv_inertia[1], parameters.inv_inertia[2])


@njit
def set_servo_direction(row: Any, links: Any, k: Any, bodies: Any, body_parameters: Any, substep_bodies: Any) -> None:
    """Set the Jacobian of J v = rate of a turn or slide, and the inverse inertias of both bodies in its direction."""
    link = links[k]
    inner = row.jacobian_a if link.flipped else row.jacobian_b
    outer = row.jacobian_b if link.flipped else row.jacobian_a
    u = vec(link.direction)
    if link.kind == _TURN:
        _six(inner, (0.0, 0.0, 0.0), u)
        _six(outer, (0.0, 0.0, 0.0), scaled(u, -1.0))
    else:
        _six(inner, u, cross(u, vec(link.arm)))
        _six(outer, scaled(u, -1.0), cross(u, vec(link.reach)))
    _, rotation = _holder(links, link, bodies)
    holder = body_parameters[link.holder]
    own = body_parameters[link.body]
    _set_inverse(substep_bodies[link.holder].inverse, holder, rotation, spin_of(outer))
    _set_inverse(substep_bodies[link.body].inverse, own, quaternion(link.rotation), spin_of(inner))


@njit
def _set_inverse(inverse: Any, parameters: Any, rotation: Quaternion, v: Vec) -> None:
    """Set a diagonal inverse inertia in the axes of the world that is right for torques along v."""
    own = turned(conjugate(multiply(rotation, quaternion(parameters.axes))), v)
    size = dot(own, own)
    i = parameters.inv_inertia
    give = i[0] * own[0] * own[0] + i[1] * own[1] * own[1] + i[2] * own[2] * own[2]
    for d in range(3):
        inverse[3 + d] = give / size if size > 0.0 else 0.0


@njit
def turning_rate(link: Any, parameters: Any) -> float:
    """Return the rate in rad/s at which forces on a link change direction."""
    speed = norm(spin_of(link.velocity))
    if link.kind == _FREE or norm(vec(link.arm)) <= OFF_CENTER * parameters.radius:
        return 0.0 if is_round(parameters) else speed
    return speed


@njit
def keep_world_frames(world: Any, island: Any) -> None:
    """Keep the axes of the world for all bodies of the island, whatever their inertia."""
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        world.scratch.substep_bodies[island_bodies[k]].rotated_frame = 0


@njit
def add_reaction(link: Any, reaction: Any) -> None:
    """Add the impulse of a joint on its body b, which ``link.force`` has about the origin, about b's anchor."""
    force, torque = vec(link.force), spin_of(link.force)
    at = vec(link.anchor)
    if link.flipped:
        at = along(at, -link.coordinate, vec(link.direction)) if link.kind == _SLIDE else at
        force, torque = scaled(force, -1.0), scaled(torque, -1.0)
    torque = sub(torque, cross(at, force))
    for d in range(3):
        reaction[d] += force[d]
        reaction[3 + d] += torque[d]


@njit
def keep_momentum(link: Any, parameters: Any) -> None:
    """Set the momentum of a link about its centre of mass."""
    set_moment(link, parameters)
    _six(link.momentum, scaled(vec(link.velocity), parameters.mass), _times(link.moment, spin_of(link.velocity)))


@njit
def leave_link(link: Any, body: Any, substep_body: Any) -> None:
    """Set the pose and velocity of the link's body, and add to its displacement."""
    for d in range(3):
        substep_body.displacement[d] += link.position[d] - link.start[d]
        substep_body.displacement[3 + d] += link.half[d] + link.turn[d]
        body.position[d] = link.position[d]
    for d in range(4):
        body.rotation[d] = link.rotation[d]
    for d in range(6):
        body.velocity[d] = link.velocity[d]
