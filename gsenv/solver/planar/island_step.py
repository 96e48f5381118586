"""All substeps of one island: rows, impacts, solve, positions. Islands are independent in a step."""

from __future__ import annotations

from typing import Any

from numba import int64

from ..islands import AWAKE, PRESSED
from ..jit import njit
from ..rows import apply_warm_start
from ..solvers import solve_rows
from .contact_rows import (
    add_contact_rows,
    forget_impulses,
    refresh_contact_rows,
    store_contact_impulses,
    store_separations,
)
from .energy import guard_energy, natural_residual, residual_scale
from .impacts import resolve_impacts
from .integrate import integrate_positions, integrate_velocities, move_kinematic
from .joints import add_joint_rows, any_driven, store_joint_impulses
from .joints.target import move_targets
from .positions import correct_positions, smooth_fraction


@njit
def count_joint_rows(indices: Any, joint_models: Any) -> Any:
    count = 0
    for k in range(len(indices)):
        count += joint_models[indices[k]].row_count
    return count


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
    rows: Any,
    body_list: Any,
    contact_list: Any,
    joint_list: Any,
    envelope: Any,
    edges: Any,
    blocks: Any,
    pull: Any,
    bouncy: Any,
    wakefulness: Any,
    kinematic: Any,
) -> Any:
    """Advance the bodies of one island by a whole timestep; returns (error, load, size) of nm."""
    n = options.substeps
    h = options.timestep / n
    pressed = wakefulness == PRESSED
    driven = wakefulness != AWAKE
    first = int64(0)
    if joint_models is not None:
        first = count_joint_rows(joint_list, joint_models)
        driven = driven or any_driven(joint_list, joint_models, joint_parameters)
    end = add_contact_rows(rows, first, contacts, contact_list, bodies, body_parameters, options.warm_start)
    impacts = False
    if bouncy is not None:
        impacts = bounces(contacts, contact_list)
    world_state.row_count += end
    error = 0.0
    load = 0.0
    size = 0.0
    residual = 0.0
    for s in range(n):
        if kinematic:
            move_kinematic(bodies, body_models, body_parameters, motions, s * h)
        refresh_contact_rows(rows, first, end, contacts, motions, options, h)
        if bouncy is not None:
            if impacts:
                world_state.impacts += resolve_impacts(rows, first, end, contacts, bodies, motions, body_list, pull, h)
                refresh_contact_rows(rows, first, end, contacts, motions, options, h)
        integrate_velocities(body_list, bodies, body_parameters, motions, h)
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
                options.warm_start,
                h,
            )
        scale = residual_scale(rows, end, bodies, pull, h)
        apply_warm_start(rows, end, bodies)
        if end > 0:
            sweeps, residual = solve_rows(
                rows,
                end,
                bodies,
                options.solver,
                options.sweeps,
                options.tolerance,
                scale,
                body_list,
                motions,
                envelope,
                edges,
                blocks,
                pressed,
            )
            world_state.sweeps += sweeps
            world_state.residual = max(world_state.residual, residual)
            if residual > options.tolerance:
                world_state.unconverged += 1
            if not driven:
                guard_energy(rows, end, body_list, bodies, body_parameters, motions)
            if s == n - 1:
                error, load, size = natural_residual(rows, end, first, bodies, motions)
            correct_positions(rows, end, first, motions, contacts, options, h)
        smooth = smooth_fraction(rows, first, end, body_list, bodies, body_parameters, motions, contacts, h)
        integrate_positions(body_list, bodies, motions, h, smooth)
        store_contact_impulses(rows, first, end, contacts)
        if pressed and residual > options.tolerance:
            forget_impulses(rows, first, end, contacts)
        if joint_models is not None:
            store_joint_impulses(rows, int64(0), joint_list, joint_models, joint_states)
            move_targets(joint_list, joint_models, joint_states, h)
    store_separations(rows, first, end, contacts, motions)
    return error, load, size
