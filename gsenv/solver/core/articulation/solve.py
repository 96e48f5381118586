"""Accelerated sweeps over rows in joint space, against the vector z of whitened rates with unit masses.

z = sum of y times impulse; a row's velocity is its free velocity + y . z.  The acceleration is that of
methods/nncg.py.
"""

from __future__ import annotations

from typing import Any

from numba import int64, uint64

from ...jit import inline_njit, njit
from ...methods.disc import minimise_again, minimise_near, minimise_on_disc
from ...records.options import SolverKind
from ..coupled import share_corrections, share_impulses
from ..energy import STRICT
from ..rows import DISC, EQUATION, FRICTION, IDLE, UNILATERAL, push_row
from .equations import add_to, correct_others, dot_with, start_corrections, sweep_others

_PGS = int(SolverKind.PGS)
LOOK = 6  # sweeps between two looks at the progress
STALLED = 0.7  # of the least squared change before: sweeps that reduce it less are the last
WEDGED = 1e-3  # of the squared effect of the impulses of a contact: smaller if they almost cancel in the joints
POOR = 1e-3  # of the inverse masses: compliance of corrections, which joints hinder where levers are short


@njit
def start_solve(world: Any, island: Any, articulation: Any) -> Any:
    """Set z from the stored impulses; returns the scale of the squared residual, as energy.apply_warm_start does."""
    rows = world.scratch.rows
    spans = articulation.spans
    fall = island.gravity_norm * island.h
    s = 1e-300
    approach = 0.0
    slip = 0.0
    for r in range(island.rows):
        row = rows[r]
        u = spans[r].free
        if row.correction == UNILATERAL:
            u = min(u, 0.0)
            approach = fall - u
        elif row.kind == FRICTION:
            u = min(abs(u), row.friction * approach)
        elif row.kind == DISC:
            slip = u
            u = min(abs(u), row.friction * approach)
        elif row.kind > DISC:
            u = min(abs(u), max((row.friction * approach) ** 2 - slip * slip, 0.0) ** 0.5)
        mass = row.effective_mass
        if r >= island.joint_rows and (row.correction == UNILATERAL or spans[r].width == 0):
            mass = min(mass, island.mass)  # more where joints hold the point still
        s += (fall * fall + u * u) * mass
    _forget_wedged(world, island, articulation)
    add_all_impulses(world, island, articulation)
    return s


@njit
def _forget_wedged(world: Any, island: Any, articulation: Any) -> None:
    """Clear the stored impulses of contacts between two bodies if they almost cancel in the joints.

    Such contacts can be stuck with any impulse, so a solve would keep one that an unfinished solve left there.
    From zero, they stick only if the free motion wedges them.
    """
    rows = world.scratch.rows
    spans = articulation.spans
    z = articulation.whitened
    for f in range(island.freedoms):
        z[f] = 0.0
    r = int64(island.joint_rows)
    while r < island.rows:
        first = r
        last = r
        apart = 0.0
        while r < island.rows and rows[r].body_a == rows[first].body_a and rows[r].body_b == rows[first].body_b:
            p = rows[r].impulse
            if p != 0.0:
                apart += p * p * rows[r].diagonal
                add_to(spans[r], articulation.ways, articulation.values, z, p)
                last = r
            r += 1
        if apart > 0.0 and _take_square(spans[last], articulation.ways, z) < WEDGED * apart:
            for i in range(first, r):
                rows[i].impulse = 0.0


@njit
def _take_square(span: Any, ways: Any, z: Any) -> Any:
    """Return the square of z on the degrees of freedom of a row, and set z to 0 there."""
    s = 0.0
    for p in range(span.places, span.places + span.count):
        s += z[ways[p]] * z[ways[p]]
        z[ways[p]] = 0.0
    return s


@njit
def add_all_impulses(world: Any, island: Any, articulation: Any) -> None:
    """Set z to the whitened rates by the impulses of all rows."""
    rows = world.scratch.rows
    spans = articulation.spans
    z = articulation.whitened
    for f in range(island.freedoms):
        z[f] = 0.0
    for r in range(island.rows):
        if rows[r].impulse != 0.0:
            add_to(spans[r], articulation.ways, articulation.values, z, rows[r].impulse)


@njit
def _sweep(rows: Any, first: Any, count: Any, articulation: Any, push: Any) -> Any:
    """Take one sweep over ``rows[first:count]``; returns sum d^2 A_rr.  ``push`` as in methods/pgs.sweep."""
    spans = articulation.spans
    ways = articulation.ways
    values = articulation.values
    z = articulation.whitened
    change = 0.0
    normal = 0.0
    r = first
    while r < count:
        span = spans[r]
        if span.width == 3:
            step, normal = _solve_three(span, ways, values, z, push)
            change += step
            r += 3
            continue
        row = rows[r]
        if row.kind == DISC:
            change += _solve_disc(rows, r, articulation, normal, push)
            r += 2
        elif row.kind == IDLE:
            r += 1
        else:
            push_row(row, push)
            old = row.impulse
            w = span.free + row.softness * old + dot_with(span, ways, values, z)
            new = old - row.effective_mass * w
            if row.kind == FRICTION:
                bound = row.friction * normal
                new = min(max(new, -bound), bound)
            else:
                new = min(max(new, row.lower), row.upper)
                normal = new
            d = new - old
            row.impulse = new
            if d != 0.0:
                add_to(span, ways, values, z, d)
            change += d * d * row.diagonal
            r += 1
    return change


