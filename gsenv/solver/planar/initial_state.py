"""Initial poses, velocities and masses of 2D bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.trig import sin_cos
from ..records.model import Array
from . import shapes as planar_shapes

_sin_cos = getattr(sin_cos, "py_func", sin_cos)


def rotation_of(angle: float) -> tuple[float, float]:
    """Return (cos, sin) by the kernels' polynomials, since libm's bits differ from machine to machine."""
    c, s = _sin_cos(float(angle))
    return float(c), float(s)


def solid_mass(shapes: tuple[Any, ...]) -> tuple[float, Array, float]:
    """Return (mass kg, centre of mass m in the body's frame, inertia kg m^2 about it) from densities."""
    mass = 0.0
    moment = np.zeros(2)
    parts = []
    for shape in shapes:
        if not shape.solid or shape.sensor:
            continue
        area, center, inertia = planar_shapes.mass_properties(shape)
        m = area * shape.density
        mass += m
        moment += m * np.asarray(center)
        parts.append((m, np.asarray(center), inertia * shape.density))
    if mass <= 0.0:
        return 0.0, np.zeros(2), 0.0
    middle = moment / mass
    total = sum(i + m * float(((c - middle) ** 2).sum()) for m, c, i in parts)
    return mass, middle, float(total)


def mass_of(spec: Any) -> tuple[float, Array, float]:
    """Return (mass, centre of mass, inertia) of a body, as given or else from its shapes."""
    mass, center, inertia = solid_mass(spec.shapes)
    if spec.mass is not None:
        inertia *= spec.mass / mass if mass > 0.0 else 0.0
        mass = spec.mass
    if spec.inertia is not None:
        inertia = spec.inertia
    if spec.center is not None:
        center = spec.center
    return mass, center, inertia


def has_inertia(spec: Any) -> bool:
    return spec.inertia is not None or solid_mass(spec.shapes)[2] > 0.0


def fill_mass(spec: Any, nominal: Array, mass: float, inertia: float) -> None:
    """Write the masses of a dynamic body to a one-entry slice of parameters."""
    nominal["inertia"] = inertia
    nominal["inv_inertia"] = 1.0 / inertia if spec.enabled else 0.0


def fill_pose(spec: Any, start: Array) -> None:
    """Write rotation and angular velocity to a one-entry slice of states."""
    start["rotation"] = rotation_of(spec.angle)
    start["angle"] = spec.angle


def velocity_of(spec: Any) -> tuple[float, ...]:
    return (*spec.linear_velocity, spec.angular_velocity)


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
