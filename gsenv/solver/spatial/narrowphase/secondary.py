"""Secondary impacts: a body that is hit within the step leaves its way, and may meet others on the new one.

Contacts are found once per step.  Those that close on the present ways are found by prediction; what
an impact makes of these ways, only the solve knows.  So pairs that pass by are candidates, and stay if
velocities that impacts may give to the two close the gap.  Without impacts, at rest, rolling or in free
flight, none does.

An impact of bodies with velocities u and v, in any direction, leaves v in the ball whose diameter is its
change in a central impact (Thales): (1 + e) m_u / (m_u + m_v) (u - v).  So each body has a box of velocities
that grows by those of what it may meet, and what it may become is in the ball around the box.  Masses
damp what a blow hands on in a heap; the ground's stop goes on undamped, for what stands on it may not yield.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.spatial.geometry import BASE_MARGIN
from gsenv.solver.spatial.math import Vec, add, cross, dot, norm, sub, vec

Array = NDArray[Any]

MAX_ROUNDS = 8  # of handing velocities on, from body to body


@njit
def keep_secondary(
    contacts: Array, count: int, bodies: Array, body_parameters: Array, motions: Array, timestep: float
) -> tuple[int, bool]:
    """Drop the candidates that no impact can close: (how many contacts are left, whether anything is hit).

    `contacts[:count]` as of find_contacts; they stay in order. Leaves in `motions` (body,) the velocities
    that a body may get, a ball of radius `spread` around `likely`, if anything is hit.
    """
    if not any_impact(contacts, count, bodies, timestep):
        return drop_candidates(contacts, count), False
    for b in range(len(bodies)):
        motions[b].backed = 0
        motions[b].spread = 0.0
        for d in range(3):
            motions[b].slowest[d] = bodies[b].velocity[d]
            motions[b].fastest[d] = bodies[b].velocity[d]
            motions[b].likely[d] = bodies[b].velocity[d]
    for _ in range(MAX_ROUNDS):
        if not hand_on(contacts, count, bodies, body_parameters, motions, timestep):
            break
    return drop_candidates(contacts, count), True


@njit
def velocity_at(body: Any, point: Vec) -> Vec:
    v = body.velocity
    return add((v[0], v[1], v[2]), cross((v[3], v[4], v[5]), sub(point, vec(body.position))))


@njit
def any_impact(contacts: Array, count: int, bodies: Array, timestep: float) -> bool:
    """Whether some two would go into each other by more than a contact at rest may be off."""
    for k in range(count):
        contact = contacts[k]
        if contact.miss > 0.0 or contact.sensor != 0:
            continue
        point = vec(contact.point)
        u = velocity_at(bodies[contact.body_a], point)
        v = velocity_at(bodies[contact.body_b], point)
        depth = timestep * dot(vec(contact.normal), sub(u, v)) - max(contact.separation, 0.0)
        if depth > BASE_MARGIN * contact.extent:
            return True
    return False


@njit
def set_ball(motion: Any) -> None:
    """Around the box."""
    low = vec(motion.slowest)
    high = vec(motion.fastest)
    motion.spread = 0.5 * norm(sub(high, low))
    for d in range(3):
        motion.likely[d] = 0.5 * (low[d] + high[d])


@njit
def hand_on(
    contacts: Array, count: int, bodies: Array, body_parameters: Array, motions: Array, timestep: float
) -> bool:
    """Two that may meet hand on their velocities; whether any of this is new.

    Candidates that may meet are contacts from then on: their `miss` is 0.
    """
    changed = False
    for k in range(count):
        contact = contacts[k]
        if contact.sensor != 0:
            continue
        a = contact.body_a
        b = contact.body_b
        speed = motions[a].spread + motions[b].spread
        if contact.miss > 0.0 and speed == 0.0:
            continue
        n = contact.normal
        for d in range(3):
            speed += n[d] * (motions[a].likely[d] - motions[b].likely[d])
        if not timestep * speed > contact.separation:
            continue
        contact.miss = 0.0
        least = BASE_MARGIN * contact.extent / timestep
        inverse_a = body_parameters[a].inv_mass
        inverse_b = body_parameters[b].inv_mass
        bounce = 1.0 + contact.restitution
        if inverse_a > 0.0:
            share = bounce * inverse_a / (inverse_a + inverse_b)
            changed |= take_in(bodies[a], motions[a], motions[b], share, inverse_b == 0.0, least)
        if inverse_b > 0.0:
            share = bounce * inverse_b / (inverse_a + inverse_b)
            changed |= take_in(bodies[b], motions[b], motions[a], share, inverse_a == 0.0, least)
    return changed


@njit
def take_in(body: Any, motion: Any, other: Any, share: float, immovable: bool, least: float) -> bool:
    """Widen a body's velocities by what those of another may make of its own; whether by more than `least` m/s."""
    changed = False
    wider = False
    backed = immovable or other.backed != 0
    if backed and motion.backed == 0:
        motion.backed = 1
        changed = True
    for d in range(3):
        v = body.velocity[d]
        low = v + share * (other.slowest[d] - v)
        high = v + share * (other.fastest[d] - v)
        if backed:
            low = min(low, 0.0)
            high = max(high, 0.0)
        if low < motion.slowest[d]:
            changed |= low < motion.slowest[d] - least
            wider = True
            motion.slowest[d] = low
        if high > motion.fastest[d]:
            changed |= high > motion.fastest[d] + least
            wider = True
            motion.fastest[d] = high
    if wider:
        set_ball(motion)
    return changed


@njit
def drop_candidates(contacts: Array, count: int) -> int:
    kept = count - count  # a zero of its type
    for k in range(count):
        if contacts[k].miss > 0.0:
            continue
        if kept != k:
            contacts[kept] = contacts[k]
        kept += 1
    return kept


@njit
def widen_boxes(
    shape_models: Array, bodies: Array, body_parameters: Array, motions: Array, timestep: float, geometry: Array
) -> bool:
    """Boxes and margins hold what velocities of secondary impacts make of the ways; whether any grew."""
    grown = False
    for k in range(len(shape_models)):
        b = shape_models[k].body
        entry = geometry[k]
        if entry.dynamic == 0:
            continue
        extent = body_parameters[b].extent
        radius = motions[b].spread
        middle = motions[b].likely
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
