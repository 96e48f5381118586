"""Rows in joint space: y = D^-1/2 L^-T J^T, so that the Delassus matrix of two rows is the product of their y.

A row is not zero only on the ways from its two bodies to their roots.  The rows of a contact alternate in memory
and share their list of degrees of freedom: first those of body a alone, then of body b alone, then of both.
"""

from __future__ import annotations

from typing import Any

from numba import int64, uint64

from ...jit import inline_njit, njit
from ..coupled import has_half
from ..dispatch import by_dimension
from ..rows import DISC, FRICTION, HALF, IDLE, free_rate

REGULAR = 1e-12  # of the product of the diagonals: smallest determinant of the block of two tangents
GIVE = 1e-4  # of the inverse masses of a contact that joints hold in one direction: compliance
HELD = 1e-6  # of the inverse mass of all bodies: least diagonal of a row at a point that joints hold still

reduced = by_dimension("articulation", "reduced")
added = by_dimension("articulation", "added")
no_impulse = by_dimension("articulation", "no_impulse")
impulse_at_origin = by_dimension("articulation", "impulse_at_origin")


@njit
def whiten_rows(world: Any, island: Any, articulation: Any) -> None:
    """Express all rows of the island in joint space, and set their diagonals and free velocities."""
    rows = world.scratch.rows
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    places = articulation.places
    links = articulation.links
    freedoms = articulation.freedoms
    spans = articulation.spans
    way = 0
    value = 0
    r = 0
    end = int64(island.joint_rows)  # of the contact
    while r < island.rows:
        row = rows[r]
        least = 0.0
        if row.kind == IDLE or row.kind == HALF:
            _leave_out(row, spans[r])
            r += 1
            continue
        width = 1
        if r == end:
            end = r + int(row.span)
            width = _width(rows, r, end - r)
            least = HELD / island.mass
        a = places[row.body_a] if body_parameters[row.body_a].inv_mass > 0.0 else -1
        b = places[row.body_b] if body_parameters[row.body_b].inv_mass > 0.0 else -1
        ends = (links[a].last if a >= 0 else -1, links[b].last if b >= 0 else -1)
        counts = _list_way(freedoms, ends, articulation.ways, way)
        for i in range(width):
            span = spans[r + i]
            span.places = way
            span.count = counts[2]
            span.values = value + i
            span.stride = width
            span.width = width if i == 0 else 0
            span.free = rows[r + i].bias + free_rate(rows[r + i], substep_bodies)
        if width == 3:
            _whiten_three(rows, r, (a, b), counts, articulation)
        else:
            for i in range(width):
                _whiten_one(rows, r + i, (a, b), counts, articulation)
        if width == 3:
            _gather_three(rows, r, spans, articulation.values, least)
        else:
            if width == 2:
                _gather_two(rows, r, spans, articulation.values)
            for i in range(width):
                _set_diagonal(rows, r + i, spans, articulation.values, least)
        way += counts[2]
        value += width * counts[2]
        more = _add_half(world, island, articulation, articulation.others, (r, way, value))
        way += more
        value += more
        r += width
    _couple_rolling(world, island, articulation)


@njit
def _add_half(world: Any, island: Any, articulation: Any, others: Any, at: Any) -> Any:
    """List the degrees of freedom of the second half of a row, if it has one, after its own; returns their number.

    ``at``: (row, place of the next degree of freedom, of the next value).
    """
    if others is None:
        return 0
    r, way, value = at
    rows = world.scratch.rows
    if not has_half(rows, r, island.other_rows):
        return 0
    body_parameters = world.parameters.bodies
    row = rows[r + 1]
    places = articulation.places
    links = articulation.links
    a = places[row.body_a] if body_parameters[row.body_a].inv_mass > 0.0 else -1
    b = places[row.body_b] if body_parameters[row.body_b].inv_mass > 0.0 else -1
    ends = (links[a].last if a >= 0 else -1, links[b].last if b >= 0 else -1)
    counts = _list_way(articulation.freedoms, ends, articulation.ways, way)
    span = articulation.spans[r + 1]
    span.places = way
    span.values = value
    span.stride = 1
    _whiten_one(rows, r + 1, (a, b), counts, articulation)
    articulation.spans[r].count += counts[2]
    articulation.spans[r].free += free_rate(row, world.scratch.substep_bodies)
    _set_size(rows[r], _square(articulation.spans[r], articulation, others))
    return counts[2]


