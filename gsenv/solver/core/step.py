"""One step of a world, stage by stage; the same for 2D and 3D."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..jit import njit
from ..records.bundle import select_world
from .activity import ALL_ASLEEP, AWAKE
from .contact_cache import update_contacts
from .continuous_collision import keep_start, resolve_continuous_collisions
from .detection import find_contacts
from .division import (
    PART,
    STEP,
    add_part,
    check_part,
    check_step,
    keep_state,
    restore_state,
    set_length,
    start_part_of_step,
    start_sums,
    store_sums,
    substeps_of_part,
)
from .geometry import gravity_norm, update_geometry
from .integrate import (
    any_kinematic,
    any_lost,
    clear_forces,
    hold_disabled,
    move_kinematic,
    release_disabled,
    start_bodies,
)
from .islands import build_islands, start_counters
from .joints import drive_joints, start_joints
from .sleep import any_awake, update_sleep
from .slices import part
from .status import BAD_CONTROL, MORE_CONTACTS, NOT_FINITE, OK
from .substep import step_island


@njit
def step_worlds(world: Any, first: Any, last: Any, count: Any) -> Any:
    """Step the worlds first .. last - 1 ``count`` times; with ``count`` -1, continue where the last call stopped.

    Returns (status, needed): OK and 0, or which buffer is too small for the next step of a world and how many
    entries it needs.  That step has then changed nothing; call again with larger buffers and -1.
    BAD_CONTROL means that a control of some world is not finite; nothing has changed then.  NOT_FINITE means that
    all steps are taken, after which some world has a position or velocity that is not finite.

    ``world`` is the bundle of records/kernel_world.py.  Parts that a scene lacks are None.  They are passed to
    their stages as arguments, so that numba compiles nothing that needs them.
    """
    until = world.until
    if count >= 0:
        if not _all_finite(world.control):
            return BAD_CONTROL, int64(0)
        for w in range(first, last):
            select_world(world, w)
            until[w] = world.state.world.step + count
    for w in range(first, last):
        select_world(world, w)
        while world.state.world.step < until[w]:
            status, needed = step_world(world)
            if status != OK:
                return status, needed
    for w in range(first, last):
        select_world(world, w)
        if may_move(world) and any_lost(world.state.bodies):
            return NOT_FINITE, int64(0)
    return OK, int64(0)


@njit
def step_world(world: Any) -> Any:
    """Step the selected world once; returns (status, needed) as ``step_worlds`` does."""
    joints = world.state.joints
    drive_joints(world, joints)
    if not may_move(world):
        start_counters(world.state.world)
        finish_step(world)
        return OK, int64(0)
    if any_lost(world.state.bodies):  # nothing that follows from it would be finite
        start_counters(world.state.world)
        world.state.world.contact_count = 0
        finish_step(world)
        return OK, int64(0)
    status, needed, far_moving = step_part(world, joints, True)
    if far_moving:
        status, needed, grown = check_step(world, joints)
        if status != OK:
            restore_state(world, joints, STEP)
        elif grown:
            status, needed = divide_step(world, joints)
    if status == OK:
        finish_step(world)
    return status, needed


@njit
def may_move(world: Any) -> Any:
    """Whether a body of the world may move in the next step."""
    return any_awake(world.state.bodies, world.model.bodies, world.parameters.bodies)


@njit
def step_part(world: Any, joints: Any, whole: bool) -> Any:
    """Take the step, the ``whole`` of it or a part, once; returns (status, needed, whether it is to be checked).

    The state at the start is kept where the step may have to be divided.
    """
    update_geometry(world)
    status, needed, pair_count, found_count, far_moving = find_contacts(world)
    if status != OK:
        return status, needed, False
    far_moving = far_moving and world.options.halvings > 0
    if far_moving and whole:
        keep_state(world, joints, STEP)
    contact_count = match_contacts(world, found_count)
    if contact_count > len(world.state.contacts):
        return MORE_CONTACTS, int64(contact_count), False
    start_counters(world.state.world)
    world.state.world.pair_count = pair_count
    world.state.world.contact_count = contact_count
    keep_start(world, world.scratch.start_poses)
    island_count = build_islands(world, found_count, joints)
    start_step(world, joints)
    step_islands(world, island_count)
    resolve_continuous_collisions(world, world.scratch.start_poses)
    restore_disabled(world, joints)
    return OK, int64(0), far_moving


@njit
def divide_step(world: Any, joints: Any) -> Any:
    """Repeat in parts a step in which an overlap has grown; returns (status, needed) as ``step_worlds`` does.

    The state is that at the start of the step.  Lengths are whole numbers of shortest parts.  If even one of these
    fails, the rest of the step is not checked.
    """
    timestep = world.options.timestep
    substeps = int64(world.options.substeps)
    end = 1 << int64(world.options.halvings)
    length = end // 2
    done = int64(0)
    status = OK
    needed = int64(0)
    checked = True
    world.scratch.division.finest[0] = substeps
    start_sums(world, joints)
    while done < end:
        part_substeps = substeps_of_part(world, substeps, length, end)
        set_length(world, joints, timestep * (length / end), part_substeps)
        start_part_of_step(world, joints, length / (done if done > 0 else end))
        failed = False
        status, needed, far_moving = step_part(world, joints, False)
        if status == OK and far_moving and checked:
            status, needed, failed = check_part(world)
        if status != OK:
            break
        if failed and length > 1:
            restore_state(world, joints, PART)
            length //= 2
            continue
        checked = checked and not failed
        needed = add_part(world, joints, done == 0)
        if needed > len(world.state.contacts):
            status = MORE_CONTACTS
            break
        done += length
        while done % (2 * length) == 0 and done + 2 * length <= end:
            length *= 2
    world.scratch.division.finest[0] = 0
    if status != OK:
        restore_state(world, joints, STEP)
        return status, needed
    set_length(world, joints, timestep, substeps)
    store_sums(world, joints)
    return OK, int64(0)


@njit
def match_contacts(world: Any, found_count: Any) -> Any:
    """Replace the contacts of the world by those found, with the impulses of the last step; returns their number."""
    scratch = world.scratch
    return update_contacts(
        world.state.contacts,
        world.state.world.contact_count,
        scratch.found,
        found_count,
        scratch.geometry,
        scratch.displaced,
        scratch.found_places,
        scratch.articulation,
    )


@njit
def start_step(world: Any, joints: Any) -> None:
    """Prepare the scratch of bodies and joints for the step."""
    if joints is not None:
        hold_disabled(world.state.bodies, world.parameters.bodies, world.scratch.substep_bodies)
    start_bodies(world)
    if joints is not None:
        start_joints(joints, world.parameters.joints)
    island = world.scratch.island
    island.kinematic = any_kinematic(world.state.bodies, world.model.bodies, world.parameters.bodies)
    island.gravity_norm = gravity_norm(world.parameters.world)


@njit
def step_islands(world: Any, island_count: Any) -> None:
    """Take all substeps of each awake island; within a step, islands are independent of each other."""
    counters = world.state.world
    scratch = world.scratch
    island = scratch.island
    error_sum = 0.0
    velocity_sum = 0.0
    impulse_sum = 0.0
    for i in range(island_count):
        if scratch.islands[i].activity == ALL_ASLEEP:
            continue
        enter_island(island, scratch.islands[i])
        step_island(world, island, world.state.joints, scratch.joint_factor)
        error_sum += island.error_sum
        velocity_sum += island.velocity_sum
        impulse_sum += island.impulse_sum
        counters.island_count += 1
        counters.awake_count += island.body_count
        # a body that touches nothing keeps moving, however slowly
        restless = island.activity != AWAKE or island.contact_count + island.joint_count == 0
        island_bodies = part(scratch.island_bodies, island.body_first, island.body_count)
        bodies = world.state.bodies
        update_sleep(island_bodies, bodies, world.parameters.bodies, scratch.substep_bodies, world.options, restless)
    counters.natural_residual = (error_sum / max(velocity_sum, impulse_sum)) ** 0.5 if error_sum > 0.0 else 0.0
    if island.kinematic:
        move_kinematic(world, world.options.timestep)


@njit
def enter_island(island: Any, listed: Any) -> None:
    """Copy an entry of the list of islands into the record of the current island."""
    island.body_first = listed.body_first
    island.body_count = listed.body_count
    island.contact_first = listed.contact_first
    island.contact_count = listed.contact_count
    island.joint_first = listed.joint_first
    island.joint_count = listed.joint_count
    island.activity = listed.activity


@njit
def restore_disabled(world: Any, joints: Any) -> None:
    """Give disabled bodies their velocities back."""
    if joints is not None:
        release_disabled(world.state.bodies, world.parameters.bodies, world.scratch.substep_bodies)


@njit
def finish_step(world: Any) -> None:
    """Clear the applied forces and count the step."""
    clear_forces(world.state.bodies)
    world.state.world.step += 1


@njit
def _all_finite(control: Any) -> Any:
    for w in range(len(control)):
        for k in range(control.shape[1]):
            if not np.isfinite(control[w, k]):
                return False
    return True
