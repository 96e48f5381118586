"""Islands: groups of bodies that rows connect. Each is solved, stopped and put to sleep alone.

Static and kinematic bodies connect nothing.  Islands are numbered by their lowest body, and keep
bodies, contacts and joints in the order of the world, so the numbering depends on the state alone.
Sleeping bodies that nothing awake touches can't be woken in the step, and are left out.

The loops read and write the arrays themselves: numba counts references to an array that is handed to
a helper, which costs more than what a helper would do here.
"""

from __future__ import annotations

from typing import Any

from .jit import njit

AWAKE = 1
DRIVEN = 2  # by a target: awake, and may not fall asleep
PRESSED = 3  # by a moving kinematic body, whose rows may contradict others

# labels of bodies outside of all islands, and of all bodies before islands have numbers
FIXED = -1
MOVING = -2  # kinematic
ASLEEP = -3
MEMBER = -4


@njit
def start_counters(state: Any) -> None:
    """Nothing counted yet in this step."""
    state.pair_count = 0
    state.row_count = 0
    state.island_count = 0
    state.awake_count = 0
    state.sweeps = 0
    state.unconverged = 0
    state.impacts = 0
    state.residual = 0.0
    state.natural_residual = 0.0


@njit
def _root(islands: Any, body: Any) -> Any:
    """Root of a body's set, halving the path on the way."""
    while islands[body].parent != body:
        islands[body].parent = islands[islands[body].parent].parent
        body = islands[body].parent
    return body


@njit
def _unite(islands: Any, a: Any, b: Any) -> None:
    """Merge two sets under the lower body."""
    a = _root(islands, a)
    b = _root(islands, b)
    if a < b:
        islands[b].parent = a
    elif b < a:
        islands[a].parent = b


@njit
def _start_sets(bodies: Any, body_models: Any, body_parameters: Any, islands: Any, sleepers: Any) -> None:
    """Each movable body is a set of its own; one asleep only with ``sleepers``."""
    for b in range(len(bodies)):
        entry = islands[b]
        entry.parent = -1
        entry.label = FIXED
        if body_parameters[b].inv_mass > 0.0:
            entry.label = MEMBER
            if bodies[b].asleep != 0 and not sleepers:
                entry.label = ASLEEP
            else:
                entry.parent = b
        elif body_models[b].kind == 1 and body_parameters[b].enabled != 0:
            velocity = bodies[b].velocity
            for i in range(len(velocity)):
                if velocity[i] != 0.0:
                    entry.label = MOVING


@njit
def _stirs(one: Any, other: Any) -> Any:
    """Whether a body wakes another that was left out; labels before numbers."""
    return (one == ASLEEP and (other == MEMBER or other == MOVING)) or (
        other == ASLEEP and (one == MEMBER or one == MOVING)
    )


@njit
def _join_through_contacts(contacts: Any, listed: Any, listed_count: Any, islands: Any) -> Any:
    """Unite the bodies of each listed contact; keep those with a member in the list.

    Returns how many, or -1 where a contact wakes a body that was left out.
    """
    count = 0
    for i in range(listed_count):
        contact = contacts[listed[i]]
        if contact.sensor != 0:
            continue
        a = islands[contact.body_a]
        b = islands[contact.body_b]
        if _stirs(a.label, b.label):
            return -1
        if a.parent >= 0 or b.parent >= 0:
            listed[count] = listed[i]
            count += 1
            if a.parent >= 0 and b.parent >= 0 and a.parent != b.parent:
                _unite(islands, contact.body_a, contact.body_b)
    return count


@njit
def _join_through_joints(joint_models: Any, joint_parameters: Any, islands: Any) -> Any:
    """The same for joints; False where one wakes a body that was left out."""
    for j in range(len(joint_models)):
        if joint_parameters[j].enabled == 0:
            continue
        a = islands[joint_models[j].body_a]
        b = islands[joint_models[j].body_b]
        if _stirs(a.label, b.label) or (joint_models[j].wakes and (a.label == ASLEEP or b.label == ASLEEP)):
            return False
        if a.parent >= 0 and b.parent >= 0:
            _unite(islands, joint_models[j].body_a, joint_models[j].body_b)
    return True


