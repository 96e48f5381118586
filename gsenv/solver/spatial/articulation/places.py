"""Poses and velocities of links in 3D, along a tree of joints.

A link is placed from its parent outward, so that joints hold by construction.  A joint with axes is a list of slides
along axes of body a and of turns, each about an axis that the turns before it have moved, at the anchor on body b.  The
rates of a pivot are the components, in the axes of the world, of the spin of the link relative to its parent; those of
a free link are its velocity and spin.
"""

from __future__ import annotations

from typing import Any

from ...core.joints import OFF_CENTER
from ...core.slices import part
from ...core.trig import sin_cos
from ...jit import inline_njit, njit
from ...records.articulation import SLIDES, LinkKind
from ..joints.axes import FIRST_TURN, LAST_TURN, NODE_TURN, TWIST, angle_of, axis_of, cardan_angle, turn_coordinate
from ..math import (
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
    turned,
    vec,
)
from ..rotation import is_round, set_spin, spin_of

_FREE = int(LinkKind.FREE)
_PIVOT = int(LinkKind.PIVOT)
_AXES = int(LinkKind.AXES)
_EQUAL = 1e-10  # m and m/s: differences that are those of rounding
_LARGEST_NODE = 1.4  # rad: beyond it the first and the last of three turns nearly coincide


@njit
def set_vec(field: Any, v: Vec) -> None:
    """Set a field of length three."""
    field[0] = v[0]
    field[1] = v[1]
    field[2] = v[2]


@njit
def set_six(field: Any, v: Vec, w: Vec) -> None:
    """Set a field of length six."""
    set_vec(field, v)
    set_spin(field, w)


@njit
def row_of(matrix: Any, i: Any) -> Vec:
    """Return a row of a matrix with three columns."""
    return matrix[i, 0], matrix[i, 1], matrix[i, 2]


@njit
def set_row(matrix: Any, i: Any, v: Vec) -> None:
    """Set a row of a matrix with three columns."""
    matrix[i, 0] = v[0]
    matrix[i, 1] = v[1]
    matrix[i, 2] = v[2]


@njit
def enter_link(link: Any, body: Any) -> None:
    """Set the pose of a link to that of its body."""
    set_vec(link.position, vec(body.position))
    for d in range(4):
        link.rotation[d] = body.rotation[d]


@njit
def holder_of(links: Any, link: Any, bodies: Any) -> tuple[Vec, Quaternion]:
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
    x, turn = sub(vec(body.position), vec(link.position)), (e[1], e[2], e[3])
    v, w = vec(body.velocity), spin_of(body.velocity)
    u, spin = sub(v, vec(link.velocity)), sub(w, spin_of(link.velocity))
    if _sum(x) + radius * _sum(turn) + _sum(u) + radius * _sum(spin) < _EQUAL:
        return 0.0, 0.0, 0.0
    gap = norm(x) + 2.0 * radius * norm(turn)
    return gap, norm(u) + radius * norm(spin), norm(v) + radius * norm(w)


@inline_njit
def _sum(v: Vec) -> float:
    return abs(v[0]) + abs(v[1]) + abs(v[2])


@njit
def place_link(links: Any, k: Any, step: Any, bodies: Any, body_parameters: Any, joint: Any) -> None:
    """Move link k from its base by the displacement ``step`` of its degrees of freedom; its parent has moved before.

    ``joint``: parameters of its joint, of any joint for a free link.
    """
    link = links[k]
    i = link.first
    if link.kind == _FREE:
        turn = (step[i + 3], step[i + 4], step[i + 5])
        set_vec(link.turn, turn)
        set_vec(link.position, add(vec(link.base_position), (step[i], step[i + 1], step[i + 2])))
        _set_rotation(link, multiply(near_turn_of(turn), quaternion(link.base_rotation)))
        return
    at, rotation = holder_of(links, link, bodies)
    turn = (0.0, 0.0, 0.0)
    if link.parent >= 0:
        turn = vec(links[link.parent].turn)
    outer, inner = _arms(link, joint, body_parameters)
    reach = turned(rotation, outer)
    arm = (0.0, 0.0, 0.0)
    if link.kind == _PIVOT:
        turn = add(turn, (step[i], step[i + 1], step[i + 2]))
        _set_rotation(link, multiply(near_turn_of(turn), quaternion(link.base_rotation)))
    else:
        turn, slid = _follow(link, rotation, turn, step, joint)
        if link.flipped:
            arm = slid
        else:
            reach = add(reach, slid)
    arm = sub(arm, turned(quaternion(link.rotation), inner))
    pin = add(at, reach)
    set_vec(link.turn, turn)
    set_vec(link.reach, reach)
    set_vec(link.arm, arm)
    set_vec(link.pin, pin)
    set_vec(link.position, add(pin, arm))


