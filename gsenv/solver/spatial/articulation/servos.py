"""Coordinates of 3D joints in joint coordinates, and the directions of their rows."""

from __future__ import annotations

from typing import Any

from ...core.springs import is_slow, mean_reach
from ...jit import njit
from ...records.articulation import SLIDES
from ..joints.axes import BALL_TURN, axes_of, counts_turns, turn_coordinate, turn_direction, unwrapped
from ..math import Quaternion, Vec, conjugate, cross, dot, multiply, quaternion, scaled, sub, turned, vec
from ..rotation import spin_of
from .places import dual_of, holder_of, row_of, set_six, set_vec

_INFINITY = float("inf")


@njit
def numbers_of(model: Any, parameters: Any) -> tuple[int, int]:
    """Return the numbers of the coordinates of limit and spring, and of the motor; -1: none."""
    return model.coordinate, model.motor_coordinate


@njit
def coordinate_of(link: Any, servo: Any, bodies: Any, joint: Any) -> float:
    """Return the coordinate of a joint at the start of the substep, rad or m; counts the turns of one that can turn."""
    number = servo.number
    if servo.place >= 0:
        angle = link.coordinates[servo.place]
    else:
        on_a, on_b = _frames(bodies[joint.model.body_a], bodies[joint.model.body_b], joint.parameters)
        angle = turn_coordinate(number, on_a, on_b)
    if counts_turns(number):
        angle = unwrapped(angle, joint.state.angle)
        joint.state.angle = angle
    return angle


@njit
def _frames(a: Any, b: Any, joint: Any) -> tuple[Quaternion, Quaternion]:
    """Return the rotations of a joint's frames on both bodies."""
    frame = quaternion(joint.frame)
    on_b = multiply(conjugate(quaternion(joint.reference)), frame)
    return multiply(quaternion(a.rotation), frame), multiply(quaternion(b.rotation), on_b)


@njit
def set_servo_direction(row: Any, link: Any, place: Any) -> None:
    """Set the Jacobian of J v = rate of a turn or slide."""
    inner = row.jacobian_a if link.flipped else row.jacobian_b
    outer = row.jacobian_b if link.flipped else row.jacobian_a
    if link.numbers[place] < SLIDES:
        u = row_of(link.directions, place)
        set_six(inner, u, cross(u, vec(link.arm)))
        set_six(outer, scaled(u, -1.0), cross(u, vec(link.reach)))
    else:
        u = dual_of(link, place)
        set_six(inner, (0.0, 0.0, 0.0), u)
        set_six(outer, (0.0, 0.0, 0.0), scaled(u, -1.0))


@njit
def set_servo_inverses(row: Any, links: Any, k: Any, bodies: Any, body_parameters: Any, substep_bodies: Any) -> None:
    """Set the inverse inertias of both bodies in the direction of a row."""
    link = links[k]
    inner = row.jacobian_a if link.flipped else row.jacobian_b
    outer = row.jacobian_b if link.flipped else row.jacobian_a
    _set_inverses(links, link, (spin_of(outer), spin_of(inner)), bodies, body_parameters, substep_bodies)


@njit
def _set_inverses(
    links: Any, link: Any, turns: tuple[Vec, Vec], bodies: Any, body_parameters: Any, substep_bodies: Any
) -> None:
    """Set the inverse inertias of the parent's body and the link's own for torques along ``turns``."""
    _, rotation = holder_of(links, link, bodies)
    holder = body_parameters[link.holder]
    own = body_parameters[link.body]
    _set_inverse(substep_bodies[link.holder].inverse, holder, rotation, turns[0])
    _set_inverse(substep_bodies[link.body].inverse, own, quaternion(link.rotation), turns[1])


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
def set_pivot_direction(world: Any, row: Any, links: Any, k: Any, joint: Any, number: Any, h: Any) -> float:
    """Set the Jacobian of J v = rate of a coordinate of a ball; returns its change by the end of the substep, rad/s."""
    link = links[k]
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    axes = axes_of(joint, bodies, substep_bodies, h)
    u = turn_direction(number, axes.middle[0], axes.middle[1])
    set_six(row.jacobian_a, (0.0, 0.0, 0.0), scaled(u, -1.0))
    set_six(row.jacobian_b, (0.0, 0.0, 0.0), u)
    _set_inverses(links, link, (u, u), bodies, world.parameters.bodies, substep_bodies)
    end = turn_direction(number, axes.end[0], axes.end[1])
    spin_a = spin_of(substep_bodies[joint.model.body_a].start_velocity)
    spin_b = spin_of(substep_bodies[joint.model.body_b].start_velocity)
    return dot(sub(end, u), sub(spin_b, spin_a))


@njit
def is_isotropic(joint_models: Any, joint_parameters: Any, j: Any) -> bool:
    """Whether j is a rotation of a ball without rotors, and its springs about all three axes are equal and unbounded.

    Rotors keep their rates about axes that turn with body a, so that they are rows.
    """
    number = joint_models[j].coordinate - BALL_TURN
    if number < 0:
        return False
    p = joint_parameters[j]
    for k in range(j - number, j - number + 3):
        q = joint_parameters[k]
        if q.stiffness != p.stiffness or q.damping != p.damping or q.armature > 0.0:
            return False
        if q.frequency > 0.0 or not q.spring_effort == _INFINITY:
            return False
    return True


@njit
def add_ball_spring(world: Any, articulation: Any, servo: Any, joint: Any, h: Any) -> None:
    """Add the spring about one axis of a ball, and a third of the stiffness of all, to its degrees of freedom.

    As core/springs.set_rotor_spring does: at the mean position and speed of the substep where it is slow, else at the
    end.
    """
    link = articulation.links[servo.link]
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    p = joint.parameters
    axes = axes_of(joint, bodies, world.scratch.substep_bodies, h)
    u = turn_direction(servo.number, axes.middle[0], axes.middle[1])
    set_vec(servo.direction, scaled(u, -1.0) if link.flipped else u)
    give = _largest_give(body_parameters[link.body]) + _largest_give(body_parameters[link.holder])
    slow = is_slow(p.stiffness, p.damping, give, h)
    stiffness = h * (mean_reach(p.stiffness, p.damping, h) if slow else h * p.stiffness + p.damping)
    servo.stiffness = stiffness
    servo.pull = -h * p.stiffness * (servo.begin - joint.state.rest)
    if slow:
        for d in range(3):
            servo.pull -= stiffness * servo.direction[d] * articulation.start[link.first + d]
    for d in range(3):
        articulation.freedoms[link.first + d].stiffness += stiffness / 3.0
        articulation.freedoms[link.first + d].pull += servo.pull * servo.direction[d]


@njit
def _largest_give(parameters: Any) -> float:
    i = parameters.inv_inertia
    return max(i[0], max(i[1], i[2]))
