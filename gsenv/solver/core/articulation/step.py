"""The substeps of an island in joint coordinates, stage by stage."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ..contact_rows import (
    add_contact_rows,
    any_restitution,
    forget_contact_impulses,
    refresh_contact_rows,
    store_contact_impulses,
)
from ..dispatch import by_dimension, nothing
from ..energy import natural_residual
from ..integrate import move_kinematic
from ..islands import AWAKE, KINEMATIC_CONTACT
from ..joints import any_driven, clear_totals
from ..position_pass import smooth_fraction
from ..slices import part
from ..springs import any_sprung
from .balance import limit_speed, settle_rates
from .dynamics import PASSES, factorise_links, respond_outward, set_free_rates, set_middle
from .links import list_links, measure_motion, move_links, place_links, set_base, substeps_of_links
from .reactions import add_contact_impulses, keep_momenta, store_reactions
from .rows import whiten_rows
from .runge_kutta import swing, swings
from .servos import add_servo_rows, count_servo_rows, keep_coordinates, store_servo_impulses
from .solve import correct_overlaps, limit_energy, start_solve, sweep_rows
from .tension import is_taut, set_tension

leave_link = by_dimension("articulation", "leave_link")
enter_link = by_dimension("articulation", "enter_link")
keep_world_frames = by_dimension("articulation", "keep_world_frames", otherwise=nothing)

SLOW_TURN = 0.03  # rad in a substep: slower links need no balance of momentum where rows act
PARTS = 8  # of a substep whose rates do not settle


@njit
def step_articulated(world: Any, island: Any, joints: Any, articulation: Any) -> Any:
    """Advance the island by one timestep in joint coordinates; False where it needs the rows of its joints.

    ``articulation`` is None unless the option is set and the scene has joints that can be in trees.
    """
    if articulation is None:
        return False
    if world.variant.soft is not None:
        return False
    if world.variant.restitution is not None:
        if any_restitution(world, island):
            return False
    if not list_links(world, island, articulation):
        return False
    measure_motion(world, island, joints, articulation)
    island.taut = 0
    island.substeps = substeps_of_links(world, island)
    if swings(world, island, articulation):
        island.substeps = world.options.substeps
        if not is_taut(world, island):
            _start(world, island, joints, articulation)
            swing(world, island, joints, articulation)
            return True
        island.taut = 1
    if island.substeps == 0:
        return False
    _start(world, island, joints, articulation)
    for s in range(island.substeps):
        _substep(world, island, s, joints, articulation)
    return True


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
    island.joint_rows = count_servo_rows(world, island, articulation)
    island.rows = add_contact_rows(world, island)
    world.state.world.row_count += island.rows


@njit
def _substep(world: Any, island: Any, s: Any, joints: Any, articulation: Any) -> None:
    """Take substep number ``s`` of the island."""
    last = s == island.substeps - 1
    if island.kinematic:
        move_kinematic(world, s * island.h)
    if s > 0:
        _continue(island, articulation)
    refresh_contact_rows(world, island)
    _enter_middle(world, island, joints, articulation)
    fast = island.turning > SLOW_TURN
    set_free_rates(world, island, articulation, 1 if island.rows == 0 or fast else PASSES)
    if island.rows > 0 and fast:
        _settle_free_rates(world, island, articulation)
    touched = False
    if island.rows > 0:
        touched = _solve(world, island, articulation, last)
    if touched:
        place_links(world, island, articulation)
        move_links(island, articulation, articulation.rate)
    elif not settle_rates(world, island, articulation):
        _divide(world, island, joints, articulation)
    _leave(world, island, articulation)
    _store(world, island, last, joints, articulation)


@njit
def _settle_free_rates(world: Any, island: Any, articulation: Any) -> None:
    """Take the rates that the links would have without rows as those from which the rows start."""
    settle_rates(world, island, articulation)
    for f in range(island.freedoms):
        articulation.free[f] = articulation.rate[f]
        articulation.step[f] = 0.0
    place_links(world, island, articulation)


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
    keep_coordinates(world, island, articulation, joints)
    for f in range(island.freedoms):
        articulation.step[f] = 0.5 * island.h * start[f]
    place_links(world, island, articulation)
    set_middle(world, island, articulation)
    move_links(island, articulation, start)
    _keep_start_velocities(world, island, articulation)
    if island.taut:
        set_tension(world, island, articulation, joints)
    if island.servos:
        add_servo_rows(world, island, articulation, joints)
    factorise_links(articulation.links, island.body_count, articulation.freedoms)


@njit
def _divide(world: Any, island: Any, joints: Any, articulation: Any) -> None:
    """Take a substep whose rates did not settle again, in parts; leaves the last part to the caller.

    Motors and limits, whose rows are those of the whole substep, exclude this.
    """
    if island.joint_rows > 0:
        limit_speed(world, island, articulation)
        return
    links = articulation.links
    bodies = world.state.bodies
    whole = island.h
    add_contact_impulses(world, island, articulation)
    for k in range(island.body_count):
        enter_link(links[k], bodies[links[k].body])
        links[k].coordinate = links[k].begin
        set_base(links[k])
    for f in range(island.freedoms):
        articulation.step[f] = 0.0
    place_links(world, island, articulation)
    move_links(island, articulation, articulation.start)
    island.h = whole / PARTS
    for part_number in range(PARTS):
        if part_number > 0:
            _leave(world, island, articulation)
            store_reactions(world, island, articulation, joints)
            _continue(island, articulation)
        _enter_middle(world, island, joints, articulation)
        set_free_rates(world, island, articulation, 1)
        if not settle_rates(world, island, articulation):
            limit_speed(world, island, articulation)
    island.h = whole


@njit
def _keep_start_velocities(world: Any, island: Any, articulation: Any) -> None:
    links = articulation.links
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        velocity = substep_bodies[links[k].body].start_velocity
        for d in range(len(velocity)):
            velocity[d] = links[k].velocity[d]


@njit
def _solve(world: Any, island: Any, articulation: Any, last: Any) -> Any:
    """Make all rows true; sets ``rate`` to the new rates and ``step`` to the displacement that is left.

    Returns whether any row had to act.
    """
    rate = articulation.rate
    step = articulation.step
    start = articulation.start
    change = articulation.change
    h = island.h
    corrected = _solve_rows(world, island, articulation, last)
    for f in range(island.freedoms):
        step[f] = h * (rate[f] + 0.5 * island.smooth * (start[f] - rate[f]) - 0.5 * start[f])
        if corrected:
            step[f] += h * change[f]
    rows = world.scratch.rows
    for r in range(island.rows):
        if rows[r].impulse != 0.0:
            return True
    return corrected


@njit
def _solve_rows(world: Any, island: Any, articulation: Any, last: Any) -> Any:
    """Solve the rows; sets ``rate``, and ``change`` to the pseudo-rates of the position pass if it returns True."""
    rate = articulation.rate
    free = articulation.free
    change = articulation.change
    counters = world.state.world
    move_links(island, articulation, free)
    _keep_free_velocities(world, island, articulation)
    whiten_rows(world, island, articulation)
    island.residual_scale = start_solve(world, island, articulation)
    sweeps, residual = sweep_rows(world, island, articulation)
    counters.sweeps += sweeps
    island.residual = residual
    counters.residual = max(counters.residual, residual)
    if residual > world.options.tolerance:
        counters.unconverged += 1
        if not island.driven and not island.has_springs:
            limit_energy(world, island, articulation)
    _change_rates(island, articulation)
    for f in range(island.freedoms):
        rate[f] = free[f] + change[f]
    move_links(island, articulation, rate)
    _keep_velocities(world, island, articulation)
    if last:
        island.error_sum, island.velocity_sum, island.impulse_sum = natural_residual(world, island)
    island.smooth = smooth_fraction(world, island)
    if correct_overlaps(world, island, articulation):
        _change_rates(island, articulation)
        return True
    return False


@njit
def _change_rates(island: Any, articulation: Any) -> None:
    """Set ``change`` to the change of the rates that the whitened rates mean."""
    freedoms = articulation.freedoms
    change = articulation.change
    z = articulation.whitened
    for f in range(island.freedoms):
        change[f] = z[f] * freedoms[f].root
    respond_outward(articulation.links, island.body_count, freedoms, change)


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
def _leave(world: Any, island: Any, articulation: Any) -> None:
    """Move the bodies to their links at the end of the substep."""
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
    add_contact_impulses(world, island, articulation)
    store_reactions(world, island, articulation, joints)
    store_contact_impulses(world, island, last)
    if island.activity == KINEMATIC_CONTACT and island.residual > world.options.tolerance:
        forget_contact_impulses(world, island)
    if island.servos:
        store_servo_impulses(world, island, articulation, joints)