@njit
def _square(span: Any, articulation: Any, others: Any) -> Any:
    """Return y . y of a row that may list a degree of freedom twice."""
    ways = articulation.ways
    values = articulation.values
    dense = others.dense
    first = span.values - span.places
    s = 0.0
    for p in range(span.places, span.places + span.count):
        dense[ways[p]] += values[first + p]
    for p in range(span.places, span.places + span.count):
        s += values[first + p] * dense[ways[p]]
    for p in range(span.places, span.places + span.count):
        dense[ways[p]] = 0.0
    return s


@njit
def _leave_out(row: Any, span: Any) -> None:
    """Give a row that takes no impulse no degrees of freedom."""
    span.places = 0
    span.values = 0
    span.count = 0
    span.width = 1
    span.free = 0.0
    _set_size(row, 0.0)


@njit
def _gather_three(rows: Any, r: Any, spans: Any, values: Any, least: Any) -> None:
    """Set the products of a normal and its two tangents, and write what sweeps read of them to the normal's span."""
    span = spans[r]
    nn, ns, nt, a, b, c = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    at = uint64(span.values)  # no sign to check
    for _ in range(span.count):
        x, y, z = values[at], values[at + uint64(1)], values[at + uint64(2)]
        nn += x * x
        ns += x * y
        nt += x * z
        a += y * y
        b += z * z
        c += y * z
        at += uint64(3)
    minors = nn * a - ns * ns + nn * b - nt * nt + a * b - c * c
    whole = nn * (a * b - c * c) - ns * (ns * b - nt * c) + nt * (ns * c - nt * a)
    give = _give(nn + a + b, whole, minors)
    span.give = give
    for i in range(3):
        rows[r + i].softness = give
    nn += give
    a += give
    b += give
    _set_size(rows[r], max(nn, least))
    _set_size(rows[r + 1], max(a, least))
    _set_size(rows[r + 2], max(b, least))
    rows[r + 1].coupling = c
    span.one = ns
    span.two = nt
    span.mass = rows[r].effective_mass
    span.cross = c
    span.friction = rows[r + 1].friction
    a = rows[r + 1].diagonal
    b = rows[r + 2].diagonal
    det = a * b - c * c
    inverse = 1.0 / det if det > REGULAR * a * b else 0.0
    span.inverse[0] = b * inverse
    span.inverse[1] = -c * inverse
    span.inverse[2] = a * inverse
    for i in range(3):
        span.sizes[i] = rows[r + i].diagonal
    for i in range(2):
        span.slip[i] = spans[r + 1 + i].free


@njit
def _gather_two(rows: Any, r: Any, spans: Any, values: Any) -> None:
    """Set the coupling of a normal and its tangent, and their compliance."""
    one = _product(spans[r], spans[r + 1], values)
    nn = _product(spans[r], spans[r], values)
    a = _product(spans[r + 1], spans[r + 1], values)
    spans[r].one = one
    give = _give(nn + a, nn * a - one * one, nn + a)
    rows[r].softness = give
    rows[r + 1].softness = give


@inline_njit
def _give(trace: Any, last: Any, before: Any) -> Any:
    """Return the compliance that keeps the least eigenvalue of a contact's block above ``GIVE`` of its trace.

    ``last`` and ``before``: the last two coefficients of its characteristic polynomial, whose ratio is that eigenvalue
    where it is small.
    """
    least = last / before if before > 0.0 else 0.0
    return max(GIVE * trace - max(least, 0.0), 0.0)


@njit
def _width(rows: Any, r: Any, left: Any) -> Any:
    """Return the number of rows from r on that are solved together: a normal with its tangents, or one."""
    if left < 2:
        return 1
    if rows[r + 1].kind == DISC:
        return 3
    return 2 if rows[r + 1].kind == FRICTION and rows[r + 1].base == 1 else 1


@njit
def _list_way(freedoms: Any, ends: Any, ways: Any, first: Any) -> Any:
    """List the degrees of freedom from two ends to their roots; returns (of a alone, of a or b alone, all)."""
    i, j = ends
    while i != j:
        if i > j:
            i = freedoms[i].parent
        else:
            j = freedoms[j].parent
    shared = i
    n = 0
    i, j = ends
    while i != shared:
        ways[first + n] = i
        n += 1
        i = freedoms[i].parent
    alone = n
    while j != shared:
        ways[first + n] = j
        n += 1
        j = freedoms[j].parent
    apart = n
    while shared >= 0:
        ways[first + n] = shared
        n += 1
        shared = freedoms[shared].parent
    return alone, apart, n


