"""Position pass: corrects overlaps and joint errors by pseudo-velocities that are then discarded.

The velocities do not change, so no energy is added.  Guendelman, Bridson, Fedkiw,
"Nonconvex rigid bodies with stacking", SIGGRAPH 2003, separate the two solves in the same way.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..methods.cholesky import add_force, change_of, clear_sides, substitute
from ..methods.joint_factor import compliance
from .contact_rows import shifted
from .coupled import has_half
from .rows import (
    BILATERAL,
    COUPLED,
    EQUATION,
    GROUNDED,
    LIMIT_SLOP,
    NO_CORRECTION,
    OPEN,
    UNILATERAL,
    add_response,
    relative_velocity,
    row_product,
    start_rate,
)
from .slices import part

REACH = 0.1  # rad, and of a body's radius: largest correction of joints in one sweep
SMOOTH = 1e-5  # of the extent: largest overlap that the mean of velocities may add
SMOOTH_TURN = 0.05  # of the relative speed: largest rate at which the mean of velocities may open a joint


@njit
def correct_positions(world: Any, island: Any, joint_factor: Any) -> None:
    """Sweep over the rows with an error; fills ``correction`` of the substep bodies.

    Where there is a joint factor, the joints are solved last in each sweep, so that separating overlapping
    bodies cannot open their joints.  Their error is that at the end of the substep, whose velocities are
    known.
    """
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    exact = False
    if joint_factor is not None:
        exact = joint_factor.plan.size > 0
    separates = False
    for k in range(world.options.position_sweeps):
        if k == 0:
            busy, separates = _first_sweep(world, island, exact)
            if not busy:
                return
        elif exact and not separates:
            break  # equations alone, which one solve solves exactly
        else:
            r = 0
            while r < island.rows:
                _correct_row(rows[r], substep_bodies, exact)
                r += 1 if r < island.joint_rows else int(rows[r].span)
        if joint_factor is not None:
            if exact:
                _correct_equations(world, island, joint_factor)


@njit
def _first_sweep(world: Any, island: Any, exact: Any) -> Any:
    """Set ``previous`` of each row to the rate at which its error is reduced, and take the first sweep.

    Returns whether any row has an error, and whether any of these is unilateral.
    """
    rows = world.scratch.rows
    bodies = world.state.bodies
    contacts = world.state.contacts
    substep_bodies = world.scratch.substep_bodies
    options = world.options
    h = island.h
    rate = options.correction_rate / h
    busy = False
    separates = False
    r = 0
    while r < island.rows:
        first = r
        row = rows[r]
        r += 1 if r < island.joint_rows else int(row.span)
        row.position_impulse = 0.0
        row.previous = 0.0
        if row.correction == BILATERAL:
            row.previous = rate * row.error
            if exact:
                displacement = displacement_rate(row, bodies, substep_bodies, island.smooth, h)
                row.previous = row.error / h + displacement + row.drive
        elif row.correction == UNILATERAL and first < island.joint_rows:
            row.previous = rate * min(row.error, 0.0)
        elif row.correction == UNILATERAL:
            extent = contacts[row.source].extent
            depth = row.error + options.slop * extent
            if depth < 0.0:
                row.previous = max(rate * depth, -options.push_speed * extent)
            if island.smooth == 0.0:
                row.previous -= _sinking(row, options.slop * extent, h)
        if row.previous != 0.0:
            busy = True
            separates = separates or row.correction == UNILATERAL
        if busy:  # else all pseudo-velocities are 0
            _correct_row(row, substep_bodies, exact)
    return busy, separates


@njit
def _sinking(row: Any, slop: Any, h: Any) -> Any:
    """Return the speed that a turning contact may have at the middle of the substep, m/s; see turn_contact_rows.

    The mean of old and new velocity does not have it, but the new one, with which bodies move where one lands.
    """
    if row.flight != GROUNDED or not row.impulse > 0.0:
        return 0.0
    return max(row.bias - max(row.error - slop, 0.0) / h, 0.0)


@njit
def displacement_rate(row: Any, bodies: Any, substep_bodies: Any, smooth: Any, h: Any) -> Any:
    """Return J times the displacement of the coming substep, divided by h."""
    v = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
    mean = v + 0.5 * smooth * (start_rate(row, substep_bodies) - v)
    return mean + shifted(row, substep_bodies) / h


@njit
def _correct_row(row: Any, substep_bodies: Any, exact: Any) -> None:
    if (
        row.correction == NO_CORRECTION
        or (row.correction == UNILATERAL and row.error > 0.0)
        or (row.correction == BILATERAL and exact)
        or row.kind == COUPLED
    ):
        return
    w = row.previous + _correction_of(row, substep_bodies)
    old = row.position_impulse
    new = old - row.effective_mass * w
    if row.correction == UNILATERAL:
        new = max(new, 0.0)
    d = new - old
    row.position_impulse = new
    if d != 0.0:
        a = substep_bodies[row.body_a]
        b = substep_bodies[row.body_b]
        add_response(row, d, a.correction, a.inverse, b.correction, b.inverse)


@njit
def _correction_of(row: Any, substep_bodies: Any) -> Any:
    """Return J times the pseudo-velocities."""
    return row_product(row, substep_bodies[row.body_a].correction, substep_bodies[row.body_b].correction)


@njit
def _lengths(x: Any) -> Any:
    """Return the 1-norms of the linear and the angular part of a vector (3,) or (6,)."""
    linear = 0.0
    angular = 0.0
    for d in range(len(x)):
        if d < (len(x) + 1) // 2:
            linear += abs(x[d])
        else:
            angular += abs(x[d])
    return linear, angular


@njit
def _correct_equations(world: Any, island: Any, joint_factor: Any) -> None:
    """Take one Gauss-Newton step on the joints' errors, limited to where their linear model is valid."""
    rows = world.scratch.rows
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    entries = joint_factor.entries
    size = joint_factor.plan.size
    h = island.h
    clear_sides(size, entries)
    for r in range(island.joint_rows):
        row = rows[r]
        if row.kind == EQUATION and row.diagonal > 0.0:
            add_force(row, entries, -_error_rate(row, substep_bodies) / compliance(row))
    substitute(size, entries, joint_factor.blocks)
    farthest = 1.0
    for p in range(size):
        radius = body_parameters[entries[p].order].radius
        linear, angular = _lengths(entries[p].x)
        farthest = max(farthest, h * angular / REACH)
        if radius > 0.0:
            farthest = max(farthest, h * linear / (REACH * radius))
    for r in range(island.joint_rows):
        row = rows[r]
        if row.kind == EQUATION and row.softness > 0.0:
            remaining = _error_rate(row, substep_bodies) + change_of(row, entries)
            row.position_impulse -= remaining / (compliance(row) * farthest)
    for p in range(size):
        substep_body = substep_bodies[entries[p].order]
        for i in range(len(substep_body.correction)):
            substep_body.correction[i] += entries[p].x[i] / farthest