@njit
def _solve_three(span: Any, ways: Any, values: Any, z: Any, push: Any) -> Any:
    """Solve a normal row and its disc; returns (sum d^2 A_rr, normal impulse)."""
    _push_three(span, push)
    n, s, t = span.impulse[0], span.impulse[1], span.impulse[2]
    if n == 0.0 and s == 0.0 and t == 0.0 and span.free + dot_with(span, ways, values, z) >= 0.0:
        return 0.0, 0.0
    w, u, v = _dot_three(span, ways, values, z)
    a, b, c = span.sizes[1], span.sizes[2], span.cross
    give = span.give
    new = max(n - span.mass * (span.free + w + give * n), 0.0)
    d = new - n
    u += span.slip[0] + span.one * d - (a - give) * s - c * t
    v += span.slip[1] + span.two * d - c * s - (b - give) * t
    bound = span.friction * new
    x = -span.inverse[0] * u - span.inverse[1] * v
    y = -span.inverse[1] * u - span.inverse[2] * v
    if span.inverse[0] == 0.0:
        x, y = minimise_on_disc(a, c, b, u, v, bound)
    elif x * x + y * y > bound * bound:
        x, y = minimise_near((a, c, b), (u, v), bound, (s, t))
    span.impulse[0], span.impulse[1], span.impulse[2] = new, x, y
    x -= s
    y -= t
    if d != 0.0 or x != 0.0 or y != 0.0:
        _add_three(span, ways, values, z, (d, x, y))
    return d * d * span.sizes[0] + x * x * a + y * y * b, new


@inline_njit
def _push_three(span: Any, push: Any) -> None:
    """Take the conjugate step of three rows, as rows.push_row does of one."""
    beta, keep = push
    for i in range(3):
        d = beta * span.direction[i] if beta > 0.0 else 0.0
        span.direction[i] = d + span.impulse[i] - span.previous[i] if keep else d
        span.impulse[i] += d
        span.previous[i] = span.impulse[i]


@inline_njit
def _dot_three(span: Any, ways: Any, values: Any, z: Any) -> Any:
    """Return y . z of three rows that alternate."""
    w, u, v = 0.0, 0.0, 0.0
    i = uint64(span.values)  # no sign to check
    for p in range(uint64(span.places), uint64(span.places + span.count)):
        x = z[ways[p]]
        w += values[i] * x
        u += values[i + uint64(1)] * x
        v += values[i + uint64(2)] * x
        i += uint64(3)
    return w, u, v


@inline_njit
def _add_three(span: Any, ways: Any, values: Any, z: Any, impulses: Any) -> None:
    """Add y times impulse of three rows that alternate to z."""
    d, x, y = impulses
    i = uint64(span.values)
    for p in range(uint64(span.places), uint64(span.places + span.count)):
        z[ways[p]] += values[i] * d + values[i + uint64(1)] * x + values[i + uint64(2)] * y
        i += uint64(3)


@njit
def _load_impulses(rows: Any, first: Any, count: Any, spans: Any) -> None:
    """Copy the impulses of rows to the spans of those that are solved in threes."""
    for r in range(first, count):
        if spans[r].width == 3:
            for i in range(3):
                spans[r].impulse[i] = rows[r + i].impulse


@njit
def _store_impulses(rows: Any, first: Any, count: Any, spans: Any) -> None:
    """Copy them back."""
    for r in range(first, count):
        if spans[r].width == 3:
            for i in range(3):
                rows[r + i].impulse = spans[r].impulse[i]


@njit
def _solve_disc(rows: Any, r: Any, articulation: Any, normal: Any, push: Any) -> Any:
    """Solve rows r and r + 1, a disc of its own; returns sum d^2 A_rr."""
    ways = articulation.ways
    values = articulation.values
    z = articulation.whitened
    spans = articulation.spans
    one = rows[r]
    two = rows[r + 1]
    push_row(one, push)
    push_row(two, push)
    s = one.impulse
    t = two.impulse
    c = one.coupling
    u = spans[r].free + dot_with(spans[r], ways, values, z) - one.diagonal * s - c * t
    v = spans[r + 1].free + dot_with(spans[r + 1], ways, values, z) - c * s - two.diagonal * t
    x, y = minimise_again((one.diagonal, c, two.diagonal), (u, v), one.friction * max(normal, 0.0), (s, t))
    one.impulse = x
    two.impulse = y
    x -= s
    y -= t
    if x != 0.0 or y != 0.0:
        add_to(spans[r], ways, values, z, x)
        add_to(spans[r + 1], ways, values, z, y)
    return x * x * one.diagonal + y * y * two.diagonal


