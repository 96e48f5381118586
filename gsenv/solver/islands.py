"""Islands: groups of bodies that rows connect. Each is solved, stopped and put to sleep alone.

Static and kinematic bodies connect nothing.  Islands are numbered by their lowest body, and keep
bodies, contacts and joints in the order of the world, so the numbering depends on the state alone.
"""

from __future__ import annotations

from typing import Any

from .jit import njit

AWAKE = 1
DRIVEN = 2  # by a target: awake, and may not fall asleep
PRESSED = 3  # by a moving kinematic body, whose rows may contradict others


@njit
def _root(motions: Any, body: Any) -> Any:
    """Root of a body's set, halving the path on the way."""
    while motions[body].parent != body:
        motions[body].parent = motions[motions[body].parent].parent
        body = motions[body].parent
    return body


@njit
def _unite(motions: Any, a: Any, b: Any) -> None:
    """Merge two sets under the lower body."""
    a = _root(motions, a)
    b = _root(motions, b)
    if a < b:
        motions[b].parent = a
    elif b < a:
        motions[a].parent = b


@njit
def _movable(body_parameters: Any, body: Any) -> Any:
    return body_parameters[body].inv_mass > 0.0


@njit
def _moving_kinematic(body_models: Any, body_parameters: Any, bodies: Any, body: Any) -> Any:
    if body_models[body].kind != 1 or body_parameters[body].enabled == 0:
        return False
    velocity = bodies[body].velocity
    for i in range(len(velocity)):
        if velocity[i] != 0.0:
            return True
    return False


@njit
def _number_islands(body_parameters: Any, motions: Any, islands: Any) -> Any:
    count = 0
    for b in range(len(motions)):
        motions[b].island = -1
        if _movable(body_parameters, b):
            root = _root(motions, b)
            if root == b:
                island = islands[count]
                island.body_count = 0
                island.contact_count = 0
                island.joint_count = 0
                island.awake = 0
                motions[b].island = count
                count += 1
            else:
                motions[b].island = motions[root].island
            islands[motions[b].island].body_count += 1
    return count


@njit
def _island_of(motions: Any, body_a: Any, body_b: Any) -> Any:
    a = motions[body_a].island
    return a if a >= 0 else motions[body_b].island


@njit
def _set_firsts(islands: Any, count: Any) -> None:
    """Counts become ranges; the counts are counted up again as the lists are filled."""
    body = 0
    contact = 0
    joint = 0
    for k in range(count):
        island = islands[k]
        island.body_first = body
        island.contact_first = contact
        island.joint_first = joint
        body += island.body_count
        contact += island.contact_count
        joint += island.joint_count
        island.body_count = 0
        island.contact_count = 0
        island.joint_count = 0


@njit
def _join_through_contacts(contacts: Any, contact_count: Any, body_parameters: Any, motions: Any) -> None:
    for k in range(contact_count):
        a = contacts[k].body_a
        b = contacts[k].body_b
        if contacts[k].sensor == 0 and _movable(body_parameters, a) and _movable(body_parameters, b):
            _unite(motions, a, b)


@njit
def _join_through_joints(joint_models: Any, joint_parameters: Any, body_parameters: Any, motions: Any) -> None:
    for j in range(len(joint_models)):
        a = joint_models[j].body_a
        b = joint_models[j].body_b
        if joint_parameters[j].enabled and _movable(body_parameters, a) and _movable(body_parameters, b):
            _unite(motions, a, b)


@njit
def _fill_bodies(bodies: Any, body_parameters: Any, motions: Any, islands: Any, island_bodies: Any) -> None:
    for b in range(len(motions)):
        k = motions[b].island
        if k >= 0:
            island = islands[k]
            island_bodies[island.body_first + island.body_count] = b
            island.body_count += 1
            if bodies[b].asleep == 0:
                island.awake = AWAKE


@njit
def build_islands(
    bodies: Any,
    body_models: Any,
    body_parameters: Any,
    contacts: Any,
    contact_count: Any,
    joint_models: Any,
    joint_parameters: Any,
    motions: Any,
    islands: Any,
    island_bodies: Any,
    island_contacts: Any,
    island_joints: Any,
) -> Any:
    """Fill ``islands[:count]`` and their lists of bodies, contacts and joints; return count.

    An island with one awake body, or touched by a moving kinematic one, is awake as a whole.
    """
    for b in range(len(motions)):
        motions[b].parent = b
    _join_through_contacts(contacts, contact_count, body_parameters, motions)
    if joint_models is not None:
        _join_through_joints(joint_models, joint_parameters, body_parameters, motions)
    count = _number_islands(body_parameters, motions, islands)

    for k in range(contact_count):
        if contacts[k].sensor == 0:
            i = _island_of(motions, contacts[k].body_a, contacts[k].body_b)
            if i >= 0:
                islands[i].contact_count += 1
    if joint_models is not None:
        for j in range(len(joint_models)):
            i = _island_of(motions, joint_models[j].body_a, joint_models[j].body_b)
            if joint_parameters[j].enabled and i >= 0:
                islands[i].joint_count += 1
    _set_firsts(islands, count)

    _fill_bodies(bodies, body_parameters, motions, islands, island_bodies)
    for k in range(contact_count):
        contact = contacts[k]
        if contact.sensor == 0:
            i = _island_of(motions, contact.body_a, contact.body_b)
            if i >= 0:
                island = islands[i]
                island_contacts[island.contact_first + island.contact_count] = k
                island.contact_count += 1
                if island.awake != PRESSED and (
                    _moving_kinematic(body_models, body_parameters, bodies, contact.body_a)
                    or _moving_kinematic(body_models, body_parameters, bodies, contact.body_b)
                ):
                    island.awake = PRESSED
    if joint_models is not None:
        for j in range(len(joint_models)):
            i = _island_of(motions, joint_models[j].body_a, joint_models[j].body_b)
            if joint_parameters[j].enabled and i >= 0:
                island = islands[i]
                island_joints[island.joint_first + island.joint_count] = j
                island.joint_count += 1
                if joint_models[j].wakes and island.awake != PRESSED:
                    island.awake = DRIVEN
                if _moving_kinematic(body_models, body_parameters, bodies, joint_models[j].body_a) or _moving_kinematic(
                    body_models, body_parameters, bodies, joint_models[j].body_b
                ):
                    island.awake = PRESSED
    return count
