"""The substeps of an island in joint coordinates, stage by stage."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ...jit import njit
from ..activity import AWAKE, KINEMATIC_CONTACT
from ..contact_rows import (
    add_contact_rows,
    forget_contact_impulses,
    refresh_contact_rows,
    store_contact_impulses,
)
from ..dispatch import by_dimension, nothing
from ..energy import natural_residual, set_free_rates_of_rows
from ..impacts import expects_impact
from ..integrate import move_kinematic
from ..joints import any_driven, clear_totals
from ..slices import part
from ..springs import any_sprung
from .balance import restore_momenta, restore_paths_of_rows, settle_rates
from .closing import close_others
from .contact_balance import change_of_rows, correct_forces, end_with_rows, rates_of_rows, settle_rows
from .dynamics import factorise_links, set_free_rates, set_middle
from .energy import UNEVEN_TURN, keep_energy, lose_energy, stored_energy
from .equations import (
    clear_biases,
    contradiction,
    factorise_equations,
    is_apart,
    only_closes,
    smooth_with_others,
)
from .joining import join_velocities
from .links import (
    has_chain,
    largest_share,
    largest_turn,
    list_links,
    measure_motion,
    move_links,
    place_links,
    set_base,
    substeps_of_links,
)
from .other_joints import (
    CONTRADICTED,
    keep_other_velocities,
    store_other_impulses,
    substeps_of_others,
    write_other_rows,
)
from .reactions import add_impulses, keep_momenta, store_reactions
from .rows import whiten_rows
from .runge_kutta import swing, swings
from .servos import (
    add_joint_forces,
    add_servo_rows,
    any_row_acts,
    keep_coordinates,
    list_servos,
    reach_limits,
    store_servo_impulses,
    turn_limits,
)
from .solve import add_all_impulses, correct_overlaps, limit_energy, start_solve, sweep_rows
from .tension import damp_taut_joints, is_taut, set_tension

leave_link = by_dimension("articulation", "leave_link")
enter_link = by_dimension("articulation", "enter_link")
enter_joint = by_dimension("articulation", "enter_joint")
keep_world_frames = by_dimension("articulation", "keep_world_frames", otherwise=nothing)

SLOW_TURN = 0.004  # rad in a substep: slower links need no balance of momentum where rows act,
STILL_TURN = 1e-5  # and these not even the forces at their new rates
FAST_TURN = 0.3  # rad in a step: chains of trees whose links turn faster stay in joint coordinates
TAUT_GAIN = 1e-4  # of the kinetic energy: larger gains in a substep with implicit tension are no rounding
REST = 2  # value of ``taut`` in the rest of a step whose links swing too fast
PARTS = 8  # of a substep whose rates do not settle


@njit
def step_articulated(world: Any, island: Any, joints: Any, articulation: Any) -> Any:
    """Advance the island by one timestep in joint coordinates; False where it needs the rows of its joints.

    ``articulation`` is None unless the option is set and the scene has joints that can be in trees; in the kernel of
    all scenes it has no links instead.
    """
    if articulation is None:
        return False
    if len(articulation.links) == 0:
        return False
    if world.variant.soft is not None:
        return False
    if not list_links(world, island, articulation):
        return False
    measure_motion(world, island, joints, articulation)
    if island.spin * world.options.timestep < FAST_TURN and has_chain(world, island, articulation):
        return False
    island.taut = 0
    island.substeps = substeps_of_links(world, island)
    if swings(world, island, joints, articulation):
        island.substeps = world.options.substeps
        if not is_taut(world, island):
            _start(world, island, joints, articulation)
            left = swing(world, island, joints, articulation)
            if left > 0.0:
                _end_swing(world, island, left, joints, articulation)
            return True
        island.taut = 1
    elif island.substeps > 0:
        island.substeps = substeps_of_others(world, island, joints, articulation.others)
    if island.substeps == 0:
        return False
    _start(world, island, joints, articulation)
    if world.variant.restitution is not None:
        if expects_impact(world, island):  # bounces propagate through the rows of joints
            world.state.world.row_count -= island.rows
            return False
    for s in range(island.substeps):
        if not _substep(world, island, s, joints, articulation):
            world.state.world.row_count -= island.rows
            return False
    return True


@njit
def _end_swing(world: Any, island: Any, left: Any, joints: Any, articulation: Any) -> None:
    """Take the last ``left`` s of a step, where links swing too fast for the shortest ones, with implicit tension.

    The substeps are about as long as the usual ones: in many short ones the tensions, those of the last, fluctuate.
    """
    options = world.options
    measure_motion(world, island, joints, articulation)
    island.taut = REST
    island.substeps = int(np.ceil(0.999 * left * options.substeps / options.timestep))
    island.h = left / island.substeps
    island.turning = island.h * island.spin
    island.stored_scale = options.timestep / (options.substeps * island.h)
    island.warm_start = options.warm_start / island.stored_scale
    for s in range(island.substeps):
        _substep(world, island, s, joints, articulation)


@njit
def _start(world: Any, island: Any, joints: Any, articulation: Any) -> None:
    """Set what is constant over the substeps, and write the contact rows."""
    options = world.options
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    island.driven = island.activity != AWAKE or any_driven(island_joints, joint_models, joint_parameters)
    island.has_springs = any_sprung(island_joints, joint_parameters)
    island.h = options.timestep / island.substeps
    island.stored_scale = island.substeps / options.substeps
    island.warm_start = options.warm_start / island.stored_scale
    island.residual = 0.0
    clear_totals(island_joints, joints)
    keep_world_frames(world, island)
    island.joint_rows = island.other_rows + list_servos(world, island, articulation, joints)
    island.rows = add_contact_rows(world, island)
    world.state.world.row_count += island.rows
    join_velocities(world, island, articulation, joints)


@njit
def _substep(world: Any, island: Any, s: Any, joints: Any, articulation: Any) -> Any:
    """Take substep number ``s`` of the island; False where joints in no tree cannot hold; no body has moved then."""
    last = s == island.substeps - 1
    if island.kinematic:
        move_kinematic(world, s * island.h)
    if s > 0:
        _continue(island, articulation)
    refresh_contact_rows(world, island)
    _enter_middle(world, island, joints, articulation)
    settled = _find_rates(world, island, last, joints, articulation)
    if not settled and _can_divide(island):
        return _divide(world, island, s, joints, articulation)
    if s == 0 and island.apart:
        _return_to_start(world, island, articulation)
        return False
    _finish(world, island, (s + 1) * island.h, last, settled, joints, articulation)
    return True


@njit
def _find_rates(world: Any, island: Any, last: Any, joints: Any, articulation: Any) -> Any:
    """Find the rates at the end of the substep, and place the links there; returns whether they settled."""
    fast = island.turning > SLOW_TURN
    set_free_rates(world, island, articulation)
    turn = 0.0
    island.touched = False
    island.apart = False
    reach_limits(world, island, articulation, articulation.free)
    if any_row_acts(island, articulation):
        _solve_rows(world, island, articulation, last)
        turn = SLOW_TURN if fast else largest_turn(world, island, articulation)
        island.touched = _correct(world, island, articulation)
        if island.other_rows > 0:
            island.apart = not island.residual <= CONTRADICTED or is_apart(world, island, articulation.others)
    elif island.rows > 0:
        add_servo_rows(world, island, articulation, joints)
    if not island.touched:
        return settle_rates(world, island, articulation)
    if not fast and turn <= SLOW_TURN:
        if turn > STILL_TURN:
            correct_forces(world, island, articulation)
        end_with_rows(world, island, articulation)
        return not island.apart
    if not settle_rows(world, island, articulation):
        return False
    if not only_closes(world, island, articulation.others):
        return not island.apart
    if island.smooth == 1.0:
        keep_energy(world, island, articulation, 0.0)
    return island.smooth == 1.0 and not island.apart  # loops make velocities jump in too long a substep only


@njit
def _finish(world: Any, island: Any, end: Any, last: Any, settled: Any, joints: Any, articulation: Any) -> None:
    """Move the bodies to their links at the end of the substep, ``end`` s into the step; store impulses, close loops.

    ``last``: whether the step ends there.
    """
    if island.touched and island.share > 0.0 and (island.other_rows > 0 or island.share < 1.0):
        restore_paths_of_rows(world, island, articulation)
    add_impulses(world, island, articulation, island.joint_rows)
    _leave(world, island, articulation, not settled)
    _store(world, island, last, joints, articulation)
    close_others(world, island, end, joints, articulation, articulation.others)


@njit
def _continue(island: Any, articulation: Any) -> None:
    """Start from the rates of the last substep."""
    for f in range(island.freedoms):
        articulation.start[f] = articulation.rate[f]


@njit
def _enter_middle(world: Any, island: Any, joints: Any, articulation: Any) -> None:
    """Move the links by half a substep with the old rates, and factorise their inertias there."""
    start = articulation.start
    keep_momenta(world, island, articulation)
    keep_other_velocities(world, island, articulation, articulation.others)
    keep_coordinates(world, island, articulation, joints)
    for f in range(island.freedoms):
        articulation.step[f] = 0.5 * island.h * start[f]
    place_links(world, island, articulation)
    set_middle(world, island, articulation)
    move_links(island, articulation, start)
    _keep_start_velocities(world, island, articulation)
    write_other_rows(world, island, joints, articulation.others)
    if island.taut:
        set_tension(world, island, articulation, joints)
        if island.taut == REST:
            damp_taut_joints(island, articulation)
    if island.servos:
        add_joint_forces(world, island, articulation, joints)
    factorise_links(articulation.links, island.body_count, articulation.freedoms)


@njit
def _can_divide(island: Any) -> Any:
    """Whether a substep can be taken again in parts: no contact acts, whose rows are those of the whole substep."""
    return island.rows == island.joint_rows or not island.touched


@njit
def _divide(world: Any, island: Any, s: Any, joints: Any, articulation: Any) -> Any:
    """Take a substep whose rates did not settle again, in parts; False as for ``_substep``."""
    last = s == island.substeps - 1
    whole, stored_scale, warm_start = island.h, island.stored_scale, island.warm_start
    island.h = whole / PARTS
    island.stored_scale = stored_scale * PARTS
    island.warm_start = warm_start / PARTS
    _place_at_start(world, island, articulation)
    for part_number in range(PARTS):
        if part_number > 0:
            _continue(island, articulation)
        if island.kinematic:
            move_kinematic(world, s * whole + part_number * island.h)
        refresh_contact_rows(world, island)
        _enter_middle(world, island, joints, articulation)
        settled = _find_rates(world, island, last, joints, articulation)
        if s == 0 and part_number == 0 and island.apart:
            island.h, island.stored_scale, island.warm_start = whole, stored_scale, warm_start
            _return_to_start(world, island, articulation)
            return False
        end = s * whole + (part_number + 1) * island.h
        _finish(world, island, end, last, settled, joints, articulation)
    island.h, island.stored_scale, island.warm_start = whole, stored_scale, warm_start
    return True


@njit
def _place_at_start(world: Any, island: Any, articulation: Any) -> None:
    """Move the links back to the poses and rates at the start of the substep; the bodies have not moved yet."""
    links = articulation.links
    bodies = world.state.bodies
    joint_parameters = world.parameters.joints
    for k in range(island.body_count):
        enter_link(links[k], bodies[links[k].body])
        enter_joint(links, k, bodies, world.parameters.bodies, joint_parameters[max(links[k].joint, 0)])
        set_base(links[k])
    for f in range(island.freedoms):
        articulation.step[f] = 0.0
    place_links(world, island, articulation)
    move_links(island, articulation, articulation.start)


@njit
def _return_to_start(world: Any, island: Any, articulation: Any) -> None:
    """Give the bodies the velocities at the start of the step, for the rows of their joints to act instead."""
    _place_at_start(world, island, articulation)
    _keep_velocities(world, island, articulation)


@njit
def _keep_start_velocities(world: Any, island: Any, articulation: Any) -> None:
    links = articulation.links
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        velocity = substep_bodies[links[k].body].start_velocity
        for d in range(len(velocity)):
            velocity[d] = links[k].velocity[d]


@njit
def _correct(world: Any, island: Any, articulation: Any) -> Any:
    """Set ``shift`` to the displacement that corrects overlaps; returns whether any row had to act."""
    shift = articulation.shift
    change = articulation.change
    corrected = correct_overlaps(world, island, articulation)
    share = 0.0
    if corrected:
        change_of_rows(island, articulation)
        share = largest_share(world, island, articulation)
        add_all_impulses(world, island, articulation)
    island.share = share
    for f in range(island.freedoms):
        shift[f] = share * island.h * change[f] if corrected else 0.0
    rows = world.scratch.rows
    for r in range(island.rows):
        if rows[r].impulse != 0.0:
            return True
    return corrected


@njit
def _solve_rows(world: Any, island: Any, articulation: Any, last: Any) -> None:
    """Make all rows true at the middle of the substep; sets ``rate`` to the new rates."""
    counters = world.state.world
    move_links(island, articulation, articulation.free)
    _keep_free_velocities(world, island, articulation)
    _solve_reached(world, island, articulation)
    while _finds_limits(world, island, articulation):
        _solve_reached(world, island, articulation)
    counters.residual = max(counters.residual, island.residual)
    if not island.residual <= world.options.tolerance:  # NaN counts, too
        counters.unconverged += 1
    move_links(island, articulation, articulation.rate)
    _keep_velocities(world, island, articulation)
    if last:
        set_free_rates_of_rows(world, island)
        island.error_sum, island.velocity_sum, island.impulse_sum = natural_residual(world, island)
    island.smooth = smooth_with_others(world, island, articulation.others)


@njit
def _finds_limits(world: Any, island: Any, articulation: Any) -> Any:
    """Whether the solution pushes joints to further limits, or past the other limit than that of the row."""
    new = reach_limits(world, island, articulation, articulation.rate)
    return turn_limits(world, island, articulation) or new


@njit
def _solve_reached(world: Any, island: Any, articulation: Any) -> None:
    """Solve all rows but those of limits out of reach, and set ``rate``."""
    options = world.options
    counters = world.state.world
    if island.joint_rows > island.other_rows:
        add_servo_rows(world, island, articulation, world.state.joints)
    whiten_rows(world, island, articulation)
    factorise_equations(world, island, articulation, articulation.others)
    island.residual_scale = start_solve(world, island, articulation)
    sweeps, residual = sweep_rows(world, island, articulation, int64(options.sweeps))
    counters.sweeps += sweeps
    if residual <= options.tolerance and clear_biases(world, island, articulation, articulation.others):
        sweeps, residual = sweep_rows(world, island, articulation, int64(options.sweeps))
        counters.sweeps += sweeps
    hidden = contradiction(world, island, articulation.others)
    if hidden > CONTRADICTED:
        residual = max(residual, hidden)
    island.residual = residual
    if residual > options.tolerance and not island.driven and not island.has_springs:
        limit_energy(world, island, articulation)
    rates_of_rows(island, articulation)


@njit
def _keep_free_velocities(world: Any, island: Any, articulation: Any) -> None:
    links = articulation.links
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        velocity = substep_bodies[links[k].body].free_velocity
        for d in range(len(velocity)):
            velocity[d] = links[k].velocity[d]


@njit
def _keep_velocities(world: Any, island: Any, articulation: Any) -> None:
    links = articulation.links
    bodies = world.state.bodies
    for k in range(island.body_count):
        velocity = bodies[links[k].body].velocity
        for d in range(len(velocity)):
            velocity[d] = links[k].velocity[d]


@njit
def _leave(world: Any, island: Any, articulation: Any, held: Any) -> None:
    """Move the bodies to their links at the end of the substep; ``held``: whether their rates did not settle."""
    restore_momenta(world, island, articulation, island.h)
    if held:
        world.state.world.unconverged += 1
        stored = stored_energy(world, island, articulation) if island.has_springs else 0.0
        lose_energy(world, island, articulation, stored)
    elif island.touched and island.turning > UNEVEN_TURN and not island.has_springs:
        lose_energy(world, island, articulation, 0.0)
    elif island.taut:
        gain = 0.0 if island.taut == REST else 0.5 * TAUT_GAIN * island.kinetic
        lose_energy(world, island, articulation, gain)
    links = articulation.links
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        i = links[k].body
        set_base(links[k])
        leave_link(links[k], bodies[i], substep_bodies[i])


@njit
def _store(world: Any, island: Any, last: Any, joints: Any, articulation: Any) -> None:
    """Store impulses and reactions."""
    store_reactions(world, island, articulation, joints)
    store_other_impulses(world, island, joints, articulation.others)
    store_contact_impulses(world, island, last)
    if island.activity == KINEMATIC_CONTACT and not island.residual <= world.options.tolerance:
        forget_contact_impulses(world, island)
    if island.servos:
        store_servo_impulses(world, island, articulation, joints)
