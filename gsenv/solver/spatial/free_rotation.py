"""Free rotation of a rigid body, accurate to rounding at any timestep.

With L the angular momentum and 1/I_i = 1/I_m + c_i (m the middle moment, so c_m = 0) the energy is

    H = L.L / (2 I_m) + c_j L_j^2 / 2 + c_k L_k^2 / 2.

The first part rotates the body about the constant L and commutes with the others.  The rest turns the body with
the angular velocity (c_j L_j, c_k L_k, 0) in its own axes, far slower than the body itself; L in these axes follows
from its Taylor series, and the rotation from three values of it by a Magnus method of order six (Blanes, Casas, Ros,
"Improved high order integrators based on the Magnus expansion", BIT 40 (2000)).  L is conserved as a vector;
steps are so short that the energy keeps to rounding.  A symmetric top has one of the two terms only and is exact.
"""

from __future__ import annotations

import numpy as np

from ..jit import njit
from .math import (
    Quaternion,
    Vec,
    add,
    along,
    conjugate,
    cross,
    multiply,
    near_turn_of,
    near_unit,
    norm,
    scaled,
    sub,
    turned,
)

ONE_STEP = 0.03  # rad of the rest in one step of the Magnus method: error 5e-16
SHORT = 1e-5  # rad: largest angle for which the middle of the step is as accurate
MOST_STEPS = 1024
_NODE = 0.5 * 0.6**0.5  # of the step: distance of the outer nodes of Gauss from its middle
_SLOPE = 15.0**0.5 / 3.0
_BEND = 10.0 / 3.0


@njit
def rotate_with_velocity(q: Quaternion, inertia: Vec, spin: Vec, h: float) -> tuple[Quaternion, Vec]:
    """Return (rotation, angular velocity rad/s in the world) after h s without torque.

    q: rotation of the principal axes; inertia: kg m^2 about them; spin: rad/s in the world.
    """
    own = turned(conjugate(q), spin)
    momentum = (own[0] * inertia[0], own[1] * inertia[1], own[2] * inertia[2])
    size = norm(momentum)
    if not size > 0.0:
        return q, spin
    world = turned(q, momentum)
    q = _turn(q, inertia, momentum, world, size, h, ONE_STEP)
    momentum = turned(conjugate(q), world)
    own = (momentum[0] / inertia[0], momentum[1] / inertia[1], momentum[2] / inertia[2])
    return q, turned(q, own)


@njit
def rotate_with_momentum(q: Quaternion, inertia: Vec, momentum: Vec, h: float, one_step: float) -> Quaternion:
    """Return the rotation after h s without torque; h may be negative.

    momentum: angular momentum in the world, kg m^2/s, which is constant.
    one_step: rad, see ONE_STEP.
    """
    size = norm(momentum)
    if not size > 0.0:
        return q
    return _turn(q, inertia, turned(conjugate(q), momentum), momentum, size, h, one_step)


@njit
def _turn(q: Quaternion, inertia: Vec, momentum: Vec, world: Vec, size: float, h: float, one_step: float) -> Quaternion:
    """Return the rotation after h; ``momentum`` in the body's axes, ``world`` the same in the world."""
    m = _middle(inertia)
    j = (m + 1) % 3
    k = (m + 2) % 3
    cj = 1.0 / inertia[j] - 1.0 / inertia[m]
    ck = 1.0 / inertia[k] - 1.0 / inertia[m]
    if cj != 0.0 and ck != 0.0:
        reach = max(abs(cj), abs(ck)) * size * abs(h)
        steps = min(int(np.ceil(min(reach / one_step, 1e6))), MOST_STEPS)
        t = h * min(1.0 / steps, one_step / reach) if steps > 0 else 0.0  # a body too fast for all keeps its energy
        for _ in range(steps):
            turn = near_turn_of(_turn_of_rest(momentum, m, cj * t, ck * t))
            q = multiply(q, turn)
            momentum = turned(conjugate(turn), momentum)
    elif cj != 0.0 or ck != 0.0:
        axis = j if cj != 0.0 else k
        angle = (cj + ck) * h * momentum[axis]
        about = (angle if axis == 0 else 0.0, angle if axis == 1 else 0.0, angle if axis == 2 else 0.0)
        q = multiply(q, near_turn_of(about))
    return near_unit(multiply(near_turn_of(scaled(world, h / inertia[m])), q))


