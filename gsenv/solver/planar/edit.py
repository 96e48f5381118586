"""Edits of a 2D world between two steps, for kernels: sizes, inertias, poses. See core/edit.py."""

from __future__ import annotations

import math
from typing import Any

from ..core.edit import release_contacts, wake_body
from ..jit import njit

# ---------------------------------------------------------------- masses


@njit
def update_inverses(parameters: Any) -> None:
    """Update inverse mass and inertia; both are 0 unless the body is dynamic and enabled."""
    moves = parameters.enabled != 0 and parameters.mass > 0.0
    parameters.inv_mass = 1.0 / parameters.mass if moves else 0.0
    parameters.inv_inertia = 1.0 / parameters.inertia if moves else 0.0


@njit
def set_inertia(parameters: Any, inertia: Any) -> None:
    """Set a dynamic body's moment of inertia about its centre of mass, kg m^2."""
    parameters.inertia = inertia
    update_inverses(parameters)


@njit
def scale_inertia(parameters: Any, factor: Any) -> None:
    """Multiply the inertia; the caller updates the inverses."""
    parameters.inertia *= factor


@njit
def box_inertia(half_x: Any, half_y: Any, mass: Any) -> Any:
    """Return the inertia in kg m^2 about the centre. Plain Python takes arrays as well."""
    return mass * (half_x * half_x + half_y * half_y) / 3.0


# ---------------------------------------------------------------- sizes


@njit
def set_extent(parameters: Any, shape: Any, extent: Any, reach: Any) -> None:
    """Set the extents of a body of one shape, m: half-width, and distance of the farthest point from its centre."""
    x = shape.local_position[0] - parameters.center[0]
    y = shape.local_position[1] - parameters.center[1]
    shape.extent = extent
    parameters.extent = extent
    parameters.radius = reach + math.sqrt(x * x + y * y)


@njit
def set_box(parameters: Any, shape: Any, half_x: Any, half_y: Any, mass: Any) -> None:
    """Set size, m, and mass, kg, of a dynamic body of one solid box, with density, inertia and extents.

    Args:
        parameters, shape: records of the parameters of the body and of its box.
    """
    shape.size[0] = half_x
    shape.size[1] = half_y
    shape.density = mass / (4.0 * half_x * half_y)
    set_extent(parameters, shape, min(half_x, half_y), math.sqrt(half_x * half_x + half_y * half_y))
    parameters.mass = mass
    set_inertia(parameters, box_inertia(half_x, half_y, mass))


@njit
def set_capsule_size(parameters: Any, shape: Any, half_length: Any, radius: Any) -> None:
    """Set size, m, and extents of a body of one capsule; mass and inertia do not change."""
    shape.size[0] = half_length
    shape.radius = radius
    set_extent(parameters, shape, radius, half_length + radius)


# ---------------------------------------------------------------- poses


@njit
def place_body(b: Any, bodies: Any, parameters: Any, contacts: Any, position: Any, turn: Any, velocity: Any) -> None:
    """Set the pose of body b, wake it, clear the impulses of its contacts, and wake the bodies that it touched.

    Sleeping bodies at the new pose of a static body stay asleep; call `wake_body` for them.

    Args:
        bodies, parameters: (body,) records of the world's state and parameters.
        contacts: (contact,) records of the last step, ``contacts[:contact_count]``.
        position: (x, y) m, of the body's own frame.
        turn: (cos, sin, angle rad); the angle may be unwrapped.
        velocity: (vx, vy, w) m/s and rad/s, of the centre of mass.
    """
    release_contacts(b, bodies, contacts)
    body = bodies[b]
    center = parameters[b].center
    c, s, angle = turn
    body.position[0] = position[0] + (c * center[0] - s * center[1])
    body.position[1] = position[1] + (s * center[0] + c * center[1])
    body.rotation[0] = c
    body.rotation[1] = s
    body.angle = angle
    for d in range(3):
        body.velocity[d] = velocity[d]
    wake_body(body)
