"""Edits of a world between two steps, for kernels: masses, enabled flags, sleep.

Some fields of a body are derived from others: inverses from masses and enabled flags, extents from sizes.
These functions set both, so callers never write the derived ones.  ``Parameters.set`` uses them too.  What depends
on the geometry is in ``planar/edit.py`` and ``spatial/edit.py``.

``parameters`` and ``body`` are one body's records, of a world's parameters and of its state.
"""

from __future__ import annotations

import math
from typing import Any

from ..jit import njit
from .dispatch import by_dimension

write_inertia = by_dimension("edit", "write_inertia")
invert_inertia = by_dimension("edit", "invert_inertia")
write_box_inertia = by_dimension("edit", "write_box_inertia")
write_pose = by_dimension("edit", "write_pose")


# ---------------------------------------------------------------- masses


@njit
def update_inverses(parameters: Any) -> None:
    """Update the inverses of mass and inertia; all are 0 unless the body is dynamic and enabled."""
    moves = parameters.enabled != 0 and parameters.mass > 0.0
    parameters.inv_mass = 1.0 / parameters.mass if moves else 0.0
    invert_inertia(parameters, moves)


@njit
def set_inertia(parameters: Any, inertia: Any) -> None:
    """Set a dynamic body's inertia about its centre of mass, kg m^2; in 3D its three principal moments."""
    write_inertia(parameters, inertia, 1.0)
    update_inverses(parameters)


@njit
def set_mass(parameters: Any, mass: Any) -> None:
    """Set a dynamic body's mass, kg, and scale its inertia with it."""
    write_inertia(parameters, parameters.inertia, mass / parameters.mass)
    set_mass_alone(parameters, mass)


@njit
def set_mass_alone(parameters: Any, mass: Any) -> None:
    """Set a dynamic body's mass, kg, and keep its inertia."""
    parameters.mass = mass
    update_inverses(parameters)


@njit
def set_extent(parameters: Any, shape: Any, extent: Any, reach: Any) -> None:
    """Set the extents of a body of one shape, m: half-width, and distance of the farthest point from its centre."""
    square = 0.0
    for d in range(len(parameters.center)):
        offset = shape.local_position[d] - parameters.center[d]
        square += offset * offset
    shape.extent = extent
    parameters.extent = extent
    parameters.radius = reach + math.sqrt(square)


@njit
def set_box(parameters: Any, shape: Any, half_extents: Any, mass: Any) -> None:
    """Set size, m, and mass, kg, of a dynamic body of one solid box, with density, inertia and extents.

    Args:
        parameters, shape: records of the parameters of the body and of its box.
        half_extents: (x, y) or (x, y, z) m.
    """
    volume = 1.0
    smallest = math.inf
    square = 0.0
    for d in range(len(half_extents)):
        half = half_extents[d]
        shape.size[d] = half
        volume *= 2.0 * half
        smallest = min(smallest, half)
        square += half * half
    shape.density = mass / volume
    set_extent(parameters, shape, smallest, math.sqrt(square))
    parameters.mass = mass
    write_box_inertia(parameters, half_extents, mass)
    update_inverses(parameters)


@njit
def fit_solid(parameters: Any, shape: Any, solid: Any, keep_mass: Any, keep_inertia: Any) -> None:
    """Update extents, mass and inertia of a body of one shape after a change of its size or density.

    Args:
        solid: a record of `solid_dtype`: the shape's extents, and its mass and inertia by its density.
        keep_mass: whether the mass was given and is kept; the inertia then scales with it.
        keep_inertia: whether the inertia was given and is kept.
    """
    if solid.extent >= 0.0:
        set_extent(parameters, shape, solid.extent, solid.reach)
    if parameters.mass == 0.0:  # only dynamic bodies have a mass
        return
    if not keep_mass:
        parameters.mass = solid.mass
    if not keep_inertia:
        write_inertia(parameters, solid.inertia, parameters.mass / solid.mass)
    update_inverses(parameters)


# ---------------------------------------------------------------- enabled


@njit
def enable_body(parameters: Any) -> None:
    """Enable a body: it collides and moves again, with the velocity that it had when it was disabled.

    The caller sets its pose and avoids overlaps: `place_body` sets a pose and wakes the body.
    """
    parameters.enabled = 1
    update_inverses(parameters)


