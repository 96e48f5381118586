"""The substeps of one island, stage by stage: rows, impacts, solve, positions.

``joints`` is None in a scene without joints; ``joint_factor`` is None in a scene whose joints need no factor.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..methods import solve_rows
from ..methods.cholesky import forget_factor
from ..methods.joint_factor import factorise_equations
from ..methods.soft import keep_pseudo_velocities, solve_biased
from ..records.options import SolverKind
from .activity import AWAKE, KINEMATIC_CONTACT
from .articulation.step import step_articulated
from .contact_rows import (
    add_contact_rows,
    any_restitution,
    forget_contact_impulses,
    refresh_contact_rows,
    start_contact_impulses,
    store_contact_impulses,
)
from .dispatch import by_dimension, never, nothing
from .energy import (
    apply_warm_start,
    clear_equation_biases,
    gains_energy,
    guard_energy,
    is_self_stressed,
    limit_squeeze,
    natural_residual,
)
from .impacts import resolve_impacts, set_constrained_accelerations
from .integrate import copy_velocities, integrate_positions, integrate_velocities, keep_velocities, move_kinematic
from .joint_closing import close_joints
from .joints import (
    add_joint_rows,
    any_driven,
    any_equation,
    clear_totals,
    count_joint_rows,
    forget_joint_impulses,
    move_targets,
    slow_swings,
    store_joint_impulses,
    substeps_for,
)
from .landings import MAX_PARTS, NONE, end_landing, may_land, next_landing
from .position_pass import correct_positions, smooth_fraction
from .sleep import all_calm
from .slices import part
from .springs import any_sprung, guard_springs, release_springs
from .step_energy import guard_step_energy, start_step_energy

rotate_contact_rows = by_dimension("contact_rows", "rotate_contact_rows", otherwise=nothing)
enter_frames = by_dimension("rotation", "enter_frames", otherwise=nothing)
leave_frames = by_dimension("rotation", "leave_frames", otherwise=nothing)
any_rotated_frame = by_dimension("rotation", "any_rotated_frame", otherwise=never)
flies_freely = by_dimension("rotation", "flies_freely", otherwise=never)
has_single_pivot = by_dimension("single_pivot", "has_single_pivot", otherwise=never)
swing_about_pivot = by_dimension("single_pivot", "swing_about_pivot", otherwise=nothing)
set_gyroscopic_biases = by_dimension("joints.gyroscopic", "set_gyroscopic_biases", otherwise=nothing)
set_gyroscopic_errors = by_dimension("joints.gyroscopic", "set_gyroscopic_errors", otherwise=nothing)

SUBSPACE = int(SolverKind.SUBSPACE)
SHORT = 0.25  # of a substep: impulses of shorter parts are not stored
CONTRADICTED = 0.1  # residual above which the rows contradict each other; their impulses would grow in each step


@njit
def step_island(world: Any, island: Any, joints: Any, joint_factor: Any) -> None:
    """Advance the bodies of one island by one timestep."""
    island.error_sum = 0.0
    island.velocity_sum = 0.0
    island.impulse_sum = 0.0
    island.stopped = False
    if step_exactly(world, island, joint_factor):
        return
    if step_articulated(world, island, joints, world.scratch.articulation):
        return
    start_island(world, island, joints, joint_factor)
    for s in range(island.substeps):
        take_substep(world, island, s, joints, joint_factor)
    guard_step_energy(world, island, joints)


@njit
def step_exactly(world: Any, island: Any, joint_factor: Any) -> Any:
    """Step an island that is one body on one ball joint, without rows; False for any other island."""
    if joint_factor is None:
        return False
    if not has_single_pivot(world, island):
        return False
    swing_about_pivot(world, island)
    return True


@njit
def start_island(world: Any, island: Any, joints: Any, joint_factor: Any) -> None:
    """Set the number of substeps of the island and what is constant over them."""
    options = world.options
    island.substeps = options.substeps
    island.driven = island.activity != AWAKE
    island.has_springs = False
    island.slowed = False
    island.joint_rows = 0
    island.residual = 0.0
    start_island_joints(world, island, joints, joint_factor)
    start_step_energy(world, island, joints)
    island.has_restitution = any_restitution(world, island)
    island.calm = rests_undriven(world, island)
    if island.calm or flies_freely(world, island):
        island.substeps = 1
    island.h = options.timestep / island.substeps
    island.stored_scale = island.substeps / options.substeps
    island.warm_start = options.warm_start / island.stored_scale
    enter_frames(world, island)
    island.rows = add_contact_rows(world, island)
    island.rotated_frame = any_rotated_frame(world, island)
    island.may_land = world.variant.soft is None and may_land(world, island, joint_factor)
    world.state.world.row_count += island.rows


@njit
def rests_undriven(world: Any, island: Any) -> Any:
    """Whether the bodies of the island rest on each other, without joints or drives; then one substep is enough.

    A body at the end of its bounces may be as slow, but longer substeps would make its last bounce later.
    """
    if island.driven or island.joint_count > 0 or island.has_restitution or world.options.solver != SUBSPACE:
        return False
    return all_calm(world, island)


@njit
def start_island_joints(world: Any, island: Any, joints: Any, joint_factor: Any) -> None:
    """Set the number of joint rows and what follows from the joints: driven, has_springs, the number of substeps."""
    if joints is None:
        return
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    island.joint_rows = count_joint_rows(island_joints, joint_models, joint_parameters)
    island.driven = island.driven or any_driven(island_joints, joint_models, joint_parameters)
    island.has_springs = any_sprung(island_joints, joint_parameters)
    if joint_factor is not None:
        if joint_factor.plan.used:
            island.substeps = substeps_for(world, island, joints)
            slow_swings(world, island, joints)
    clear_totals(island_joints, joints)


@njit
def take_substep(world: Any, island: Any, s: Any, joints: Any, joint_factor: Any) -> None:
    """Take substep number ``s`` of the island, in parts where a body lands within it."""
    last = s == island.substeps - 1
    island.time = s * island.h
    island.end = (s + 1) * island.h
    move_surroundings(world, island, s > 0)
    if s > 0 or not island.calm:
        refresh_contact_rows(world, island)
    if island.may_land:
        take_parts(world, island, last, joints, joint_factor)
    else:
        substep(world, island, last, joints, joint_factor)


@njit
def take_parts(world: Any, island: Any, last: Any, joints: Any, joint_factor: Any) -> None:
    """Take a substep in parts between landings, or as one if there are none."""
    end = island.end
    stored_scale = island.stored_scale
    warm_start = island.warm_start
    island.whole = island.h
    landing = NONE
    for count in range(MAX_PARTS):
        landing = next_landing(world, island, joints, joint_factor) if count < MAX_PARTS - 1 else NONE
        if landing <= 0.0:
            break
        left = island.h - landing
        leave_frames(world, island)
        start_part(world, island, landing, stored_scale, warm_start)
        island.end = island.time + landing
        substep(world, island, False, joints, joint_factor)
        end_landing(world, island)
        island.time = island.end
        island.end = end
        start_part(world, island, left, stored_scale, warm_start)
    if landing == 0.0:
        island.stored_scale = 0.0  # do not store the impulses of the impact
        refresh_contact_rows(world, island)
    substep(world, island, last, joints, joint_factor)
    if landing == 0.0:
        end_landing(world, island)
    if island.h != island.whole:
        island.h = island.whole
        island.stored_scale = stored_scale
        island.warm_start = warm_start
        start_contact_impulses(world, island, 1.0 / stored_scale)


@njit
def start_part(world: Any, island: Any, h: Any, stored_scale: Any, warm_start: Any) -> None:
    """Start a part of length ``h`` of the substep; the impulses of a short part are not stored, for they vary much."""
    share = h / island.whole
    island.h = h
    island.stored_scale = stored_scale / share if share > SHORT else 0.0
    island.warm_start = warm_start * share
    move_surroundings(world, island, True)
    start_contact_impulses(world, island, share / stored_scale)
    refresh_contact_rows(world, island)


@njit
def substep(world: Any, island: Any, last: Any, joints: Any, joint_factor: Any) -> None:
    """Take a substep of the island, or a part of one; ``last``: with it the step ends."""
    variant = world.variant
    clear_factor(joint_factor)
    impact_phase(world, island, joints, joint_factor, variant.restitution)
    integrate_velocities(world, island)
    add_joint_rows(world, island, joints, joint_factor, island.warm_start)
    factorise_joints(world, island, joint_factor, variant.soft)
    island.residual_scale = apply_warm_start(world, island)
    add_gyroscopic_biases(world, island, joint_factor)
    if island.rows > 0:
        solve(world, island, joint_factor, variant.soft, variant.newton)
        if last:
            island.error_sum, island.velocity_sum, island.impulse_sum = natural_residual(world, island)
    island.smooth = smooth_fraction(world, island)
    if island.rows > 0:
        position_phase(world, island, joint_factor, variant.soft)
    integrate_positions(world, island)
    forget_joint_factor(world, island, joint_factor)
    store_joints(world, island, joints)
    close_joints(world, island, joints, joint_factor)
    store_contacts(world, island, last)


@njit
def clear_factor(joint_factor: Any) -> None:
    """Mark the joint factor as not computed."""
    if joint_factor is not None:
        joint_factor.plan.size = 0


@njit
def move_surroundings(world: Any, island: Any, moved: Any) -> None:
    """Move kinematic bodies to the present time, and the frames of bodies that have ``moved`` since."""
    if island.kinematic:
        move_kinematic(world, island.time)
    if moved:
        enter_frames(world, island)
        if island.rotated_frame:
            rotate_contact_rows(world, island)


@njit
def impact_phase(world: Any, island: Any, joints: Any, joint_factor: Any, restitution: Any) -> None:
    """Resolve impacts before the solve; ``restitution`` is None in a scene without restitution."""
    if restitution is None:
        return
    if not island.has_restitution:
        return
    factorise_for_impacts(world, island, joints, joint_factor)
    world.state.world.impacts += resolve_impacts(world, island, joint_factor)
    forget_joint_factor(world, island, joint_factor)
    refresh_contact_rows(world, island)


@njit
def factorise_for_impacts(world: Any, island: Any, joints: Any, joint_factor: Any) -> None:
    """Factorise the joints, through which impacts propagate, and set the accelerations of their bodies."""
    if joint_factor is None:
        return
    if island.joint_rows == 0 or not joint_factor.plan.used:
        return
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    keep_velocities(island_bodies, world.state.bodies, world.scratch.substep_bodies)
    add_joint_rows(world, island, joints, joint_factor, 0.0)
    release_springs(world.scratch.rows, island.joint_rows, len(joints[0].impulse) - 1)  # rotors have the last slot
    factorise_joints(world, island, joint_factor, None)
    set_constrained_accelerations(world, island, joint_factor)


@njit
def factorise_joints(world: Any, island: Any, joint_factor: Any, soft: Any) -> None:
    """Factorise the equations of the joints; the soft method, ``soft`` not None, uses sweeps alone."""
    if joint_factor is None:
        return
    if not joint_factor.plan.used:
        return
    if soft is None:
        rows = world.scratch.rows
        substep_bodies = world.scratch.substep_bodies
        island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
        entries = joint_factor.entries
        end = island.joint_rows
        joint_factor.plan.row_end = end
        joint_factor.plan.size = factorise_equations(
            rows, end, island_bodies, substep_bodies, entries, joint_factor.graph, joint_factor.blocks
        )


@njit
def forget_joint_factor(world: Any, island: Any, joint_factor: Any) -> None:
    """Remove the bodies of the island from the factor."""
    if joint_factor is not None:
        island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
        forget_factor(island_bodies, joint_factor.entries)


@njit
def add_gyroscopic_biases(world: Any, island: Any, joint_factor: Any) -> None:
    """Set the gyroscopic biases of the joint rows of 3D bodies with a rotated frame."""
    if joint_factor is not None:
        if island.rotated_frame and joint_factor.plan.used:
            set_gyroscopic_biases(world, island)


@njit
def add_gyroscopic_errors(world: Any, island: Any, joint_factor: Any) -> None:
    """Set the position errors that these rows will have at the end of the substep."""
    if joint_factor is not None:
        if island.rotated_frame and island.smooth > 0.0 and joint_factor.plan.used:
            set_gyroscopic_errors(world, island)


@njit
def solve(world: Any, island: Any, joint_factor: Any, soft: Any, newton: Any) -> None:
    """Make all rows true, and guard the energy of what did not converge."""
    counters = world.state.world
    rows = world.scratch.rows
    tolerance = world.options.tolerance
    if soft is not None:
        clear_factor(joint_factor)
        counters.sweeps += solve_biased(world, island)
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    jointed = any_equation(rows, island.joint_rows)
    passive = not island.driven and not island.has_springs
    residual = 0.0
    converged = True
    for attempt in range(2):
        island.stopped = False
        sweeps, residual = solve_rows(world, island, joint_factor, soft, newton)
        copy_velocities(island_bodies, world.state.bodies, world.scratch.solver_bodies)
        counters.sweeps += sweeps
        converged = residual <= tolerance  # NaN is not
        if attempt > 0 or not passive or not jointed or not converged:
            break
        if not gains_energy(world, island):
            break
        clear_equation_biases(rows, island.joint_rows)
    island.residual = residual
    counters.residual = max(counters.residual, residual)
    if not converged:
        counters.unconverged += 1
    # converged joints of rotating bodies change the energy to third order only: the guard must not act on that
    if passive and (not converged or not jointed):
        guard_energy(world, island, not converged and not jointed)
    if island.activity == KINEMATIC_CONTACT and not converged and island.joint_rows == 0:
        limit_squeeze(world, island)
    guard_unfinished_springs(world, island, joint_factor)


@njit
def guard_unfinished_springs(world: Any, island: Any, joint_factor: Any) -> None:
    """Limit the energy that an unfinished solve may have added where there are springs.

    Not where the rigid joints and stiff springs have no factor: their response to contacts is then unknown.
    """
    if joint_factor is not None:
        unfinished = not island.residual <= world.options.tolerance
        if island.has_springs and not island.driven and unfinished:
            if joint_factor.plan.size > 0 or not any_equation(world.scratch.rows, island.joint_rows):
                guard_springs(world, island, joint_factor)


@njit
def position_phase(world: Any, island: Any, joint_factor: Any, soft: Any) -> None:
    """Compute the pseudo-velocities that correct position errors; ``soft`` has them from its first solve."""
    if soft is not None:
        keep_pseudo_velocities(world, island)
    else:
        add_gyroscopic_errors(world, island, joint_factor)
        correct_positions(world, island, joint_factor)


@njit
def store_joints(world: Any, island: Any, joints: Any) -> None:
    """Store the impulses of joints that the next substep or step starts from, and move the targets."""
    if joints is None:
        return
    store_joint_impulses(world, island, joints)
    if not island.residual <= CONTRADICTED or is_self_stressed(world, island):  # NaN, too
        forget_joint_impulses(world.scratch.rows, island.joint_rows, joints)
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    move_targets(island_joints, world.model.joints, joints, island.h)


@njit
def store_contacts(world: Any, island: Any, last: Any) -> None:
    """Store the impulses of contacts that the next substep or step starts from."""
    store_contact_impulses(world, island, last)
    if island.activity == KINEMATIC_CONTACT and not island.residual <= world.options.tolerance:
        forget_contact_impulses(world, island)
