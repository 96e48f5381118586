"""Unit quaternions (w, x, y, z), of many bodies at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def conjugate(q: Array) -> Array:
    """Return the conjugates (..., 4), w first."""
    return np.asarray(q) * np.array([1.0, -1.0, -1.0, -1.0])


def multiply(p: Array, q: Array) -> Array:
    """Return the products (..., 4): the rotation q, then the rotation p."""
    a, u = p[..., :1], p[..., 1:]
    b, v = q[..., :1], q[..., 1:]
    scalar = a * b - (u * v).sum(-1, keepdims=True)
    return np.concatenate([scalar, a * v + b * u + np.cross(u, v)], -1)


def rotated(q: Array, v: Array) -> Array:
    """Return the vectors (..., 3) rotated by unit quaternions."""
    w, u = q[..., :1], q[..., 1:]
    t = 2.0 * np.cross(u, v)
    return v + w * t + np.cross(u, t)


def matrices(q: Array) -> Array:
    """Return rotation matrices (..., 3, 3), whose columns are the rotated axes."""
    return np.stack([rotated(q, np.broadcast_to(axis, (*q.shape[:-1], 3))) for axis in np.eye(3)], -1)
