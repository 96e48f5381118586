"""Division of a step: it is repeated in parts where overlaps have grown in it.

Contacts are searched once, at the start of a step, and their rows are linear in the motion. An impact may turn a body
within the step onto others with corners that were not near before. So after a step with far motions the overlaps are
measured: where one has grown, the state is restored and the step halved, as a method with control of its error does.
The impulses of a part are in proportion to its length, those of the step their sums.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ..jit import njit
from .broadphase import find_pairs
from .contact_cache import pair_order
from .detection import collide_pairs
from .dispatch import by_dimension
from .geometry import update_geometry
from .status import MORE_CONTACTS, MORE_PAIRS, OK

Array = NDArray[Any]

add_total = by_dimension("contact_rows", "add_total")

STEP = 0  # places of copies of the state: at the start of the step,
PART = 1  # and at that of the present part
DEPTH = 0.01  # of the extent: an overlap up to this is accepted; more where many bodies are awake,
MANY = 128.0  # from this number on,
MOST_DEPTH = 0.1  # at most
GROWTH = 0.001  # of the extent: a deeper overlap may grow by this in the step, and by what is accepted above DEPTH
NEARLY = 0.9  # cosine of the angle between normals, from which on contacts of one feature are the same


@njit
def keep_state(world: Any, joints: Any, place: int) -> None:
    """Copy what a step changes, and its length and substeps, to `place` of `scratch.division`."""
    division = world.scratch.division
    state = world.state
    bodies = state.bodies
    contacts = state.contacts
    for b in range(len(bodies)):
        division.bodies[place, b] = bodies[b]
    for k in range(int(state.world.contact_count)):
        division.contacts[place, k] = contacts[k]
    if joints is not None:
        for j in range(len(joints)):
            division.joints[place, j] = joints[j]
    copy_counters(state.world, division.worlds[place])
    division.timesteps[place] = world.options.timestep
    division.substeps[place] = world.options.substeps


@njit
def restore_state(world: Any, joints: Any, place: int) -> None:
    """Undo all that has happened since `keep_state`."""
    division = world.scratch.division
    state = world.state
    bodies = state.bodies
    contacts = state.contacts
    for b in range(len(bodies)):
        bodies[b] = division.bodies[place, b]
    copy_counters(division.worlds[place], state.world)
    for k in range(int(state.world.contact_count)):
        contacts[k] = division.contacts[place, k]
    if joints is not None:
        for j in range(len(joints)):
            joints[j] = division.joints[place, j]
    set_substeps(world, division.timesteps[place], int64(division.substeps[place]))


@njit
def copy_counters(source: Any, target: Any) -> None:
    """Copy the counters and residuals of a world."""
    target.step = source.step
    target.contact_count = source.contact_count
    target.awake_count = source.awake_count
    target.pair_count = source.pair_count
    target.row_count = source.row_count
    target.island_count = source.island_count
    target.sweeps = source.sweeps
    target.unconverged = source.unconverged
    target.impacts = source.impacts
    target.residual = source.residual
    target.natural_residual = source.natural_residual


@njit
def set_length(world: Any, joints: Any, timestep: float, substeps: int) -> None:
    """Set the length in s and the substeps of the next part, and scale the impulses that these start from."""
    scale = timestep / world.options.timestep
    substep_scale = set_substeps(world, timestep, substeps)
    contacts = world.state.contacts
    for k in range(int(world.state.world.contact_count)):
        for d in range(len(contacts[k].impulse)):
            contacts[k].impulse[d] *= substep_scale
    if joints is not None:
        for j in range(len(joints)):
            for d in range(len(joints[j].impulse)):
                joints[j].impulse[d] *= substep_scale
            for d in range(len(joints[j].total_impulse)):
                joints[j].total_impulse[d] *= scale
            for d in range(len(joints[j].reaction)):
                joints[j].reaction[d] *= scale


@njit
def substeps_of_part(world: Any, substeps: int, length: int, end: int) -> int:
    """Return the number of substeps of ``length`` of the ``end`` shortest parts of a step that has ``substeps``.

    Where few bodies are awake, each part has as many as the step, and is as much more accurate.
    """
    if not world.scratch.division.many[0]:
        return substeps
    return (substeps * length + end - 1) // end


@njit
def set_substeps(world: Any, timestep: float, substeps: int) -> float:
    """Set the length of the present part in s and its substeps; returns the factor of the length of a substep."""
    division = world.scratch.division
    options = world.options
    before = options.timestep / options.substeps
    options.timestep = timestep
    options.substeps = substeps
    length = timestep / substeps
    division.share[0] = length / (division.timesteps[STEP] / division.substeps[STEP])
    return length / before


@njit
def start_sums(world: Any, joints: Any) -> None:
    """Set the sums over the parts of a step to 0."""
    if joints is not None:
        sums = world.scratch.division.joint_sums
        for j in range(len(joints)):
            for d in range(len(joints[j].total_impulse)):
                sums[j].total_impulse[d] = 0.0
            for d in range(len(joints[j].reaction)):
                sums[j].reaction[d] = 0.0


@njit
def start_part_of_step(world: Any, joints: Any, share: float) -> None:
    """Keep the state, and give contacts that sleep in the part their ``share`` of the impulses so far.

    The impulses of the others start from 0 in each part; `add_part` adds those so far.
    """
    keep_state(world, joints, PART)
    contacts = world.state.contacts
    for k in range(int(world.state.world.contact_count)):
        for d in range(len(contacts[k].total_impulse)):
            contacts[k].total_impulse[d] *= share


@njit
def add_part(world: Any, joints: Any, first: bool) -> int:
    """Add the impulses and counters of a part to those of the parts before; returns the number of contacts.

    Contacts that have ended since or have turned far stay in the list, after others of their pair, with their sums
    and no impulse to start from. Where they do not fit into it, the number exceeds its length.
    """
    division = world.scratch.division
    if joints is not None:
        sums = division.joint_sums
        for j in range(len(joints)):  # a sleeping joint adds its last sum, scaled to the part
            for d in range(len(joints[j].total_impulse)):
                sums[j].total_impulse[d] += joints[j].total_impulse[d]
            for d in range(len(joints[j].reaction)):
                sums[j].reaction[d] += joints[j].reaction[d]
    counters = world.state.world
    if first:
        return int64(counters.contact_count)
    before = division.worlds[PART]
    counters.sweeps += before.sweeps
    counters.unconverged += before.unconverged
    counters.impacts += before.impacts
    counters.residual = max(counters.residual, before.residual)
    counters.natural_residual = max(counters.natural_residual, before.natural_residual)
    counters.pair_count = max(counters.pair_count, before.pair_count)
    counters.row_count = max(counters.row_count, before.row_count)
    counters.island_count = max(counters.island_count, before.island_count)
    counters.awake_count = max(counters.awake_count, before.awake_count)
    ended = add_contact_sums(world)
    count = int64(counters.contact_count + ended)
    if ended > 0 and count <= len(world.state.contacts):
        insert_ended(world, ended)
        counters.contact_count = count
    return count


@njit
def store_sums(world: Any, joints: Any) -> None:
    """Set the impulses of the joints over the step to the sums over its parts."""
    if joints is not None:
        sums = world.scratch.division.joint_sums
        for j in range(len(joints)):
            for d in range(len(joints[j].total_impulse)):
                joints[j].total_impulse[d] = sums[j].total_impulse[d]
            for d in range(len(joints[j].reaction)):
                joints[j].reaction[d] = sums[j].reaction[d]


@njit
def add_contact_sums(world: Any) -> int:
    """Add the kept sums to the same contacts; move those of ended contacts to the front of the copy."""
    division = world.scratch.division
    contacts = world.state.contacts
    count = int(world.state.world.contact_count)
    ended = int64(0)
    first = 0
    for k in range(int(division.worlds[PART].contact_count)):
        kept = division.contacts[PART, k]
        if not has_impulse(kept):
            continue
        while first < count and pair_order(contacts[first], kept) < 0:
            first += 1
        place = first
        while place < count and pair_order(contacts[place], kept) == 0 and not is_same(contacts[place], kept):
            place += 1
        if place < count and pair_order(contacts[place], kept) == 0:
            add_total(contacts[place], kept)
        else:
            division.contacts[PART, ended] = kept
            ended += 1
    return ended


@njit
def is_same(contact: Any, kept: Any) -> bool:
    """Whether two contacts of a pair have the same feature and nearly the same normal."""
    cosine = 0.0
    for d in range(len(kept.normal)):
        cosine += contact.normal[d] * kept.normal[d]
    return contact.feature == kept.feature and cosine > NEARLY


@njit
def has_impulse(contact: Any) -> bool:
    """Whether a contact had an impulse in the step."""
    for d in range(len(contact.total_impulse)):
        if contact.total_impulse[d] != 0.0:
            return True
    return False


@njit
def insert_ended(world: Any, ended: int) -> None:
    """Insert the first `ended` contacts of the copy into the list, which stays sorted by pairs."""
    extra = world.scratch.division.contacts
    contacts = world.state.contacts
    last = int(world.state.world.contact_count) - 1
    left = ended - 1
    while left >= 0:
        if last >= 0 and pair_order(contacts[last], extra[PART, left]) > 0:
            contacts[last + left + 1] = contacts[last]
            last -= 1
        else:
            contact = contacts[last + left + 1]
            contacts[last + left + 1] = extra[PART, left]
            contact.form = np.inf  # equal to none: the narrowphase searches this pair again
            for d in range(len(contact.impulse)):
                contact.impulse[d] = 0.0
            left -= 1


@njit
def check_step(world: Any, joints: Any) -> tuple[int, int, bool]:
    """Test whether an overlap has grown in the whole step; returns (status, needed, grown).

    If so, the state is that at the start of the step, and `scratch.division` has the overlaps there.  They are not
    those of the contacts that the step began with, of which some are predicted.
    """
    division = world.scratch.division
    awake_count = int64(world.state.world.awake_count)
    depth = accepted_depth(awake_count)
    status, needed, count = find_overlaps(world, False, depth)
    if status != OK or not any_deeper(world.scratch.found, count, division.overlaps, int64(0), depth):
        return status, needed, False
    deep_count = copy_overlaps(world.scratch.found, count, division.overlaps)
    keep_state(world, joints, PART)
    restore_state(world, joints, STEP)
    status, needed, count = find_overlaps(world, True, 0.0)
    if status != OK:
        return status, needed, False
    division.many[0] = awake_count > MANY
    grown = any_deeper(division.overlaps, deep_count, world.scratch.found, count, depth)
    if grown:
        division.overlap_count[0] = copy_overlaps(world.scratch.found, count, division.overlaps)
    else:
        restore_state(world, joints, PART)
    return OK, int64(0), grown


@njit
def check_part(world: Any) -> tuple[int, int, bool]:
    """Test whether an overlap has grown since the start of the step; returns (status, needed, grown)."""
    division = world.scratch.division
    depth = accepted_depth(world.state.world.awake_count)
    status, needed, count = find_overlaps(world, False, depth)
    if status != OK:
        return status, needed, False
    before = int64(division.overlap_count[0])
    return OK, int64(0), any_deeper(world.scratch.found, count, division.overlaps, before, depth)


@njit
def accepted_depth(awake_count: int) -> float:
    """Return the overlap that is accepted, over the extent.

    One pair divides the step of all bodies.  So that large heaps are not divided in nearly every step, the depth that
    one pair of many exceeds grows with their number.
    """
    return min(DEPTH * max(awake_count / MANY, 1.0), MOST_DEPTH)


@njit
def find_overlaps(world: Any, asleep: bool, depth: float) -> tuple[int, int, int]:
    """Fill `scratch.found` with the contacts of the present poses; returns (status, needed, number of contacts).

    ``asleep``: also with those of bodies that sleep; ``depth``: as of ``collide_pairs``.
    """
    scratch = world.scratch
    timestep = world.options.timestep
    world.options.timestep = 0.0  # for boxes and margins of the present
    update_geometry(world)
    if asleep:
        for k in range(len(scratch.geometry)):
            scratch.geometry[k].awake = scratch.geometry[k].dynamic
    pair_count = find_pairs(
        scratch.geometry, world.shapes.models, world.model.exclusions, scratch.broadphase, scratch.pairs
    )
    count = int64(0)
    if pair_count <= len(scratch.pairs):
        count = collide_pairs(world, pair_count, depth)
    world.options.timestep = timestep
    if pair_count > len(scratch.pairs):
        return MORE_PAIRS, pair_count, count
    if count > len(scratch.found):
        return MORE_CONTACTS, count, count
    return OK, int64(0), count


@njit
def copy_overlaps(found: Array, count: int, overlaps: Array) -> int:
    """Copy the overlapping ones of the first `count` contacts; returns their number."""
    kept = int64(0)
    for k in range(count):
        if found[k].separation < 0.0 and found[k].sensor == 0:
            overlaps[kept] = found[k]
            kept += 1
    return kept


@njit
def any_deeper(contacts: Array, count: int, others: Array, other_count: int, depth: float) -> bool:
    """Whether one of the first `count` contacts is deep, and deeper than all of its pair among the others.

    ``depth``: of the extent, from which on an overlap is deep.
    """
    growth = depth - DEPTH + GROWTH
    first = 0
    for k in range(count):
        contact = contacts[k]
        if contact.sensor != 0 or contact.separation >= -depth * contact.extent:
            continue
        while first < other_count and pair_order(others[first], contact) < 0:
            first += 1
        before = 0.0
        place = first
        while place < other_count and pair_order(others[place], contact) == 0:
            before = min(before, others[place].separation)
            place += 1
        if contact.separation < before - growth * contact.extent:
            return True
    return False