@njit
def _error_rate(row: Any, substep_bodies: Any) -> Any:
    """Return the remaining rate of an equation's error; its softness lets a spring deflect."""
    return row.previous + _correction_of(row, substep_bodies) + row.softness * row.position_impulse


@njit
def _nothing_jumped(island_bodies: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> Any:
    """Whether half of the change of velocity moves no point by more than the tolerance."""
    for k in range(len(island_bodies)):
        i = island_bodies[k]
        v = bodies[i].velocity
        u = substep_bodies[i].start_velocity
        jump = 0.0
        for d in range(len(v)):
            jump += abs(v[d] - u[d]) * (1.0 if d < (len(v) + 1) // 2 else body_parameters[i].radius)
        if 0.25 * h * jump > SMOOTH * body_parameters[i].extent:
            return False
    return True


@njit
def _mean_velocity(row: Any, bodies: Any, substep_bodies: Any) -> Any:
    """Return J (v_old + v_new) / 2."""
    return 0.5 * (relative_velocity(row, bodies[row.body_a], bodies[row.body_b]) + start_rate(row, substep_bodies))


@njit
def relative_speed(row: Any, bodies: Any, body_parameters: Any) -> Any:
    """Return the speed at which two bodies move about each other, in m/s: the scale of errors of smooth rotation."""
    a = bodies[row.body_a].velocity
    b = bodies[row.body_b].velocity
    speed = 0.0
    for d in range((len(a) + 1) // 2):
        speed += abs(b[d] - a[d])
    _, spin_a = _lengths(a)
    _, spin_b = _lengths(b)
    return speed + spin_a * body_parameters[row.body_a].radius + spin_b * body_parameters[row.body_b].radius


@njit
def smooth_fraction(world: Any, island: Any) -> Any:
    """Return 1.0 if the mean of old and new velocity closes no contact of the island, else 0.0.

    Where bodies slide, roll or fly, both velocities obey the contacts and their mean is second
    order.  Where one lands, the old velocity points into the other body, and only the new one is valid.
    """
    rows = world.scratch.rows
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    if island.joint_rows == 0 and _nothing_jumped(island_bodies, bodies, body_parameters, substep_bodies, island.h):
        return 1.0
    for r in range(island.joint_rows):
        row = rows[r]
        if row.correction != NO_CORRECTION:
            other = 0.0
            if has_half(rows, r, island.joint_rows):
                other = _mean_velocity(rows[r + 1], bodies, substep_bodies)
            if not _is_smooth(row, other, bodies, body_parameters, substep_bodies, island.h):
                return 0.0
    contacts = world.state.contacts
    r = island.joint_rows
    while r < island.rows:
        row = rows[r]
        r += int(row.span)
        if row.flight == OPEN:
            continue
        extent = contacts[row.source].extent
        after = row.error + island.h * _mean_velocity(
            row, bodies, substep_bodies
        )  # the error includes the shift of impacts
        if after < min(row.error, 0.0) - SMOOTH * extent:
            return 0.0
    return 1.0


@njit
def _is_smooth(row: Any, other: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any) -> Any:
    """Whether the mean velocity opens a joint's row by no more than smooth rotation does.

    ``other``: m/s or rad/s, mean velocity of the second half of a coupled row.
    """
    opened = h * (_mean_velocity(row, bodies, substep_bodies) + other)
    turning = SMOOTH_TURN * relative_speed(row, bodies, body_parameters)
    bend = h * (turning + abs(row.bias))  # the bias of a row is due to rotation
    if row.correction == BILATERAL and abs(opened) > SMOOTH * body_parameters[row.body_b].extent + bend:
        return False
    if row.correction == UNILATERAL:
        taut = abs(start_rate(row, substep_bodies)) <= turning  # and not just reaching the limit
        tolerance = LIMIT_SLOP + (h * turning if taut else 0.0)
        if row.error + opened < min(row.error, 0.0) - tolerance:
            return False
    return True
