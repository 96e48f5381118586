"""Velocities and positions of free bodies over one substep, second order in smooth motion."""

from __future__ import annotations

from typing import Any

from ..islands import ASLEEP
from ..jit import njit
from .math import turn


@njit
def start_motion(
    bodies: Any, body_parameters: Any, gravity: Any, islands: Any, motions: Any, movers: Any
) -> None:
    """Scratch of the step: accelerations, starting poses, no displacement yet; of all but sleepers."""
    for i in range(len(bodies)):
        if islands[i].label == ASLEEP:
            continue
        body = bodies[i]
        parameters = body_parameters[i]
        motion = motions[i]
        for d in range(3):
            for e in range(3):
                motion.mass_matrix[d, e] = 0.0
            motion.mass_matrix[d, d] = parameters.mass if d < 2 else parameters.inertia
            motion.inverse[d] = parameters.inv_mass if d < 2 else parameters.inv_inertia
            movers[i].inverse[d] = motion.inverse[d]
            movers[i].velocity[d] = body.velocity[d]
            movers[i].start[d] = body.velocity[d]
        motion.acceleration[0] = 0.0
        motion.acceleration[1] = 0.0
        motion.acceleration[2] = body.force[2] * parameters.inv_inertia
        if parameters.inv_mass > 0.0:
            scale = parameters.gravity_scale
            motion.acceleration[0] = gravity[0] * scale + body.force[0] * parameters.inv_mass
            motion.acceleration[1] = gravity[1] * scale + body.force[1] * parameters.inv_mass
        motion.start_position[0] = body.position[0]
        motion.start_position[1] = body.position[1]
        motion.start_rotation[0] = body.rotation[0]
        motion.start_rotation[1] = body.rotation[1]
        motion.start_angle = body.angle
        for d in range(3):
            motion.path[d] = motion.acceleration[d]
            motion.displacement[d] = 0.0
            motion.shift[d] = 0.0
            motion.correction[d] = 0.0
            motion.start_velocity[d] = body.velocity[d]
            motion.free_velocity[d] = body.velocity[d]


@njit
def hold_disabled(bodies: Any, body_parameters: Any, motions: Any) -> None:
    """A disabled body stands still for its joints; its velocity is put aside."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            for d in range(3):
                motions[i].held_velocity[d] = bodies[i].velocity[d]
                bodies[i].velocity[d] = 0.0


@njit
def release_disabled(bodies: Any, body_parameters: Any, motions: Any) -> None:
    """Velocities that were put aside are back: enabled again, a body goes on with its own."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            for d in range(3):
                bodies[i].velocity[d] = motions[i].held_velocity[d]


@njit
def keep_velocities(indices: Any, bodies: Any, motions: Any) -> None:
    """The start velocities of the substep are those of now."""
    for k in range(len(indices)):
        for d in range(3):
            motions[indices[k]].start_velocity[d] = bodies[indices[k]].velocity[d]


@njit
def integrate_velocities(
    indices: Any, bodies: Any, body_parameters: Any, motions: Any, movers: Any, h: Any
) -> None:
    """v += h a, then damping, implicit: v / (1 + h c); movers start from there."""
    for k in range(len(indices)):
        body = bodies[indices[k]]
        motion = motions[indices[k]]
        parameters = body_parameters[indices[k]]
        linear = 1.0 / (1.0 + h * parameters.linear_damping)
        angular = 1.0 / (1.0 + h * parameters.angular_damping)
        for d in range(3):
            motion.start_velocity[d] = body.velocity[d]
        body.velocity[0] = (body.velocity[0] + h * motion.acceleration[0]) * linear
        body.velocity[1] = (body.velocity[1] + h * motion.acceleration[1]) * linear
        body.velocity[2] = (body.velocity[2] + h * motion.acceleration[2]) * angular
        for d in range(3):
            motion.free_velocity[d] = body.velocity[d]
            motion.correction[d] = 0.0
            movers[indices[k]].velocity[d] = body.velocity[d]
            movers[indices[k]].start[d] = body.velocity[d]


@njit
def take_velocities(indices: Any, bodies: Any, movers: Any) -> None:
    """Velocities of the bodies are those of the movers."""
    for k in range(len(indices)):
        for d in range(3):
            bodies[indices[k]].velocity[d] = movers[indices[k]].velocity[d]


@njit
def move_body(body: Any, dx: Any, dy: Any, angle: Any) -> None:
    body.position[0] += dx
    body.position[1] += dy
    body.angle += angle
    c, s = turn(body.rotation[0], body.rotation[1], angle)
    body.rotation[0] = c
    body.rotation[1] = s


@njit
def integrate_positions(indices: Any, bodies: Any, motions: Any, h: Any, trapezoid: Any) -> None:
    """x += h (v + correction) + shift; with ``trapezoid`` = 1, v is the mean of old and new.

    The mean makes smooth motion second order (a parabola exact); the caller passes 0 where a
    velocity jumped at a contact, which the mean would push into the other body.
    """
    for k in range(len(indices)):
        body = bodies[indices[k]]
        motion = motions[indices[k]]
        for d in range(3):
            v = body.velocity[d] + 0.5 * trapezoid * (motion.start_velocity[d] - body.velocity[d])
            step = h * (v + motion.correction[d]) + motion.shift[d]
            motion.correction[d] = step  # what move_body applies
            motion.displacement[d] += step
            motion.shift[d] = 0.0
        move_body(body, motion.correction[0], motion.correction[1], motion.correction[2])


@njit
def any_kinematic(bodies: Any, body_models: Any, body_parameters: Any) -> Any:
    """Whether an enabled kinematic body is there to be moved."""
    for i in range(len(bodies)):
        if body_models[i].kind == 1 and body_parameters[i].enabled:
            return True
    return False


@njit
def move_kinematic(bodies: Any, body_models: Any, body_parameters: Any, motions: Any, time: Any) -> None:
    """Put kinematic bodies where they are ``time`` seconds into the step."""
    for i in range(len(bodies)):
        if body_models[i].kind == 1 and body_parameters[i].enabled:
            body = bodies[i]
            motion = motions[i]
            for d in range(3):
                motion.displacement[d] = body.velocity[d] * time
            body.position[0] = motion.start_position[0]
            body.position[1] = motion.start_position[1]
            body.rotation[0] = motion.start_rotation[0]
            body.rotation[1] = motion.start_rotation[1]
            body.angle = motion.start_angle
            move_body(body, motion.displacement[0], motion.displacement[1], motion.displacement[2])


@njit
def clear_forces(bodies: Any) -> None:
    """Applied forces have acted and are gone."""
    for i in range(len(bodies)):
        for d in range(3):
            bodies[i].force[d] = 0.0