@njit
def _follow(link: Any, rotation: Quaternion, turn: Vec, step: Any, joint: Any) -> tuple[Vec, Vec]:
    """Set rotation, coordinates and directions of a link on axes.

    Returns (rotation vector from its base, with ``turn`` of its parent, translation along its slides).
    """
    rest = quaternion(joint.reference)
    sign = -1.0 if link.flipped else 1.0
    slid = (0.0, 0.0, 0.0)
    q = multiply(rotation, conjugate(rest)) if link.flipped else rotation
    for i in range(link.count):
        moved = step[link.first + i]
        axis = row_of(link.axes, i)
        u = scaled(turned(q, axis), sign)
        set_row(link.directions, i, u)
        link.coordinates[i] = link.base_coordinates[i] + moved
        if link.numbers[i] < SLIDES:
            slid = along(slid, link.coordinates[i], u)
        else:
            turn = along(turn, 0.5 * moved, add(row_of(link.base_directions, i), u))
            c, s = _turned_half(link.base_halves[i, 0], link.base_halves[i, 1], 0.5 * moved)
            link.halves[i, 0] = c
            link.halves[i, 1] = s
            s *= sign
            q = multiply(q, (c, s * axis[0], s * axis[1], s * axis[2]))
    _set_rotation(link, q if link.flipped else multiply(q, rest))
    return turn, slid


