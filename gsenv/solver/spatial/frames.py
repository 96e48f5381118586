"""The frame in which a body turns for one substep: its principal axes half a substep ahead.

There its inertia is diagonal, so that the solvers' bodies have a vector of inverse masses as in the
plane, and rows see the inertia of the middle of the substep.  A body whose moments are equal keeps
the world's axes.  Between ``enter_frames`` and ``leave_frames`` the angular parts of ``velocity`` and of
all ``motions`` stand in the frame.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .math import Vec, add, conjugate, multiply, pose_of, quaternion, scaled, turn_of, vec
from .spin import spin_freely

EQUAL = 1e-9  # of a moment: two that differ less are one


@njit
def in_frame(motion: Any, v: Vec) -> Vec:
    """A direction of the world in the body's frame."""
    f = motion.frame
    return (
        f[0, 0] * v[0] + f[0, 1] * v[1] + f[0, 2] * v[2],
        f[1, 0] * v[0] + f[1, 1] * v[1] + f[1, 2] * v[2],
        f[2, 0] * v[0] + f[2, 1] * v[1] + f[2, 2] * v[2],
    )


@njit
def in_world(motion: Any, v: Vec) -> Vec:
    f = motion.frame
    return (
        f[0, 0] * v[0] + f[1, 0] * v[1] + f[2, 0] * v[2],
        f[0, 1] * v[0] + f[1, 1] * v[1] + f[2, 1] * v[2],
        f[0, 2] * v[0] + f[1, 2] * v[1] + f[2, 2] * v[2],
    )


@njit
def spin_of(field: Any) -> Vec:
    """The angular part of a field of six."""
    return field[3], field[4], field[5]


@njit
def set_spin(field: Any, v: Vec) -> None:
    field[3] = v[0]
    field[4] = v[1]
    field[5] = v[2]


@njit
def world_frame(motion: Any) -> None:
    motion.tilted = 0
    for i in range(3):
        for j in range(3):
            motion.frame[i, j] = 1.0 if i == j else 0.0


@njit
def is_round(parameters: Any) -> Any:
    """Whether all three moments are equal: turning then knows no axes."""
    i = parameters.inertia
    return abs(i[0] - i[1]) <= EQUAL * i[0] and abs(i[0] - i[2]) <= EQUAL * i[0]


@njit
def enter_frames(indices: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any) -> None:
    """Frames of the substep, the free motion in it, and all angular quantities put into them."""
    for k in range(len(indices)):
        i = indices[k]
        motion = motions[i]
        parameters = body_parameters[i]
        torque = spin_of(bodies[i].force)
        if motion.tilted == 0:
            for d in range(3):
                motion.acceleration[3 + d] = torque[d] * parameters.inv_inertia[d]
        else:
            _enter_frame(bodies[i], parameters, motion, torque, h)
        for d in range(6):
            motion.path[d] = motion.acceleration[d]


@njit
def _enter_frame(body: Any, parameters: Any, motion: Any, torque: Vec, h: Any) -> None:
    shift = in_world(motion, spin_of(motion.displacement))
    axes = quaternion(parameters.axes)
    own = quaternion(body.rotation)
    spin = spin_of(body.velocity)
    principal = multiply(own, axes)
    after, spin_after = spin_freely(principal, vec(parameters.inertia), spin, h)
    rotation = multiply(after, conjugate(axes))
    for d in range(4):
        motion.free_rotation[d] = rotation[d]
    middle = pose_of((0.0, 0.0, 0.0), multiply(turn_of(scaled(add(spin, spin_after), 0.25 * h)), principal))
    for d in range(3):
        motion.frame[0, d] = middle.x[d]
        motion.frame[1, d] = middle.y[d]
        motion.frame[2, d] = middle.z[d]
    start = in_frame(motion, spin)
    end = in_frame(motion, spin_after)
    push = in_frame(motion, torque)
    set_spin(body.velocity, start)
    set_spin(motion.displacement, in_frame(motion, shift))
    for d in range(3):
        motion.acceleration[3 + d] = (end[d] - start[d]) / h + push[d] * parameters.inv_inertia[d]
        motion.free_turn[d] = 0.5 * h * (start[d] + end[d])


@njit
def leave_frames(indices: Any, bodies: Any, motions: Any) -> None:
    """Velocities of the bodies back into the world."""
    for k in range(len(indices)):
        if motions[indices[k]].tilted:
            velocity = bodies[indices[k]].velocity
            set_spin(velocity, in_world(motions[indices[k]], spin_of(velocity)))


@njit
def any_tilted(indices: Any, motions: Any) -> Any:
    """Whether the frame of a body turns with it."""
    for k in range(len(indices)):
        if motions[indices[k]].tilted:
            return True
    return False
