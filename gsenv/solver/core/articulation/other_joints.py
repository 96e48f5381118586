"""Joints that are in no tree, in joint coordinates: loops, rods, ropes, springs, gears, targets, user constraints.

Their rows are those of core/joints.py, at the pose half a substep ahead, and come before all other rows.  whiten_rows
expresses them in joint space; equations.py solves those of rigid joints together.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...jit import njit
from ...records.model import JointKind
from ..coupled import has_half, make_equations
from ..dispatch import by_dimension, nothing
from ..joint_rows import has_limit
from ..joints import (
    arm_over_inertia,
    forget_joint_impulses,
    joint_row_count,
    move_targets,
    rod_swing,
    store_joint_impulses,
    tension_of,
    write_joint_rows,
)
from ..rows import BILATERAL, HALF, free_rate, start_rate
from ..slices import part
from ..springs import has_spring

enter_link_frames = by_dimension("rotation", "enter_link_frames", otherwise=nothing)
leave_link_frames = by_dimension("rotation", "leave_link_frames", otherwise=nothing)

_WELD = int(JointKind.WELD)
_ROWS = int(JointKind.ROWS)
_TARGET = int(JointKind.TARGET)
_DISTANCE = int(JointKind.DISTANCE)
_GEAR = int(JointKind.GEAR)
_AXIS = int(JointKind.AXIS)
SWING_PER_SUBSTEP = 1.5  # rad: largest swing of a taut rod, rope or loop in a substep
NOW = 1e-9  # of the substep: time ahead for which rows of the present pose are written
CONTRADICTED = 0.1  # residual above which the rows contradict each other; their impulses would grow in each step


@njit
def main_joint(joint_models: Any, j: Any) -> Any:
    """Return the joint that a coordinate belongs to, and other joints as they are."""
    return joint_models[j].joint_a if joint_models[j].kind == _AXIS else j


@njit
def is_in_tree(world: Any, j: Any) -> Any:
    """Whether joint j is one of those that joint coordinates describe, so that it needs no rows."""
    trees = world.model.trees
    model = world.model.joints[j]
    main = main_joint(world.model.joints, j)
    child = model.body_a if trees[model.body_a].joint == main else model.body_b
    return trees[child].joint == main and world.parameters.bodies[child].inv_mass > 0.0 and not is_soft(world, main)


@njit
def is_soft(world: Any, j: Any) -> Any:
    """Whether a joint is a weld that was made soft."""
    return world.model.joints[j].kind == _WELD and has_spring(world.parameters.joints[j])


@njit
def count_other_rows(world: Any, island: Any, others: Any) -> Any:
    """Set ``other_rows`` of the island; False where there are more than fit or no joints in trees.

    ``others`` is None in a scene whose joints are all in trees.
    """
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    island.other_rows = 0
    island.equations = 0
    in_trees = 0
    equations = 0
    for k in range(len(island_joints)):
        j = island_joints[k]
        if is_in_tree(world, j):
            in_trees += 1
            continue
        count = joint_row_count(joint_models[j], joint_parameters[j])
        island.other_rows += count
        if joint_models[j].kind != _DISTANCE or joint_parameters[j].rigid != 0 or has_spring(joint_parameters[j]):
            equations += count
    if in_trees == 0:
        return False
    if others is None:
        return in_trees == len(island_joints)
    return equations <= len(others.order) and island.other_rows <= len(others.slots)


@njit
def substeps_of_others(world: Any, island: Any, joints: Any, others: Any) -> Any:
    """Return the number of substeps that keeps taut rods, ropes and loops stable; 0 where there cannot be so many.

    See ``joints.substeps_for``; in body space slow_swings helps where there cannot be so many.
    """
    if others is None or island.other_rows == 0:
        return island.substeps
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    body_parameters = world.parameters.bodies
    dt = world.options.timestep
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    fastest = rod_swing(world, island_joints, joints, dt)
    for k in range(len(island_joints)):
        j = island_joints[k]
        model = joint_models[j]
        if model.kind > _TARGET and model.kind != _DISTANCE and model.kind != _GEAR and not is_in_tree(world, j):
            parameters = joint_parameters[j]
            a = arm_over_inertia(body_parameters[model.body_a], parameters.anchor_a)
            b = arm_over_inertia(body_parameters[model.body_b], parameters.anchor_b)
            fastest = max(fastest, tension_of(joints[j]) / dt * (a + b))
    needed = dt * fastest**0.5 / SWING_PER_SUBSTEP
    most = max(world.options.max_substeps, world.options.substeps)
    return max(island.substeps, int(min(np.ceil(needed), most)))


@njit
def write_other_rows(world: Any, island: Any, joints: Any, others: Any) -> None:
    """Write the rows of joints that are in no tree, at the pose half a substep ahead."""
    if others is None or island.other_rows == 0:
        return
    rows = world.scratch.rows
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    linked = world.scratch.joint_factor
    _keep_start_rates(world, island, joints, others)
    enter_link_frames(world, island)
    row = 0
    for k in range(len(island_joints)):
        if not is_in_tree(world, island_joints[k]):
            row = write_joint_rows(world, island_joints[k], row, joints, linked, island.warm_start, island.h)
    leave_link_frames(world, island)
    make_equations(rows, 0, row)
    _bend(world, island, others)
    for r in range(island.other_rows):
        others.slots[r] = rows[r].slot
        others.free[r] = rows[r].diagonal - rows[r].softness


@njit
def keep_other_velocities(world: Any, island: Any, articulation: Any, others: Any) -> None:
    """Keep the velocities at the start of the substep as the free ones, for limits with restitution and ``_bend``."""
    if others is None or island.other_rows == 0:
        return
    links = articulation.links
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        substep_body = substep_bodies[links[k].body]
        for d in range(len(substep_body.free_velocity)):
            substep_body.free_velocity[d] = links[k].velocity[d]


@njit
def _keep_start_rates(world: Any, island: Any, joints: Any, others: Any) -> None:
    """Set ``start_rate`` of the rows of rigid joints to J v at the pose and velocities of the start of the substep."""
    rows = world.scratch.rows
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    linked = world.scratch.joint_factor
    row = 0
    for k in range(len(island_joints)):
        j = island_joints[k]
        if is_in_tree(world, j):
            continue
        first = row
        row = write_joint_rows(world, j, row, joints, linked, 0.0, NOW * island.h)
        rigid = has_position(joint_models[j], joint_parameters[j])
        for r in range(first, row):
            known = rigid and rows[r].correction == BILATERAL and rows[r].softness == 0.0
            others.start_rate[r] = free_rate(rows[r], world.scratch.substep_bodies) if known else np.nan


@njit
def _bend(world: Any, island: Any, others: Any) -> None:
    """Add to the biases how J v changes in half a substep at constant rates, h/2 d(J v)/dt.

    Rows ask for J v at the end of the substep, from the pose half a substep ahead; in its first half J v has changed by
    as much.  Measured and not from derivatives, it is 0 for all rows that a common rotation leaves true: redundant rows
    would contradict each other by the terms of third order.  Rows whose biases have more in them know how their own
    directions change; for them, only the change of the velocities is added.
    """
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    for r in range(island.other_rows):
        row = rows[r]
        if row.softness > 0.0 or row.kind == HALF or has_half(rows, r, island.other_rows):
            continue
        if others.start_rate[r] == others.start_rate[r]:  # not NaN
            row.bias = start_rate(row, substep_bodies) - others.start_rate[r]
        else:
            row.bias += start_rate(row, substep_bodies) - free_rate(row, substep_bodies)


@njit
def store_other_impulses(world: Any, island: Any, joints: Any, others: Any) -> None:
    """Store the impulses that the next substep or step starts from, add them to the reactions, move the targets."""
    if others is None or island.other_rows == 0:
        return
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    links = world.scratch.articulation.links
    for k in range(island.body_count):
        correction = substep_bodies[links[k].body].correction
        dim = len(links[k].start)
        for d in range(dim):
            correction[d] = links[k].position[d] - links[k].start[d]
        for d in range(len(links[k].turn)):
            correction[dim + d] = links[k].half[d] + links[k].turn[d]
    all_rows = island.joint_rows
    island.joint_rows = island.other_rows
    store_joint_impulses(world, island, joints)
    island.joint_rows = all_rows
    if not island.residual <= CONTRADICTED:  # NaN, too
        forget_joint_impulses(rows, island.other_rows, joints)
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    move_targets(island_joints, world.model.joints, joints, island.h)


@njit
def has_position(model: Any, parameters: Any) -> Any:
    """Whether the errors of a joint's rows follow from the poses of its bodies alone."""
    if model.kind == _ROWS or model.kind == _TARGET or parameters.armature > 0.0:
        return False
    return model.kind != _DISTANCE or parameters.rigid != 0 or has_limit(parameters)
