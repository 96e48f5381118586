"""Edits of a 3D world between two steps, for kernels: sizes, inertias, poses. See core/edit.py."""

from __future__ import annotations

import math
from typing import Any

from ..core.edit import release_contacts, wake_body
from ..jit import njit
from .math import add, turned, vec

# ---------------------------------------------------------------- masses


@njit
def update_inverses(parameters: Any) -> None:
    """Update the inverses of mass and moments; all are 0 unless the body is dynamic and enabled."""
    moves = parameters.enabled != 0 and parameters.mass > 0.0
    parameters.inv_mass = 1.0 / parameters.mass if moves else 0.0
    for d in range(3):
        parameters.inv_inertia[d] = 1.0 / parameters.inertia[d] if moves else 0.0


@njit
def set_inertia(parameters: Any, inertia: Any) -> None:
    """Set a dynamic body's three moments of inertia about its principal axes, kg m^2."""
    for d in range(3):
        parameters.inertia[d] = inertia[d]
    update_inverses(parameters)


@njit
def scale_inertia(parameters: Any, factor: Any) -> None:
    """Multiply the moments; the caller updates the inverses."""
    for d in range(3):
        parameters.inertia[d] *= factor


@njit
def box_inertia(half_x: Any, half_y: Any, half_z: Any, mass: Any) -> Any:
    """Return the three moments about the axes of the box, kg m^2. Plain Python takes arrays as well."""
    x, y, z = half_x * half_x, half_y * half_y, half_z * half_z
    third = mass / 3.0
    return third * (y + z), third * (z + x), third * (x + y)


# ---------------------------------------------------------------- sizes


@njit
def set_extent(parameters: Any, shape: Any, extent: Any, reach: Any) -> None:
    """Set the extents of a body of one shape, m: half-width, and distance of the farthest point from its centre."""
    square = 0.0
    for d in range(3):
        offset = shape.local_position[d] - parameters.center[d]
        square += offset * offset
    shape.extent = extent
    parameters.extent = extent
    parameters.radius = reach + math.sqrt(square)


@njit
def set_box(parameters: Any, shape: Any, half_x: Any, half_y: Any, half_z: Any, mass: Any) -> None:
    """Set size, m, and mass, kg, of a dynamic body of one solid box, with density, inertia and extents.

    Args:
        parameters, shape: records of the parameters of the body and of its box.
    """
    shape.size[0] = half_x
    shape.size[1] = half_y
    shape.size[2] = half_z
    shape.density = mass / (8.0 * half_x * half_y * half_z)
    reach = math.sqrt(half_x * half_x + half_y * half_y + half_z * half_z)
    set_extent(parameters, shape, min(half_x, min(half_y, half_z)), reach)
    parameters.mass = mass
    set_inertia(parameters, box_inertia(half_x, half_y, half_z, mass))


# ---------------------------------------------------------------- poses


@njit
def place_body(b: Any, bodies: Any, parameters: Any, contacts: Any, position: Any, turn: Any, velocity: Any) -> None:
    """Set the pose of body b, wake it, clear the impulses of its contacts, and wake the bodies that it touched.

    Sleeping bodies at the new pose of a static body stay asleep; call `wake_body` for them.

    Args:
        bodies, parameters: (body,) records of the world's state and parameters.
        contacts: (contact,) records of the last step, ``contacts[:contact_count]``.
        position: (x, y, z) m, of the body's own frame.
        turn: unit quaternion (w, x, y, z).
        velocity: (vx, vy, vz, wx, wy, wz) m/s and rad/s, of the centre of mass.
    """
    release_contacts(b, bodies, contacts)
    body = bodies[b]
    at = add(position, turned(turn, vec(parameters[b].center)))
    for d in range(3):
        body.position[d] = at[d]
    for d in range(4):
        body.rotation[d] = turn[d]
    for d in range(6):
        body.velocity[d] = velocity[d]
    wake_body(body)
