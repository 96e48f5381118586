"""Initial poses, velocities and masses of 3D bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..records.model import Array
from .mass import principal_axes, solid_mass
from .math import Quaternion, conjugate, multiply, normalised

_multiply = getattr(multiply, "py_func", multiply)
_conjugate = getattr(conjugate, "py_func", conjugate)
_normalised = getattr(normalised, "py_func", normalised)


def rotation_of(rotation: Any) -> Quaternion:
    """Return the nearest unit quaternion."""
    w, x, y, z = (float(n) for n in rotation)
    w, x, y, z = _normalised((w, x, y, z))
    return float(w), float(x), float(y), float(z)


def tensor_of(inertia: Array) -> Array:
    """Return the tensor (3, 3) of an inertia given as three moments about the body's axes or as a tensor."""
    return np.diag(inertia) if inertia.ndim == 1 else inertia


def mass_of(spec: Any) -> tuple[float, Array, tuple[Array, Quaternion]]:
    """Return (mass, centre of mass, (principal moments, their axes)) of a body, as given or else from its shapes."""
    mass, center, moments, axes = solid_mass(spec.shapes)
    if spec.mass is not None:
        moments = moments * (spec.mass / mass if mass > 0.0 else 0.0)
        mass = spec.mass
    if spec.inertia is not None:
        moments, axes = principal_axes(tensor_of(spec.inertia))
    if spec.center is not None:
        center = spec.center
    return mass, center, (moments, axes)


def has_inertia(spec: Any) -> bool:
    return spec.inertia is not None or bool((solid_mass(spec.shapes)[2] > 0.0).all())


def fill_mass(spec: Any, nominal: Array, mass: float, inertia: tuple[Array, Quaternion]) -> None:
    """Write the masses of a dynamic body to a one-entry slice of parameters."""
    moments, axes = inertia
    nominal["inertia"] = moments
    nominal["axes"] = axes
    nominal["inv_inertia"] = 1.0 / moments if spec.enabled else 0.0


def fill_pose(spec: Any, start: Array) -> None:
    """Write rotation and angular velocity to a one-entry slice of states."""
    start["rotation"] = rotation_of(spec.orientation)


def velocity_of(spec: Any) -> tuple[float, ...]:
    return (*spec.linear_velocity, *spec.angular_velocity)


def turned(spec: Any, v: Array) -> Array:
    """Rotate a direction of the body's frame to the world, at the initial pose."""
    return turned_by(rotation_of(spec.orientation), v)


def turned_back(spec: Any, v: Array) -> Array:
    """Rotate a direction of the world to the body's frame."""
    return turned_by(_conjugate(rotation_of(spec.orientation)), v)


def turned_by(q: Any, v: Any) -> Array:
    """Rotate directions (..., 3) by quaternions (..., 4)."""
    q, v = np.asarray(q, float), np.asarray(v, float)
    w, u = q[..., :1], q[..., 1:]
    t = 2.0 * _cross(u, v)
    return np.asarray(v + w * t + _cross(u, t))


def _cross(a: Array, b: Array) -> Array:
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], -1)


def multiplied(p: Any, q: Any) -> Array:
    """Return the quaternions (..., 4) of rotations by q, then by p."""
    p, q = np.asarray(p, float), np.asarray(q, float)
    return np.stack(_multiply(np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)), -1)


def rotation_from(matrix: Array) -> Array:
    """Return the quaternion (w, x, y, z) of a rotation matrix (3, 3), from its largest component."""
    m = matrix
    square = np.array(
        [
            m[0, 0] + m[1, 1] + m[2, 2],
            m[0, 0] - m[1, 1] - m[2, 2],
            m[1, 1] - m[0, 0] - m[2, 2],
            m[2, 2] - m[0, 0] - m[1, 1],
        ]
    )
    products = np.array(
        [
            [0.0, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [0.0, 0.0, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [0.0, 0.0, 0.0, m[1, 2] + m[2, 1]],
            [0.0, 0.0, 0.0, 0.0],
        ]
    )
    products = products + products.T + np.diag(1.0 + square)
    q = products[int(np.argmax(square))]
    return np.asarray(q / np.hypot.reduce(q))


def rotation_in(a: Any, orientation: Any) -> Quaternion:
    """Return an orientation in the world, by default that of its axes, in the frame of a body at its initial pose."""
    own = rotation_of(a.orientation)
    return _normalised(_multiply(_conjugate(own), (1.0, 0.0, 0.0, 0.0) if orientation is None else orientation))


def fill_reference(a: Any, b: Any, parameters: Any, state: Any) -> None:
    """Write the rotations of b in a and of b in the world, at the initial poses, to a joint's records."""
    one, other = rotation_of(a.orientation), rotation_of(b.orientation)
    parameters["reference"] = _normalised(_multiply(_conjugate(one), other))
    state["target_rotation"] = other
