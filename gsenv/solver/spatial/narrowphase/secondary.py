"""Secondary impacts: a body that is hit within the step changes its path, and may hit others on the new one.

Contacts are found once per step.  Those on the present paths are found by prediction; paths after an
impact are known only after the solve.  So pairs that miss each other are candidates, and are kept if
velocities that impacts may give to the two bodies close the gap.  Without impacts, at rest, rolling or in
free flight, none is kept.

An impact of bodies with velocities u and v, in any direction, leaves v in the ball whose diameter is its
change in a central impact (Thales): (1 + e) m_u / (m_u + m_v) (u - v).  So each body has a box of velocities
that grows by those of bodies that it may hit, and its possible velocities are in the ball around the box.
The masses reduce the velocities that pass on in a heap, except from fixed bodies and from what rests on them.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from ...core.geometry import BASE_MARGIN
from ...jit import njit
from ..math import Vec, add, cross, dot, norm, sub, vec

Array = NDArray[Any]

MAX_ROUNDS = 8  # largest number of passes over all contacts


@njit
def look_again(world: Any, count: int, last: bool) -> tuple[int, bool]:
    """Remove candidates that no impact can close; returns (contacts left, whether to search again in wider boxes).

    After the `last` search the boxes stay as they are.
    """
    scratch = world.scratch
    bodies = world.state.bodies
    parameters = world.parameters.bodies
    substep_bodies = scratch.substep_bodies
    timestep = world.options.timestep
    count, hit = keep_secondary(scratch.found, count, bodies, parameters, substep_bodies, timestep)
    if last or not hit:
        return count, False
    return count, widen_boxes(world.shapes.models, bodies, parameters, substep_bodies, timestep, scratch.geometry)


@njit
def keep_secondary(
    contacts: Array, count: int, bodies: Array, body_parameters: Array, substep_bodies: Array, timestep: float
) -> tuple[int, bool]:
    """Remove candidates that no impact can close; returns (number of contacts left, whether there is any impact).

    `contacts[:count]` are those of find_contacts; their order is kept. If there is an impact, `substep_bodies`
    (body,) get the velocities that each body may have, a ball of radius `velocity_radius` around `velocity_center`.
    """
    if not any_impact(contacts, count, bodies, timestep):
        return drop_candidates(contacts, count), False
    for b in range(len(bodies)):
        substep_bodies[b].blocked = 0
        substep_bodies[b].velocity_radius = 0.0
        for d in range(3):
            substep_bodies[b].velocity_lower[d] = bodies[b].velocity[d]
            substep_bodies[b].velocity_upper[d] = bodies[b].velocity[d]
            substep_bodies[b].velocity_center[d] = bodies[b].velocity[d]
    for _ in range(MAX_ROUNDS):
        if not exchange_velocities(contacts, count, bodies, body_parameters, substep_bodies, timestep):
            break
    return drop_candidates(contacts, count), True


@njit
def velocity_at(body: Any, point: Vec) -> Vec:
    v = body.velocity
    return add((v[0], v[1], v[2]), cross((v[3], v[4], v[5]), sub(point, vec(body.position))))


@njit
def any_impact(contacts: Array, count: int, bodies: Array, timestep: float) -> bool:
    """Whether two bodies would penetrate each other by more than the error of a contact at rest."""
    for k in range(count):
        contact = contacts[k]
        if contact.miss_distance > 0.0 or contact.sensor != 0:
            continue
        point = vec(contact.point)
        u = velocity_at(bodies[contact.body_a], point)
        v = velocity_at(bodies[contact.body_b], point)
        depth = timestep * dot(vec(contact.normal), sub(u, v)) - max(contact.separation, 0.0)
        if depth > BASE_MARGIN * contact.extent:
            return True
    return False


@njit
def set_velocity_ball(motion: Any) -> None:
    """Set the ball around the box of velocities."""
    low = vec(motion.velocity_lower)
    high = vec(motion.velocity_upper)
    motion.velocity_radius = 0.5 * norm(sub(high, low))
    for d in range(3):
        motion.velocity_center[d] = 0.5 * (low[d] + high[d])


@njit
def exchange_velocities(
    contacts: Array, count: int, bodies: Array, body_parameters: Array, substep_bodies: Array, timestep: float
) -> bool:
    """Exchange the possible velocities of bodies that may touch; returns whether any range has grown.

    Candidates that may touch become contacts: their `miss_distance` is set to 0.
    """
    changed = False
    for k in range(count):
        contact = contacts[k]
        if contact.sensor != 0:
            continue
        a = contact.body_a
        b = contact.body_b
        speed = substep_bodies[a].velocity_radius + substep_bodies[b].velocity_radius
        if contact.miss_distance > 0.0 and speed == 0.0:
            continue
        n = contact.normal
        for d in range(3):
            speed += n[d] * (substep_bodies[a].velocity_center[d] - substep_bodies[b].velocity_center[d])
        if not timestep * speed > contact.separation:
            continue
        contact.miss_distance = 0.0
        least = BASE_MARGIN * contact.extent / timestep
        inverse_a = body_parameters[a].inv_mass
        inverse_b = body_parameters[b].inv_mass
        bounce = 1.0 + contact.restitution
        if inverse_a > 0.0:
            share = bounce * inverse_a / (inverse_a + inverse_b)
            changed |= widen_velocities(bodies[a], substep_bodies[a], substep_bodies[b], share, inverse_b == 0.0, least)
        if inverse_b > 0.0:
            share = bounce * inverse_b / (inverse_a + inverse_b)
            changed |= widen_velocities(bodies[b], substep_bodies[b], substep_bodies[a], share, inverse_a == 0.0, least)
    return changed


@njit
def widen_velocities(body: Any, motion: Any, other: Any, share: float, immovable: bool, least: float) -> bool:
    """Widen a body's velocities by impacts with another body; returns whether by more than `least` m/s."""
    changed = False
    wider = False
    blocked = immovable or other.blocked != 0
    if blocked and motion.blocked == 0:
        motion.blocked = 1
        changed = True
    for d in range(3):
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
def widen_boxes(
    shape_models: Array, bodies: Array, body_parameters: Array, substep_bodies: Array, timestep: float, geometry: Array
) -> bool:
    """Widen boxes and margins by the possible velocities after secondary impacts; returns whether any grew."""
    grown = False
    for k in range(len(shape_models)):
        b = shape_models[k].body
        entry = geometry[k]
        if entry.dynamic == 0:
            continue
        extent = body_parameters[b].extent
        radius = substep_bodies[b].velocity_radius
        middle = substep_bodies[b].velocity_center
        if not timestep * radius > BASE_MARGIN * extent:
            continue
        grown = True
        entry.reach += min(timestep * radius, extent)
        for d in range(3):
            v = timestep * bodies[b].velocity[d]
            low = timestep * (middle[d] - radius) - min(v, 0.0)
            high = timestep * (middle[d] + radius) - max(v, 0.0)
            entry.lower[d] += max(min(low, 0.0), -extent)
            entry.upper[d] += min(max(high, 0.0), extent)
    return grown
