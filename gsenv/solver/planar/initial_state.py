"""Initial poses of 2D bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.trig import sin_cos
from ..records.model import Array

_sin_cos = getattr(sin_cos, "py_func", sin_cos)


def rotation_of(angle: float) -> tuple[float, float]:
    """Return (cos, sin) by the kernels' polynomials, since libm's bits differ from machine to machine."""
    c, s = _sin_cos(float(angle))
    return float(c), float(s)


def fill_pose(spec: Any, start: Array) -> None:
    """Write the rotation to a one-entry slice of states."""
    start["rotation"] = rotation_of(spec.angle)
    start["angle"] = spec.angle


def turned(spec: Any, v: Array) -> Array:
    """Rotate a direction of the body's frame to the world, at the initial pose."""
    c, s = rotation_of(spec.angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])


def turned_back(spec: Any, v: Array) -> Array:
    """Rotate a direction of the world to the body's frame."""
    c, s = rotation_of(spec.angle)
    return np.array([c * v[0] + s * v[1], c * v[1] - s * v[0]])


def fill_reference(a: Any, b: Any, parameters: Any, state: Any) -> None:
    """Write the rotations of b in a and of b in the world, at the initial poses, to a joint's records."""
    parameters["reference"] = rotation_of(b.angle - a.angle)
    parameters["reference_angle"] = b.angle - a.angle
    state["target_angle"] = b.angle