@njit
def sweep_rows(world: Any, island: Any, articulation: Any, most: Any) -> Any:
    """Take at most ``most`` sweeps until the residual is below the tolerance. Returns (sweeps, residual).

    Ends before where sweeps no longer reduce the residual, as between surfaces that friction locks.
    """
    rows = world.scratch.rows
    spans = articulation.spans
    z = articulation.whitened
    before = articulation.before
    conjugate = articulation.conjugate
    options = world.options
    first = int64(island.other_rows)
    count = int64(island.rows)
    plain = options.solver == _PGS
    goal = options.tolerance * options.tolerance * island.residual_scale
    change = 0.0
    last = 0.0
    least = 0.0
    mark = 0.0
    used = int64(0)
    _load_impulses(rows, first, count, spans)
    for f in range(island.freedoms):
        before[f] = z[f]
        conjugate[f] = 0.0
    for k in range(most):
        beta = 0.0
        keep = k == 1
        if k > 1 and change <= last and not plain:  # else a restart: the next direction is the last change alone
            beta = change / last
            keep = True
        last = change
        for f in range(island.freedoms):
            d = beta * conjugate[f]
            conjugate[f] = d + z[f] - before[f] if keep else d
            z[f] += d
            before[f] = z[f]
        change = _sweep(rows, first, count, articulation, (beta, keep))
        change += sweep_others(world, island, articulation, articulation.others, (beta, keep))
        used += 1
        least = change if k == 0 else min(least, change)
        if change <= goal:
            break
        if used % LOOK == 0:
            if used > LOOK and least > STALLED * mark:
                break
            mark = least
    _store_impulses(rows, first, count, spans)
    share_impulses(rows, first)
    return used, (change / island.residual_scale) ** 0.5


@njit
def limit_energy(world: Any, island: Any, articulation: Any) -> None:
    """Scale impulses of an unfinished solve back where they increased the energy; see energy.guard_energy.

    The rates without impulses contain all that joints of trees do; joints that close loops may do positive work.
    """
    least = 0.5 if island.other_rows > 0 else STRICT
    rows = world.scratch.rows
    spans = articulation.spans
    z = articulation.whitened
    slope = 0.0
    curve = 0.0
    for f in range(island.freedoms):
        curve += z[f] * z[f]
    for r in range(island.rows):
        slope += rows[r].impulse * (spans[r].free - rows[r].bias)
    if curve <= 0.0 or slope <= -least * curve:
        return
    s = max(-slope / curve, 0.0)
    for r in range(island.rows):
        rows[r].impulse *= s
    for f in range(island.freedoms):
        z[f] *= s


@njit
def correct_overlaps(world: Any, island: Any, articulation: Any) -> Any:
    """Set z to the pseudo-rates that reduce overlaps and errors of limits; False where there are none.

    See core/position_pass.py, whose rules these are.
    """
    rows = world.scratch.rows
    contacts = world.state.contacts
    body_parameters = world.parameters.bodies
    spans = articulation.spans
    z = articulation.whitened
    options = world.options
    rate = options.correction_rate / island.h
    others = articulation.others
    busy = start_corrections(world, island, others)
    for r in range(island.other_rows, island.rows):
        row = rows[r]
        row.position_impulse = 0.0
        row.previous = 0.0
        if row.correction != UNILATERAL:
            if row.kind == EQUATION and row.softness == 0.0:
                row.previous = rate * row.error
        elif r < island.joint_rows:
            row.previous = rate * min(row.error, 0.0)
        else:
            extent = contacts[row.source].extent
            depth = row.error + options.slop * extent
            if depth < 0.0:
                row.previous = max(rate * depth, -options.push_speed * extent)
        busy = busy or row.previous != 0.0
    if not busy:
        return False
    for f in range(island.freedoms):
        z[f] = 0.0
    for _ in range(options.position_sweeps):
        for r in range(island.other_rows, island.rows):
            row = rows[r]
            one_sided = row.correction == UNILATERAL
            if (one_sided and row.error > 0.0) or (not one_sided and row.previous == 0.0):
                continue
            give = POOR * (body_parameters[row.body_a].inv_mass + body_parameters[row.body_b].inv_mass)
            w = row.previous + give * row.position_impulse
            w += dot_with(spans[r], articulation.ways, articulation.values, z)
            new = row.position_impulse - w / (row.diagonal + give)
            if one_sided:
                new = max(new, 0.0)
            d = new - row.position_impulse
            row.position_impulse = new
            if d != 0.0:
                add_to(spans[r], articulation.ways, articulation.values, z, d)
        correct_others(world, island, articulation, others)
    share_corrections(rows, int64(island.other_rows))
    return options.position_sweeps > 0
