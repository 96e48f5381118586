"""Impact phase: Newton impacts at their own times within the substep, before the solve.

A body in flight meets another at the root t of  gap + u t + a t^2/2 = 0.  There an impulse p changes
the approach speed u + a t to -e times itself.  The impulse acts over the rest of the substep
only, so ``impact_displacement`` subtracts  t M^-1 J^T p  from the displacement: bounces are exact parabolas at any
timestep.  The earliest impact comes first and may cause the next (Newton's cradle); a simultaneous
solve would distribute the momentum among all.  Approach speeds are those before the gravity of the
substep is added; otherwise bounces would gain height.

Kane, "A dynamics puzzle", Stanford Mechanics Alumni Club 1984: Newton restitution with friction may
create energy; impulses are scaled so that they cannot increase the kinetic energy.
Bounces that would all end within the substep (their times are a geometric series) are left to the
contact solve: the body is at rest.

The contacts of one manifold that are hit at the same time share the impact: see planar/impacts.py and
spatial/impacts.py.
"""

from __future__ import annotations

from typing import Any

from numba import int64

from ..jit import njit
from ..methods.cholesky import add_force, change_of, clear_sides, substitute
from ..methods.joint_factor import EPSILON, solve_equations
from .contact_rows import shifted
from .dispatch import by_dimension
from .rows import EQUATION, GROUNDED, UNILATERAL, relative_velocity, row_product
from .slices import part

apply_impact = by_dimension("impacts", "apply_impact")

_NEVER = 1e300
ORDERED_LIMIT = 48  # largest number of contacts whose impacts are resolved in order of time, at quadratic cost
MAX_PASSES = 8


@njit
def acceleration_of(row: Any, substep_bodies: Any) -> Any:
    """Return J times the accelerations, those of bodies with joints along the joints."""
    a = substep_bodies[row.body_a]
    b = substep_bodies[row.body_b]
    return row_product(row, a.constrained_acceleration, b.constrained_acceleration)


@njit
def speed_at(row: Any, bodies: Any, substep_bodies: Any, time: Any) -> Any:
    """Return J v of a row ``time`` s into the substep."""
    u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
    return u + time * acceleration_of(row, substep_bodies)


@njit
def meeting_time(gap: Any, speed: Any, acceleration: Any, start: Any) -> Any:
    """Return the first time >= start at which gap + speed t + acceleration t^2/2 falls to 0, else _NEVER."""
    now = gap + start * (speed + 0.5 * acceleration * start)
    v = speed + acceleration * start
    if now <= 0.0:
        if v < 0.0:
            return start
        return start - 2.0 * v / acceleration if acceleration < 0.0 else _NEVER
    root = v * v - 2.0 * acceleration * now
    if root < 0.0:
        return _NEVER
    root = root**0.5
    if v < 0.0:
        return start + 2.0 * now / (root - v)
    if acceleration < 0.0:
        return start + (v + root) / -acceleration
    return _NEVER


@njit
def _comes_to_rest(speed: Any, restitution: Any, acceleration: Any, remaining: Any) -> Any:
    """Whether all further bounces, t_k = 2 e^k speed / acceleration, fit into the rest of h."""
    if restitution >= 1.0:
        return speed <= 0.0
    return 2.0 * restitution * speed <= acceleration * (1.0 - restitution) * remaining


@njit
def _impact_time(row: Any, contacts: Any, bodies: Any, substep_bodies: Any, gravity_norm: Any, h: Any) -> Any:
    """Return the time in s within the substep at which the contact of a normal row has an impact, else _NEVER."""
    restitution = contacts[row.source].restitution
    if restitution <= 0.0:
        return _NEVER
    u = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
    a = acceleration_of(row, substep_bodies)
    start = max(substep_bodies[row.body_a].event_time, substep_bodies[row.body_b].event_time)
    gap = row.error + shifted(row, substep_bodies)
    time = meeting_time(gap, u, a, start)
    if time > h:
        row.flight = a
        return _NEVER
    row.flight = GROUNDED
    speed = -(u + a * time)
    if speed <= 1e-12 * (abs(u) + abs(a) * h):
        return _NEVER
    if _comes_to_rest(speed, restitution, max(-a, gravity_norm), h - time):
        return _NEVER
    return time


