"""Free rotation of a rigid body, accurate to rounding at any timestep.

With L the angular momentum and 1/I_i = 1/I_m + c_i (m the middle moment, so c_m = 0) the energy is

    H = L.L / (2 I_m) + c_j L_j^2 / 2 + c_k L_k^2 / 2.

Each part has an exact flow: L.L rotates the body about the constant L and commutes with the others; c_j L_j^2 / 2
rotates it about its own axis j by c_j L_j t.  The latter two are composed symmetrically (McLachlan, "Explicit
Lie-Poisson integration and the Euler equations", Phys. Rev. Lett. 71 (1993)) to order six (Yoshida, "Construction
of higher order symplectic integrators", Phys. Lett. A 150 (1990), solution A).  A symmetric top has only
one of them and is exact.  L is conserved as a vector; the energy has no drift.
"""

from __future__ import annotations

import numpy as np

from ..core.trig import sin_cos
from ..jit import njit
from .math import Quaternion, Vec, conjugate, multiply, norm, normalised, scaled, turn_of, turned

# Yoshida's solution A of order six: weights of seven symmetric steps
_W1 = -1.17767998417887
_W2 = 0.235573213359357
_W3 = 0.784513610477560
_W0 = 1.0 - 2.0 * (_W1 + _W2 + _W3)
_WEIGHTS = (_W3, _W2, _W1, _W0, _W1, _W2, _W3)
ONE_STEP = 0.03  # rad about the body's own axes in one composed step: error 1e-13
PLAIN = 1e-5  # rad: largest angle for which one symmetric step of second order is as accurate
MOST_STEPS = 256


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
    q, momentum = _turn(q, inertia, momentum, turned(q, momentum), size, h, ONE_STEP)
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
    q, _ = _turn(q, inertia, turned(conjugate(q), momentum), momentum, size, h, one_step)
    return q


@njit
def _turn(
    q: Quaternion, inertia: Vec, momentum: Vec, world: Vec, size: float, h: float, one_step: float
) -> tuple[Quaternion, Vec]:
    """Return (rotation, angular momentum in the body's axes); ``world``: the momentum in the world."""
    m = _middle(inertia)
    j = 1 if m == 0 else 0
    k = 1 if m == 2 else 2
    cj = 1.0 / inertia[j] - 1.0 / inertia[m]
    ck = 1.0 / inertia[k] - 1.0 / inertia[m]
    q, momentum = _turn_about_axes(q, momentum, j, cj, k, ck, size, h, one_step)
    return normalised(multiply(turn_of(scaled(world, h / inertia[m])), q)), momentum


@njit
def _middle(inertia: Vec) -> int:
    low = min(inertia[0], min(inertia[1], inertia[2]))
    high = max(inertia[0], max(inertia[1], inertia[2]))
    for i in range(3):
        if low < inertia[i] < high:
            return i
    return 0 if inertia[0] == inertia[1] or inertia[0] == inertia[2] else 1  # one of the two equal moments


@njit
def _turn_about_axes(
    q: Quaternion, momentum: Vec, j: int, cj: float, k: int, ck: float, size: float, h: float, one_step: float
) -> tuple[Quaternion, Vec]:
    """Apply the flow of the two terms of H with differences of moments; ``momentum`` in the body's axes."""
    if cj == 0.0 or ck == 0.0:
        q, momentum = _turn_about_axis(q, momentum, j, cj * h)
        return _turn_about_axis(q, momentum, k, ck * h)
    reach = max(abs(cj), abs(ck)) * size * abs(h)
    if reach <= PLAIN:
        q, momentum = _turn_about_axis(q, momentum, j, 0.5 * cj * h)
        q, momentum = _turn_about_axis(q, momentum, k, ck * h)
        return _turn_about_axis(q, momentum, j, 0.5 * cj * h)
    steps = min(int(np.ceil(min(reach / one_step, 1e6))), MOST_STEPS)
    t = h / steps
    for _ in range(steps):
        before = 0.0
        for s in range(7):
            weight = _WEIGHTS[s]
            q, momentum = _turn_about_axis(q, momentum, j, 0.5 * (before + weight) * cj * t)
            q, momentum = _turn_about_axis(q, momentum, k, weight * ck * t)
            before = weight
        q, momentum = _turn_about_axis(q, momentum, j, 0.5 * before * cj * t)
    return q, momentum


@njit
def _turn_about_axis(q: Quaternion, momentum: Vec, axis: int, rate: float) -> tuple[Quaternion, Vec]:
    """Rotate the body about its own axis by rate * L_axis rad; in its axes the constant L rotates back."""
    lx, ly, lz = momentum
    w, x, y, z = q
    if axis == 0:
        c, s = sin_cos(0.5 * rate * lx)
        q = (w * c - x * s, x * c + w * s, y * c + z * s, z * c - y * s)
        c, s = c * c - s * s, 2.0 * c * s
        return q, (lx, c * ly + s * lz, c * lz - s * ly)
    if axis == 1:
        c, s = sin_cos(0.5 * rate * ly)
        q = (w * c - y * s, x * c - z * s, y * c + w * s, z * c + x * s)
        c, s = c * c - s * s, 2.0 * c * s
        return q, (c * lx - s * lz, ly, c * lz + s * lx)
    c, s = sin_cos(0.5 * rate * lz)
    q = (w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s)
    c, s = c * c - s * s, 2.0 * c * s
    return q, (c * lx + s * ly, c * ly - s * lx, lz)
