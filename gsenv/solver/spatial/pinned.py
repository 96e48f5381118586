"""A body that one ball joint alone holds at a point that stands still: a pendulum or a heavy top, of any shape.

Its mass and the joint make a body that turns about the pin, with the inertia about it, and has no rows.  Free
turning is exact (``spin.py``), so that only the moment of weight and applied forces is left to split off: Blanes,
Moan, "Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystrom methods", J. Comput. Appl. Math. 142
(2002), SRKN14a, order six.  Momentum about a vertical through the pin is kept and the energy has no drift; what
the angular velocity has of another motion than turning about the pin, the joint takes at the start of the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..jit import njit
from .frames import EQUAL, set_spin, spin_of
from .joints import JointKind
from .joints.point import arm
from .math import (
    Quaternion,
    Vec,
    add,
    along,
    conjugate,
    cross,
    dot,
    multiply,
    norm,
    normalised,
    quaternion,
    scaled,
    sub,
    turned,
    vec,
)
from .spin import turn_freely

_BALL = int(JointKind.BALL)
# parts of a step: turn, kick, turn, ..., turn; both palindromes
_TURNS = (0.0378593198406116, 0.102635633102435, -0.0258678882665587, 0.314241403071447,
          -0.130144459517415, 0.106417700369543, -0.00879424312851058)  # fmt: skip
_KICKS = (0.09171915262446165, 0.183983170005006, -0.05653436583288827, 0.004914688774712854,
          0.143761127168358, 0.328567693746804)  # fmt: skip
_LAST_TURN = 1.0 - 2.0 * sum(_TURNS)
_LAST_KICK = 0.5 - sum(_KICKS)
TURNS = np.array([*_TURNS, _LAST_TURN, *_TURNS[::-1]])
KICKS = np.array([*_KICKS, _LAST_KICK, _LAST_KICK, *_KICKS[::-1], 0.0])
REACH = 6.0  # rad that the arm may turn in one composed step: error 1e-6 at worst
MOST_STEPS = 1000
ONE_TURN = 0.12  # rad: of the free turning of unequal moments, error 1e-9
NEAR = 0.1  # of the radius: anchors farther apart are first drawn together by the joint's rows


@njit
def is_pinned(
    body_list: Any,
    contact_list: Any,
    joint_list: Any,
    joint_models: Any,
    joint_parameters: Any,
    bodies: Any,
    body_parameters: Any,
) -> Any:
    """Whether the island is one undamped body that may turn every way about a pin, and nothing touches it."""
    if len(body_list) != 1 or len(joint_list) != 1 or len(contact_list) != 0:
        return False
    model = joint_models[joint_list[0]]
    if model.kind != _BALL:
        return False
    i = body_list[0]
    held = body_parameters[i]
    for d in range(3):
        if not (held.inv_inertia[d] > 0.0 and held.inertia[d] > 0.0):
            return False
    if held.linear_damping != 0.0 or held.angular_damping != 0.0:
        return False
    holder = model.body_a if model.body_b == i else model.body_b
    if body_parameters[holder].inv_mass > 0.0:
        return False
    for d in range(6):
        if bodies[holder].velocity[d] != 0.0:
            return False
    parameters = joint_parameters[joint_list[0]]
    a = _anchor(bodies[model.body_a], body_parameters[model.body_a], parameters.anchor_a)
    b = _anchor(bodies[model.body_b], body_parameters[model.body_b], parameters.anchor_b)
    return norm(sub(b, a)) <= NEAR * held.radius


@njit
def _anchor(body: Any, parameters: Any, anchor: Any) -> Vec:
    return add(vec(body.position), arm(body, parameters, anchor))


@njit
def swing_pinned(
    i: Any,
    joint: Any,
    joint_models: Any,
    joint_parameters: Any,
    joint_states: Any,
    bodies: Any,
    body_parameters: Any,
    motions: Any,
    options: Any,
) -> None:
    """Body i of a pinned island by a whole timestep, and the reaction of its joint."""
    model = joint_models[joint]
    parameters = joint_parameters[joint]
    body = bodies[i]
    mass = body_parameters[i]
    motion = motions[i]
    dt = options.timestep
    first = model.body_a == i
    local = vec(parameters.anchor_a) if first else vec(parameters.anchor_b)
    holder = model.body_b if first else model.body_a
    pin = _anchor(bodies[holder], body_parameters[holder], parameters.anchor_b if first else parameters.anchor_a)
    axes = quaternion(mass.axes)
    own_arm = turned(conjugate(axes), sub(vec(mass.center), local))  # from the pin to the centre
    inertia, turn = moments_about(vec(mass.inertia), mass.mass, own_arm)
    back = conjugate(multiply(axes, turn))
    q = multiply(quaternion(body.rotation), multiply(axes, turn))
    own_arm = turned(conjugate(turn), own_arm)
    force = scaled(vec(motion.acceleration), mass.mass)
    before = vec(body.velocity)
    momentum = _momentum(body, mass, turned(q, own_arm))
    steps = _steps_for(inertia, own_arm, norm(momentum), force, spin_of(body.force), options)
    q, momentum = _turn_and_kick(q, inertia, own_arm, momentum, force, spin_of(body.force), dt, steps)
    _place(body, motion, inertia, q, back, momentum, own_arm, pin)
    pull = sub(scaled(sub(vec(body.velocity), before), mass.mass), scaled(force, dt))
    _react(joint_states[joint], scaled(pull, -1.0) if first else pull, options.substeps)
    set_spin(motion.displacement, scaled(spin_of(body.velocity), dt))


@njit
def _momentum(body: Any, parameters: Any, to_center: Vec) -> Vec:
    """kg m^2/s about the pin."""
    axes = multiply(quaternion(body.rotation), quaternion(parameters.axes))
    own = turned(conjugate(axes), spin_of(body.velocity))
    i = parameters.inertia
    about_center = turned(axes, (i[0] * own[0], i[1] * own[1], i[2] * own[2]))
    return add(about_center, scaled(cross(to_center, vec(body.velocity)), parameters.mass))


@njit
def _steps_for(inertia: Vec, own_arm: Vec, momentum: Any, force: Vec, torque: Vec, options: Any) -> int:
    """Composed steps: a round body's spin about the arm changes nothing, all else does, and the force swings it."""
    length = norm(own_arm)
    if norm(force) * length + norm(torque) == 0.0:
        return 1  # turns freely
    least = -1.0
    for d in range(3):
        across = length * length - own_arm[d] * own_arm[d] > 1e-12 * length * length
        counts = across or length == 0.0 or inertia[(d + 1) % 3] != inertia[(d + 2) % 3]
        if counts and (least < 0.0 or inertia[d] < least):
            least = inertia[d]
    moment = norm(force) * length + norm(torque)
    rate = momentum / least + np.sqrt(moment / least)
    finer = max(0.5 * options.substeps, 1.0) ** 0.5  # where more substeps are asked for; to the sixth power
    return max(min(int(np.ceil(min(finer * options.timestep * rate / REACH, 1e6))), MOST_STEPS), 1)


