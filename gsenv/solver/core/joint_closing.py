"""Closing of rods and ropes: Newton's method on the positions at the end of a substep.

The position pass corrects a linear prediction of each joint's error. That is not enough where the direction of
a short rod changes by a large angle within the substep, or where a slack rope becomes taut. So the lengths of
rods and ropes are measured after bodies have moved. If one is off, the bodies are moved by the smallest
displacement, weighted by the masses, that satisfies all rigid joints of the island, taut ropes and limits, and
that pushes no body deeper into another; directions and errors are taken anew in each iteration.

The displacement divided by h is added to the velocities as far as that lowers the kinetic energy. A straight taut
chain needs this: its rows resist no motion across it, so without it the chain would fall ever faster and be lifted
back in each substep.

Goldenthal, Harmon, Fattal, Bercovier, Grinspun, "Efficient simulation of inextensible cloth", SIGGRAPH 2007,
call this fast projection; they take all of the velocity from the displacements.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..methods.cholesky import add_force, change_of, clear_sides, forget_factor, substitute
from ..methods.joint_factor import compliance, factorise_equations
from ..records.model import JointKind
from .contact_rows import moved
from .dispatch import by_dimension
from .integrate import copy_pose, move_kinematic
from .joint_rows import has_limit
from .joints import add_joint_rows
from .rows import BILATERAL, BOUNDED, EQUATION, UNILATERAL
from .slices import part

displace_body = by_dimension("rotation", "displace_body")
start_closing = by_dimension("rotation", "start_closing")
spin_to_frame = by_dimension("rotation", "spin_to_frame")
spin_to_world = by_dimension("rotation", "spin_to_world")
anchor_distance = by_dimension("joints.distance", "anchor_distance")

_DISTANCE = int(JointKind.DISTANCE)
LOOSE = 1e-3  # of its length: a rod or rope that is off by more is closed
CLOSED = 1e-4  # of its length: smaller errors end the iteration
MAX_CLOSINGS = 60  # a bridge whose rods turn across takes more than 20
PATIENCE = 30  # iterations that may pass without progress; joints that contradict each other make none
PROGRESS = 0.9  # of the smallest error so far
LARGEST_TURN = 0.3  # rad: largest rotation in one iteration, for which directions are nearly constant
_NOW = 1e-9  # of the substep: time ahead for which rows are made


@njit
def close_joints(world: Any, island: Any, joints: Any, joint_factor: Any) -> None:
    """Close the island's rods and ropes after the substep has moved the bodies."""
    if joint_factor is None:
        return
    if not joint_factor.plan.used:
        return
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    if not any_distance(island_joints, world.model.joints):
        return
    if island.kinematic:
        move_kinematic(world, island.end)
    least = largest_stretch(world, island_joints)
    if least <= LOOSE:
        return
    _start_bodies(world, island)
    _start_contact_rows(world, island)
    _keep_poses(world, island)
    waited = 0
    stretch = least
    for _ in range(MAX_CLOSINGS):
        if waited == PATIENCE or not _take_step(world, island, joints, joint_factor):
            break
        stretch = largest_stretch(world, island_joints)
        waited += 1
        if stretch < PROGRESS * least:
            least = stretch
            waited = 0
            _keep_poses(world, island)
        if stretch <= CLOSED:
            break
    if not stretch <= LOOSE:
        _return_to_kept_poses(world, island)
    _slow_bodies(world, island)


@njit
def _keep_poses(world: Any, island: Any) -> None:
    """Keep the present poses of the bodies, for the case that all further ones are worse."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    kept = world.scratch.closing_poses
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        copy_pose(bodies[i], kept[i])
        _copy_motion(bodies[i], substep_bodies[i], kept[i], kept[i])


@njit
def _return_to_kept_poses(world: Any, island: Any) -> None:
    """Move the bodies to where the errors were least: joints that contradict each other never hold."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    kept = world.scratch.closing_poses
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        copy_pose(kept[i], bodies[i])
        _copy_motion(kept[i], kept[i], bodies[i], substep_bodies[i])
        start_closing(bodies[i], substep_bodies[i])


@njit
def _copy_motion(body: Any, substep_body: Any, to_body: Any, to_substep_body: Any) -> None:
    """Copy what a displacement changes besides the pose: a tilted body's velocity turns with it."""
    for d in range(len(body.velocity)):
        to_body.velocity[d] = body.velocity[d]
        to_substep_body.impact_displacement[d] = substep_body.impact_displacement[d]


@njit
def any_distance(island_joints: Any, joint_models: Any) -> Any:
    """Whether there is a rod or a rope among the joints of the island."""
    for k in range(len(island_joints)):
        if joint_models[island_joints[k]].kind == _DISTANCE:
            return True
    return False


@njit
def largest_stretch(world: Any, island_joints: Any) -> Any:
    """Return the largest error of a rod or rope at the present poses, relative to its length."""
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    largest = 0.0
    for k in range(len(island_joints)):
        j = island_joints[k]
        model = joint_models[j]
        if model.kind != _DISTANCE:
            continue
        parameters = joint_parameters[j]
        if not (parameters.rigid or has_limit(parameters)):
            continue
        a = model.body_a
        b = model.body_b
        distance = anchor_distance(bodies[a], bodies[b], body_parameters[a], body_parameters[b], parameters)
        error = max(parameters.lower - distance, distance - parameters.upper)
        length = parameters.upper if distance > parameters.upper else parameters.lower
        if parameters.rigid:
            error = abs(distance - parameters.length)
            length = parameters.length
        if error > 0.0 and length > 0.0:
            largest = max(largest, error / length)
    return largest


