"""One step of a spatial world, as a table of contents. All substeps run in one jitted call."""

from __future__ import annotations

from typing import Any

from ..contact_cache import update_contacts
from ..islands import AWAKE, build_islands, start_counters
from ..jit import njit
from ..optional import at
from ..sleep import any_awake, update_sleep
from .detection import MORE_CONTACTS, OK, detect
from .geometry import update_geometry
from .integrate import any_kinematic, clear_forces, hold_disabled, move_kinematic, release_disabled, start_motion
from .island_step import step_island
from .joints import drive_joints, start_joints
from .math import norm, vec
from .sweep_fast import keep_start, sweep_fast_bodies


@njit
def step_world(
    w: Any,
    options: Any,
    body_models: Any,
    shape_models: Any,
    joint_models: Any,
    actuators: Any,
    exclusions: Any,
    world_parameters: Any,
    body_parameters: Any,
    shape_parameters: Any,
    joint_parameters: Any,
    constraint_rows: Any,
    vertices: Any,
    world_states: Any,
    bodies: Any,
    contacts: Any,
    joint_states: Any,
    control: Any,
    bouncy: Any,
    soft: Any,
    newton: Any,
    geometry: Any,
    pairs: Any,
    found: Any,
    displaced: Any,
    motions: Any,
    movers: Any,
    islands: Any,
    island_bodies: Any,
    island_contacts: Any,
    island_joints: Any,
    rows: Any,
    broadphase: Any,
    fast_start: Any,
    factor: Any,
    edges: Any,
    blocks: Any,
    tree: Any,
    tree_blocks: Any,
    manifold: Any,
    clip: Any,
    field: Any,
    convex: Any,
) -> Any:
    """One step of world ``w``. The arrays are as in step_worlds."""
    dt = options.timestep
    gravity = world_parameters[w].gravity
    state = world_states[w]
    if joint_models is not None:
        drive_joints(
            actuators,
            control[w],
            joint_models,
            at(joint_parameters, w),
            at(joint_states, w),
            bodies[w],
            body_parameters[w],
        )
    if not any_awake(bodies[w], body_models, body_parameters[w]):
        start_counters(state)
        clear_forces(bodies[w])
        state.step += 1
        return OK, 0

    update_geometry(
        bodies[w],
        body_models,
        body_parameters[w],
        shape_models,
        shape_parameters[w],
        at(vertices, w),
        gravity,
        dt,
        geometry,
    )
    status, needed, pair_count, found_count = detect(
        bodies[w],
        body_models,
        body_parameters[w],
        shape_models,
        shape_parameters[w],
        at(vertices, w),
        exclusions,
        gravity,
        dt,
        geometry,
        broadphase,
        pairs,
        found,
        motions,
        manifold,
        clip,
        field,
        convex,
    )
    if status != OK:
        return status, needed
    places = island_contacts[len(island_contacts) // 2 :]
    contact_count = update_contacts(
        contacts[w], state.contact_count, found, found_count, geometry, displaced, places
    )
    if contact_count > len(contacts[w]):
        return MORE_CONTACTS, contact_count

    start_counters(state)
    state.pair_count = pair_count
    state.contact_count = contact_count
    if fast_start is not None:
        keep_start(bodies[w], fast_start)
    island_count = build_islands(
        bodies[w],
        body_models,
        body_parameters[w],
        contacts[w],
        contact_count,
        places,
        found_count,
        joint_models,
        at(joint_parameters, w),
        islands,
        island_bodies,
        island_contacts,
        island_joints,
    )
    if joint_models is not None:
        hold_disabled(bodies[w], body_parameters[w], motions)
    start_motion(bodies[w], body_parameters[w], gravity, islands, motions, movers)
    if joint_models is not None:
        start_joints(at(joint_states, w), at(joint_parameters, w))
    kinematic = any_kinematic(bodies[w], body_models, body_parameters[w])
    pull = norm(vec(gravity))
    error = 0.0
    load = 0.0
    size = 0.0
    for i in range(island_count):
        island = islands[i]
        if island.awake == 0:
            continue
        body_list = island_bodies[island.body_first : island.body_first + island.body_count]
        e, q, r = step_island(
            options,
            state,
            body_models,
            body_parameters[w],
            joint_models,
            at(joint_parameters, w),
            at(constraint_rows, w),
            bodies[w],
            contacts[w],
            at(joint_states, w),
            motions,
            movers,
            rows,
            body_list,
            island_contacts[island.contact_first : island.contact_first + island.contact_count],
            island_joints[island.joint_first : island.joint_first + island.joint_count],
            factor,
            edges,
            blocks,
            tree,
            tree_blocks,
            pull,
            bouncy,
            soft,
            newton,
            island.awake,
            kinematic,
        )
        # a body that touches nothing floats on, however slowly
        restless = island.awake != AWAKE or island.contact_count + island.joint_count == 0
        error += e
        load += q
        size += r
        state.island_count += 1
        state.awake_count += island.body_count
        update_sleep(body_list, bodies[w], body_parameters[w], motions, options, restless)
    state.natural_residual = (error / max(load, size)) ** 0.5 if error > 0.0 else 0.0
    if kinematic:
        move_kinematic(bodies[w], body_models, body_parameters[w], motions, dt)
    if fast_start is not None:
        sweep_fast_bodies(
            bodies[w],
            body_models,
            body_parameters[w],
            shape_models,
            shape_parameters[w],
            at(vertices, w),
            geometry,
            exclusions,
            fast_start,
            motions,
            dt,
            manifold,
            clip,
            field,
            convex,
        )
    if joint_models is not None:
        release_disabled(bodies[w], body_parameters[w], motions)
    clear_forces(bodies[w])
    state.step += 1
    return OK, 0


@njit
def step_worlds(
    first: Any,
    last: Any,
    until: Any,
    options: Any,
    body_models: Any,
    shape_models: Any,
    joint_models: Any,
    actuators: Any,
    exclusions: Any,
    world_parameters: Any,
    body_parameters: Any,
    shape_parameters: Any,
    joint_parameters: Any,
    constraint_rows: Any,
    vertices: Any,
    world_states: Any,
    bodies: Any,
    contacts: Any,
    joint_states: Any,
    control: Any,
    bouncy: Any,
    soft: Any,
    newton: Any,
    geometry: Any,
    pairs: Any,
    found: Any,
    displaced: Any,
    motions: Any,
    movers: Any,
    islands: Any,
    island_bodies: Any,
    island_contacts: Any,
    island_joints: Any,
    rows: Any,
    broadphase: Any,
    fast_start: Any,
    factor: Any,
    edges: Any,
    blocks: Any,
    tree: Any,
    tree_blocks: Any,
    manifold: Any,
    clip: Any,
    field: Any,
    convex: Any,
) -> Any:
    """Step worlds first..last-1 until each has taken ``until[w]`` steps.

    Returns (status, needed): OK, or which buffer is too small for the next step of a world and how
    many entries it needs.  That step has then changed nothing; call again with larger buffers.
    The arrays up to ``control`` are (world, item); the rest is scratch for one world at a time.
    Arguments that a scene has no use for are None, and nothing behind them is compiled.
    """
    for w in range(first, last):
        while world_states[w].step < until[w]:
            status, needed = step_world(
                w,
                options[0],
                body_models,
                shape_models,
                joint_models,
                actuators,
                exclusions,
                world_parameters,
                body_parameters,
                shape_parameters,
                joint_parameters,
                constraint_rows,
                vertices,
                world_states,
                bodies,
                contacts,
                joint_states,
                control,
                bouncy,
                soft,
                newton,
                geometry,
                pairs,
                found,
                displaced,
                motions,
                movers,
                islands,
                island_bodies,
                island_contacts,
                island_joints,
                rows,
                broadphase,
                fast_start,
                factor,
                edges,
                blocks,
                tree,
                tree_blocks,
                manifold,
                clip,
                field,
                convex,
            )
            if status != OK:
                return status, needed
    return OK, 0
