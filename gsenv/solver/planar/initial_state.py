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


def turn_about(axis: Array, angle: Array) -> Array:
    """Return rotations (world, 3), cos, sin and angle, by angles (world,) in rad; the axis is that of the plane."""
    return np.array([(*rotation_of(one), one) for one in angle]).reshape(-1, 3)


def turned_vectors(turn: Array, v: Array) -> Array:
    """Rotate vectors (world, 2)."""
    c, s = turn[:, 0], turn[:, 1]
    return np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]], -1)


def turn_bodies(bodies: Array, turn: Array, pivot: Array) -> None:
    """Rotate bodies, state records (world,), about points (world, 2)."""
    bodies["position"] = pivot + turned_vectors(turn, bodies["position"] - pivot)
    bodies["angle"] += turn[:, 2]
    bodies["rotation"] = np.array([rotation_of(one) for one in bodies["angle"]]).reshape(-1, 2)
