"""The order in which the bodies of an island are eliminated, and what each elimination joins.

The body with the fewest neighbours is next (minimum degree), on a quotient graph: what an eliminated body joined is
kept as one list of neighbours, not as edges between them.  A tree of joints (a chain, a ragdoll) has no fill-in and
costs linear time; loops and heaps have little.  Bodies with very many neighbours, such as a tray with a heap on it,
are last, since their degrees would be counted anew in each elimination.

The graph is one int32 array, which is small enough to stay in the cache: edges (4 for each row), from ``_marks`` on the
mark of each body, and from ``_lists`` on as many numbers as there are blocks for each of: neighbours of eliminated
bodies; the eliminated body; the next place where the neighbour is one.

George, Liu, "The evolution of the minimum degree ordering algorithm", SIAM Review 31 (1989);
Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM J. Matrix Anal. Appl. 17 (1996).
"""

from __future__ import annotations

from typing import Any

from ..core.rows import EQUATION
from ..jit import njit

GRAPH_NUMBERS = 3  # for each block of the factor, in the array of the graph
OUTSIDE = -1  # places of bodies without a block row: not in the factor,
_WAITING = -2  # with rows, but not eliminated yet,
_IDLE = -3  # in the island, but without a row so far
_ABSORBED = -1  # degree of an eliminated body whose neighbours are all those of another one
_GONE = (1 << 31) - 1  # mark of an eliminated body: no mark is larger
_LAST = -2  # degree of a body with very many neighbours
MANY = 16  # neighbours, and
MANY_ROOTS = 10.0  # of the number of bodies: a body with more than both is one of the last


@njit
def _counts(row: Any, equations: Any) -> Any:
    return row.kind == EQUATION or not equations


@njit
def link_bodies(rows: Any, count: Any, equations: Any, island_bodies: Any, factor: Any, graph: Any) -> None:
    """List the neighbours of each body as linked lists: entries 2e and 2e+1 are the edge before e and its other body.

    The lists spare later code the access to a row, in memory, for each edge.
    """
    for k in range(len(island_bodies)):
        factor[island_bodies[k]].place = _IDLE
    last_a = -1
    last_b = -1
    e = 0
    for r in range(count):
        a = rows[r].body_a
        b = rows[r].body_b
        if (a == last_a and b == last_b) or not _counts(rows[r], equations):
            continue
        last_a = a
        last_b = b
        for side in range(2):
            body = a if side == 0 else b
            if factor[body].place == _IDLE:
                factor[body].place = _WAITING
                factor[body].head = -1
        if a != b and factor[a].place == _WAITING and factor[b].place == _WAITING:
            graph[2 * e] = factor[a].head
            graph[2 * e + 1] = b
            factor[a].head = e
            graph[2 * e + 2] = factor[b].head
            graph[2 * e + 3] = a
            factor[b].head = e + 1
            e += 2


@njit
def _put(body: Any, degree: Any, factor: Any) -> None:
    """Add a body to the list of those with a degree."""
    entry = factor[body]
    entry.degree = degree
    entry.before = -1
    entry.after = factor[degree].bucket
    if entry.after >= 0:
        factor[entry.after].before = body
    factor[degree].bucket = body


@njit
def _take(body: Any, factor: Any) -> None:
    """Remove a body from the list of those with its degree."""
    entry = factor[body]
    if entry.before >= 0:
        factor[entry.before].after = entry.after
    else:
        factor[entry.degree].bucket = entry.after
    if entry.after >= 0:
        factor[entry.after].before = entry.before


@njit
def _marks(factor: Any, graph: Any, room: Any) -> Any:
    return len(graph) - GRAPH_NUMBERS * room - len(factor)


@njit
def _lists(graph: Any, room: Any) -> Any:
    return len(graph) - GRAPH_NUMBERS * room


@njit
def _list_degrees(island_bodies: Any, factor: Any, graph: Any, room: Any) -> Any:
    """Sort the bodies that rows move by their number of neighbours; returns (how many they are, how many are last)."""
    marks = _marks(factor, graph, room)
    n = 0
    for k in range(len(island_bodies)):
        factor[k].bucket = -1
        body = island_bodies[k]
        factor[body].list = -1
        graph[marks + body] = -1
        n += int(factor[body].place == _WAITING)
    most = max(MANY, MANY_ROOTS * n**0.5)
    last = 0
    for k in range(len(island_bodies)):
        body = island_bodies[k]
        if factor[body].place == _WAITING:
            degree = _count_marked(body, 0, body, factor, graph, marks)
            if degree <= most:
                _put(body, degree, factor)
            else:
                factor[body].degree = _LAST
                last += 1
    return n, last


@njit
def _count_marked(body: Any, count: Any, mark: Any, factor: Any, graph: Any, marks: Any) -> Any:
    """Mark the neighbours by edges that have a smaller mark; returns ``count`` plus their number."""
    edge = factor[body].head
    while edge >= 0:
        other = graph[2 * edge + 1]
        if graph[marks + other] != _GONE and graph[marks + other] != mark:
            graph[marks + other] = mark
            count += 1
        edge = graph[2 * edge]
    return count