@njit
def _middle(inertia: Vec) -> int:
    low = min(inertia[0], min(inertia[1], inertia[2]))
    high = max(inertia[0], max(inertia[1], inertia[2]))
    for i in range(3):
        if low < inertia[i] < high:
            return i
    return 0 if inertia[0] == inertia[1] or inertia[0] == inertia[2] else 1  # one of the two equal moments


@njit
def _turn_of_rest(momentum: Vec, m: int, cj: float, ck: float) -> Vec:
    """Return the rotation vector in the body's axes by c_j L_j^2 / 2 + c_k L_k^2 / 2 in the time 1."""
    j0 = momentum[(m + 1) % 3]
    k0 = momentum[(m + 2) % 3]
    m0 = momentum[m]
    cm = ck - cj
    # Taylor series of L x (c_j L_j, c_k L_k, 0)
    j1 = -ck * m0 * k0
    k1 = cj * m0 * j0
    m1 = cm * j0 * k0
    if max(abs(cj), abs(ck)) * (abs(j0) + abs(k0) + abs(m0)) < SHORT:
        return _in_body_axes(m, (cj * (j0 + 0.5 * j1), ck * (k0 + 0.5 * k1), 0.0))
    j2 = -ck * (m0 * k1 + m1 * k0) / 2.0
    k2 = cj * (m0 * j1 + m1 * j0) / 2.0
    m2 = cm * (j0 * k1 + j1 * k0) / 2.0
    j3 = -ck * (m0 * k2 + m1 * k1 + m2 * k0) / 3.0
    k3 = cj * (m0 * j2 + m1 * j1 + m2 * j0) / 3.0
    m3 = cm * (j0 * k2 + j1 * k1 + j2 * k0) / 3.0
    j4 = -ck * (m0 * k3 + m1 * k2 + m2 * k1 + m3 * k0) / 4.0
    k4 = cj * (m0 * j3 + m1 * j2 + m2 * j1 + m3 * j0) / 4.0
    m4 = cm * (j0 * k3 + j1 * k2 + j2 * k1 + j3 * k0) / 4.0
    j5 = -ck * (m0 * k4 + m1 * k3 + m2 * k2 + m3 * k1 + m4 * k0) / 5.0
    k5 = cj * (m0 * j4 + m1 * j3 + m2 * j2 + m3 * j1 + m4 * j0) / 5.0
    m5 = cm * (j0 * k4 + j1 * k3 + j2 * k2 + j3 * k1 + j4 * k0) / 5.0
    j6 = -ck * (m0 * k5 + m1 * k4 + m2 * k3 + m3 * k2 + m4 * k1 + m5 * k0) / 6.0
    k6 = cj * (m0 * j5 + m1 * j4 + m2 * j3 + m3 * j2 + m4 * j1 + m5 * j0) / 6.0
    of_j = (j0, j1, j2, j3, j4, j5, j6)
    of_k = (k0, k1, k2, k3, k4, k5, k6)
    early = (cj * _value(of_j, 0.5 - _NODE), ck * _value(of_k, 0.5 - _NODE), 0.0)
    middle = (cj * _value(of_j, 0.5), ck * _value(of_k, 0.5), 0.0)
    late = (cj * _value(of_j, 0.5 + _NODE), ck * _value(of_k, 0.5 + _NODE), 0.0)
    return _in_body_axes(m, _magnus(early, middle, late))


@njit
def _in_body_axes(m: int, v: Vec) -> Vec:
    """Return a vector that is given along axes j, k and m."""
    if m == 0:
        return v[2], v[0], v[1]
    if m == 1:
        return v[1], v[2], v[0]
    return v


@njit
def _value(series: tuple[float, float, float, float, float, float, float], t: float) -> float:
    """Return the value of a series at t."""
    c0, c1, c2, c3, c4, c5, c6 = series
    return c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * c6)))))


@njit
def _magnus(early: Vec, middle: Vec, late: Vec) -> Vec:
    """Return the rotation vector of angular velocities in the body's axes, given at the nodes of Gauss of [0, 1]."""
    a = middle
    b = scaled(sub(late, early), _SLOPE)
    c = scaled(add(sub(late, scaled(middle, 2.0)), early), _BEND)
    ab = cross(b, a)  # commutators of rotations in the body's axes
    acab = scaled(cross(add(scaled(c, 2.0), ab), a), -1.0 / 60.0)
    last = cross(add(b, acab), sub(sub(ab, c), scaled(a, 20.0)))
    return along(along(a, 1.0 / 12.0, c), 1.0 / 240.0, last)
