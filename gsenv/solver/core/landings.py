"""Landings: a substep is divided at the time at which a body without restitution lands on another.

In the solve such an impact has no time of its own: a contact that closes within the substep slows the bodies for
all of it, and the contacts that carried them until then are unloaded too early. The velocities are then wrong by
about g h: a block that rocks on its corners would lose up to twice the energy that it should in an impact.
So the substep is taken in parts, up to the landing without the contacts that land, and the rest with them. In the
rest the solve is the inelastic impact of all contacts that are closed then.

The time of a landing is the root of  gap + u t + a t^2/2 = 0,  where a is the acceleration with the impulses of the
last substep. Left to the contact solve are approach speeds below g h; landings of bodies that nothing else carries,
whose velocities it finds exactly; islands with many contacts; and many landings at once, as in a falling heap.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from .impacts import ORDERED_LIMIT, meeting_time
from .joint_closing import any_distance
from .joints import add_joint_rows
from .rows import CLOSED, GROUNDED, OPEN, add_response, relative_velocity, row_product
from .slices import part

LEAST_SPEED = 1.0  # of g h: slower landings are left to the contact solve
LEAST_CHANGE = 0.01  # of the approach speed, by the acceleration within the substep: less changes little
MOST_CONTACTS = 8  # largest number of contacts of an island that land in one substep
MAX_PARTS = 3  # largest number of parts of a substep
NOW = 4e-3  # of the substep: times of landings closer than this to each other, or to its ends, count as equal
NONE = -1.0  # no landing


@njit
def next_landing(world: Any, island: Any, joints: Any, linked: Any) -> Any:
    """Return the time in s from now at which the next contact of the island lands, or NONE.

    The contacts that land then are marked in their rows, whose errors are up to date: they do not act in a part
    that ends with the landing, and they are closed in one that starts with it, where the time is 0.
    """
    rows = world.scratch.rows
    bodies = world.state.bodies
    contacts = world.state.contacts
    least = LEAST_SPEED * island.gravity_norm * island.whole
    h = island.h
    count = 0
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        r += int(row.span)
        if contacts[row.source].restitution > 0.0:
            continue
        speed = -relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
        if speed > 0.5 * least and row.error < h * (speed + island.gravity_norm * h):
            count += 1
    if count == 0 or count > MOST_CONTACTS:
        return NONE
    _set_accelerations(world, island, joints, linked)
    return _mark_first(world, island, least)


@njit
def may_land(world: Any, island: Any, joint_factor: Any) -> Any:
    """Whether an island has few contacts, and bodies that are fast enough for a landing in this step.

    Islands with rods or ropes are excluded: these are closed by displacements, which short parts would make fast.
    """
    count = island.rows - island.joint_rows
    if count == 0 or count > len(world.scratch.substep_bodies[0].start_position) * ORDERED_LIMIT:
        return False
    if joint_factor is not None:
        island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
        if any_distance(island_joints, world.model.joints):
            return False
    if island.kinematic:
        return True
    least = 0.5 * LEAST_SPEED * island.gravity_norm * island.h
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        v = bodies[island_bodies[k]].velocity
        linear = 0.0
        angular = 0.0
        for d in range(len(v)):
            if d < (len(v) + 1) // 2:
                linear += v[d] * v[d]
            else:
                angular += v[d] * v[d]
        radius = body_parameters[island_bodies[k]].radius
        if 2.0 * (linear + angular * radius * radius) > 0.25 * least * least:
            return True
    return False


@njit
def _set_accelerations(world: Any, island: Any, joints: Any, linked: Any) -> None:
    """Set ``correction`` of the bodies to their accelerations with the present impulses, which act for h.

    ``event_time`` of a body is set to 0 unless a contact carries it.
    """
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    add_joint_rows(world, island, joints, linked, island.warm_start * island.h / island.whole)
    for r in range(island.rows):
        for side in range(2):
            body = substep_bodies[rows[r].body_a if side == 0 else rows[r].body_b]
            body.event_time = 0.0
            for d in range(len(body.correction)):
                body.correction[d] = 0.0
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        body = substep_bodies[island_bodies[k]]
        for d in range(len(body.correction)):
            body.correction[d] = body.acceleration[d]
    for r in range(island.rows):
        row = rows[r]
        if row.impulse == 0.0:
            continue
        a = substep_bodies[row.body_a]
        b = substep_bodies[row.body_b]
        force = row.impulse / island.h
        add_response(row, force, a.correction, a.inverse, b.correction, b.inverse)
        if r >= island.joint_rows:
            a.event_time = a.inverse[0]
            b.event_time = b.inverse[0]


@njit
def _landing_time(row: Any, world: Any, h: Any, least: Any) -> Any:
    """Return the time at which a contact of a carried body lands at a speed of at least ``least`` m/s, or NONE."""
    substep_bodies = world.scratch.substep_bodies
    bodies = world.state.bodies
    if world.state.contacts[row.source].restitution > 0.0:
        return NONE
    if substep_bodies[row.body_a].event_time + substep_bodies[row.body_b].event_time == 0.0:
        return NONE
    u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
    if u >= -0.5 * least:
        return NONE
    a = row_product(row, substep_bodies[row.body_a].correction, substep_bodies[row.body_b].correction)
    time = meeting_time(max(row.error, 0.0), u, a, 0.0)
    speed = -(u + a * time)
    if time > h or speed < least or abs(a) * h < LEAST_CHANGE * speed:
        return NONE
    return time


@njit
def _mark_first(world: Any, island: Any, least: Any) -> Any:
    """Return the time of the first landing; mark its contacts as closed if that is now, else as open.

    A landing at the very start of the substep needs no division.
    """
    rows = world.scratch.rows
    first = NONE
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        r += int(row.span)
        time = _landing_time(row, world, island.h, least)
        if time >= 0.0 and (first < 0.0 or time < first):
            first = time
    if first < 0.0 or first > island.h - NOW * island.whole:
        return NONE
    now = NOW * island.whole
    if first <= now and island.h == island.whole:
        return NONE
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        r += int(row.span)
        time = _landing_time(row, world, island.h, least)
        if time >= 0.0 and time <= first + now:
            row.flight = OPEN if first > now else CLOSED
    return first if first > now else 0.0


@njit
def end_landing(world: Any, island: Any) -> None:
    """Unmark the contacts that landed."""
    rows = world.scratch.rows
    r = island.joint_rows
    while r < island.rows:
        if rows[r].flight == CLOSED or rows[r].flight == OPEN:
            rows[r].flight = GROUNDED
        r += int(rows[r].span)
