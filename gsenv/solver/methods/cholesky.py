"""Sparse block Cholesky factor of an island's mass matrix plus some of its rows.

H = M + sum_r J_r^T J_r / s_r has a block for each body and for each pair of bodies that rows connect.
ordering.py orders the bodies.  Blocks are stored by columns and computed row by row (up-looking); a factor that does
not fit into the buffer is refused before it is computed.

Davis, "Direct Methods for Sparse Linear Systems" (2006), chapter 4.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.dispatch import by_dimension
from ..jit import njit
from ..records.model import NDOF
from .ordering import GRAPH_NUMBERS, OUTSIDE, link_bodies, neighbour, order_bodies

BLOCKS_PER_BODY = 40  # mean number of blocks in a row of the factor for which there is memory
ANY_COST = 1 << 62  # products of blocks: more than any factor has
VISITS = 96  # of neighbours, for each row, by the ordering of a factor whose products are bounded: some sweeps long


PLAN_DTYPE = np.dtype(
    [
        ("size", "i8"),  # number of block rows of the factor; 0: there is no factor
        ("row_end", "i8"),  # its equations are among the rows before this index
        ("used", "i8"),  # 1: the scene has joints that need the factor
    ],
    align=True,
)


def block_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of a block: its entries, (i, j) at ``m[j, i]``, its place, and the next block of its row."""
    return np.dtype([("m", "f8", (NDOF[dim], NDOF[dim])), ("row", "i4"), ("column", "i4"), ("next", "i4")], align=True)


def factor_dtype(dim: int) -> np.dtype[Any]:
    """Return the dtype of the factor's scratch, one entry for each body; entry p also describes block row p."""
    return np.dtype(
        [
            ("order", "i4"),  # body of block row p
            ("place", "i4"),  # block row of a body; negative outside the factor
            ("first", "i4"),  # diagonal block of column p; those below it follow, rows ascending
            ("count", "i4"),  # number of blocks below the diagonal
            ("row_first", "i4"),  # first block of row p left of the diagonal, -1: none
            ("row_last", "i4"),
            ("in_row", "i4"),  # block of column p in the row that is being computed
            ("head", "i4"),  # first edge of a body, -1: none
            ("start", "i4"),  # of the list of neighbours of an eliminated body, and their number
            ("size", "i4"),
            ("list", "i4"),  # first place where a body is a neighbour of an eliminated one, -1: none
            ("degree", "i4"),  # number of neighbours of a body
            ("before", "i4"),  # in the list of bodies of equal degree
            ("after", "i4"),
            ("bucket", "i4"),  # first body of degree p, -1: none
            ("x", "f8", (NDOF[dim],)),  # right-hand side, then the solution, of row p
        ],
        align=True,
    )


def graph_size(rows: int, bodies: int, blocks: int) -> int:
    """Return the size of the graph's array, for numbers of rows, bodies and blocks; see ordering.py."""
    return 4 * rows + bodies + GRAPH_NUMBERS * blocks


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
def plan_factor(
    rows: Any, count: Any, equations: Any, island_bodies: Any, factor: Any, graph: Any, blocks: Any, most_products: Any
) -> Any:
    """Order the bodies that rows move, and lay out the factor.

    Returns the number of block rows and that of the products of blocks in ``factorise``; (0, 0) where the blocks do
    not fit or the products are more than ``most_products``.  ``equations``: whether only rows of that kind count.
    ``factor`` (body,), all ``place`` negative on entry; ``graph`` int32, of ``graph_size``.
    """
    link_bodies(rows, count, equations, island_bodies, factor, graph)
    most_visits = VISITS * count if most_products < ANY_COST else ANY_COST
    n, products = order_bodies(island_bodies, factor, graph, len(blocks), most_products, most_visits)
    total = 0
    for p in range(n):
        body = factor[p].order
        entry = factor[p]
        entry.first = total
        entry.count = factor[body].size
        entry.row_first = -1
        for k in range(entry.count + 1):
            blocks[total + k].column = p
            blocks[total + k].row = p if k == 0 else neighbour(body, k - 1, factor, graph, len(blocks))
        _sort_rows(blocks, total + 1, total + 1 + entry.count)
        total += 1 + entry.count
    for p in range(n):
        for k in range(factor[p].first + 1, factor[p].first + 1 + factor[p].count):
            row = factor[blocks[k].row]
            blocks[k].next = -1
            if row.row_first < 0:
                row.row_first = k
            else:
                blocks[row.row_last].next = k
            row.row_last = k
    return n, products


