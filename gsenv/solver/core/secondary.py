"""Secondary impacts: a body that is hit within the step changes its path, and may hit others on the new one.

Contacts are found at the start of a step.  Those on the present paths are found by prediction; paths after an
impact are known only after the solve.  So pairs that miss each other are candidates, and are kept if
velocities that impacts may give to the two bodies close the gap.  Without impacts, at rest, rolling or in
free flight, none is kept.

An impact of bodies with velocities u and v, in any direction, leaves v in the ball whose diameter is its
change in a central impact (Thales): (1 + e) m_u / (m_u + m_v) (u - v).  So each body has a box of velocities
that grows by those of bodies that it may hit, and its possible velocities are in the ball around the box.
The masses reduce the velocities that pass on in a heap, except from fixed bodies and from what rests on them, and
except in fast impacts between bodies that no fixed one blocks: there all that stick together behind a body may push
it, and it may take over their velocity.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..jit import njit
from .dispatch import by_dimension
from .geometry import BASE_MARGIN, angular_norm, swing_of

Array = NDArray[Any]

approach_speed = by_dimension("narrowphase.motion", "approach_speed")

IMPACT = 1e-3  # of the extent: smallest depth that an approach within the step must reach to count as an impact
FALL = 0.1  # of the extent: the same for the fall of a small body at rest within the step
TOUCHING = 1e-3  # of the extent: gap of bodies that rest on each other, and may block each other
DEEP = 0.05  # of the extent: smallest depth of an approach within the step at which it counts who pushes from behind
FAR = 0.1  # of the extent: smallest relative motion after which the poses are checked
MAX_ROUNDS = 8  # largest number of passes over all contacts
MAX_LOOKS = 8  # largest number of searches for contacts in a step


@njit
def keep_secondary(world: Any, count: int) -> tuple[int, bool, bool]:
    """Remove candidates that no impact can close; returns (number of contacts left, any impact, any_far_moving).

    `world.scratch.found[:count]` are those of collide_pairs; their order is kept. If there is an impact, the
    substep bodies get the velocities that each body may have: a ball of radius `velocity_radius` around
    `velocity_center`.
    """
    contacts = world.scratch.found
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    timestep = world.options.timestep
    if all_slow(world):
        return drop_candidates(contacts, count), False, False
    falls = any_fall(contacts, count, body_parameters, world.parameters.world.gravity, timestep)
    if not falls and not any_impact(contacts, count, bodies, timestep):
        return drop_candidates(contacts, count), False, any_far_moving(world, count)
    far_moving = any_far_moving(world, count)
    for b in range(len(bodies)):
        substep_body = substep_bodies[b]
        substep_body.blocked = 0
        substep_body.widened_in = -1
        for d in range(len(bodies[b].position)):
            v = bodies[b].velocity[d]
            fall = 0.0
            if falls and body_parameters[b].inv_mass > 0.0:
                fall = timestep * body_parameters[b].gravity_scale * world.parameters.world.gravity[d]
            substep_body.velocity_lower[d] = v + min(fall, 0.0)
            substep_body.velocity_upper[d] = v + max(fall, 0.0)
        set_velocity_ball(substep_body)
    for k in range(MAX_ROUNDS):
        if not exchange_velocities(contacts, count, bodies, body_parameters, substep_bodies, timestep, k):
            break
    return drop_candidates(contacts, count), True, far_moving


@njit
def all_slow(world: Any) -> bool:
    """Whether no two bodies can have an impact or a fall in the step, by their sizes and speeds alone.

    It reads each body and shape once, but no contact: a resting pile has four times as many of these.
    """
    geometry = world.scratch.geometry
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    gravity = world.parameters.world.gravity
    timestep = world.options.timestep
    least = np.inf
    for k in range(len(geometry)):
        least = min(least, geometry[k].extent)
    fastest = 0.0
    lowest = 0.0
    highest = 0.0
    for b in range(len(bodies)):
        v = bodies[b].velocity
        linear = 0.0
        angular = 0.0
        for d in range(len(v)):
            if d < len(gravity):
                linear += v[d] * v[d]
            else:
                angular += v[d] * v[d]
        arm = 2.0 * body_parameters[b].radius if angular > 0.0 else 0.0  # contacts are at the surface or near it
        fastest = max(fastest, linear + arm * arm * angular)
        lowest = min(lowest, body_parameters[b].gravity_scale)
        highest = max(highest, body_parameters[b].gravity_scale)
    speed = 2.0 * (2.0 * fastest) ** 0.5  # of approach, of two bodies that move and rotate
    fall = 0.0
    for d in range(len(gravity)):
        fall += abs(gravity[d])
    depth = timestep * timestep * (highest - lowest) * fall
    return timestep * speed <= IMPACT * least and depth <= FALL * least


@njit
def any_impact(contacts: Array, count: int, bodies: Array, timestep: float) -> bool:
    """Whether two bodies approach each other so fast that they would penetrate each other within the step."""
    for k in range(count):
        contact = contacts[k]
        if contact.miss_distance > 0.0 or contact.sensor != 0:
            continue
        speed = approach_speed(contact, bodies[contact.body_a], bodies[contact.body_b])
        depth = timestep * speed - max(contact.separation, 0.0)
        if depth > IMPACT * contact.extent:
            return True
    return False


@njit
def any_far_moving(world: Any, count: int) -> bool:
    """Whether two bodies that may meet move so far that their overlap must be measured after the step.

    Rows are linear in the motion: they follow a translation along a fixed surface, but not a rotation.
    """
    contacts = world.scratch.found
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    timestep = world.options.timestep
    for k in range(count):
        contact = contacts[k]
        if contact.sensor != 0:
            continue
        a = bodies[contact.body_a]
        b = bodies[contact.body_b]
        one = body_parameters[contact.body_a]
        other = body_parameters[contact.body_b]
        dim = len(a.position)
        if one.inv_mass > 0.0 and other.inv_mass > 0.0:
            square = 0.0
            for d in range(dim):
                square += (b.velocity[d] - a.velocity[d]) ** 2
            speed = np.sqrt(square)
        else:
            speed = max(approach_speed(contact, a, b), 0.0)
        spin_a = angular_norm(a.velocity, dim)
        spin_b = angular_norm(b.velocity, dim)
        speed += spin_a * swing_of(one) if spin_a > 0.0 else 0.0
        speed += spin_b * swing_of(other) if spin_b > 0.0 else 0.0
        if timestep * speed - max(contact.separation, 0.0) > FAR * contact.extent:
            return True
    return False


@njit
def any_fall(contacts: Array, count: int, body_parameters: Array, gravity: Any, timestep: float) -> bool:
    """Whether a body is so small that without its contact it would fall deep into another within the step."""
    for k in range(count):
        contact = contacts[k]
        if contact.miss_distance > 0.0 or contact.sensor != 0:
            continue
        a = body_parameters[contact.body_a]
        b = body_parameters[contact.body_b]
        scale = (a.gravity_scale if a.inv_mass > 0.0 else 0.0) - (b.gravity_scale if b.inv_mass > 0.0 else 0.0)
        fall = 0.0
        for d in range(len(gravity)):
            fall += contact.normal[d] * gravity[d]
        depth = timestep * timestep * scale * fall - max(contact.separation, 0.0)
        if depth > FALL * contact.extent:
            return True
    return False


@njit
def set_velocity_ball(motion: Any) -> None:
    """Set the ball around the box of velocities."""
    square = 0.0
    for d in range(len(motion.velocity_center)):
        low = motion.velocity_lower[d]
        high = motion.velocity_upper[d]
        square += (high - low) * (high - low)
        motion.velocity_center[d] = 0.5 * (low + high)
    motion.velocity_radius = 0.5 * square**0.5


@njit
def exchange_velocities(
    contacts: Array,
    count: int,
    bodies: Array,
    body_parameters: Array,
    substep_bodies: Array,
    timestep: float,
    number: int,
) -> bool:
    """Exchange the possible velocities of bodies that may touch; returns whether any range has grown.

    Passes in both directions carry them along a row of bodies, whatever its order.  Candidates that may touch
    become contacts: their `miss_distance` is set to 0.  `number`: of the pass, from 0.
    """
    changed = False
    for place in range(count):
        contact = contacts[count - 1 - place if number % 2 == 1 else place]
        a = contact.body_a
        b = contact.body_b
        if contact.sensor != 0 or max(substep_bodies[a].widened_in, substep_bodies[b].widened_in) < number - 1:
            continue
        speed = substep_bodies[a].velocity_radius + substep_bodies[b].velocity_radius
        if contact.miss_distance > 0.0 and speed == 0.0:
            continue
        n = contact.normal
        for d in range(len(n)):
            speed += n[d] * (substep_bodies[a].velocity_center[d] - substep_bodies[b].velocity_center[d])
        if not timestep * speed > contact.separation - TOUCHING * contact.extent:
            continue
        contact.miss_distance = 0.0
        least = BASE_MARGIN * contact.extent / timestep
        inverse_a = body_parameters[a].inv_mass
        inverse_b = body_parameters[b].inv_mass
        bounce = 1.0 + contact.restitution
        free = substep_bodies[a].blocked + substep_bodies[b].blocked == 0
        pushed = 1.0 if free and timestep * speed > DEEP * contact.extent else 0.0
        if inverse_a > 0.0:
            share = max(bounce * inverse_a / (inverse_a + inverse_b), pushed)
            fixed = inverse_b == 0.0
            changed |= widen_velocities(bodies[a], substep_bodies[a], substep_bodies[b], share, fixed, least, number)
        if inverse_b > 0.0:
            share = max(bounce * inverse_b / (inverse_a + inverse_b), pushed)
            fixed = inverse_a == 0.0
            changed |= widen_velocities(bodies[b], substep_bodies[b], substep_bodies[a], share, fixed, least, number)
    return changed


@njit
def widen_velocities(
    body: Any, motion: Any, other: Any, share: float, immovable: bool, least: float, number: int
) -> bool:
    """Widen a body's velocities by impacts with another body; returns whether by more than `least` m/s."""
    changed = False
    wider = False
    blocked = immovable or other.blocked != 0
    if blocked and motion.blocked == 0:
        motion.blocked = 1
        motion.widened_in = number
        changed = True
    for d in range(len(motion.velocity_center)):
        v = body.velocity[d]
        low = v + share * (other.velocity_lower[d] - v)
        high = v + share * (other.velocity_upper[d] - v)
        if blocked:
            low = min(low, 0.0)
            high = max(high, 0.0)
        if low < motion.velocity_lower[d]:
            changed |= low < motion.velocity_lower[d] - least
            wider = True
            motion.velocity_lower[d] = low
        if high > motion.velocity_upper[d]:
            changed |= high > motion.velocity_upper[d] + least
            wider = True
            motion.velocity_upper[d] = high
    if wider:
        motion.widened_in = number
        set_velocity_ball(motion)
    return changed