@njit
def _start_bodies(world: Any, island: Any) -> None:
    """Make the present poses those from which rows are made."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        start_closing(bodies[island_bodies[k]], substep_bodies[island_bodies[k]])


@njit
def _take_step(world: Any, island: Any, joints: Any, joint_factor: Any) -> Any:
    """Take one Newton step; returns False where the factor does not fit."""
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    entries = joint_factor.entries
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    h = island.h
    island.h = _NOW * h
    add_joint_rows(world, island, joints, joint_factor, 0.0)
    island.h = h
    _choose_joint_rows(rows, island.joint_rows)
    _choose_contact_rows(world, island)
    size = factorise_equations(
        rows, island.rows, island_bodies, substep_bodies, entries, joint_factor.graph, joint_factor.blocks
    )
    if size > 0:
        clear_sides(size, entries)
        for r in range(island.rows):
            if rows[r].kind == EQUATION and rows[r].diagonal > 0.0:
                add_force(rows[r], entries, -rows[r].error / compliance(rows[r]))
        substitute(size, entries, joint_factor.blocks)
        _move_bodies(world, joint_factor, size)
    _release_contact_rows(world, island, joint_factor, size)
    forget_factor(island_bodies, entries)
    return size > 0


@njit
def _choose_joint_rows(rows: Any, end: Any) -> None:
    """Make equations of rigid rows, of taut ropes and of limits that are passed, and of no others."""
    for r in range(end):
        row = rows[r]
        rigid = row.kind == EQUATION and row.correction == BILATERAL and row.softness == 0.0
        beyond = row.correction == UNILATERAL and row.error < 0.0
        row.kind = EQUATION if rigid or beyond else BOUNDED


@njit
def _start_contact_rows(world: Any, island: Any) -> None:
    """Keep the separation of each contact before the closing, and start from those that carry a load."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        separation = contacts[row.source].separation + moved(row, substep_bodies)
        row.position_impulse = min(separation, 0.0)  # m, below which the closing may not push the bodies
        row.previous = 1.0 if row.impulse > 0.0 else 0.0  # 1: an equation
        r += int(row.span)


@njit
def _choose_contact_rows(world: Any, island: Any) -> None:
    rows = world.scratch.rows
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        row.error = contacts[row.source].separation + moved(row, substep_bodies) - row.position_impulse
        if row.previous > 0.0:
            row.kind = EQUATION
        r += int(row.span)


@njit
def _release_contact_rows(world: Any, island: Any, joint_factor: Any, size: Any) -> None:
    """Make normal rows of contacts again, and choose those that the next step must respect.

    A contact that the step would have pulled apart is left; one that the step pushed deeper is added.
    """
    rows = world.scratch.rows
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    entries = joint_factor.entries
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        if row.kind == EQUATION:
            row.kind = BOUNDED
            if size > 0 and row.error + change_of(row, entries) > 0.0:
                row.previous = 0.0
        elif contacts[row.source].separation + moved(row, substep_bodies) < row.position_impulse:
            row.previous = 1.0
        r += int(row.span)


@njit
def _move_bodies(world: Any, joint_factor: Any, size: Any) -> None:
    """Move the bodies by the solution, shortened to where directions are nearly constant."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    entries = joint_factor.entries
    turn = LARGEST_TURN
    for p in range(size):
        x = entries[p].x
        angle = 0.0
        for d in range((len(x) + 1) // 2, len(x)):
            angle += abs(x[d])
        turn = max(turn, angle)
    share = LARGEST_TURN / turn
    for p in range(size):
        i = entries[p].order
        substep_body = substep_bodies[i]
        for d in range(len(substep_body.displacement)):
            substep_body.correction[d] = share * entries[p].x[d]
            substep_body.impact_displacement[d] += substep_body.correction[d]
        displace_body(bodies[i], substep_body)
        start_closing(bodies[i], substep_body)


@njit
def _slow_bodies(world: Any, island: Any) -> None:
    """Add the share of the displacement over h to the velocities that leaves least energy, and end the closing."""
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    slope = 0.0
    curve = 0.0
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        substep_body = substep_bodies[island_bodies[k]]
        spin_to_frame(body, substep_body)
        for d in range(len(body.velocity)):
            change = substep_body.impact_displacement[d] / island.h
            slope += substep_body.mass_matrix[d, d] * body.velocity[d] * change
            curve += substep_body.mass_matrix[d, d] * change * change
    share = min(max(-slope / curve, 0.0), 1.0) if curve > 0.0 else 0.0
    for k in range(len(island_bodies)):
        body = bodies[island_bodies[k]]
        substep_body = substep_bodies[island_bodies[k]]
        for d in range(len(body.velocity)):
            body.velocity[d] += share * substep_body.impact_displacement[d] / island.h
            substep_body.displacement[d] += substep_body.impact_displacement[d]
            substep_body.impact_displacement[d] = 0.0
        spin_to_world(body, substep_body)
