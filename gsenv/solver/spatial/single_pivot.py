"""A body that is held only by one ball joint on a body at rest: a pendulum or a heavy top, of any shape.

It is integrated without rows, as a body that rotates about the pin with its inertia about the pin.  Free
rotation is exact (free_rotation.py), so only the moment of gravity and applied forces is split off: Blanes,
Moan, "Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystrom methods", J. Comput. Appl. Math.
142 (2002), SRKN14a, order six.  The angular momentum about a vertical through the pin is conserved and the
energy has no drift.  A velocity that is no rotation about the pin is removed by the joint at the start of
the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..jit import njit
from ..records.model import JointKind
from .free_rotation import rotate_with_momentum
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
from .rotation import EQUAL, set_spin, spin_of

_BALL = int(JointKind.BALL)
# fractions of a step: rotation, impulse, rotation, ..., rotation; both sequences are palindromes
_TURNS = (0.0378593198406116, 0.102635633102435, -0.0258678882665587, 0.314241403071447,
          -0.130144459517415, 0.106417700369543, -0.00879424312851058)  # fmt: skip
_KICKS = (0.09171915262446165, 0.183983170005006, -0.05653436583288827, 0.004914688774712854,
          0.143761127168358, 0.328567693746804)  # fmt: skip
_LAST_TURN = 1.0 - 2.0 * sum(_TURNS)
_LAST_KICK = 0.5 - sum(_KICKS)
TURNS = np.array([*_TURNS, _LAST_TURN, *_TURNS[::-1]])
KICKS = np.array([*_KICKS, _LAST_KICK, _LAST_KICK, *_KICKS[::-1], 0.0])
REACH = 6.0  # rad: largest rotation of the arm in one composed step: error up to 1e-6
MOST_STEPS = 1000
ONE_TURN = 0.12  # rad: step of the free rotation with unequal moments: error 1e-9
NEAR = 0.1  # of the radius: anchors farther apart are first brought together by the joint's rows


@njit
def has_single_pivot(world: Any, island: Any) -> Any:
    """Whether the island is one undamped body that can rotate freely about a pin, without contacts."""
    if island.body_count != 1 or island.joint_count != 1 or island.contact_count != 0:
        return False
    joint = world.scratch.island_joints[island.joint_first]
    model = world.model.joints[joint]
    if model.kind != _BALL:
        return False
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    i = world.scratch.island_bodies[island.body_first]
    pendulum = body_parameters[i]
    for d in range(3):
        if not (pendulum.inv_inertia[d] > 0.0 and pendulum.inertia[d] > 0.0):
            return False
    if pendulum.linear_damping != 0.0 or pendulum.angular_damping != 0.0:
        return False
    holder = model.body_a if model.body_b == i else model.body_b
    if body_parameters[holder].inv_mass > 0.0:
        return False
    for d in range(6):
        if bodies[holder].velocity[d] != 0.0:
            return False
    parameters = world.parameters.joints[joint]
    a = _anchor(bodies[model.body_a], body_parameters[model.body_a], parameters.anchor_a)
    b = _anchor(bodies[model.body_b], body_parameters[model.body_b], parameters.anchor_b)
    return norm(sub(b, a)) <= NEAR * pendulum.radius


@njit
def _anchor(body: Any, parameters: Any, anchor: Any) -> Vec:
    return add(vec(body.position), arm(body, parameters, anchor))


@njit
def swing_about_pivot(world: Any, island: Any) -> None:
    """Move the body by a whole timestep, and store the reaction of its joint."""
    i = world.scratch.island_bodies[island.body_first]
    joint = world.scratch.island_joints[island.joint_first]
    options = world.options
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    model = world.model.joints[joint]
    parameters = world.parameters.joints[joint]
    body = bodies[i]
    mass = body_parameters[i]
    substep_body = world.scratch.substep_bodies[i]
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
    force = scaled(vec(substep_body.acceleration), mass.mass)
    before = vec(body.velocity)
    momentum = _momentum(body, mass, turned(q, own_arm))
    steps = _steps_for(inertia, own_arm, norm(momentum), force, spin_of(body.force), options)
    q, momentum = _integrate(q, inertia, own_arm, momentum, force, spin_of(body.force), dt, steps)
    _set_pose(body, substep_body, inertia, q, back, momentum, own_arm, pin)
    impulse = sub(scaled(sub(vec(body.velocity), before), mass.mass), scaled(force, dt))
    _store_reaction(world.state.joints[joint], scaled(impulse, -1.0) if first else impulse, options.substeps)
    set_spin(substep_body.displacement, scaled(spin_of(body.velocity), dt))


@njit
def _momentum(body: Any, parameters: Any, to_center: Vec) -> Vec:
    """Return the angular momentum about the pin, kg m^2/s."""
    axes = multiply(quaternion(body.rotation), quaternion(parameters.axes))
    own = turned(conjugate(axes), spin_of(body.velocity))
    i = parameters.inertia
    about_center = turned(axes, (i[0] * own[0], i[1] * own[1], i[2] * own[2]))
    return add(about_center, scaled(cross(to_center, vec(body.velocity)), parameters.mass))


@njit
def _steps_for(inertia: Vec, own_arm: Vec, momentum: Any, force: Vec, torque: Vec, options: Any) -> int:
    """Return the number of composed steps; rotation of a symmetric body about its arm needs none."""
    length = norm(own_arm)
    if norm(force) * length + norm(torque) == 0.0:
        return 1  # free rotation
    least = -1.0
    for d in range(3):
        across = length * length - own_arm[d] * own_arm[d] > 1e-12 * length * length
        counts = across or length == 0.0 or inertia[(d + 1) % 3] != inertia[(d + 2) % 3]
        if counts and (least < 0.0 or inertia[d] < least):
            least = inertia[d]
    moment = norm(force) * length + norm(torque)
    rate = momentum / least + np.sqrt(moment / least)
    finer = (
        max(0.5 * options.substeps, 1.0) ** 0.5
    )  # more steps where the options ask for more substeps; the error is of sixth order
    return max(min(int(np.ceil(min(finer * options.timestep * rate / REACH, 1e6))), MOST_STEPS), 1)


@njit
def _integrate(
    q: Quaternion, inertia: Vec, own_arm: Vec, momentum: Vec, force: Vec, torque: Vec, dt: float, steps: int
) -> tuple[Quaternion, Vec]:
    h = dt / steps
    for _ in range(steps):
        for s in range(len(TURNS)):
            q = rotate_with_momentum(q, inertia, momentum, TURNS[s] * h, ONE_TURN)
            moment = add(cross(turned(q, own_arm), force), torque)
            momentum = along(momentum, KICKS[s] * h, moment)
    return q, momentum


@njit
def _set_pose(
    body: Any, substep_body: Any, inertia: Vec, q: Quaternion, back: Quaternion, momentum: Vec, own_arm: Vec, pin: Vec
) -> None:
    """Set pose, velocity and displacement of the body at the end of the step."""
    own = turned(conjugate(q), momentum)
    spin = turned(q, (own[0] / inertia[0], own[1] / inertia[1], own[2] / inertia[2]))
    to_center = turned(q, own_arm)
    at = add(pin, to_center)
    velocity = cross(spin, to_center)
    rotation = normalised(multiply(q, back))
    for d in range(3):
        substep_body.displacement[d] = at[d] - body.position[d]
        body.position[d] = at[d]
        body.velocity[d] = velocity[d]
    for d in range(4):
        body.rotation[d] = rotation[d]
    set_spin(body.velocity, spin)


@njit
def _store_reaction(state: Any, impulse: Vec, substeps: Any) -> None:
    """Store the impulse on body b over the step, N s, as reaction and for the warm start of the next step."""
    for d in range(3):
        state.reaction[d] = impulse[d]
        state.reaction[3 + d] = 0.0
        state.total_impulse[d] = impulse[d]
        state.impulse[d] = impulse[d] / substeps


# ---------------------------------------------------------------- inertia about the pin


@njit
def moments_about(inertia: Vec, mass: float, r: Vec) -> tuple[Vec, Quaternion]:
    """Return (moments, rotation of their axes) about a point at -r from the centre, from those about the centre."""
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
    """Return moments and rotation of the axes of a tensor with ``off`` = (yz, zx, xy), by Jacobi rotations."""
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
    """Rotate the axes about the k-th so that the product of the other two becomes 0."""
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
    u, v = off[(k + 2) % 3], off[p]  # products with the k-th axis: of p, of the one after it
    a, b, x, y = i[p] + t * o, i[(k + 2) % 3] - t * o, c * u + s * v, c * v - s * u
    if k == 0:
        return (i[0], a, b), (0.0, y, x), multiply(turn, (half, sine, 0.0, 0.0))
    if k == 1:
        return (b, i[1], a), (x, 0.0, y), multiply(turn, (half, 0.0, sine, 0.0))
    return (a, b, i[2]), (y, x, 0.0), multiply(turn, (half, 0.0, 0.0, sine))
