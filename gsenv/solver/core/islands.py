"""Islands: groups of bodies that rows connect. Each is solved and put to sleep as a whole.

Static and kinematic bodies connect nothing.  Islands are numbered by their lowest body, and list
bodies, contacts and joints in the order of the world, so the numbering depends on the state alone.
Sleeping bodies that nothing awake touches cannot be woken in the step, and are left out.

The loops access the arrays directly: numba counts references to an array that is passed to a helper,
which costs more than the work of the helper.
"""

from __future__ import annotations

from typing import Any

from numba import int64

from ..jit import njit
from .activity import ALL_ASLEEP, AWAKE, DRIVEN, KINEMATIC_CONTACT
from .joint_rows import has_armature, has_friction, has_limit, has_motor, runs
from .springs import has_spring

# labels of bodies outside all islands, and of all bodies before the islands are numbered
FIXED = -1
MOVING = -2  # kinematic and moving
ASLEEP = -3
MEMBER = -4  # of an island that has no number yet


@njit
def is_kinematic(body_model: Any, body_parameters: Any) -> Any:
    """Whether a body is kinematic and enabled: it moves at its velocity, whatever it touches."""
    return body_model.kind == 1 and body_parameters.enabled != 0


@njit
def start_counters(state: Any) -> None:
    """Set the counters of the step to zero."""
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
    """Return the root of a body's set, halving the path (union-find)."""
    while islands[body].parent != body:
        islands[body].parent = islands[islands[body].parent].parent
        body = islands[body].parent
    return body


@njit
def _unite(islands: Any, a: Any, b: Any) -> None:
    """Merge the sets of two bodies; the lower root becomes the root."""
    a = _root(islands, a)
    b = _root(islands, b)
    if a < b:
        islands[b].parent = a
    elif b < a:
        islands[a].parent = b


@njit
def _start_sets(bodies: Any, body_models: Any, body_parameters: Any, islands: Any, sleepers: Any) -> None:
    """Make each movable body its own set; sleeping bodies only with ``sleepers``."""
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
        elif is_kinematic(body_models[b], body_parameters[b]):
            velocity = bodies[b].velocity
            for i in range(len(velocity)):
                if velocity[i] != 0.0:
                    entry.label = MOVING


@njit
def _wakes(one: Any, other: Any) -> Any:
    """Whether one of two labels is that of a sleeping body and the other that of one that wakes it."""
    return (one == ASLEEP and (other == MEMBER or other == MOVING)) or (
        other == ASLEEP and (one == MEMBER or one == MOVING)
    )


@njit
def _join_through_contacts(contacts: Any, listed: Any, listed_count: Any, islands: Any) -> Any:
    """Unite the bodies of each listed contact, and drop contacts without a member of an island from the list.

    Returns the new length of the list, or -1 where a contact wakes a body that was left out.
    """
    count = 0
    for i in range(listed_count):
        contact = contacts[listed[i]]
        if contact.sensor != 0:
            continue
        a = islands[contact.body_a]
        b = islands[contact.body_b]
        if _wakes(a.label, b.label):
            return -1
        if a.parent >= 0 or b.parent >= 0:
            listed[count] = listed[i]
            count += 1
            if a.parent >= 0 and b.parent >= 0 and a.parent != b.parent:
                _unite(islands, contact.body_a, contact.body_b)
    return count


@njit
def _join_through_joints(joint_models: Any, joint_parameters: Any, islands: Any) -> Any:
    """Unite the bodies of each enabled joint; returns False where one wakes a body that was left out."""
    for j in range(len(joint_models)):
        if joint_parameters[j].enabled == 0:
            continue
        a = islands[joint_models[j].body_a]
        b = islands[joint_models[j].body_b]
        if _wakes(a.label, b.label) or (joint_models[j].driven and (a.label == ASLEEP or b.label == ASLEEP)):
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
            island.activity = ALL_ASLEEP
            islands[b].label = count
            count += 1
        else:
            islands[b].label = islands[root].label
        islands[islands[b].label].body_count += 1
    return count


@njit
def _island_of(one: Any, other: Any) -> Any:
    """Return the number of the island of two connected bodies, negative where neither is in an island."""
    return one.label if one.label >= 0 else other.label


