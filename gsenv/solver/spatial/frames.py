"""The frame in which a body turns for one substep: its principal axes half a substep ahead.

There its inertia is diagonal, so that the solvers' bodies have a vector of inverse masses as in the
plane.  Turning is drift, kick, drift: the body turns freely, and exactly, for half of the substep, takes
all impulses and torques there, and turns on freely.  So a top precesses at the right rate however
fast it spins.  A body whose moments are equal keeps the world's axes.  Between ``enter_frames`` and
``leave_frame`` the angular parts of ``velocity`` and of all ``motions`` stand in the frame, and are those of
the middle of the substep.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .math import Vec, conjugate, cross, multiply, normalised, pose_of, quaternion, turn_of, turned, vec
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
    """Half of the substep's free turning, and all angular quantities in the frames that it leads to."""
    for k in range(len(indices)):
        i = indices[k]
        motion = motions[i]
        parameters = body_parameters[i]
        torque = spin_of(bodies[i].force)
        if motion.tilted:
            _enter_frame(bodies[i], parameters, motion, h)
            torque = in_frame(motion, torque)
        for d in range(3):
            motion.acceleration[3 + d] = torque[d] * parameters.inv_inertia[d]
        for d in range(6):
            motion.path[d] = motion.acceleration[d]


@njit
def _enter_frame(body: Any, parameters: Any, motion: Any, h: Any) -> None:
    shift = in_world(motion, spin_of(motion.displacement))
    axes = quaternion(parameters.axes)
    principal = multiply(quaternion(body.rotation), axes)
    middle, spin = spin_freely(principal, vec(parameters.inertia), spin_of(body.velocity), 0.5 * h)
    rotation = multiply(middle, conjugate(axes))
    for d in range(4):
        motion.middle[d] = rotation[d]
    own = pose_of((0.0, 0.0, 0.0), middle)
    for d in range(3):
        motion.frame[0, d] = own.x[d]
        motion.frame[1, d] = own.y[d]
        motion.frame[2, d] = own.z[d]
    set_spin(body.velocity, in_frame(motion, spin))
    set_spin(motion.displacement, in_frame(motion, shift))


@njit
def leave_frame(body: Any, parameters: Any, motion: Any, extra: Vec, h: Any) -> None:
    """The other half of the free turning, with the velocity that the solve has made; ``extra``: rad of the frame
    by which the body is turned on top, and its velocity with it: the energy would not stay."""
    axes = quaternion(parameters.axes)
    turn = turn_of(in_world(motion, extra))
    middle = multiply(turn, multiply(quaternion(motion.middle), axes))
    spin = turned(turn, in_world(motion, spin_of(body.velocity)))
    after, spin = spin_freely(middle, vec(parameters.inertia), spin, 0.5 * h)
    rotation = normalised(multiply(after, conjugate(axes)))
    for d in range(4):
        body.rotation[d] = rotation[d]
    set_spin(body.velocity, spin)


@njit
def spin_change(motion: Any, parameters: Any) -> Vec:
    """rad/s^2 in the frame, at which the body's own inertia turns its velocity: I^-1 (I w x w)."""
    if motion.tilted == 0:
        return 0.0, 0.0, 0.0
    w = spin_of(motion.start_velocity)
    i = parameters.inertia
    turning = cross((i[0] * w[0], i[1] * w[1], i[2] * w[2]), w)
    return turning[0] / i[0], turning[1] / i[1], turning[2] / i[2]


@njit
def any_tilted(indices: Any, motions: Any) -> Any:
    """Whether the frame of a body turns with it."""
    for k in range(len(indices)):
        if motions[indices[k]].tilted:
            return True
    return False