@njit
def disable_body(b: Any, bodies: Any, parameters: Any, contacts: Any) -> None:
    """Disable body b: it has no contacts and does not move; bodies that touched it wake.

    Args:
        bodies, parameters: (body,) records of the world's state and parameters.
        contacts: (contact,) records of the last step, ``contacts[:contact_count]``.
    """
    release_contacts(b, bodies, contacts)
    parameters[b].enabled = 0
    update_inverses(parameters[b])


@njit
def enable_joint(joint: Any, body_a: Any, body_b: Any) -> None:
    """Enable a joint, given by its parameters, and wake its two bodies, given by their states."""
    joint.enabled = 1
    wake_body(body_a)
    wake_body(body_b)


@njit
def disable_joint(joint: Any, body_a: Any, body_b: Any) -> None:
    """Disable a joint, given by its parameters, and wake its two bodies, given by their states."""
    joint.enabled = 0
    wake_body(body_a)
    wake_body(body_b)


# ---------------------------------------------------------------- sleep and contacts


@njit
def wake_body(body: Any) -> None:
    """Wake a body, and with it in the next step all bodies of its island."""
    body.asleep = 0
    body.sleep_time = 0.0


@njit
def sleep_body(body: Any) -> None:
    """Put a body to sleep until an awake body touches it or is connected to it by a joint."""
    body.asleep = 1
    for d in range(len(body.velocity)):
        body.velocity[d] = 0.0


@njit
def release_contacts(b: Any, bodies: Any, contacts: Any) -> None:
    """Set the impulses of body b's contacts to 0, so that they start no solve, and wake the bodies that it touched."""
    for i in range(len(contacts)):
        contact = contacts[i]
        if contact.body_a != b and contact.body_b != b:
            continue
        for d in range(len(contact.impulse)):
            contact.impulse[d] = 0.0
        wake_body(bodies[contact.body_a])
        wake_body(bodies[contact.body_b])


# ---------------------------------------------------------------- poses


@njit
def place_body(b: Any, bodies: Any, parameters: Any, contacts: Any, position: Any, turn: Any, velocity: Any) -> None:
    """Set the pose of body b, wake it, clear the impulses of its contacts, and wake the bodies that it touched.

    Sleeping bodies at the new pose of a static body stay asleep; call `wake_body` for them.

    Args:
        bodies, parameters: (body,) records of the world's state and parameters.
        contacts: (contact,) records of the last step, ``contacts[:contact_count]``.
        position: (x, y) or (x, y, z) m, of the body's own frame.
        turn: (cos, sin, angle rad), the angle may be unwrapped; in 3D a unit quaternion (w, x, y, z).
        velocity: (vx, vy, w) or (vx, vy, vz, wx, wy, wz) m/s and rad/s, of the centre of mass.
    """
    release_contacts(b, bodies, contacts)
    body = bodies[b]
    write_pose(body, parameters[b].center, position, turn)
    for d in range(len(body.velocity)):
        body.velocity[d] = velocity[d]
    wake_body(body)


# ---------------------------------------------------------------- many worlds, for Parameters.set


@njit
def set_masses(worlds: Any, bodies: Any, b: Any, masses: Any, keep_inertia: Any) -> None:
    """Set the masses of body b in chosen worlds; bodies: (world, body) parameters, masses: (chosen,) kg."""
    for k in range(len(worlds)):
        if keep_inertia:
            set_mass_alone(bodies[worlds[k], b], masses[k])
        else:
            set_mass(bodies[worlds[k], b], masses[k])


@njit
def set_inertias(worlds: Any, bodies: Any, b: Any, inertias: Any) -> None:
    """Set the inertias of body b in chosen worlds: (chosen,) or, in 3D, (chosen, 3) kg m^2."""
    for k in range(len(worlds)):
        set_inertia(bodies[worlds[k], b], inertias[k])


@njit
def set_enabled(worlds: Any, bodies: Any, b: Any, enabled: Any) -> None:
    """Set the enabled flags (chosen,) of body b in chosen worlds."""
    for k in range(len(worlds)):
        parameters = bodies[worlds[k], b]
        parameters.enabled = enabled[k]
        update_inverses(parameters)


@njit
def fit_solids(
    worlds: Any, bodies: Any, shapes: Any, b: Any, s: Any, solids: Any, keep_mass: Any, keep_inertia: Any
) -> None:
    """Call `fit_solid` for body b with its only shape s in chosen worlds; solids: (chosen,) of `solid_dtype`."""
    for k in range(len(worlds)):
        fit_solid(bodies[worlds[k], b], shapes[worlds[k], s], solids[k], keep_mass, keep_inertia)
