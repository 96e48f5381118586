"""Velocities and poses of free bodies over one substep, second order in smooth motion."""

from __future__ import annotations

from typing import Any

from ..islands import ASLEEP
from ..jit import njit
from .frames import in_world, is_round, spin_of, world_frame
from .math import Vec, multiply, normalised, quaternion, scaled, turn_of


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
        world_frame(motion)
        moves = parameters.inv_mass > 0.0
        motion.tilted = 1 if moves and not is_round(parameters) else 0
        for d in range(3):
            motion.inverse[d] = parameters.inv_mass
            motion.inverse[3 + d] = parameters.inv_inertia[d]
            motion.acceleration[d] = 0.0
            motion.acceleration[3 + d] = 0.0
            if moves:
                scale = parameters.gravity_scale
                motion.acceleration[d] = gravity[d] * scale + body.force[d] * parameters.inv_mass
            motion.start_position[d] = body.position[d]
        for d in range(6):
            for e in range(6):
                motion.mass_matrix[d, e] = 0.0
            motion.mass_matrix[d, d] = parameters.mass if d < 3 else parameters.inertia[d - 3]
            movers[i].inverse[d] = motion.inverse[d]
            movers[i].velocity[d] = body.velocity[d]
            movers[i].start[d] = body.velocity[d]
            motion.displacement[d] = 0.0
            motion.shift[d] = 0.0
            motion.correction[d] = 0.0
            motion.path[d] = motion.acceleration[d]
            motion.start_velocity[d] = body.velocity[d]
            motion.free_velocity[d] = body.velocity[d]
        for d in range(4):
            motion.start_rotation[d] = body.rotation[d]


@njit
def hold_disabled(bodies: Any, body_parameters: Any, motions: Any) -> None:
    """A disabled body stands still for its joints; its velocity is put aside."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            for d in range(6):
                motions[i].held_velocity[d] = bodies[i].velocity[d]
                bodies[i].velocity[d] = 0.0


@njit
def release_disabled(bodies: Any, body_parameters: Any, motions: Any) -> None:
    """Velocities that were put aside are back: enabled again, a body goes on with its own."""
    for i in range(len(bodies)):
        if body_parameters[i].enabled == 0:
            for d in range(6):
                bodies[i].velocity[d] = motions[i].held_velocity[d]


@njit
def keep_velocities(indices: Any, bodies: Any, motions: Any) -> None:
    """The start velocities of the substep are those of now."""
    for k in range(len(indices)):
        for d in range(6):
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
        for d in range(6):
            motion.start_velocity[d] = body.velocity[d]
            v = (body.velocity[d] + h * motion.acceleration[d]) * (linear if d < 3 else angular)
            body.velocity[d] = v
            motion.free_velocity[d] = v
            motion.correction[d] = 0.0
            movers[indices[k]].velocity[d] = v
            movers[indices[k]].start[d] = v


@njit
def take_velocities(indices: Any, bodies: Any, movers: Any) -> None:
    """Velocities of the bodies are those of the movers."""
    for k in range(len(indices)):
        for d in range(6):
            bodies[indices[k]].velocity[d] = movers[indices[k]].velocity[d]


@njit
def turn_body(body: Any, rotation: Any, turn: Vec) -> None:
    """The body's rotation becomes ``rotation``, turned on by ``turn`` rad in the world."""
    q = normalised(multiply(turn_of(turn), quaternion(rotation)))
    for d in range(4):
        body.rotation[d] = q[d]


@njit
def integrate_positions(indices: Any, bodies: Any, motions: Any, h: Any, trapezoid: Any) -> None:
    """x += h (v + correction) + shift; with ``trapezoid`` = 1, v is the mean of old and new.

    The mean makes smooth motion second order (a parabola exact); the caller passes 0 where a
    velocity jumped at a contact, which the mean would push into the other body.  Turning is the free
    motion of the body, which is exact, turned on by what differs from that.
    """
    for k in range(len(indices)):
        body = bodies[indices[k]]
        motion = motions[indices[k]]
        for d in range(6):
            v = body.velocity[d] + 0.5 * trapezoid * (motion.start_velocity[d] - body.velocity[d])
            step = h * (v + motion.correction[d]) + motion.shift[d]
            motion.correction[d] = step  # how the body moves
            motion.displacement[d] += step
            motion.shift[d] = 0.0
        for d in range(3):
            body.position[d] += motion.correction[d]
        turn = spin_of(motion.correction)
        if motion.tilted:
            free = motion.free_turn
            turn = in_world(motion, (turn[0] - free[0], turn[1] - free[1], turn[2] - free[2]))
            turn_body(body, motion.free_rotation, turn)
        else:
            turn_body(body, body.rotation, turn)


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
            for d in range(6):
                motion.displacement[d] = body.velocity[d] * time
            for d in range(3):
                body.position[d] = motion.start_position[d] + motion.displacement[d]
            turn_body(body, motion.start_rotation, scaled(spin_of(body.velocity), time))


@njit
def clear_forces(bodies: Any) -> None:
    """Applied forces have acted and are gone."""
    for i in range(len(bodies)):
        for d in range(6):
            bodies[i].force[d] = 0.0
