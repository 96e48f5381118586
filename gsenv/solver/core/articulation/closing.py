"""Closing of joints in no tree: Newton's method on the poses at the end of a substep, in joint coordinates.

The position pass corrects a linear prediction of each error.  Where a direction changes by a large angle within the
substep, an error remains.  It is measured after the links have moved, and the links are moved by the least
displacement, weighted by their masses, that removes it, first with the factor of the middle of the substep, then
with that of the present poses.  See core/joint_closing.py, which does the same in body space.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...jit import njit
from ..coupled import make_equations, share_corrections
from ..dispatch import by_dimension
from ..integrate import move_kinematic
from ..joints import write_joint_rows
from ..rows import BILATERAL, UNILATERAL, relative_velocity
from ..slices import part
from .balance import average_over_trees, restore_momenta
from .dynamics import factorise_links, respond_outward, set_middle
from .energy import energy_by_forces, keep_energy, lose_energy
from .equations import bound_correction, correct_others, factorise_equations, only_closes, size_of
from .links import largest_share, move_links, place_links, set_base
from .other_joints import NOW, has_position, is_in_tree
from .reactions import add_impulses, add_pushes, keep_pushes
from .rows import whiten_rows

keep_momentum = by_dimension("articulation", "keep_momentum")
leave_link = by_dimension("articulation", "leave_link")

LOOSE = 1e-5  # of a body's size, or rad: smaller errors are left to the next substep
MOST_CLOSINGS = 12
CHORDS = 4  # of them with the factor of the middle of the substep
_SWEEPS = 3


@njit
def close_others(world: Any, island: Any, end: Any, joints: Any, articulation: Any, others: Any) -> None:
    """Move the links at the end of a substep, ``end`` s into the step, to where the joints in no tree hold."""
    if others is None or island.other_rows == 0:
        return
    if island.kinematic:
        move_kinematic(world, end)
    for f in range(island.freedoms):
        articulation.before[f] = 0.0
        articulation.conjugate[f] = 0.0
    for r in range(island.other_rows):
        others.moved[r] = 0.0
    smooth = only_closes(world, island, others) and island.smooth == 1.0
    keep_pushes(world, island, articulation)
    steps, closed = _close(world, island, joints, articulation, others)
    share = _slow_links(world, island, articulation, others) if steps > 0 else 0.0
    _set_impulses(world, island, others, share)
    add_impulses(world, island, articulation, island.rows)
    restore_momenta(world, island, articulation, 0.0)
    if not (smooth and closed and keep_energy(world, island, articulation, 0.0) > 0) and not island.has_springs:
        lose_energy(world, island, articulation, 0.0)
    _leave_velocities(world, island, articulation.links)
    add_pushes(world, island, articulation, joints)


@njit
def _close(world: Any, island: Any, joints: Any, articulation: Any, others: Any) -> Any:
    """Take steps of Newton's method while they reduce the error; returns (number of steps, whether all joints hold)."""
    newton = False
    last = np.inf
    for k in range(MOST_CLOSINGS + 1):
        error = _measure(world, island, joints, others)
        if error <= LOOSE:
            return k, True
        if error >= last:
            _take_back(world, island, articulation, others)
            if newton:  # joints contradict each other
                break
            newton = True
            last = np.inf
            continue
        if k == MOST_CLOSINGS:
            return k, False
        last = error
        newton = newton or k >= CHORDS
        if newton:
            _factorise_here(world, island, articulation, others)
        _take_step(world, island, articulation, others)
    _measure(world, island, joints, others)
    return k, False


@njit
def _set_impulses(world: Any, island: Any, others: Any, share: Any) -> None:
    """Set the impulses of the rows to those that ``_slow_links`` has given the links."""
    rows = world.scratch.rows
    for r in range(island.other_rows):
        rows[r].impulse = share * others.moved[r] if rows[r].slot == others.slots[r] else 0.0


