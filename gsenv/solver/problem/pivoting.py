"""Bounded rows by principal pivoting: finite for positive definite and for P-matrices.

Every row is at its lower bound, at its upper bound or free (its velocity is zero). The free rows are solved as
equations, and rows that then break a bound or a sign change sides, all at once while that reduces their number
(Judice and Pires, "A block principal pivoting algorithm for large-scale strictly monotone linear complementarity
problems", Computers and Operations Research 21, 1994). MOST_BLOCK_STEPS changes without a smaller number may be a
cycle. Then `pivot_rows` goes on with the last of these rows alone, which cannot cycle where W is a P-matrix (Murty,
"Note on a Bard-type scheme for solving the complementarity problem", Opsearch 11, 1974), until the number is smaller
than ever before. For symmetric matrices `descend` is faster: impulses stay within their bounds, and each solution of
free rows has a smaller quadratic function than the one before, so that none recurs (the active-set method, Nocedal
and Wright, "Numerical Optimization", 2006, section 16.5).

The rows solved are those of W + P, q - P c with a small positive diagonal P: one step of the proximal point method
from c (Rockafellar, SIAM J. Control Optim. 14, 1976). Then redundant rows have a unique solution, too, and the next
step removes the error that P has made: it is iterative refinement.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..jit import njit
from .kernels import Floats, System
from .sparse_lu import Bytes, Factor, Rows, factorise, substitute

LOWER, FREE, UPPER = 0, 1, 2
MOST_BLOCK_STEPS = 10
REFINEMENTS = 3
ROUNDING = 1e-14  # relative to the terms of a row's velocity, and to the largest scaled impulse


class Vectors(NamedTuple):
    """Work arrays (row,) of a direct solve."""

    scale: Floats  # s
    centre: Floats  # c, from which the proximal step is taken
    velocity: Floats  # W lambda + q + P (lambda - c)
    magnitude: Floats  # sum of the absolute terms of `velocity`
    rhs: Floats
    change: Floats
    trial: Floats  # of the line search over contacts


class Limits(NamedTuple):
    """How long to pivot."""

    most_steps: int  # linear systems
    symmetric: bool  # `pivot_rows` then gives up where block steps may cycle


@njit
def proximal_velocity(system: System, rows: Rows, vectors: Vectors, impulse: Floats) -> None:
    """Set `velocity` and `magnitude`."""
    for r in range(len(impulse)):
        pull = rows.proximal[r] * (impulse[r] - vectors.centre[r])
        total, size = system.rhs[r] + pull, abs(system.rhs[r]) + abs(pull)
        for k in range(system.indptr[r], system.indptr[r + 1]):
            term = system.data[k] * impulse[system.indices[k]]
            total += term
            size += abs(term)
        vectors.velocity[r], vectors.magnitude[r] = total, size


@njit
def guess_states(system: System, vectors: Vectors, impulse: Floats, state: Bytes) -> None:
    """Set the state of each row by the natural map: where one projected step from its impulse would end.

    A row at a bound with zero velocity is free: from zero impulses all contacts of a tower are, and need one system.
    """
    for r in range(len(impulse)):
        scale = vectors.scale[r]
        ahead = impulse[r] - vectors.velocity[r] / (scale * scale)
        state[r] = FREE if system.lower[r] < system.upper[r] else LOWER
        if ahead < system.lower[r]:
            state[r] = LOWER
        elif ahead > system.upper[r]:
            state[r] = UPPER


@njit
def solve_free(system: System, rows: Rows, vectors: Vectors, factor: Factor, state: Bytes, impulse: Floats) -> bool:
    """Solve the free rows as equations, the others at their bounds; False where a number overflowed."""
    count = len(impulse)
    for r in range(count):
        b = factor.block_of[r]
        free = state[r] == FREE
        rows.live[r] = 1 if free else 0
        rows.velocity_part[b, 0, 0] = 1.0 if free else 0.0
        rows.impulse_part[b, 0, 0] = 0.0 if free else 1.0
        if not free:
            impulse[r] = system.lower[r] if state[r] == LOWER else system.upper[r]
    if not factorise(system, rows, factor):
        return False
    before = np.inf
    for _ in range(REFINEMENTS):
        proximal_velocity(system, rows, vectors, impulse)
        for r in range(count):
            vectors.rhs[r] = -vectors.velocity[r] if state[r] == FREE else 0.0
        substitute(factor, vectors.rhs, vectors.change)
        step, size = 0.0, 0.0
        for r in range(count):
            step = max(step, abs(vectors.scale[r] * vectors.change[r]))
            size = max(size, abs(vectors.scale[r] * impulse[r]))
        if not step < np.inf:
            return False
        if step >= before:
            break
        for r in range(count):
            impulse[r] += vectors.change[r]
        before = 0.5 * step
        if step <= 1e-16 * size:
            break
    proximal_velocity(system, rows, vectors, impulse)
    return True


@njit
def right_state(system: System, vectors: Vectors, impulse: Floats, state: Bytes, r: int, slack: float) -> int:
    """Return the state of row r, or the one it should change to where it breaks a bound or a sign."""
    if system.lower[r] == system.upper[r]:
        return int(state[r])
    sign = ROUNDING * vectors.magnitude[r]
    if state[r] == FREE:
        if impulse[r] < system.lower[r] - slack / vectors.scale[r]:
            return LOWER
        if impulse[r] > system.upper[r] + slack / vectors.scale[r]:
            return UPPER
        return FREE
    if state[r] == LOWER and vectors.velocity[r] < -sign:
        return FREE
    if state[r] == UPPER and vectors.velocity[r] > sign:
        return FREE
    return int(state[r])


@njit
def largest_slack(vectors: Vectors, impulse: Floats) -> float:
    """Return how far a scaled impulse may be beyond its bound by rounding."""
    slack = 0.0
    for r in range(len(impulse)):
        slack = max(slack, ROUNDING * abs(vectors.scale[r] * impulse[r]))
    return slack


@njit
def pivot_rows(
    system: System, rows: Rows, vectors: Vectors, factor: Factor, state: Bytes, impulse: Floats, limits: Limits
) -> tuple[int, bool]:
    """Solve bounded rows from the given states. Returns (linear systems solved, whether solved)."""
    least = len(impulse) + 1
    block_steps = MOST_BLOCK_STEPS
    for step in range(1, limits.most_steps + 1):
        if not solve_free(system, rows, vectors, factor, state, impulse):
            return step, False
        slack = largest_slack(vectors, impulse)
        wrong, last = 0, 0
        for r in range(len(impulse)):
            if right_state(system, vectors, impulse, state, r, slack) != state[r]:
                wrong += 1
                last = r
        if wrong == 0:
            return step, True
        if wrong < least:
            least = wrong
            block_steps = MOST_BLOCK_STEPS
        else:
            block_steps -= 1
        if block_steps <= 0 and limits.symmetric:
            return step, False
        for r in range(0 if block_steps > 0 else last, last + 1):
            state[r] = right_state(system, vectors, impulse, state, r, slack)
    return limits.most_steps, False


@njit
def stop_at_bounds(system: System, vectors: Vectors, state: Bytes, impulse: Floats) -> bool:
    """Shorten the step from `trial` to `impulse` to the first bound on the way, where rows change their state.

    Returns whether the whole step was taken.
    """
    length = 1.0
    for r in range(len(impulse)):
        change = impulse[r] - vectors.trial[r]
        if state[r] == FREE and impulse[r] < system.lower[r]:
            length = min(length, (system.lower[r] - vectors.trial[r]) / change)
        elif state[r] == FREE and impulse[r] > system.upper[r]:
            length = min(length, (system.upper[r] - vectors.trial[r]) / change)
    if length >= 1.0:
        return True
    for r in range(len(impulse)):
        if state[r] != FREE:
            continue
        target = impulse[r]
        impulse[r] = vectors.trial[r] + length * (target - vectors.trial[r])
        if target < system.lower[r] and impulse[r] <= system.lower[r] + 1e-15 * abs(target - vectors.trial[r]):
            state[r] = LOWER
            impulse[r] = system.lower[r]
        elif target > system.upper[r] and impulse[r] >= system.upper[r] - 1e-15 * abs(target - vectors.trial[r]):
            state[r] = UPPER
            impulse[r] = system.upper[r]
    return False


@njit
def descend(
    system: System, rows: Rows, vectors: Vectors, factor: Factor, state: Bytes, impulse: Floats, limits: Limits
) -> tuple[int, bool]:
    """Solve bounded rows of a symmetric matrix from impulses within bounds, by a descent over sets of free rows.

    Returns (linear systems solved, whether solved).
    """
    for r in range(len(impulse)):
        state[r] = FREE
        if impulse[r] <= system.lower[r]:
            state[r] = LOWER
        elif impulse[r] >= system.upper[r]:
            state[r] = UPPER
        vectors.trial[r] = impulse[r]
    for step in range(1, limits.most_steps + 1):
        if not solve_free(system, rows, vectors, factor, state, impulse):
            return step, False
        if stop_at_bounds(system, vectors, state, impulse):
            wrong = 0
            for r in range(len(impulse)):
                becomes = right_state(system, vectors, impulse, state, r, 0.0)
                wrong += 1 if becomes != state[r] else 0
                state[r] = becomes
            if wrong == 0:
                return step, True
        for r in range(len(impulse)):
            vectors.trial[r] = impulse[r]
    return limits.most_steps, False
