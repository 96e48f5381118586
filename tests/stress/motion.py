"""Kinetic energy and speeds of the bodies of one world, compiled: they are read after every step."""

from __future__ import annotations

import numpy as np

from gsenv.solver.jit import njit

from .cases import Array


@njit
def motion(
    velocity: Array, rotation: Array, axes: Array, mass: Array, inertia: Array, radius: Array
) -> tuple[float, Array]:
    """Return the kinetic energy in J and of each body the speed in m/s of its fastest point, 0 without a mass.

    Args:
        velocity: (body, 3) or, in 3D, (body, 6): linear, then angular.
        rotation: (body, 2) or (body, 4), quaternions in 3D.
        axes: (body, 4), quaternions of the principal axes in the body; not read in 2D.
        mass: (body,), 0 for what is not dynamic.
        inertia: (body, 1) or (body, 3), about the principal axes.
        radius: (body,), of the circle or ball around it.
    """
    dim = 2 if velocity.shape[1] == 3 else 3
    energy, fastest = 0.0, np.zeros(len(mass))
    for b in range(len(mass)):
        if not mass[b] > 0.0:
            continue
        square = spin = 0.0
        for k in range(dim):
            square += velocity[b, k] ** 2
        energy += 0.5 * mass[b] * square
        if dim == 2:
            spin = velocity[b, 2] ** 2
            energy += 0.5 * inertia[b, 0] * spin
        else:
            frame = product(rotation[b], axes[b])
            w, u = frame[0], frame[1:]
            turning = velocity[b, 3:]
            twice = 2.0 * np.cross(u, turning)  # back into the frame: v - w (2 u x v) + u x (2 u x v)
            along = turning - w * twice + np.cross(u, twice)
            for k in range(3):
                spin += along[k] ** 2
                energy += 0.5 * inertia[b, k] * along[k] ** 2
        fastest[b] = np.sqrt(square) + np.sqrt(spin) * radius[b]
    return energy, fastest


@njit
def product(p: Array, q: Array) -> Array:
    """Return the quaternion of the turn by q, then by p."""
    u, v = p[1:], q[1:]
    out = np.empty(4)
    out[0] = p[0] * q[0] - (u * v).sum()
    out[1:] = p[0] * v + q[0] * u + np.cross(u, v)
    return out
