"""All substeps of one island: rows, impacts, solve, positions. Islands are independent in a step."""

from __future__ import annotations

from typing import Any

from numba import int64

from ..islands import AWAKE, PRESSED
from ..jit import njit
from ..positions import correct_positions, smooth_fraction
from ..solvers import solve_rows
from ..solvers.cholesky import forget_factor
from ..solvers.soft import keep_push, solve_biased
from ..solvers.tree import factorise_equations
from ..springs import any_sprung, guard_springs, release_springs
from .contact_rows import (
    add_contact_rows,
    forget_impulses,
    refresh_contact_rows,
    store_contacts,
    turn_contact_rows,
)
from .energy import drop_curves, gains_energy, guard_energy, natural_residual, start_impulses
from .frames import any_tilted, enter_frames
from .impacts import resolve_impacts, set_paths
from .integrate import integrate_positions, integrate_velocities, keep_velocities, move_kinematic, take_velocities
from .joints import (
    add_joint_rows,
    any_driven,
    any_equation,
    clear_totals,
    count_joint_rows,
    forget_joint_impulses,
    store_joint_impulses,
    substeps_for,
)
from .joints.spinning import bend_spinning, drift_spinning
from .joints.target import move_targets
from .pinned import is_pinned, swing_pinned

CONTRADICTED = 0.1  # residual above which rows can't all be true: their impulses would grow in each step


@njit
def flies_freely(indices: Any, body_parameters: Any) -> Any:
    """Whether nothing slows the bodies down."""
    for k in range(len(indices)):
        parameters = body_parameters[indices[k]]
        if parameters.linear_damping != 0.0 or parameters.angular_damping != 0.0:
            return False
    return True


@njit
def bounces(contacts: Any, indices: Any) -> Any:
    for k in range(len(indices)):
        if contacts[indices[k]].restitution > 0.0:
            return True
    return False