@njit
def expects_impact(world: Any, island: Any) -> Any:
    """Whether a contact of the island may bounce within the timestep, by the velocities at its start and gravity."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    gravity = island.gravity_norm
    for r in range(island.joint_rows, island.rows):
        contact = contacts[rows[r].source]
        if rows[r].correction != UNILATERAL or contact.restitution <= 0.0:
            continue
        u = relative_velocity(rows[r], bodies[rows[r].body_a], bodies[rows[r].body_b])
        time = meeting_time(contact.separation, u, -gravity, 0.0)
        if time <= world.options.timestep:
            speed = gravity * time - u
            if speed > 0.0 and not _comes_to_rest(speed, contact.restitution, gravity, island.h):
                return True
    return False


@njit
def _respond(row: Any, joint_factor: Any, impulse: Any) -> None:
    """Set x of the joint factor to the changes of the velocities of jointed bodies by an impulse on a row."""
    entries = joint_factor.entries
    size = joint_factor.plan.size
    clear_sides(size, entries)
    add_force(row, entries, impulse)
    substitute(size, entries, joint_factor.blocks)


@njit
def couple(row: Any, other: Any, substep_bodies: Any, joint_factor: Any) -> Any:
    """Return J_row M^-1 J_other^T of two rows on the same pair of bodies, with the joints of these bodies."""
    s = 0.0
    free_a = True
    free_b = True
    if joint_factor is not None:
        if joint_factor.plan.size > 0:
            entries = joint_factor.entries
            _respond(other, joint_factor, 1.0)
            s = change_of(row, entries)
            free_a = entries[row.body_a].place < 0
            free_b = entries[row.body_b].place < 0
    inverse_a = substep_bodies[row.body_a].inverse
    inverse_b = substep_bodies[row.body_b].inverse
    for i in range(len(row.jacobian_a)):
        if free_a:
            s += row.jacobian_a[i] * (inverse_a[i] * other.jacobian_a[i])
        if free_b:
            s += row.jacobian_b[i] * (inverse_b[i] * other.jacobian_b[i])
    return s


@njit
def _apply_to_free(row: Any, bodies: Any, substep_bodies: Any, impulse: Any, time: Any) -> None:
    """Apply an impulse at ``time`` to two bodies without joints."""
    a = bodies[row.body_a]
    b = bodies[row.body_b]
    substep_a = substep_bodies[row.body_a]
    substep_b = substep_bodies[row.body_b]
    for i in range(len(row.jacobian_a)):
        da = substep_a.inverse[i] * row.jacobian_a[i] * impulse
        db = substep_b.inverse[i] * row.jacobian_b[i] * impulse
        a.velocity[i] += da
        b.velocity[i] += db
        substep_a.impact_displacement[i] -= time * da
        substep_b.impact_displacement[i] -= time * db


@njit
def _apply_to_jointed(row: Any, bodies: Any, substep_bodies: Any, impulse: Any, time: Any, joint_factor: Any) -> None:
    """Apply an impulse at ``time``, propagated through the joints of the bodies."""
    _respond(row, joint_factor, impulse)
    entries = joint_factor.entries
    for p in range(joint_factor.plan.size):
        body = entries[p].order
        for i in range(len(entries[p].x)):
            bodies[body].velocity[i] += entries[p].x[i]
            substep_bodies[body].impact_displacement[i] -= time * entries[p].x[i]
    for side in range(2):
        body = row.body_a if side == 0 else row.body_b
        if entries[body].place < 0:
            jacobian = row.jacobian_a if side == 0 else row.jacobian_b
            for i in range(len(jacobian)):
                response = substep_bodies[body].inverse[i] * jacobian[i]
                bodies[body].velocity[i] += response * impulse
                substep_bodies[body].impact_displacement[i] -= time * response * impulse


@njit
def _acts_on_position(jacobian: Any, dim: Any) -> Any:
    """Whether a row acts on the position of a body, and not only on its rotation."""
    for d in range(dim):
        if jacobian[d] != 0.0:
            return True
    return False


@njit
def apply_impulse_at(row: Any, bodies: Any, substep_bodies: Any, impulse: Any, time: Any, joint_factor: Any) -> None:
    """Apply an impulse on a row ``time`` s into the substep, and shift the bodies by what it moved too early."""
    substep_a = substep_bodies[row.body_a]
    substep_b = substep_bodies[row.body_b]
    if joint_factor is None:
        _apply_to_free(row, bodies, substep_bodies, impulse, time)
    elif joint_factor.plan.size > 0:
        _apply_to_jointed(row, bodies, substep_bodies, impulse, time, joint_factor)
    else:
        _apply_to_free(row, bodies, substep_bodies, impulse, time)
    dim = len(substep_a.start_position)
    if substep_a.inverse[0] > 0.0 and _acts_on_position(row.jacobian_a, dim):
        substep_a.event_time = time  # not of the ground, which may have many impacts at once
    if substep_b.inverse[0] > 0.0 and _acts_on_position(row.jacobian_b, dim):
        substep_b.event_time = time


@njit
def set_constrained_accelerations(world: Any, island: Any, joint_factor: Any) -> None:
    """Set the accelerations x along the joints: (M + E^T s^-1 E) x = M a - E^T s^-1 dE/dt v.

    The bias of a row is h/2 dE/dt v.
    """
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    entries = joint_factor.entries
    size = joint_factor.plan.size
    clear_sides(size, entries)
    for r in range(island.joint_rows):
        row = rows[r]
        if row.kind == EQUATION and row.diagonal > 0.0:
            add_force(row, entries, -2.0 * row.bias / (island.h * EPSILON * row.diagonal))
    for p in range(size):
        substep_body = substep_bodies[entries[p].order]
        for i in range(len(substep_body.constrained_acceleration)):
            for j in range(len(substep_body.constrained_acceleration)):
                entries[p].x[i] += substep_body.mass_matrix[i, j] * substep_body.acceleration[j]
    substitute(size, entries, joint_factor.blocks)
    for p in range(size):
        substep_body = substep_bodies[entries[p].order]
        for i in range(len(substep_body.constrained_acceleration)):
            substep_body.constrained_acceleration[i] = entries[p].x[i]


@njit
def _satisfy_joints(rows: Any, bodies: Any, joint_factor: Any) -> None:
    """Project the velocities onto the joints' equations: an impact would take a violation for approach."""
    plan = joint_factor.plan
    for r in range(plan.row_end):
        row = rows[r]
        if row.softness > 0.0:  # a rotor resists the change from its present rate
            row.bias = -relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
        else:
            row.bias *= -1.0  # at the start of the substep instead of its end
    solve_equations(rows, plan.row_end, bodies, plan.size, joint_factor.entries, joint_factor.blocks, 0.0, None)