@njit
def _turn_and_kick(
    q: Quaternion, inertia: Vec, own_arm: Vec, momentum: Vec, force: Vec, torque: Vec, dt: float, steps: int
) -> tuple[Quaternion, Vec]:
    h = dt / steps
    for _ in range(steps):
        for s in range(len(TURNS)):
            q = turn_freely(q, inertia, momentum, TURNS[s] * h, ONE_TURN)
            moment = add(cross(turned(q, own_arm), force), torque)
            momentum = along(momentum, KICKS[s] * h, moment)
    return q, momentum


@njit
def _place(
    body: Any, motion: Any, inertia: Vec, q: Quaternion, back: Quaternion, momentum: Vec, own_arm: Vec, pin: Vec
) -> None:
    """Pose and velocity of the body at the end, and how far its centre came."""
    own = turned(conjugate(q), momentum)
    spin = turned(q, (own[0] / inertia[0], own[1] / inertia[1], own[2] / inertia[2]))
    to_center = turned(q, own_arm)
    at = add(pin, to_center)
    velocity = cross(spin, to_center)
    rotation = normalised(multiply(q, back))
    for d in range(3):
        motion.displacement[d] = at[d] - body.position[d]
        body.position[d] = at[d]
        body.velocity[d] = velocity[d]
    for d in range(4):
        body.rotation[d] = rotation[d]
    set_spin(body.velocity, spin)


@njit
def _react(state: Any, pull: Vec, substeps: Any) -> None:
    """``pull``, N s on body b over the step; rows may start from it in the next."""
    for d in range(3):
        state.reaction[d] = pull[d]
        state.reaction[3 + d] = 0.0
        state.total_impulse[d] = pull[d]
        state.impulse[d] = pull[d] / substeps


# ---------------------------------------------------------------- inertia about the pin


@njit
def moments_about(inertia: Vec, mass: float, r: Vec) -> tuple[Vec, Quaternion]:
    """(moments, turn of their axes) about a point that is -r from the centre, from those about the centre."""
    square = dot(r, r)
    i = (
        inertia[0] + mass * (square - r[0] * r[0]),
        inertia[1] + mass * (square - r[1] * r[1]),
        inertia[2] + mass * (square - r[2] * r[2]),
    )
    off = (-mass * (r[1] * r[2]), -mass * (r[2] * r[0]), -mass * (r[0] * r[1]))
    (x, y, z), turn = _diagonal(i, off)
    if abs(y - x) <= EQUAL * x:
        y = x
    if abs(z - x) <= EQUAL * x:
        z = x
    elif abs(z - y) <= EQUAL * y:
        z = y
    return (x, y, z), turn


@njit
def _diagonal(i: Vec, off: Vec) -> tuple[Vec, Quaternion]:
    """Moments and the turn of their axes of a tensor with ``off`` = (yz, zx, xy), by Jacobi's rotations."""
    turn = (1.0, 0.0, 0.0, 0.0)
    scale = 1e-15 * (i[0] + i[1] + i[2])
    for _ in range(12):
        if max(abs(off[0]), abs(off[1]), abs(off[2])) <= scale:
            break
        for axis in range(3):
            i, off, turn = _rotated(i, off, turn, axis)
    return i, turn


@njit
def _rotated(i: Vec, off: Vec, turn: Quaternion, k: int) -> tuple[Vec, Vec, Quaternion]:
    """The axes turned about the k-th until the product of the other two is gone."""
    o = off[k]
    if o == 0.0:
        return i, off, turn
    p = (k + 1) % 3
    z = (i[(k + 2) % 3] - i[p]) / (o + o)
    t = (-1.0 if z >= 0.0 else 1.0) / (abs(z) + np.sqrt(z * z + 1.0))
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    half = np.sqrt(0.5 + 0.5 * c)
    sine = 0.5 * s / half
    u, v = off[(k + 2) % 3], off[p]  # with the k-th axis: of p, of the one after
    a, b, x, y = i[p] + t * o, i[(k + 2) % 3] - t * o, c * u + s * v, c * v - s * u
    if k == 0:
        return (i[0], a, b), (0.0, y, x), multiply(turn, (half, sine, 0.0, 0.0))
    if k == 1:
        return (b, i[1], a), (x, 0.0, y), multiply(turn, (half, 0.0, sine, 0.0))
    return (a, b, i[2]), (y, x, 0.0), multiply(turn, (half, 0.0, 0.0, sine))
