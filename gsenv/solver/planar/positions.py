"""Position pass: overlap and joint error leave through pseudo-velocities that are then discarded.

Real velocities stay untouched, so no energy is made.  Guendelman, Bridson, Fedkiw,
"Nonconvex rigid bodies with stacking", SIGGRAPH 2003, separate the two solves in the same way.
"""

from __future__ import annotations

from typing import Any

from ..jit import njit
from ..rows import BOUNDED, FRICTION

_INFINITY = float("inf")
SMOOTH = 1e-5  # of the extent: an overlap that the mean of velocities may add


@njit
def correct_positions(
    rows: Any, count: Any, contact_first: Any, motions: Any, contacts: Any, options: Any, h: Any
) -> None:
    """Sweeps over the rows with an error; fills ``motion.correction``."""
    rate = options.correction_rate / h
    busy = False
    for r in range(count):
        row = rows[r]
        row.position_impulse = 0.0
        row.previous = 0.0
        if r < contact_first:
            row.previous = rate * row.error
        elif row.kind == BOUNDED:
            extent = contacts[row.source].extent
            depth = row.error + options.slop * extent
            if depth < 0.0:
                row.previous = max(rate * depth, -options.push_speed * extent)
        if row.previous != 0.0:
            busy = True
    if not busy:
        return
    for _ in range(options.position_sweeps):
        _position_sweep(rows, count, contact_first, motions)


@njit
def _position_sweep(rows: Any, count: Any, contact_first: Any, motions: Any) -> None:
    for r in range(count):
        row = rows[r]
        if r >= contact_first and (row.kind == FRICTION or row.error > 0.0):
            continue
        a = motions[row.body_a]
        b = motions[row.body_b]
        w = row.previous
        for i in range(len(row.jacobian_a)):
            w += row.jacobian_a[i] * a.correction[i] + row.jacobian_b[i] * b.correction[i]
        old = row.position_impulse
        new = old - row.effective_mass * w
        if r >= contact_first:
            new = max(new, 0.0)
        d = new - old
        row.position_impulse = new
        if d != 0.0:
            for i in range(len(row.response_a)):
                a.correction[i] += row.response_a[i] * d
                b.correction[i] += row.response_b[i] * d


@njit
def _nothing_jumped(body_list: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any) -> Any:
    """Whether the change of velocity moves no point by more than the tolerance."""
    for k in range(len(body_list)):
        i = body_list[k]
        v = bodies[i].velocity
        u = motions[i].start_velocity
        jump = abs(v[0] - u[0]) + abs(v[1] - u[1]) + abs(v[2] - u[2]) * body_parameters[i].radius
        if 0.25 * h * jump > SMOOTH * body_parameters[i].extent:
            return False
    return True


@njit
def _mean_velocity(row: Any, bodies: Any, motions: Any) -> Any:
    """J (v_old + v_new) / 2."""
    s = 0.0
    a = bodies[row.body_a].velocity
    b = bodies[row.body_b].velocity
    start_a = motions[row.body_a].start_velocity
    start_b = motions[row.body_b].start_velocity
    for i in range(len(row.jacobian_a)):
        s += row.jacobian_a[i] * (a[i] + start_a[i]) + row.jacobian_b[i] * (b[i] + start_b[i])
    return 0.5 * s


@njit
def smooth_fraction(
    rows: Any,
    contact_first: Any,
    count: Any,
    body_list: Any,
    bodies: Any,
    body_parameters: Any,
    motions: Any,
    contacts: Any,
    h: Any,
) -> Any:
    """1.0 if the mean of old and new velocity keeps every contact of the island apart, else 0.0.

    Where bodies slide, roll or fly, both velocities obey the contacts and their mean is second
    order.  Where one lands, the old velocity points into the other body: the new one alone counts.
    """
    if _nothing_jumped(body_list, bodies, body_parameters, motions, h):
        return 1.0
    for r in range(contact_first):
        row = rows[r]
        if row.softness == 0.0 and row.lower == -_INFINITY and row.upper == _INFINITY:
            opened = h * abs(_mean_velocity(row, bodies, motions))
            if opened > SMOOTH * body_parameters[row.body_b].extent:
                return 0.0
    r = contact_first
    while r < count:
        row = rows[r]
        r += row.span
        extent = contacts[row.source].extent
        after = row.error + h * _mean_velocity(row, bodies, motions)  # impacts' shift is in error
        if after < min(row.error, 0.0) - SMOOTH * extent:
            return 0.0
    return 1.0