@njit
def step_island(
    options: Any,
    world_state: Any,
    body_models: Any,
    body_parameters: Any,
    joint_models: Any,
    joint_parameters: Any,
    constraint_rows: Any,
    bodies: Any,
    contacts: Any,
    joint_states: Any,
    motions: Any,
    movers: Any,
    rows: Any,
    body_list: Any,
    contact_list: Any,
    joint_list: Any,
    factor: Any,
    edges: Any,
    blocks: Any,
    tree: Any,
    tree_blocks: Any,
    pull: Any,
    bouncy: Any,
    soft: Any,
    newton: Any,
    wakefulness: Any,
    kinematic: Any,
) -> Any:
    """Advance the bodies of one island by a whole timestep; returns (error, load, size) of nm."""
    if tree is not None:
        if is_pinned(body_list, contact_list, joint_list, joint_models, joint_parameters, bodies, body_parameters):
            swing_pinned(
                body_list[0],
                joint_list[0],
                joint_models,
                joint_parameters,
                joint_states,
                bodies,
                body_parameters,
                motions,
                options,
            )
            return 0.0, 0.0, 0.0
    n = int64(options.substeps)
    pressed = wakefulness == PRESSED
    driven = wakefulness != AWAKE
    sprung = False
    first = int64(0)
    if joint_models is not None:
        first = count_joint_rows(joint_list, joint_models, joint_parameters)
        driven = driven or any_driven(joint_list, joint_models, joint_parameters)
        sprung = any_sprung(joint_list, joint_parameters)
        if tree is not None:
            n = substeps_for(
                joint_list,
                joint_models,
                joint_parameters,
                joint_states,
                bodies,
                body_parameters,
                n,
                options.max_substeps,
                options.timestep,
            )
        clear_totals(joint_list, joint_states)
    if len(contact_list) + len(joint_list) == 0 and flies_freely(body_list, body_parameters):
        n = int64(1)  # exact whatever the timestep
    h = options.timestep / n
    kept = n / options.substeps  # impulses are stored for substeps of the usual length
    start = options.warm_start / kept
    enter_frames(body_list, bodies, body_parameters, motions, h)
    end = add_contact_rows(rows, first, contacts, contact_list, motions, start)
    tilted = any_tilted(body_list, motions)
    impacts = False
    if bouncy is not None:
        impacts = bounces(contacts, contact_list)
    world_state.row_count += end
    error = 0.0
    load = 0.0
    scale_of_nm = 0.0
    residual = 0.0
    for s in range(n):
        size = int64(0)
        if kinematic:
            move_kinematic(bodies, body_models, body_parameters, motions, s * h)
        if s > 0:
            enter_frames(body_list, bodies, body_parameters, motions, h)
            if tilted:
                turn_contact_rows(rows, first, end, contacts, motions)
        refresh_contact_rows(rows, first, end, contacts, motions, options, h)
        if bouncy is not None:
            if impacts:
                if tree is not None:
                    if first > 0:
                        keep_velocities(body_list, bodies, motions)
                        add_joint_rows(
                            rows,
                            int64(0),
                            joint_list,
                            joint_models,
                            joint_parameters,
                            joint_states,
                            constraint_rows,
                            bodies,
                            body_parameters,
                            motions,
                            tree,
                            0.0,
                            h,
                        )
                        release_springs(rows, first)
                        size = factorise_equations(rows, first, body_list, motions, tree, edges, tree_blocks)
                        set_paths(rows, first, motions, size, tree, tree_blocks, h)
                world_state.impacts += resolve_impacts(
                    rows, first, end, contacts, bodies, motions, body_list, pull, h, size, tree, tree_blocks
                )
                if tree is not None:
                    forget_factor(body_list, tree)
                refresh_contact_rows(rows, first, end, contacts, motions, options, h)
        integrate_velocities(body_list, bodies, body_parameters, motions, movers, h)
        if joint_models is not None:
            add_joint_rows(
                rows,
                int64(0),
                joint_list,
                joint_models,
                joint_parameters,
                joint_states,
                constraint_rows,
                bodies,
                body_parameters,
                motions,
                tree,
                start,
                h,
            )
            if tree is not None:
                if soft is None:
                    size = factorise_equations(rows, first, body_list, motions, tree, edges, tree_blocks)
        scale = start_impulses(rows, end, movers, pull, h)
        if tree is not None:
            if tilted:
                bend_spinning(rows, first, joint_parameters, bodies, body_parameters, motions, movers, h)
        if end > 0:
            if soft is not None:
                size = int64(0)  # sweeps alone
                world_state.sweeps += solve_biased(
                    rows, first, end, movers, contacts, body_list, motions, options, scale, h
                )
            turning = False
            if joint_models is not None:
                turning = any_equation(rows, first)
            for attempt in range(2):
                sweeps, residual = solve_rows(
                    rows,
                    end,
                    movers,
                    options.solver,
                    options.sweeps,
                    options.tolerance,
                    scale,
                    body_list,
                    motions,
                    factor,
                    edges,
                    blocks,
                    pressed,
                    (first, size),
                    tree,
                    tree_blocks,
                    soft,
                    newton,
                )
                take_velocities(body_list, bodies, movers)
                world_state.sweeps += sweeps
                if attempt > 0 or driven or sprung or not turning or residual > options.tolerance:
                    break
                if not gains_energy(body_list, bodies, motions):
                    break
                drop_curves(rows, first)
            world_state.residual = max(world_state.residual, residual)
            if residual > options.tolerance:
                world_state.unconverged += 1
            # converged joints that turn add and take energy of third order: no case for the guard
            if not driven and not sprung and (residual > options.tolerance or not turning):
                guard_energy(rows, end, body_list, bodies, motions)
            if tree is not None:
                if sprung and not driven and size > 0 and residual > options.tolerance:
                    guard_springs(rows, first, end, body_list, bodies, motions, movers, size, tree, tree_blocks)
            if s == n - 1:
                error, load, scale_of_nm = natural_residual(rows, end, first, bodies, motions)
        smooth = smooth_fraction(rows, first, end, body_list, bodies, body_parameters, motions, contacts, h)
        if end > 0:
            if soft is not None:
                keep_push(body_list, bodies, motions)
            else:
                if tree is not None:
                    if tilted and smooth > 0.0:
                        drift_spinning(rows, first, joint_parameters, bodies, body_parameters, motions, h)
                correct_positions(
                    rows,
                    end,
                    first,
                    motions,
                    contacts,
                    bodies,
                    body_parameters,
                    options,
                    h,
                    smooth,
                    size,
                    tree,
                    tree_blocks,
                )
        integrate_positions(body_list, bodies, body_parameters, motions, h, smooth)
        if tree is not None:
            forget_factor(body_list, tree)
        store_contacts(rows, first, end, contacts, motions, kept, s == n - 1)
        if pressed and residual > options.tolerance:
            forget_impulses(rows, first, end, contacts)
        if joint_models is not None:
            store_joint_impulses(
                rows,
                first,
                joint_models,
                joint_parameters,
                joint_states,
                bodies,
                body_parameters,
                motions,
                kept,
                h,
            )
            if residual > CONTRADICTED:
                forget_joint_impulses(rows, first, joint_states)
            move_targets(joint_list, joint_models, joint_states, h)
    return error, load, scale_of_nm