@njit
def _sort_rows(blocks: Any, first: Any, end: Any) -> None:
    for i in range(first + 1, end):
        row = blocks[i].row
        k = i
        while k > first and blocks[k - 1].row > row:
            blocks[k].row = blocks[k - 1].row
            k -= 1
        blocks[k].row = row


@njit
def forget_factor(island_bodies: Any, factor: Any) -> None:
    for k in range(len(island_bodies)):
        factor[island_bodies[k]].place = OUTSIDE


@njit
def load_masses(n: Any, factor: Any, blocks: Any, substep_bodies: Any) -> None:
    """Set H = M and x = 0."""
    for p in range(n):
        entry = factor[p]
        mass = substep_bodies[entry.order].mass_matrix
        for i in range(len(entry.x)):
            entry.x[i] = 0.0
        for k in range(entry.first + 1, entry.first + 1 + entry.count):
            for i in range(len(entry.x)):
                for j in range(len(entry.x)):
                    blocks[k].m[i, j] = 0.0
        diagonal = blocks[entry.first].m
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
        p = OUTSIDE
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
    low = factor[q].first + 1
    high = factor[q].first + factor[q].count
    while low < high:
        middle = (low + high) // 2
        if blocks[middle].row < p:
            low = middle + 1
        else:
            high = middle
    return low


@njit
def add_product(row: Any, other: Any, factor: Any, blocks: Any, scale: Any) -> None:
    """Add scale J^T J' of two rows on the same bodies to H; to keep H symmetric, add both orders."""
    p, q = places_of(row, factor)
    if p >= 0:
        add_outer(blocks[factor[p].first], row.jacobian_a, other.jacobian_a, scale)
    if q >= 0:
        add_outer(blocks[factor[q].first], row.jacobian_b, other.jacobian_b, scale)
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
def factorise(n: Any, factor: Any, blocks: Any) -> Any:
    """Factorise H = L L^T block row by block row; returns False if H is not positive definite."""
    for p in range(n):
        first = factor[p].row_first
        k = first
        while k >= 0:
            factor[blocks[k].column].in_row = k
            k = blocks[k].next
        diagonal = factor[p].first
        k = first
        while k >= 0:
            column = factor[blocks[k].column].first
            divide(blocks[k], blocks[column])
            for i in range(column + 1, k):
                subtract_product(blocks[factor[blocks[i].row].in_row], blocks[k], blocks[i])
            subtract_product(blocks[diagonal], blocks[k], blocks[k])
            k = blocks[k].next
        if not _cholesky(blocks[diagonal].m):
            return False
    return True


@njit
def substitute(n: Any, factor: Any, blocks: Any) -> None:
    """Set x = H^-1 x by forward and backward substitution."""
    for p in range(n):
        entry = factor[p]
        block = blocks[entry.first].m
        for i in range(len(entry.x)):
            s = entry.x[i]
            for k in range(i):
                s -= block[k, i] * entry.x[k]
            entry.x[i] = s * block[i, i]
        for k in range(entry.first + 1, entry.first + 1 + entry.count):
            subtract_forward(factor[blocks[k].row].x, blocks[k], entry.x)
    for p in range(n - 1, -1, -1):
        entry = factor[p]
        for k in range(entry.first + 1, entry.first + 1 + entry.count):
            _subtract_backward(entry.x, blocks[k].m, factor[blocks[k].row].x)
        block = blocks[entry.first].m
        for i in range(len(entry.x) - 1, -1, -1):
            s = entry.x[i]
            for k in range(i + 1, len(entry.x)):
                s -= block[i, k] * entry.x[k]
            entry.x[i] = s * block[i, i]


@njit
def _subtract_backward(target: Any, m: Any, x: Any) -> None:
    """Subtract block^T x."""
    for i in range(len(target)):
        s = 0.0
        for k in range(len(x)):
            s += m[i, k] * x[k]
        target[i] -= s
