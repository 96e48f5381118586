"""Sparse block Cholesky factor of an island's mass matrix plus some of its rows.

H = M + sum_r J_r^T J_r / s_r has a block for each body and for each pair of bodies that rows connect.
Bodies are eliminated in the reverse order of a breadth-first search, so that a tree of joints
(a chain, a ragdoll) has no fill-in and costs linear time; loops and heaps have little fill-in.
A factor that does not fit into the buffer is refused before it is computed.

George, Liu, "Computer Solution of Large Sparse Positive Definite Systems" (1981), chapters 4 and 5;
Liu, "The role of elimination trees in sparse factorization", SIAM J. Matrix Anal. Appl. 11 (1990).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.dispatch import by_dimension
from ..core.rows import EQUATION
from ..jit import njit
from ..records.model import NDOF

BLOCKS_PER_BODY = 40  # mean number of blocks in a row of the factor for which there is memory
ANY_COST = 1 << 62  # products of blocks: more than any factor has
_OUTSIDE = -1
_WAITING = -2  # has rows, but no block row yet
_IDLE = -3  # in the island, but no row found yet


PLAN_DTYPE = np.dtype(
    [
        ("size", "i8"),  # number of block rows of the factor; 0: there is no factor
        ("row_end", "i8"),  # its equations are among the rows before this index
        ("used", "i8"),  # 1: the scene has joints that need the factor
    ],
    align=True,
)


def block_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a block: its entries, (i, j) at ``m[j, i]``, and the block row p of its column of blocks."""
    return np.dtype([("m", "f8", (NDOF[dim], NDOF[dim])), ("column", "i4")], align=True)


def factor_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the factor's scratch, one entry for each body; entry p also describes block row p."""
    return np.dtype(
        [
            ("order", "i4"),  # body of block row p
            ("place", "i4"),  # block row of a body; negative outside the factor
            ("first", "i4"),  # first block of row p, columns ascending, the diagonal last
            ("count", "i4"),  # number of blocks left of the diagonal
            ("parent", "i4"),  # of block row p in the elimination tree
            ("mark", "i4"),
            ("head", "i4"),  # first edge of a body, -1: none
            ("x", "f8", (NDOF[dim],)),  # right-hand side, then the solution, of row p
        ],
        align=True,
    )


@njit
def _add_outer(block: Any, left: Any, right: Any, scale: Any) -> None:
    """Add scale left right^T to a block."""
    for j in range(len(right)):
        for i in range(len(left)):
            block.m[j, i] += scale * right[j] * left[i]


@njit
def _subtract_product(target: Any, left: Any, right: Any) -> None:
    """Subtract left right^T from ``target``, all blocks."""
    n = len(target.m)
    for j in range(n):
        for i in range(n):
            s = 0.0
            for k in range(n):
                s += left.m[k, i] * right.m[k, j]
            target.m[j, i] -= s


@njit
def _divide(block: Any, factor: Any) -> None:
    """Set block = block L^-T; ``factor`` has the lower factor L, with 1 / L_jj on the diagonal."""
    n = len(block.m)
    for j in range(n):
        for i in range(n):
            s = block.m[j, i]
            for k in range(j):
                s -= block.m[k, i] * factor.m[k, j]
            block.m[j, i] = s * factor.m[j, j]


@njit
def _subtract_forward(target: Any, block: Any, x: Any) -> None:
    """Subtract block x from ``target``."""
    for k in range(len(x)):
        for i in range(len(target)):
            target[i] -= block.m[k, i] * x[k]


# in 3D, where blocks are large, several numbers at a time
add_outer = by_dimension("blocks", "add_outer", otherwise=_add_outer)
subtract_product = by_dimension("blocks", "subtract_product", otherwise=_subtract_product)
divide = by_dimension("blocks", "divide", otherwise=_divide)
subtract_forward = by_dimension("blocks", "subtract_forward", otherwise=_subtract_forward)


@njit
def _counts(row: Any, equations: Any) -> Any:
    return row.kind == EQUATION or not equations


@njit
def _link_bodies(rows: Any, count: Any, equations: Any, island_bodies: Any, factor: Any, edges: Any) -> None:
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
            edges[2 * e] = factor[a].head
            edges[2 * e + 1] = b
            factor[a].head = e
            edges[2 * e + 2] = factor[b].head
            edges[2 * e + 3] = a
            factor[b].head = e + 1
            e += 2