@njit
def drop_candidates(contacts: Array, count: int) -> int:
    kept = count - count  # a zero of its type
    for k in range(count):
        if contacts[k].miss_distance > 0.0:
            continue
        if kept != k:
            contacts[kept] = contacts[k]
        kept += 1
    return kept


@njit
def clear_widening(substep_bodies: Array) -> None:
    """Start the search for contacts of a step, in which no box has been widened."""
    for b in range(len(substep_bodies)):
        substep_bodies[b].widened_radius = 0.0


@njit
def any_wider(
    shape_models: Array, body_parameters: Array, substep_bodies: Array, timestep: float, geometry: Array
) -> bool:
    """Whether a body may get further beyond its box than the boxes of the last search allowed."""
    for k in range(len(shape_models)):
        b = shape_models[k].body
        if geometry[k].dynamic != 0:
            grown = timestep * (substep_bodies[b].velocity_radius - substep_bodies[b].widened_radius)
            if grown > BASE_MARGIN * body_parameters[b].extent:
                return True
    return False


@njit
def widen_boxes(
    shape_models: Array, bodies: Array, body_parameters: Array, substep_bodies: Array, timestep: float, geometry: Array
) -> None:
    """Widen boxes and margins, which are those of the present paths, by the velocities after secondary impacts.

    Contacts of sleeping bodies with each other are searched where these may be hit.
    """
    for k in range(len(shape_models)):
        b = shape_models[k].body
        entry = geometry[k]
        if entry.dynamic == 0:
            continue
        extent = body_parameters[b].extent
        radius = substep_bodies[b].velocity_radius
        middle = substep_bodies[b].velocity_center
        substep_bodies[b].widened_radius = radius
        if not timestep * radius > BASE_MARGIN * extent:
            continue
        entry.awake = 1  # it may be woken, and then meet others that sleep,
        entry.calm = 0  # where its contacts of the last step do not reach
        entry.reach += min(timestep * radius, extent)
        for d in range(len(entry.lower)):
            v = timestep * bodies[b].velocity[d]
            low = timestep * (middle[d] - radius) - min(v, 0.0)
            high = timestep * (middle[d] + radius) - max(v, 0.0)
            entry.lower[d] += max(min(low, 0.0), -extent)
            entry.upper[d] += min(max(high, 0.0), extent)
