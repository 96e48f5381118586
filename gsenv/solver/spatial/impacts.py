"""One 3D impact: of all contacts of a manifold that are hit at the same time, with friction.

The impact is shared by Gauss-Seidel sweeps over their normals and friction discs until nothing changes.
"""

from __future__ import annotations

from typing import Any

from ..core.contact_rows import shifted
from ..core.impacts import acceleration_of, apply_impulse_at, couple, speed_at
from ..core.rows import UNILATERAL
from ..jit import njit
from ..methods.disc import minimise_on_disc
from .contact_rows import add_pushes
from .friction_cone import cone_span

GROUP_SWEEPS = 60  # largest number of sweeps over the contacts of one manifold


@njit
def _manifold_start(rows: Any, r: Any, first: Any, contacts: Any) -> Any:
    """Return the first row of the contacts between the two shapes of normal row r."""
    here = contacts[rows[r].source]
    start = r
    k = r - 1
    while k >= first:
        there = contacts[rows[k].source]
        if there.shape_a != here.shape_a or there.shape_b != here.shape_b:
            break
        if rows[k].correction == UNILATERAL:
            start = k
        k -= 1
    return start


@njit
def _manifold_stop(rows: Any, r: Any, end: Any, contacts: Any) -> Any:
    """Return the first row after the contacts between the two shapes of row r."""
    here = contacts[rows[r].source]
    stop = r
    while stop < end:
        there = contacts[rows[stop].source]
        if there.shape_a != here.shape_a or there.shape_b != here.shape_b:
            break
        stop += int(rows[stop].span)
    return stop


@njit
def _join(world: Any, k: Any, r: Any, time: Any) -> None:
    """Mark whether the contact of row k is hit together with that of row r, store its speed, clear its impulses."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    row = rows[k]
    for i in range(int(row.span)):
        rows[k + i].direction = 0.0
    u = speed_at(row, bodies, substep_bodies, time)
    gap = row.error + shifted(row, substep_bodies) + time * (u - 0.5 * acceleration_of(row, substep_bodies) * time)
    hit = k == r or (gap < 1e-4 * world.state.contacts[row.source].extent and u < 0.0)
    for i in range(cone_span(rows, k)):
        side = rows[k + i]
        side.direction = 1.0 if hit else 0.0
        side.position_impulse = 0.0
        side.previous = speed_at(side, bodies, substep_bodies, time)


@njit
def _hit(rows: Any, k: Any, restitution: Any, bodies: Any, substep_bodies: Any, time: Any, joint_factor: Any) -> Any:
    """Solve one contact: approach speed times -e, slip stopped within friction; returns the change in m/s."""
    row = rows[k]
    mass = couple(row, row, substep_bodies, joint_factor)
    if mass <= 0.0:
        return 0.0
    lack = speed_at(row, bodies, substep_bodies, time) + restitution * row.previous
    new = max(row.position_impulse - lack / mass, 0.0)
    d = new - row.position_impulse
    row.position_impulse = new
    apply_impulse_at(row, bodies, substep_bodies, d, time, joint_factor)
    change = abs(d) * mass
    if cone_span(rows, k) == 1:
        return change
    one = rows[k + 1]
    two = rows[k + 2]
    a = couple(one, one, substep_bodies, joint_factor)
    c = couple(one, two, substep_bodies, joint_factor)
    e = couple(two, two, substep_bodies, joint_factor)
    x = one.position_impulse
    y = two.position_impulse
    g = speed_at(one, bodies, substep_bodies, time) - a * x - c * y
    h = speed_at(two, bodies, substep_bodies, time) - c * x - e * y
    s, t = minimise_on_disc(a, c, e, g, h, one.friction * new)
    one.position_impulse = s
    two.position_impulse = t
    apply_impulse_at(one, bodies, substep_bodies, s - x, time, joint_factor)
    apply_impulse_at(two, bodies, substep_bodies, t - y, time, joint_factor)
    return change + abs(s - x) * a + abs(t - y) * e


@njit
def _guard(rows: Any, start: Any, stop: Any, bodies: Any, substep_bodies: Any, time: Any, joint_factor: Any) -> None:
    """Scale the impulses back so that they cannot increase the kinetic energy."""
    work = 0.0
    change = 0.0
    for k in range(start, stop):
        p = rows[k].position_impulse
        if rows[k].direction == 1.0 and p != 0.0:
            work += p * rows[k].previous
            change += 0.5 * p * (speed_at(rows[k], bodies, substep_bodies, time) - rows[k].previous)
    if work + change <= 0.0 or change <= 0.0:
        return
    scale = max(-work / change, 0.0)
    for k in range(start, stop):
        p = rows[k].position_impulse
        if rows[k].direction == 1.0 and p != 0.0:
            apply_impulse_at(rows[k], bodies, substep_bodies, (scale - 1.0) * p, time, joint_factor)
            rows[k].position_impulse = scale * p


@njit
def apply_impact(world: Any, island: Any, r: Any, time: Any, joint_factor: Any) -> None:
    """Resolve the impact of normal row r, and of all contacts of its manifold that are hit at the same time."""
    rows = world.scratch.rows
    contacts = world.state.contacts
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    restitution = contacts[rows[r].source].restitution
    start = _manifold_start(rows, r, island.joint_rows, contacts)
    stop = _manifold_stop(rows, start, island.rows, contacts)
    k = start
    while k < stop:
        _join(world, k, r, time)
        k += int(rows[k].span)
    enough = 1e-13 * abs(rows[r].previous)
    for _ in range(GROUP_SWEEPS):
        change = 0.0
        k = start
        while k < stop:
            if rows[k].direction == 1.0:
                change += _hit(rows, k, restitution, bodies, substep_bodies, time, joint_factor)
            k += int(rows[k].span)
        if change <= enough:
            break
    _guard(rows, start, stop, bodies, substep_bodies, time, joint_factor)
    k = start
    while k < stop:
        if rows[k].direction == 1.0:
            pushes = (rows[k].position_impulse, 0.0, 0.0)
            if cone_span(rows, k) == 3:
                pushes = (rows[k].position_impulse, rows[k + 1].position_impulse, rows[k + 2].position_impulse)
            add_pushes(contacts[rows[k].source], rows, k, substep_bodies, pushes)
        k += int(rows[k].span)