@njit
def _search(start: Any, placed: Any, factor: Any, edges: Any) -> Any:
    """Order the bodies that ``start`` reaches, breadth first; returns the next free block row."""
    factor[start].place = placed
    factor[placed].order = start
    head = placed
    placed += 1
    while head < placed:
        body = factor[head].order
        head += 1
        edge = factor[body].head
        while edge >= 0:
            other = edges[2 * edge + 1]
            if factor[other].place == _WAITING:
                factor[other].place = placed
                factor[placed].order = other
                placed += 1
            edge = edges[2 * edge]
    return placed


@njit
def _order_bodies(island_bodies: Any, factor: Any, edges: Any) -> Any:
    """Order the bodies by reverse Cuthill-McKee, from a far end of each component; returns their number."""
    placed = 0
    for k in range(len(island_bodies)):
        if factor[island_bodies[k]].place == _WAITING:
            end = _search(island_bodies[k], placed, factor, edges)
            far = factor[end - 1].order
            for p in range(placed, end):
                factor[factor[p].order].place = _WAITING
            placed = _search(far, placed, factor, edges)
    for p in range(placed // 2):
        body = factor[p].order
        factor[p].order = factor[placed - 1 - p].order
        factor[placed - 1 - p].order = body
    for p in range(placed):
        factor[factor[p].order].place = p
        factor[p].parent = -1
        factor[p].mark = -1
    return placed


@njit
def plan_factor(
    rows: Any, count: Any, equations: Any, island_bodies: Any, factor: Any, edges: Any, blocks: Any, most_products: Any
) -> Any:
    """Order the bodies that rows move, and lay out the factor.

    Returns the number of block rows and that of the products of blocks in ``factorise``; (0, 0) where the blocks do
    not fit or the products are more than ``most_products``.  ``equations``: whether only rows of that kind count.
    ``factor`` (body,), all ``place`` negative on entry; ``edges`` int32 (4 * row,).
    """
    _link_bodies(rows, count, equations, island_bodies, factor, edges)
    n = _order_bodies(island_bodies, factor, edges)
    total = 0
    products = 0
    for p in range(n):
        row = factor[p]
        row.first = total
        row.mark = p
        edge = factor[row.order].head
        while edge >= 0:
            q = factor[edges[2 * edge + 1]].place
            while q < p and factor[q].mark != p:  # up the elimination tree
                if total + 1 >= len(blocks):
                    return 0, 0
                factor[q].mark = p
                blocks[total].column = q
                total += 1
                if factor[q].parent < 0:
                    factor[q].parent = p
                q = factor[q].parent
            edge = edges[2 * edge]
        row.count = total - row.first
        products += row.count * (row.count + 1) // 2
        _sort_columns(blocks, row.first, total)
        if total >= len(blocks) or products > most_products:
            return 0, 0
        blocks[total].column = p
        total += 1
    return n, products


@njit
def _sort_columns(blocks: Any, first: Any, end: Any) -> None:
    for i in range(first + 1, end):
        column = blocks[i].column
        k = i
        while k > first and blocks[k - 1].column > column:
            blocks[k].column = blocks[k - 1].column
            k -= 1
        blocks[k].column = column


@njit
def forget_factor(island_bodies: Any, factor: Any) -> None:
    for k in range(len(island_bodies)):
        factor[island_bodies[k]].place = _OUTSIDE


@njit
def load_masses(n: Any, factor: Any, blocks: Any, substep_bodies: Any) -> None:
    """Set H = M and x = 0."""
    for p in range(n):
        entry = factor[p]
        mass = substep_bodies[entry.order].mass_matrix
        for i in range(len(entry.x)):
            entry.x[i] = 0.0
        for k in range(entry.first, entry.first + entry.count):
            for i in range(len(entry.x)):
                for j in range(len(entry.x)):
                    blocks[k].m[i, j] = 0.0
        diagonal = blocks[entry.first + entry.count].m
        for i in range(len(entry.x)):
            for j in range(len(entry.x)):
                diagonal[i, j] = mass[i, j]


@njit
def clear_sides(n: Any, factor: Any) -> None:
    """Set x = 0."""
    for p in range(n):
        for i in range(len(factor[p].x)):
            factor[p].x[i] = 0.0


@njit
def places_of(row: Any, factor: Any) -> Any:
    """Return the block rows of a row's two bodies; negative for bodies outside the factor."""
    p = factor[row.body_a].place
    if row.body_a == row.body_b:
        p = _OUTSIDE
    return p, factor[row.body_b].place


@njit
def add_force(row: Any, factor: Any, force: Any) -> None:
    """Add force J^T to x."""
    p, q = places_of(row, factor)
    if p >= 0:
        for i in range(len(row.jacobian_a)):
            factor[p].x[i] += force * row.jacobian_a[i]
    if q >= 0:
        for i in range(len(row.jacobian_b)):
            factor[q].x[i] += force * row.jacobian_b[i]


@njit
def change_of(row: Any, factor: Any) -> Any:
    """Return J x of a row."""
    s = 0.0
    p, q = places_of(row, factor)
    if p >= 0:
        for i in range(len(row.jacobian_a)):
            s += row.jacobian_a[i] * factor[p].x[i]
    if q >= 0:
        for i in range(len(row.jacobian_b)):
            s += row.jacobian_b[i] * factor[q].x[i]
    return s


@njit
def _block_at(factor: Any, blocks: Any, p: Any, q: Any) -> Any:
    """Return the index of block (p, q), q < p."""
    k = factor[p].first
    while blocks[k].column != q:
        k += 1
    return k


@njit
def add_product(row: Any, other: Any, factor: Any, blocks: Any, scale: Any) -> None:
    """Add scale J^T J' of two rows on the same bodies to H; to keep H symmetric, add both orders."""
    p, q = places_of(row, factor)
    if p >= 0:
        add_outer(blocks[factor[p].first + factor[p].count], row.jacobian_a, other.jacobian_a, scale)
    if q >= 0:
        add_outer(blocks[factor[q].first + factor[q].count], row.jacobian_b, other.jacobian_b, scale)
    if p > q >= 0:
        add_outer(blocks[_block_at(factor, blocks, p, q)], row.jacobian_a, other.jacobian_b, scale)
    elif q > p >= 0:
        add_outer(blocks[_block_at(factor, blocks, q, p)], row.jacobian_b, other.jacobian_a, scale)


@njit
def add_stiffness(row: Any, factor: Any, blocks: Any, stiffness: Any) -> None:
    """Add stiffness J^T J to H."""
    add_product(row, row, factor, blocks, stiffness)


@njit
def _cholesky(m: Any) -> Any:
    """Factorise a block in place, L L^T with 1 / L_jj on the diagonal; False if it is not positive definite."""
    n = len(m)
    for j in range(n):
        d = m[j, j]
        for k in range(j):
            d -= m[k, j] * m[k, j]
        if not d > 0.0:
            return False
        d = 1.0 / d**0.5
        m[j, j] = d
        for i in range(j + 1, n):
            s = m[j, i]
            for k in range(j):
                s -= m[k, i] * m[k, j]
            m[j, i] = s * d
    return True


@njit
def _subtract_common(blocks: Any, target: Any, left: Any, left_end: Any, right: Any, right_end: Any) -> None:
    """Subtract from ``target`` the products over the columns that two block rows share."""
    while left < left_end and right < right_end:
        i = blocks[left].column
        j = blocks[right].column
        if i == j:
            subtract_product(blocks[target], blocks[left], blocks[right])
        left += int(i <= j)
        right += int(j <= i)


@njit
def factorise(n: Any, factor: Any, blocks: Any) -> Any:
    """Factorise H = L L^T block row by block row; returns False if H is not positive definite."""
    for p in range(n):
        first = factor[p].first
        diagonal = first + factor[p].count
        for k in range(first, diagonal):
            other = factor[blocks[k].column]
            end = other.first + other.count
            _subtract_common(blocks, k, first, k, other.first, end)
            divide(blocks[k], blocks[end])
        for k in range(first, diagonal):
            subtract_product(blocks[diagonal], blocks[k], blocks[k])
        if not _cholesky(blocks[diagonal].m):
            return False
    return True


@njit
def substitute(n: Any, factor: Any, blocks: Any) -> None:
    """Set x = H^-1 x by forward and backward substitution."""
    for p in range(n):
        row = factor[p]
        diagonal = row.first + row.count
        for k in range(row.first, diagonal):
            subtract_forward(row.x, blocks[k], factor[blocks[k].column].x)
        block = blocks[diagonal].m
        for i in range(len(row.x)):
            s = row.x[i]
            for k in range(i):
                s -= block[k, i] * row.x[k]
            row.x[i] = s * block[i, i]
    for p in range(n - 1, -1, -1):
        row = factor[p]
        diagonal = row.first + row.count
        block = blocks[diagonal].m
        for i in range(len(row.x) - 1, -1, -1):
            s = row.x[i]
            for k in range(i + 1, len(row.x)):
                s -= block[i, k] * row.x[k]
            row.x[i] = s * block[i, i]
        for k in range(row.first, diagonal):
            _subtract_backward(factor[blocks[k].column].x, blocks[k].m, row.x)


@njit
def _subtract_backward(target: Any, m: Any, x: Any) -> None:
    """Subtract block^T x."""
    for i in range(len(target)):
        s = 0.0
        for k in range(len(x)):
            s += m[i, k] * x[k]
        target[i] -= s