@njit
def _number_islands(islands: Any) -> Any:
    count = 0
    for b in range(len(islands)):
        if islands[b].parent < 0:
            continue
        root = islands[b].parent
        while islands[root].parent != root:
            root = islands[root].parent
        if root == b:
            island = islands[count]
            island.body_count = 0
            island.contact_count = 0
            island.joint_count = 0
            island.awake = 0
            islands[b].label = count
            count += 1
        else:
            islands[b].label = islands[root].label
        islands[islands[b].label].body_count += 1
    return count


@njit
def _island_of(one: Any, other: Any) -> Any:
    """Number of the island of two connected entries, negative if both are outside."""
    return one.label if one.label >= 0 else other.label


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
def _fill_bodies(bodies: Any, islands: Any, island_bodies: Any) -> None:
    for b in range(len(bodies)):
        if islands[b].label >= 0:
            island = islands[islands[b].label]
            island_bodies[island.body_first + island.body_count] = b
            island.body_count += 1
            if bodies[b].asleep == 0:
                island.awake = AWAKE


@njit
def _fill_contacts(contacts: Any, listed: Any, islands: Any, island_contacts: Any) -> None:
    for k in range(len(listed)):
        contact = contacts[listed[k]]
        a = islands[contact.body_a]
        b = islands[contact.body_b]
        island = islands[_island_of(a, b)]
        island_contacts[island.contact_first + island.contact_count] = listed[k]
        island.contact_count += 1
        if a.label == MOVING or b.label == MOVING:
            island.awake = PRESSED


@njit
def _fill_joints(joint_models: Any, joint_parameters: Any, islands: Any, island_joints: Any) -> None:
    for j in range(len(joint_models)):
        a = islands[joint_models[j].body_a]
        b = islands[joint_models[j].body_b]
        i = _island_of(a, b)
        if joint_parameters[j].enabled == 0 or i < 0:
            continue
        island = islands[i]
        island_joints[island.joint_first + island.joint_count] = j
        island.joint_count += 1
        if joint_models[j].wakes and island.awake != PRESSED:
            island.awake = DRIVEN
        if a.label == MOVING or b.label == MOVING:
            island.awake = PRESSED


@njit
def build_islands(
    bodies: Any,
    body_models: Any,
    body_parameters: Any,
    contacts: Any,
    contact_count: Any,
    listed: Any,
    found_count: Any,
    joint_models: Any,
    joint_parameters: Any,
    islands: Any,
    island_bodies: Any,
    island_contacts: Any,
    island_joints: Any,
) -> Any:
    """Fill ``islands[:count]`` and their lists of bodies, contacts and joints; return count.

    An island with one awake body, or touched by a moving kinematic one, is awake as a whole.
    ``islands[b].label`` is the island of body b, or why it has none.  ``listed[:found_count]`` are
    the places of the contacts that may have an awake body; all of ``listed`` is scratch.
    """
    _start_sets(bodies, body_models, body_parameters, islands, False)
    listed_count = _join_through_contacts(contacts, listed, found_count, islands)
    calm = listed_count >= 0
    if joint_models is not None:
        calm = calm and _join_through_joints(joint_models, joint_parameters, islands)
    if not calm:
        _start_sets(bodies, body_models, body_parameters, islands, True)
        for k in range(contact_count):
            listed[k] = k
        listed_count = _join_through_contacts(contacts, listed, contact_count, islands)
        if joint_models is not None:
            _join_through_joints(joint_models, joint_parameters, islands)
    listed = listed[:listed_count]
    count = _number_islands(islands)

    for k in range(len(listed)):
        contact = contacts[listed[k]]
        islands[_island_of(islands[contact.body_a], islands[contact.body_b])].contact_count += 1
    if joint_models is not None:
        for j in range(len(joint_models)):
            i = _island_of(islands[joint_models[j].body_a], islands[joint_models[j].body_b])
            if joint_parameters[j].enabled and i >= 0:
                islands[i].joint_count += 1
    _set_firsts(islands, count)

    _fill_bodies(bodies, islands, island_bodies)
    _fill_contacts(contacts, listed, islands, island_contacts)
    if joint_models is not None:
        _fill_joints(joint_models, joint_parameters, islands, island_joints)
    return count