@njit
def resolve_impacts(world: Any, island: Any, joint_factor: Any) -> Any:
    """Resolve all impacts of one island within the substep; returns their number.

    The errors of its contact rows are up to date.  ``joint_factor``: that of the island's joints, through
    which impacts propagate, or None.
    """
    rows = world.scratch.rows
    substep_bodies = world.scratch.substep_bodies
    island_bodies = part(world.scratch.island_bodies, island.body_first, island.body_count)
    for k in range(len(island_bodies)):
        substep_bodies[island_bodies[k]].event_time = 0.0
    for r in range(island.joint_rows, island.rows):
        substep_bodies[rows[r].body_a].event_time = 0.0
        substep_bodies[rows[r].body_b].event_time = 0.0
    dim = len(substep_bodies[0].start_position)
    if island.rows - island.joint_rows > dim * ORDERED_LIMIT:
        return _impacts_in_passes(world, island, joint_factor)
    return _impacts_in_order(world, island, joint_factor)


@njit
def _impacts_in_order(world: Any, island: Any, joint_factor: Any) -> Any:
    """Resolve the impacts of few contacts, the earliest first, at quadratic cost."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    first = island.joint_rows
    end = island.rows
    count = 0
    satisfied = True
    if joint_factor is not None:
        satisfied = joint_factor.plan.size == 0
    for _ in range(8 + 2 * (end - first)):
        best = int64(-1)
        earliest = _NEVER
        for r in range(first, end):
            if rows[r].correction != UNILATERAL:
                continue
            time = _impact_time(rows[r], contacts, bodies, substep_bodies, island.gravity_norm, island.h)
            if time < earliest:
                earliest = time
                best = r
        if best < 0:
            break
        if joint_factor is not None:
            if not satisfied:
                _satisfy_joints(rows, bodies, joint_factor)
                satisfied = True
                continue
        apply_impact(world, island, best, earliest, joint_factor)
        count += 1
    return count


@njit
def _impacts_in_passes(world: Any, island: Any, joint_factor: Any) -> Any:
    """Resolve the impacts of many contacts in passes, in the order of the rows, at linear cost."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    h = island.h
    count = 0
    satisfied = True
    if joint_factor is not None:
        satisfied = joint_factor.plan.size == 0
    for _ in range(MAX_PASSES):
        before = count
        for r in range(island.joint_rows, island.rows):
            if rows[r].correction != UNILATERAL:
                continue
            time = _impact_time(rows[r], contacts, bodies, substep_bodies, island.gravity_norm, h)
            if time > h:
                continue
            if joint_factor is not None:
                if not satisfied:
                    _satisfy_joints(rows, bodies, joint_factor)
                    satisfied = True
                    time = _impact_time(rows[r], contacts, bodies, substep_bodies, island.gravity_norm, h)
            if time <= h:
                apply_impact(world, island, r, time, joint_factor)
                count += 1
        if count == before:
            break
    return count