@njit
def _eliminate(body: Any, first: Any, mark: Any, factor: Any, graph: Any, room: Any) -> Any:
    """List the neighbours of a body from place ``first`` on; returns where they end, -1 if there is no room.

    They are its neighbours by edges and those of eliminated bodies next to it, whose lists are then not needed.
    """
    marks, lists = _marks(factor, graph, room), _lists(graph, room)
    end = first
    graph[marks + body] = _GONE
    edge = factor[body].head
    while edge >= 0 and end >= 0:
        end = _list(graph[2 * edge + 1], end, mark, marks, lists, graph, room)
        edge = graph[2 * edge]
    place = factor[body].list
    while place >= 0 and end >= 0:
        near = factor[graph[lists + room + place]]
        if near.degree >= 0:
            for k in range(lists + near.start, lists + near.start + near.size):
                end = _list(graph[k], end, mark, marks, lists, graph, room)
            near.degree = _ABSORBED
        place = graph[lists + 2 * room + place]
    return end


@njit
def _list(body: Any, end: Any, mark: Any, marks: Any, lists: Any, graph: Any, room: Any) -> Any:
    """List a body at ``end`` unless it is marked; returns the new end, -1 if there is no room or there was none."""
    if end < 0 or graph[marks + body] >= mark:
        return end
    if end >= room:
        return -1
    graph[marks + body] = mark
    graph[lists + end] = body
    return end + 1


@njit
def _degree(body: Any, mark: Any, factor: Any, graph: Any, room: Any) -> Any:
    """Return the number of neighbours of a body, by edges or next to an eliminated body, and how many were visited."""
    marks, lists = _marks(factor, graph, room), _lists(graph, room)
    graph[marks + body] = mark
    count = visited = 0
    last = -1
    place = factor[body].list
    while place >= 0:
        near = factor[graph[lists + room + place]]
        following = graph[lists + 2 * room + place]
        if near.degree >= 0:
            last = place
            visited += near.size
            for k in range(lists + near.start, lists + near.start + near.size):
                if graph[marks + graph[k]] < mark:
                    graph[marks + graph[k]] = mark
                    count += 1
        elif last >= 0:
            graph[lists + 2 * room + last] = following
        else:
            factor[body].list = following
        place = following
    return _count_marked(body, count, mark, factor, graph, marks), visited


@njit
def _note_neighbours(body: Any, first: Any, end: Any, factor: Any, graph: Any, room: Any) -> None:
    """Note at the neighbours of an eliminated body that they are next to it."""
    lists = _lists(graph, room)
    for k in range(first, end):
        other = factor[graph[lists + k]]
        graph[lists + room + k] = body
        graph[lists + 2 * room + k] = other.list
        other.list = k


@njit
def _is_refused(products: Any, blocks: Any, degree: Any, most_products: Any, room: Any) -> Any:
    """Whether a factor is too large that has so much already, while each body left has at least ``degree`` neighbours.

    The last of them are then eliminated with at least degree, degree - 1, ..., 0 neighbours.
    """
    products += degree * (degree + 1) * (degree + 2) // 6
    blocks += (degree + 1) * (degree + 2) // 2
    return products > most_products or blocks > room


@njit
def order_bodies(island_bodies: Any, factor: Any, graph: Any, room: Any, most_products: Any, most_visits: Any) -> Any:
    """Order the bodies by minimum degree; returns their number and that of the products, (0, 0) if refused.

    ``room``: number of blocks that fit, diagonal ones included. ``most_visits`` bounds the time of the ordering itself.
    ``list``, ``start``, ``size`` and ``degree`` of an entry are those of the body with its index.
    """
    n, last = _list_degrees(island_bodies, factor, graph, room)
    mark = len(factor)  # larger than those of _list_degrees
    total = products = degree = waiting = visits = 0
    for p in range(n):
        if p < n - last:
            while factor[degree].bucket < 0:
                degree += 1
            body = factor[degree].bucket
            if visits > most_visits or _is_refused(products, total + p, degree, most_products, room):
                return 0, 0
            _take(body, factor)
        else:
            while factor[island_bodies[waiting]].place != _WAITING:
                waiting += 1
            body = island_bodies[waiting]
            factor[body].degree = 0
        end = _eliminate(body, total, mark, factor, graph, room)
        mark += 1
        if end < 0 or end + p >= room:
            return 0, 0
        entry = factor[body]
        entry.start = total
        entry.size = end - total
        products += entry.size * (entry.size + 1) // 2
        if products > most_products:
            return 0, 0
        entry.place = p
        factor[p].order = body
        _note_neighbours(body, total, end, factor, graph, room)
        for k in range(_lists(graph, room) + total, _lists(graph, room) + end):
            other = graph[k]
            if factor[other].degree != _LAST:
                _take(other, factor)
                new, visited = _degree(other, mark, factor, graph, room)
                mark += 1
                visits += visited
                _put(other, new, factor)
                degree = min(degree, new)
        total = end
    return n, products


@njit
def neighbour(body: Any, k: Any, factor: Any, graph: Any, room: Any) -> Any:
    """Return the block row of the k-th body that was next to a body when that was eliminated."""
    return factor[graph[_lists(graph, room) + factor[body].start + k]].place
