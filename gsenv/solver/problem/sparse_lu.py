"""Sparse LU factors of rows `G (W + P) + H` in which G and H act within blocks and P is diagonal.

Direct methods need many factors of one pattern: each active row contributes its row of W, each inactive one an
entry of its own. So the elimination order (minimum degree over the blocks; George and Liu, "The evolution of the
minimum degree ordering algorithm", SIAM Review 31, 1989) and the pattern of the factor, which is that of W with
all rows of a block merged, are found once by `plan_factor`. There are no row exchanges: a symmetric positive definite
matrix, a P-matrix and all their principal submatrices have an LU factor without. A pivot that rounding has
made zero is replaced by a tiny one, and the caller corrects the solution by iterative refinement.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import njit
from .kernels import Blocks, Floats, Indices, System

Bytes = NDArray[np.uint8]

# The order of elimination is found in a (block, block) byte array: 64 MB.
MOST_BLOCKS = 8000
TINY_PIVOT = 1e-15  # relative to the largest entry of its row


class Factor(NamedTuple):
    """The pattern and the numbers of L U. Positions are places in the order of elimination."""

    row_at: Indices  # (row,) row at each position
    position: Indices  # (row,) position of each row
    block_of: Indices  # (row,) block of each row
    lower_ptr: Indices  # (row + 1,) CSR pattern of L, left of the diagonal
    lower_at: Indices
    lower: Floats
    upper_ptr: Indices  # (row + 1,) CSR pattern of U, right of the diagonal
    upper_at: Indices
    upper: Floats
    pivot: Floats  # (row,) diagonal of U
    work: Floats  # (row,)

    @property
    def operations(self) -> float:
        """Multiplications of one factorisation."""
        return float(np.sum(np.diff(self.upper_ptr).astype(float) ** 2))


class Rows(NamedTuple):
    """The matrix `G (W + diag(proximal)) + H`, by blocks; columns of rows that are not live count as zero in W."""

    velocity_part: Floats  # G (block, 3, 3)
    impulse_part: Floats  # H (block, 3, 3)
    live: Bytes  # (row,)
    proximal: Floats  # (row,)


@njit
def eliminate_blocks(adjacent: Bytes, degree: Indices, near: Indices, order: Indices) -> None:
    """Fill `order` with a minimum-degree order; `adjacent[b, c]` stays 1 where c is eliminated after b and coupled.

    `near`: (block,) work array.
    """
    count = len(order)
    for step in range(count):
        chosen = -1
        for b in range(count):
            if degree[b] >= 0 and (chosen < 0 or degree[b] < degree[chosen]):
                chosen = b
        found = 0
        for c in range(count):
            if adjacent[chosen, c]:
                near[found] = c
                found += 1
        if found < count - step - 1:  # else all that remain are coupled
            for i in range(found):
                for j in range(i):
                    a, b = near[i], near[j]
                    if not adjacent[a, b]:
                        adjacent[a, b] = 1
                        adjacent[b, a] = 1
                        degree[a] += 1
                        degree[b] += 1
        for i in range(found):
            adjacent[near[i], chosen] = 0
            degree[near[i]] -= 1
        degree[chosen] = -1
        order[step] = chosen


@njit
def fill_pattern(adjacent: Bytes, order: Indices, first: Indices, upper_ptr: Indices, upper_at: Indices) -> int:
    """Set the pattern of U from the block pattern; with an empty `upper_at` only count. `first`: (block + 1,) positions
    in the order of elimination. Returns the number of entries."""
    total = 0
    for step in range(len(order)):
        for p in range(first[step], first[step + 1]):
            upper_ptr[p] = total
            for q in range(p + 1, first[step + 1]):
                if len(upper_at):
                    upper_at[total] = q
                total += 1
            for later in range(step + 1, len(order)):
                if adjacent[order[step], order[later]]:
                    for q in range(first[later], first[later + 1]):
                        if len(upper_at):
                            upper_at[total] = q
                        total += 1
    upper_ptr[first[len(order)]] = total
    return total


def plan_factor(system: System) -> Factor:
    """Return a factor of the pattern of W, to be filled by `factorise`, of at most MOST_BLOCKS blocks."""
    blocks = system.blocks
    count, rows = len(blocks), len(system.rhs)
    block_of = np.repeat(np.arange(count, dtype=np.int64), blocks["dim"])
    entry_rows = np.repeat(np.arange(rows, dtype=np.int64), np.diff(system.indptr))
    adjacent = np.zeros((count, count), np.uint8)
    adjacent[block_of[entry_rows], block_of[system.indices]] = 1
    adjacent |= adjacent.T
    np.fill_diagonal(adjacent, 0)
    degree = adjacent.sum(axis=1, dtype=np.int64)
    order = np.zeros(count, np.int64)
    eliminate_blocks(adjacent, degree, order.copy(), order)
    first = np.zeros(count + 1, np.int64)
    np.cumsum(blocks["dim"][order], out=first[1:])
    upper_ptr = np.zeros(rows + 1, np.int64)
    total = fill_pattern(adjacent, order, first, upper_ptr, np.zeros(0, np.int64))
    upper_at = np.zeros(total, np.int64)
    fill_pattern(adjacent, order, first, upper_ptr, upper_at)
    # L has the transposed pattern
    by_column = np.argsort(upper_at, kind="stable")
    lower_at = np.repeat(np.arange(rows, dtype=np.int64), np.diff(upper_ptr))[by_column]
    lower_ptr = np.zeros(rows + 1, np.int64)
    np.cumsum(np.bincount(upper_at, minlength=rows), out=lower_ptr[1:])
    start = np.asarray(blocks["row"][order], np.int64)
    dims = blocks["dim"][order]
    within = np.arange(rows, dtype=np.int64) - np.repeat(first[:-1], dims)
    row_at = np.repeat(start, dims) + within
    position = np.zeros(rows, np.int64)
    position[row_at] = np.arange(rows, dtype=np.int64)
    return Factor(
        row_at, position, block_of, lower_ptr, lower_at, np.zeros(total), upper_ptr, upper_at, np.zeros(total),
        np.zeros(rows), np.zeros(rows),
    )  # fmt: skip


@njit
def load_row(system: System, block: Blocks, rows: Rows, b: int, a: int, factor: Factor) -> float:
    """Add row a of block b of the matrix to `factor.work`; returns its largest entry."""
    work, position = factor.work, factor.position
    largest = 0.0
    for j in range(block.dim):
        r = block.row + j
        g = rows.velocity_part[b, a, j]
        work[position[r]] += rows.impulse_part[b, a, j] + g * rows.proximal[r]
        largest = max(largest, abs(rows.impulse_part[b, a, j]))
        if g != 0.0:
            for k in range(system.indptr[r], system.indptr[r + 1]):
                c = system.indices[k]
                if rows.live[c]:
                    work[position[c]] += g * system.data[k]
                    largest = max(largest, abs(g * system.data[k]))
    return largest


@njit
def factorise(system: System, rows: Rows, factor: Factor) -> bool:
    """Factorise the rows; False where a number overflowed."""
    lower_ptr, lower_at, lower = factor.lower_ptr, factor.lower_at, factor.lower
    upper_ptr, upper_at, upper = factor.upper_ptr, factor.upper_at, factor.upper
    pivot, work = factor.pivot, factor.work
    for p in range(len(pivot)):
        b = factor.block_of[factor.row_at[p]]
        block = system.blocks[b]
        largest = load_row(system, block, rows, b, factor.row_at[p] - block.row, factor)
        for k in range(lower_ptr[p], lower_ptr[p + 1]):
            q = lower_at[k]
            entry = work[q] / pivot[q]
            work[q] = 0.0
            lower[k] = entry
            if entry != 0.0:
                for m in range(upper_ptr[q], upper_ptr[q + 1]):
                    work[upper_at[m]] -= entry * upper[m]
        for k in range(upper_ptr[p], upper_ptr[p + 1]):
            upper[k] = work[upper_at[k]]
            work[upper_at[k]] = 0.0
        pivot[p] = work[p]
        work[p] = 0.0
        least = TINY_PIVOT * largest if largest > 0.0 else 1.0
        if abs(pivot[p]) < least:
            pivot[p] = least if pivot[p] >= 0.0 else -least
        if not np.isfinite(pivot[p]):
            return False
    return True


@njit
def substitute(factor: Factor, rhs: Floats, solution: Floats) -> None:
    """Solve L U solution = rhs, both by rows of the problem."""
    row_at, work = factor.row_at, factor.work
    count = len(row_at)
    for p in range(count):
        value = rhs[row_at[p]]
        for k in range(factor.lower_ptr[p], factor.lower_ptr[p + 1]):
            value -= factor.lower[k] * work[factor.lower_at[k]]
        work[p] = value
    for i in range(count):
        p = count - 1 - i
        value = work[p]
        for k in range(factor.upper_ptr[p], factor.upper_ptr[p + 1]):
            value -= factor.upper[k] * work[factor.upper_at[k]]
        work[p] = value / factor.pivot[p]
    for p in range(count):
        solution[row_at[p]] = work[p]
        work[p] = 0.0