@njit
def _count_contacts(contacts: Any, listed: Any, listed_count: Any, islands: Any) -> None:
    for k in range(listed_count):
        contact = contacts[listed[k]]
        islands[_island_of(islands[contact.body_a], islands[contact.body_b])].contact_count += 1


@njit
def _acts(joint_models: Any, joint_parameters: Any, j: Any) -> Any:
    """Whether a joint needs rows: it is enabled, and no other one holds all that it holds."""
    model = joint_models[j]
    parameters = joint_parameters[j]
    if parameters.enabled == 0:
        return False
    if model.repeats < 0 or joint_parameters[model.repeats].enabled == 0 or model.driven:
        return True
    if has_limit(parameters) or has_motor(parameters) or has_friction(parameters) or has_armature(parameters):
        return True
    return has_spring(parameters)


@njit
def _count_joints(joint_models: Any, joint_parameters: Any, islands: Any) -> None:
    for j in range(len(joint_models)):
        i = _island_of(islands[joint_models[j].body_a], islands[joint_models[j].body_b])
        if i >= 0 and _acts(joint_models, joint_parameters, j):
            islands[i].joint_count += 1


@njit
def _set_firsts(islands: Any, count: Any) -> None:
    """Set the start of each island's lists and reset the counts, which grow again as the lists are filled."""
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
                island.activity = AWAKE


@njit
def _fill_contacts(contacts: Any, listed: Any, listed_count: Any, islands: Any, island_contacts: Any) -> None:
    for k in range(listed_count):
        contact = contacts[listed[k]]
        a = islands[contact.body_a]
        b = islands[contact.body_b]
        island = islands[_island_of(a, b)]
        island_contacts[island.contact_first + island.contact_count] = listed[k]
        island.contact_count += 1
        if a.label == MOVING or b.label == MOVING:
            island.activity = KINEMATIC_CONTACT


@njit
def _fill_joints(joint_models: Any, joint_parameters: Any, joints: Any, islands: Any, island_joints: Any) -> None:
    for j in range(len(joint_models)):
        a = islands[joint_models[j].body_a]
        b = islands[joint_models[j].body_b]
        i = _island_of(a, b)
        if i < 0 or not _acts(joint_models, joint_parameters, j):
            continue
        island = islands[i]
        island_joints[island.joint_first + island.joint_count] = j
        island.joint_count += 1
        if (joint_models[j].driven or runs(joint_parameters[j], joints[j])) and island.activity != KINEMATIC_CONTACT:
            island.activity = DRIVEN
        if a.label == MOVING or b.label == MOVING:
            island.activity = KINEMATIC_CONTACT


@njit
def build_islands(world: Any, found_count: Any, joints: Any) -> Any:
    """Fill ``scratch.islands[:count]`` and the lists of bodies, contacts and joints; returns count.

    An island with an awake body, or touched by a moving kinematic body, is awake as a whole.
    ``islands[b].label`` is the island of body b, or why it has none.  ``found_places[:found_count]`` are
    the indices of the contacts that may have an awake body; the rest of ``found_places`` is scratch.
    """
    bodies = world.state.bodies
    body_models = world.model.bodies
    body_parameters = world.parameters.bodies
    contacts = world.state.contacts
    islands = world.scratch.islands
    listed = world.scratch.found_places
    _start_sets(bodies, body_models, body_parameters, islands, False)
    listed_count = _join_through_contacts(contacts, listed, found_count, islands)
    complete = listed_count >= 0
    if joints is not None:
        complete = complete and _join_through_joints(world.model.joints, world.parameters.joints, islands)
    if not complete:
        contact_count = int64(world.state.world.contact_count)
        _start_sets(bodies, body_models, body_parameters, islands, True)
        for k in range(contact_count):
            listed[k] = k
        listed_count = _join_through_contacts(contacts, listed, contact_count, islands)
        if joints is not None:
            _join_through_joints(world.model.joints, world.parameters.joints, islands)
    count = _number_islands(islands)

    _count_contacts(contacts, listed, listed_count, islands)
    if joints is not None:
        _count_joints(world.model.joints, world.parameters.joints, islands)
    _set_firsts(islands, count)

    _fill_bodies(bodies, islands, world.scratch.island_bodies)
    _fill_contacts(contacts, listed, listed_count, islands, world.scratch.island_contacts)
    if joints is not None:
        _fill_joints(world.model.joints, world.parameters.joints, joints, islands, world.scratch.island_joints)
    return count