@inline_njit
def _turned_half(c: float, s: float, angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle that is ``angle`` rad larger, by series where that is small."""
    z = angle * angle
    x = 1.0 - z * (0.5 - z * (1.0 / 24.0 - z * (1.0 / 720.0 - z * (1.0 / 40320.0))))
    y = angle - angle * z * (1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z * (1.0 / 362880.0))))
    if not z < 0.01:
        x, y = sin_cos(angle)
    return c * x - s * y, s * x + c * y


@njit
def keep_axes(link: Any) -> None:
    """Count displacements of a link on axes from its present coordinates and directions."""
    for i in range(link.count):
        link.base_coordinates[i] = link.coordinates[i]
        link.base_halves[i, 0] = link.halves[i, 0]
        link.base_halves[i, 1] = link.halves[i, 1]
        set_row(link.base_directions, i, row_of(link.directions, i))


@njit
def enter_joint(links: Any, k: Any, bodies: Any, body_parameters: Any, joint: Any) -> bool:
    """Set the coordinates of slides and turns from the poses of the bodies; False where they are nearly singular."""
    link = links[k]
    if link.kind != _AXES:
        return True
    a = bodies[link.body if link.flipped else link.holder]
    b = bodies[link.holder if link.flipped else link.body]
    outer, inner = _arms(link, joint, body_parameters)
    to_a, to_b = (inner, outer) if link.flipped else (outer, inner)
    frame = quaternion(joint.frame)
    if link.count == 1 and link.numbers[0] == TWIST:
        _enter_hinge(link, a, b, joint)
        return True
    axes = pose_of((0.0, 0.0, 0.0), frame)
    on_a = multiply(quaternion(a.rotation), frame)
    on_b = multiply(quaternion(b.rotation), multiply(conjugate(quaternion(joint.reference)), frame))
    relative = multiply(conjugate(on_a), on_b)
    apart = (0.0, 0.0, 0.0)
    if link.slides > 0:
        apart = sub(
            add(vec(b.position), turned(quaternion(b.rotation), to_b)),
            add(vec(a.position), turned(quaternion(a.rotation), to_a)),
        )
    for i in range(link.count):
        number = link.numbers[i]
        place = number if number < SLIDES else 2 if number == TWIST else number - FIRST_TURN
        set_row(link.axes, i, axes.x if place == 0 else axes.y if place == 1 else axes.z)
        if number < SLIDES:
            link.coordinates[i] = dot(apart, axis_of(on_a, number))
        elif number <= LAST_TURN:
            link.coordinates[i] = cardan_angle(number, relative)
        else:
            link.coordinates[i] = turn_coordinate(number, on_a, on_b)
        _set_half(link, i)
        if number == NODE_TURN and abs(link.coordinates[i]) > _LARGEST_NODE:
            return False
    return True


@inline_njit
def _enter_hinge(link: Any, a: Any, b: Any, joint: Any) -> None:
    """Set axis and angle of a link that only turns about one axis."""
    axis = pose_of((0.0, 0.0, 0.0), quaternion(joint.frame)).z
    set_row(link.axes, 0, axis)
    on_b = multiply(quaternion(b.rotation), conjugate(quaternion(joint.reference)))
    turn = multiply(conjugate(quaternion(a.rotation)), on_b)
    link.coordinates[0] = angle_of(dot(axis, (turn[1], turn[2], turn[3])), turn[0])
    _set_half(link, 0)


@inline_njit
def _set_half(link: Any, i: int) -> None:
    """Set cosine and sine of half the coordinate of a turn."""
    c, s = sin_cos(0.5 * link.coordinates[i])
    link.halves[i, 0] = c
    link.halves[i, 1] = s


@njit
def dual_of(link: Any, i: Any) -> Vec:
    """Return the vector whose product with the spin relative to the parent is the rate of turn i of a link."""
    u = row_of(link.directions, i)
    other = FIRST_TURN + LAST_TURN - link.numbers[i]
    if other != FIRST_TURN and other != LAST_TURN:
        return u
    for n in range(link.count):
        if link.numbers[n] == other:
            v = row_of(link.directions, n)
            c = dot(u, v)
            return scaled(along(u, -c, v), 1.0 / (1.0 - c * c))
    return u


@njit
def _set_rotation(link: Any, q: Quaternion) -> None:
    q = near_unit(q)
    for d in range(4):
        link.rotation[d] = q[d]


@njit
def start_joint_rates(links: Any, k: Any, bodies: Any, rates: Any) -> None:
    """Set the rates of link k, which is on a joint, from the velocities of the bodies."""
    link = links[k]
    v = bodies[link.body].velocity
    i = link.first
    u = bodies[link.holder].velocity
    spin = sub(spin_of(v), spin_of(u))
    if link.kind == _PIVOT:
        for d in range(3):
            rates[i + d] = spin[d]
        return
    slip = sub(sub(vec(v), cross(spin_of(v), vec(link.arm))), add(vec(u), cross(spin_of(u), vec(link.reach))))
    for n in range(link.count):
        slides = link.numbers[n] < SLIDES
        rates[i + n] = dot(row_of(link.directions, n), slip) if slides else dot(dual_of(link, n), spin)


@njit
def _holder_motion(links: Any, link: Any) -> tuple[Vec, Vec]:
    if link.parent < 0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    parent = links[link.parent]
    return vec(parent.velocity), spin_of(parent.velocity)


@njit
def set_joint_motion(links: Any, k: Any, rates: Any) -> None:
    """Set the velocity of link k, which is on a joint, by the rates; that of its parent is set."""
    link = links[k]
    i = link.first
    v, w = _holder_motion(links, link)
    v = add(v, cross(w, vec(link.reach)))
    if link.kind == _PIVOT:
        w = add(w, (rates[i], rates[i + 1], rates[i + 2]))
    else:
        for n in range(link.count):
            if link.numbers[n] < SLIDES:
                v = along(v, rates[i + n], row_of(link.directions, n))
            else:
                w = along(w, rates[i + n], row_of(link.directions, n))
    set_six(link.velocity, add(v, cross(w, vec(link.arm))), w)


@njit
def squared_turning(links: Any, k: Any, body_parameters: Any) -> float:
    """Return the squared rate in rad/s at which forces on a link and on its joint change direction."""
    link = links[k]
    parameters = body_parameters[link.body]
    rate = 0.0 if is_round(parameters) else _square(spin_of(link.velocity))
    if link.kind == _FREE:
        return rate
    if _square(vec(link.arm)) > (OFF_CENTER * parameters.radius) ** 2:
        rate = _square(spin_of(link.velocity))
    if link.parent >= 0 and _square(vec(link.reach)) > (OFF_CENTER * body_parameters[link.holder].radius) ** 2:
        rate = max(rate, _square(spin_of(links[link.parent].velocity)))
    return rate


@inline_njit
def _square(v: Vec) -> float:
    return dot(v, v)


@njit
def most_inverse(parameters: Any) -> Any:
    """Return the largest inverse moment of inertia, 1/(kg m^2)."""
    return max(parameters.inv_inertia[0], parameters.inv_inertia[1], parameters.inv_inertia[2])


@njit
def keep_world_frames(world: Any, island: Any) -> None:
    """Keep the axes of the world for all bodies of the island, whatever their inertia."""
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        world.scratch.substep_bodies[island_bodies[k]].rotated_frame = 0


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