@njit
def _leave_velocities(world: Any, island: Any, links: Any) -> None:
    bodies = world.state.bodies
    for k in range(island.body_count):
        for d in range(len(links[k].velocity)):
            bodies[links[k].body].velocity[d] = links[k].velocity[d]


@njit
def _measure(world: Any, island: Any, joints: Any, others: Any) -> Any:
    """Write the rows at the present poses, with the rates that remove their errors; returns the largest error."""
    rows = world.scratch.rows
    joint_models = world.model.joints
    joint_parameters = world.parameters.joints
    island_joints = part(world.scratch.island_joints, island.joint_first, island.joint_count)
    linked = world.scratch.joint_factor
    largest = 0.0
    row = 0
    for k in range(len(island_joints)):
        j = island_joints[k]
        if is_in_tree(world, j):
            continue
        first = row
        measured = has_position(joint_models[j], joint_parameters[j])
        if measured:
            row = write_joint_rows(world, j, row, joints, linked, 0.0, NOW * island.h)
            make_equations(rows, first, row)
        else:
            while row < island.other_rows and rows[row].source == j:
                row += 1
        for r in range(first, row):
            rows[r].previous = 0.0
            rows[r].position_impulse = 0.0
            same = rows[r].slot == others.slots[r]
            if measured and same and (rows[r].correction == BILATERAL or _is_passed(rows[r])):
                rows[r].previous = rows[r].error / island.h
                size = size_of(world, rows[r])
                largest = max(largest, abs(rows[r].error) / size)
                bound_correction(rows[r], size, island.h)
            elif rows[r].correction == UNILATERAL:
                rows[r].error = 1.0  # not to be corrected
    return largest


@njit
def _is_passed(row: Any) -> Any:
    return row.correction == UNILATERAL and row.error < 0.0


@njit
def _factorise_here(world: Any, island: Any, articulation: Any, others: Any) -> None:
    """Express the rows that were measured in joint space at the present poses of the links."""
    rows, joint_rows = island.rows, island.joint_rows
    island.rows = island.other_rows
    island.joint_rows = island.other_rows
    for f in range(island.freedoms):
        articulation.step[f] = 0.0
    _start_again(world, island, articulation)
    place_links(world, island, articulation)
    set_middle(world, island, articulation)
    factorise_links(articulation.links, island.body_count, articulation.freedoms)
    whiten_rows(world, island, articulation)
    factorise_equations(world, island, articulation, others)
    island.rows, island.joint_rows = rows, joint_rows


@njit
def _take_step(world: Any, island: Any, articulation: Any, others: Any) -> None:
    """Take one step of Newton's method with the factor of the rows."""
    rows = world.scratch.rows
    freedoms = articulation.freedoms
    z = articulation.whitened
    change = articulation.change
    step = articulation.step
    for f in range(island.freedoms):
        z[f] = 0.0
    for _ in range(_SWEEPS):
        correct_others(world, island, articulation, others)
    share_corrections(rows, island.other_rows)
    for f in range(island.freedoms):
        change[f] = z[f] * freedoms[f].root
    respond_outward(articulation.links, island.body_count, freedoms, change)
    share = largest_share(world, island, articulation)
    _keep_motion(world, island, articulation.links, share * island.h)
    for f in range(island.freedoms):
        step[f] = share * island.h * change[f]
        articulation.before[f] += share * change[f]
        z[f] *= share
        articulation.conjugate[f] += z[f]
    for r in range(island.other_rows):
        others.last[r] = share * rows[r].position_impulse
        others.moved[r] += others.last[r]
    _place(world, island, articulation)


@njit
def _keep_motion(world: Any, island: Any, links: Any, h: Any) -> None:
    """Set ``contact`` of each link to its mass times the way by which its velocity moves it in the time ``h``."""
    body_parameters = world.parameters.bodies
    for k in range(island.body_count):
        mass = body_parameters[links[k].body].mass
        for d in range(len(links[k].position)):
            links[k].contact[d] = h * mass * links[k].velocity[d]


