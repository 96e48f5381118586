"""Edits of a 2D world between two steps, for kernels: what depends on the geometry. See core/edit.py."""

from __future__ import annotations

from typing import Any

from ..core.edit import set_extent
from ..jit import njit

# ---------------------------------------------------------------- masses


@njit
def write_inertia(parameters: Any, inertia: Any, factor: Any) -> None:
    """Write ``factor`` times an inertia, kg m^2; the caller updates the inverse."""
    parameters.inertia = inertia * factor


@njit
def invert_inertia(parameters: Any, moves: Any) -> None:
    """Write the inverse of the inertia, 0 for a body that does not move by forces."""
    parameters.inv_inertia = 1.0 / parameters.inertia if moves else 0.0


@njit
def box_inertia(half_x: Any, half_y: Any, mass: Any) -> Any:
    """Return the inertia in kg m^2 about the centre. Plain Python takes arrays as well."""
    return mass * (half_x * half_x + half_y * half_y) / 3.0


@njit
def write_box_inertia(parameters: Any, half_extents: Any, mass: Any) -> None:
    """Write the inertia of a body of one solid box; the caller updates the inverses."""
    parameters.inertia = box_inertia(half_extents[0], half_extents[1], mass)


# ---------------------------------------------------------------- sizes


@njit
def set_capsule_size(parameters: Any, shape: Any, half_length: Any, radius: Any) -> None:
    """Set size, m, and extents of a body of one capsule; mass and inertia do not change."""
    shape.size[0] = half_length
    shape.radius = radius
    set_extent(parameters, shape, radius, half_length + radius)


# ---------------------------------------------------------------- poses


@njit
def write_pose(body: Any, center: Any, position: Any, turn: Any) -> None:
    """Write a body's pose from that of its own frame; `center`: its centre of mass there. See `place_body`."""
    c, s, angle = turn
    body.position[0] = position[0] + (c * center[0] - s * center[1])
    body.position[1] = position[1] + (s * center[0] + c * center[1])
    body.rotation[0] = c
    body.rotation[1] = s
    body.angle = angle
