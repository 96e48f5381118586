"""Coordinates of 3D joints in joint coordinates, and the directions of their rows."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import SLIDES
from ..joints.axes import axes_of, counts_turns, turn_coordinate, turn_direction, unwrapped
from ..math import Quaternion, Vec, conjugate, cross, dot, multiply, quaternion, scaled, sub, turned, vec
from ..rotation import spin_of
from .places import dual_of, holder_of, row_of, set_six


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
def set_servo_direction(
    row: Any, links: Any, k: Any, place: Any, bodies: Any, body_parameters: Any, substep_bodies: Any
) -> None:
    """Set the Jacobian of J v = rate of a turn or slide, and the inverse inertias of both bodies in its direction."""
    link = links[k]
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