@njit
def _take_back(world: Any, island: Any, articulation: Any, others: Any) -> None:
    """Undo the last step."""
    step = articulation.step
    for f in range(island.freedoms):
        step[f] = -step[f]
        articulation.before[f] += step[f] / island.h
        articulation.conjugate[f] -= articulation.whitened[f]
    for r in range(island.other_rows):
        others.last[r] = -others.last[r]
        others.moved[r] += others.last[r]
    for k in range(island.body_count):
        for d in range(len(articulation.links[k].position)):
            articulation.links[k].contact[d] = -articulation.links[k].contact[d]
    _place(world, island, articulation)


@njit
def _place(world: Any, island: Any, articulation: Any) -> None:
    """Move the links by ``step``, and each tree that nothing holds as a whole, so that its centre moves by ``contact``.

    Of finite rotations the first does not, by the square of the angles.  The impulses of the rows, at the present
    poses, would not do: where joints contradict each other they are huge, and balance at the poses of the factor only.
    """
    links = articulation.links
    body_parameters = world.parameters.bodies
    _start_again(world, island, articulation)
    place_links(world, island, articulation)
    dim = len(world.parameters.world.gravity)
    for k in range(island.body_count):
        link = links[k]
        mass = body_parameters[link.body].mass
        for d in range(dim):
            link.force[d] = link.contact[d] - mass * (link.position[d] - link.start[d])
        link.force[dim] = mass
    average_over_trees(island, links, dim)
    for k in range(island.body_count):
        for d in range(dim):
            links[k].position[d] += links[k].response[d]
    _leave(world, island, articulation)


@njit
def _start_again(world: Any, island: Any, articulation: Any) -> None:
    """Count displacements from the present poses, after the work of forces up to these."""
    links = articulation.links
    island.kinetic = energy_by_forces(world, island, links)
    for k in range(island.body_count):
        set_base(links[k])
        for d in range(len(links[k].position)):
            links[k].start[d] = links[k].position[d]
        for d in range(len(links[k].turn)):
            links[k].half[d] = 0.0


@njit
def _leave(world: Any, island: Any, articulation: Any) -> None:
    links = articulation.links
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    for k in range(island.body_count):
        leave_link(links[k], bodies[links[k].body], substep_bodies[links[k].body])


@njit
def _slow_links(world: Any, island: Any, articulation: Any, others: Any) -> Any:
    """Add the share of the displacement over h to the rates that leaves least energy, and return it.

    See joint_closing.py.
    """
    rows = world.scratch.rows
    bodies = world.state.bodies
    rate = articulation.rate
    z = articulation.conjugate
    slope = 0.0
    curve = 0.0
    for r in range(island.other_rows):
        if others.moved[r] != 0.0:
            slope += others.moved[r] * relative_velocity(rows[r], bodies[rows[r].body_a], bodies[rows[r].body_b])
    for f in range(island.freedoms):
        curve += z[f] * z[f]
    share = min(max(-slope / curve, 0.0), 1.0) if curve > 0.0 else 0.0
    for f in range(island.freedoms):
        articulation.step[f] = 0.0
    _start_again(world, island, articulation)
    place_links(world, island, articulation)
    move_links(island, articulation, rate)
    energy = _energy_of(world, island, articulation.links)
    for f in range(island.freedoms):
        rate[f] += share * articulation.before[f]
    move_links(island, articulation, rate)
    if _energy_of(world, island, articulation.links) > energy:  # after far displacements, of joints that contradict
        for f in range(island.freedoms):
            rate[f] -= share * articulation.before[f]
        share = 0.0
        move_links(island, articulation, rate)
    _leave(world, island, articulation)
    return share


@njit
def _energy_of(world: Any, island: Any, links: Any) -> Any:
    """Return twice the kinetic energy of the links."""
    energy = 0.0
    for k in range(island.body_count):
        keep_momentum(links[k], world.parameters.bodies[links[k].body])
        for d in range(len(links[k].momentum)):
            energy += links[k].momentum[d] * links[k].velocity[d]
    return energy
