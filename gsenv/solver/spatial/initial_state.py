"""Initial poses of 3D bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.trig import sin_cos
from ..records.model import Array
from .math import Quaternion, conjugate, multiply, normalised

_multiply = getattr(multiply, "py_func", multiply)
_conjugate = getattr(conjugate, "py_func", conjugate)
_sin_cos = getattr(sin_cos, "py_func", sin_cos)
_normalised = getattr(normalised, "py_func", normalised)


def rotation_of(rotation: Any) -> Quaternion:
    """Return the nearest unit quaternion."""
    w, x, y, z = (float(n) for n in rotation)
    w, x, y, z = _normalised((w, x, y, z))
    return float(w), float(x), float(y), float(z)


def fill_pose(spec: Any, start: Array) -> None:
    """Write the rotation to a one-entry slice of states."""
    start["rotation"] = rotation_of(spec.orientation)


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


def turn_about(axis: Array, angle: Array) -> Array:
    """Return the quaternions (world, 4) of rotations by angles (world,) in rad about unit axes (world, 3)."""
    half = 0.5 * np.asarray(angle)
    cosine, sine = np.array([_sin_cos(float(one)) for one in half]).reshape(-1, 2).T
    return np.concatenate([cosine[:, None], sine[:, None] * axis], -1)


def turned_vectors(turn: Array, v: Array) -> Array:
    """Rotate vectors (world, 3)."""
    return turned_by(turn, v)


def turn_bodies(bodies: Array, turn: Array, pivot: Array) -> None:
    """Rotate bodies, state records (world,), about points (world, 3)."""
    bodies["position"] = pivot + turned_by(turn, bodies["position"] - pivot)
    bodies["rotation"] = [rotation_of(one) for one in multiplied(turn, bodies["rotation"])]
