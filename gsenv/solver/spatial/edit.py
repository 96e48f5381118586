"""Edits of a 3D world between two steps, for kernels: what depends on the geometry. See core/edit.py."""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .math import add, turned, vec

# ---------------------------------------------------------------- masses


@njit
def write_inertia(parameters: Any, inertia: Any, factor: Any) -> None:
    """Write ``factor`` times three moments of inertia, kg m^2; the caller updates the inverses."""
    for d in range(3):
        parameters.inertia[d] = inertia[d] * factor


@njit
def invert_inertia(parameters: Any, moves: Any) -> None:
    """Write the inverses of the moments, 0 for a body that does not move by forces."""
    for d in range(3):
        parameters.inv_inertia[d] = 1.0 / parameters.inertia[d] if moves else 0.0


@njit
def box_inertia(half_x: Any, half_y: Any, half_z: Any, mass: Any) -> Any:
    """Return the three moments about the axes of the box, kg m^2. Plain Python takes arrays as well."""
    x, y, z = half_x * half_x, half_y * half_y, half_z * half_z
    third = mass / 3.0
    return third * (y + z), third * (z + x), third * (x + y)


@njit
def write_box_inertia(parameters: Any, half_extents: Any, mass: Any) -> None:
    """Write the inertia of a body of one solid box; the caller updates the inverses."""
    write_inertia(parameters, box_inertia(half_extents[0], half_extents[1], half_extents[2], mass), 1.0)


# ---------------------------------------------------------------- poses


@njit
def write_pose(body: Any, center: Any, position: Any, turn: Any) -> None:
    """Write a body's pose from that of its own frame; `center`: its centre of mass there. See `place_body`."""
    at = add(position, turned(turn, vec(center)))
    for d in range(3):
        body.position[d] = at[d]
    for d in range(4):
        body.rotation[d] = turn[d]
