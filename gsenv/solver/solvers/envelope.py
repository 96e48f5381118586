"""Block Cholesky factor of an island's mass matrix plus its active rows, within an envelope.

H = M + sum_r J_r^T J_r / s_r over the active rows; block row p of the factor reaches from its first
neighbour to the diagonal.  A tower or chain has one off-diagonal block a body, so the factor's cost is
linear; an island whose envelope does not fit into the buffer is told so at once.

George, Liu, "Computer Solution of Large Sparse Positive Definite Systems" (1981), chapter 4.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..jit import njit
from ..model import NDOF

BLOCKS_PER_BODY = 8  # mean width of the envelope that still pays against sweeps


def block_dtype(dim: int) -> np.dtype[Any]:
    return np.dtype([("m", "f8", (NDOF[dim], NDOF[dim]))], align=True)


def envelope_dtype(dim: int) -> np.dtype[Any]:
    """Scratch, one entry a body; entry p also describes place p of the ordering."""
    return np.dtype(
        [
            ("order", "i4"),  # body at place p
            ("place", "i4"),  # of a body; -1 outside the island
            ("first", "i4"),  # first place that block row p reaches to
            ("offset", "i4"),  # index of the block in column 0 of row p, if it were there
            ("degree", "i4"),
            ("head", "i4"),  # first edge of a body, -1 none
            ("x", "f8", (NDOF[dim],)),  # right-hand side, then the solution, at place p
        ],
        align=True,
    )


@njit
def _link_bodies(rows: Any, count: Any, bodies_of: Any, envelope: Any, edges: Any) -> None:
    """Neighbours of each body as linked lists: edge 2r and 2r+1 of row r."""
    for k in range(len(bodies_of)):
        entry = envelope[bodies_of[k]]
        entry.place = -2  # in the island, not ordered yet
        entry.head = -1
        entry.degree = 0
    last_a = -1
    last_b = -1
    for r in range(count):
        a = rows[r].body_a
        b = rows[r].body_b
        if a == b or (a == last_a and b == last_b):
            continue
        last_a = a
        last_b = b
        if envelope[a].place == -2 and envelope[b].place == -2:
            edges[2 * r] = envelope[a].head
            envelope[a].head = 2 * r
            edges[2 * r + 1] = envelope[b].head
            envelope[b].head = 2 * r + 1
            envelope[a].degree += 1
            envelope[b].degree += 1


@njit
def _order_bodies(rows: Any, bodies_of: Any, envelope: Any, edges: Any) -> None:
    """Breadth first from a body of least degree, as Cuthill and McKee."""
    n = len(bodies_of)
    placed = 0
    while placed < n:
        start = -1
        for k in range(n):
            entry = envelope[bodies_of[k]]
            if entry.place == -2 and (start < 0 or entry.degree < envelope[start].degree):
                start = bodies_of[k]
        envelope[start].place = placed
        envelope[placed].order = start
        head = placed
        placed += 1
        while head < placed:
            body = envelope[head].order
            head += 1
            edge = envelope[body].head
            while edge >= 0:
                row = rows[edge >> 1]
                other = row.body_a if row.body_b == body else row.body_b
                if envelope[other].place == -2:
                    envelope[other].place = placed
                    envelope[placed].order = other
                    placed += 1
                edge = edges[edge]


@njit
def plan_envelope(rows: Any, count: Any, bodies_of: Any, envelope: Any, edges: Any, blocks: Any) -> Any:
    """Order an island's bodies and lay out the factor; False if it does not fit or pay.

    ``envelope`` (body,), all ``place`` -1 on entry; ``edges`` int32 (2 * row,).
    """
    _link_bodies(rows, count, bodies_of, envelope, edges)
    _order_bodies(rows, bodies_of, envelope, edges)
    n = len(bodies_of)
    for p in range(n):
        envelope[p].first = p
    for r in range(count):
        p = envelope[rows[r].body_a].place
        q = envelope[rows[r].body_b].place
        if p >= 0 and q >= 0:
            low = min(p, q)
            high = max(p, q)
            envelope[high].first = min(envelope[high].first, low)
    total = 0
    for p in range(n):
        envelope[p].offset = total - envelope[p].first
        total += p - envelope[p].first + 1
    return total <= min(len(blocks), BLOCKS_PER_BODY * n)


@njit
def forget_envelope(bodies_of: Any, envelope: Any) -> None:
    for k in range(len(bodies_of)):
        envelope[bodies_of[k]].place = -1


@njit
def load_masses(bodies_of: Any, envelope: Any, blocks: Any, motions: Any) -> None:
    """H = M, x = 0."""
    for p in range(len(bodies_of)):
        entry = envelope[p]
        mass = motions[entry.order].mass_matrix
        for i in range(len(entry.x)):
            entry.x[i] = 0.0
        for q in range(entry.first, p + 1):
            block = blocks[entry.offset + q].m
            for i in range(len(entry.x)):
                for j in range(len(entry.x)):
                    block[i, j] = mass[i, j] if q == p else 0.0


@njit
def add_row(row: Any, envelope: Any, blocks: Any, stiffness: Any, force: Any) -> None:
    """H += stiffness J^T J, x += force J^T."""
    p = envelope[row.body_a].place
    q = envelope[row.body_b].place
    if row.body_a == row.body_b:
        p = -1
    if p >= 0:
        _add_block(blocks[envelope[p].offset + p].m, row.jacobian_a, row.jacobian_a, stiffness)
        for i in range(len(row.jacobian_a)):
            envelope[p].x[i] += force * row.jacobian_a[i]
    if q >= 0:
        _add_block(blocks[envelope[q].offset + q].m, row.jacobian_b, row.jacobian_b, stiffness)
        for i in range(len(row.jacobian_b)):
            envelope[q].x[i] += force * row.jacobian_b[i]
    if p > q >= 0:
        _add_block(blocks[envelope[p].offset + q].m, row.jacobian_a, row.jacobian_b, stiffness)
    elif q > p >= 0:
        _add_block(blocks[envelope[q].offset + p].m, row.jacobian_b, row.jacobian_a, stiffness)


@njit
def _add_block(block: Any, left: Any, right: Any, scale: Any) -> None:
    for i in range(len(left)):
        for j in range(len(right)):
            block[i, j] += scale * left[i] * right[j]


@njit
def _subtract_product(target: Any, left: Any, right: Any) -> None:
    """target -= left right^T."""
    n = len(left)
    for i in range(n):
        for j in range(n):
            s = 0.0
            for k in range(n):
                s += left[i, k] * right[j, k]
            target[i, j] -= s


@njit
def _cholesky(block: Any) -> Any:
    """Lower factor in place; False if the block is not positive definite."""
    n = len(block)
    for j in range(n):
        d = block[j, j]
        for k in range(j):
            d -= block[j, k] * block[j, k]
        if not d > 0.0:
            return False
        d = d**0.5
        block[j, j] = d
        for i in range(j + 1, n):
            s = block[i, j]
            for k in range(j):
                s -= block[i, k] * block[j, k]
            block[i, j] = s / d
    return True


@njit
def _divide(block: Any, factor: Any) -> None:
    """block = block L^-T for the lower factor L."""
    n = len(block)
    for i in range(n):
        for j in range(n):
            s = block[i, j]
            for k in range(j):
                s -= block[i, k] * factor[j, k]
            block[i, j] = s / factor[j, j]


@njit
def factorise(n: Any, envelope: Any, blocks: Any) -> Any:
    """H = L L^T, block row by block row; False if H is not positive definite."""
    for p in range(n):
        row = envelope[p]
        for q in range(row.first, p):
            block = blocks[row.offset + q].m
            for k in range(max(row.first, envelope[q].first), q):
                _subtract_product(block, blocks[row.offset + k].m, blocks[envelope[q].offset + k].m)
            _divide(block, blocks[envelope[q].offset + q].m)
        diagonal = blocks[row.offset + p].m
        for k in range(row.first, p):
            _subtract_product(diagonal, blocks[row.offset + k].m, blocks[row.offset + k].m)
        if not _cholesky(diagonal):
            return False
    return True


@njit
def substitute(n: Any, envelope: Any, blocks: Any) -> None:
    """x = H^-1 x: forward, then backward."""
    for p in range(n):
        row = envelope[p]
        for q in range(row.first, p):
            _subtract_forward(row.x, blocks[row.offset + q].m, envelope[q].x)
        factor = blocks[row.offset + p].m
        for i in range(len(row.x)):
            s = row.x[i]
            for k in range(i):
                s -= factor[i, k] * row.x[k]
            row.x[i] = s / factor[i, i]
    for p in range(n - 1, -1, -1):
        row = envelope[p]
        factor = blocks[row.offset + p].m
        for i in range(len(row.x) - 1, -1, -1):
            s = row.x[i]
            for k in range(i + 1, len(row.x)):
                s -= factor[k, i] * row.x[k]
            row.x[i] = s / factor[i, i]
        for q in range(row.first, p):
            _subtract_backward(envelope[q].x, blocks[row.offset + q].m, row.x)


@njit
def _subtract_forward(target: Any, block: Any, x: Any) -> None:
    for i in range(len(target)):
        for k in range(len(x)):
            target[i] -= block[i, k] * x[k]


@njit
def _subtract_backward(target: Any, block: Any, x: Any) -> None:
    for i in range(len(target)):
        for k in range(len(x)):
            target[i] -= block[k, i] * x[k]