@njit
def _ends_of(row: Any, links: Any, sides: Any) -> Any:
    """Return the impulses at the origin on both links by a unit impulse of a row."""
    p = no_impulse(links[0])
    q = no_impulse(links[0])
    if sides[0] >= 0:
        p = impulse_at_origin(links[sides[0]], row.jacobian_a)
    if sides[1] >= 0:
        q = impulse_at_origin(links[sides[1]], row.jacobian_b)
    return p, q


@njit
def _whiten_one(rows: Any, r: Any, sides: Any, counts: Any, articulation: Any) -> None:
    freedoms = articulation.freedoms
    ways = articulation.ways
    values = articulation.values
    span = articulation.spans[r]
    p, q = _ends_of(rows[r], articulation.links, sides)
    first = span.places
    at = span.values
    stride = span.stride
    for i in range(counts[2]):
        if i == counts[1]:
            p = added(freedoms[0], p, q)
        freedom = freedoms[ways[first + i]]
        if i >= counts[0] and i < counts[1]:
            g, q = reduced(freedom, 0.0, q)
        else:
            g, p = reduced(freedom, 0.0, p)
        values[at] = g * freedom.root
        at += stride


@njit
def _whiten_three(rows: Any, r: Any, sides: Any, counts: Any, articulation: Any) -> None:
    """Express a normal and its two tangents at once."""
    freedoms = articulation.freedoms
    ways = articulation.ways
    values = articulation.values
    first = articulation.spans[r].places
    at = articulation.spans[r].values
    links = articulation.links
    p, s = _ends_of(rows[r], links, sides)
    q, t = _ends_of(rows[r + 1], links, sides)
    o, u = _ends_of(rows[r + 2], links, sides)
    for i in range(counts[0]):
        freedom = freedoms[ways[first + i]]
        x, p = reduced(freedom, 0.0, p)
        y, q = reduced(freedom, 0.0, q)
        z, o = reduced(freedom, 0.0, o)
        _write(values, at + 3 * i, freedom.root, x, y, z)
    for i in range(counts[0], counts[1]):
        freedom = freedoms[ways[first + i]]
        x, s = reduced(freedom, 0.0, s)
        y, t = reduced(freedom, 0.0, t)
        z, u = reduced(freedom, 0.0, u)
        _write(values, at + 3 * i, freedom.root, x, y, z)
    p = added(freedoms[0], p, s)
    q = added(freedoms[0], q, t)
    o = added(freedoms[0], o, u)
    for i in range(counts[1], counts[2]):
        freedom = freedoms[ways[first + i]]
        x, p = reduced(freedom, 0.0, p)
        y, q = reduced(freedom, 0.0, q)
        z, o = reduced(freedom, 0.0, o)
        _write(values, at + 3 * i, freedom.root, x, y, z)


@njit
def _write(values: Any, at: Any, root: Any, x: Any, y: Any, z: Any) -> None:
    values[at] = x * root
    values[at + 1] = y * root
    values[at + 2] = z * root


@njit
def _set_diagonal(rows: Any, r: Any, spans: Any, values: Any, least: Any) -> None:
    """Set the diagonal, at least ``least``, and the effective mass of a row."""
    _set_size(rows[r], max(rows[r].softness + _product(spans[r], spans[r], values), least))


@njit
def _set_size(row: Any, size: Any) -> None:
    row.diagonal = size
    row.effective_mass = 1.0 / size if size > 0.0 else 0.0


@njit
def _product(span: Any, other: Any, values: Any) -> Any:
    """Return y . y of two rows with one list of degrees of freedom."""
    s = 0.0
    i = span.values
    j = other.values
    for _ in range(span.count):
        s += values[i] * values[j]
        i += span.stride
        j += other.stride
    return s


@njit
def _couple_rolling(world: Any, island: Any, articulation: Any) -> None:
    """Set the coupling of the two rows of rolling friction, which are solved alone."""
    rows = world.scratch.rows
    spans = articulation.spans
    for r in range(island.joint_rows, island.rows):
        if rows[r].kind == DISC and spans[r].width == 1:
            rows[r].coupling = _product(spans[r], spans[r + 1], articulation.values)
