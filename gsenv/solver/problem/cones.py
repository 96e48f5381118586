"""Contacts by convex problems: where Newton steps find no solution, these give them better starts.

With De Saxce's term mu |u_T| fixed at its last value, a contact's law is that of a convex cone, and each iteration
solves a problem with a symmetric positive semidefinite matrix exactly (the fixed point of Cadoux: Acary, Cadoux,
Lemarechal, Malick, "A formulation of the linear discrete Coulomb friction problem via convex optimization", ZAMM 91,
2011). The impulses of a contact are sums of generators of its cone with weights >= 0: the two edges in 2D, in 3D six
edges of the cone, of which the first is opposite to the last sliding velocity. So the fixed point is exact in 2D, and
for open and sliding contacts in 3D. The weights are bounded rows, solved by pivoting.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .csr import CsrMatrix
from .direct import FIRST_EPSILON, direct_solve
from .kernels import Floats, Rules

if TYPE_CHECKING:
    from .problem import Problem

GENERATORS = 6  # of a 3D cone
ITERATIONS = 30
SETTLED = 1e-8  # relative change of the impulses at which further iterations are of no use
CONVEX_GOAL = 1e-11  # residual of each convex problem


class Generators:
    """The edges of all cones, as the map B from weights to impulses; bounded rows are their own weights."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.is_first = np.ones(problem.row_count, bool)  # of bounded rows and of normals
        count = np.ones(problem.row_count, np.int64)
        normal = problem.contact_row
        count[normal] = np.where(problem.friction > 0.0, np.choose(problem.contact_dim - 1, [1, 2, GENERATORS]), 1)
        for offset in (1, 2):
            self.is_first[normal[problem.contact_dim > offset] + offset] = False
        count[~self.is_first] = 0
        self.start = np.cumsum(count) - count  # first weight of each row
        self.size = int(count.sum())
        self.contacts = np.flatnonzero((problem.contact_dim > 1) & (problem.friction > 0.0))

    def bounds(self) -> tuple[Floats, Floats]:
        """Return the bounds of the weights."""
        lower, upper = np.zeros(self.size), np.full(self.size, np.inf)
        bounded = self.is_first.copy()
        bounded[self.problem.contact_row] = False
        lower[self.start[bounded]] = self.problem.lower[bounded]
        upper[self.start[bounded]] = self.problem.upper[bounded]
        return lower, upper

    def matrix(self, velocity: Floats) -> CsrMatrix:
        """Return B (row, weight) for sliding velocities `velocity` (row,)."""
        own = np.flatnonzero(self.is_first)
        rows, columns, entries = [own], [self.start[own]], [np.ones(len(own))]
        for c in self.contacts:
            row, dim, mu = self.problem.contact_row[c], self.problem.contact_dim[c], self.problem.friction[c]
            count = 2 if dim == 2 else GENERATORS
            first = self.start[row]
            angle = 0.0 if dim == 2 else np.arctan2(-velocity[row + 2], -velocity[row + 1])
            angles = angle + 2.0 * np.pi / count * np.arange(count)
            index = np.arange(count, dtype=np.int64)
            rows.append(np.full(count - 1, row))
            columns.append(first + index[1:])
            entries.append(np.ones(count - 1))
            for offset, part in ((1, np.cos(angles)), (2, np.sin(angles)))[: dim - 1]:
                rows.append(np.full(count, row + offset))
                columns.append(first + index)
                entries.append(mu * part)
        shape = (self.problem.row_count, self.size)
        return CsrMatrix.from_entries(
            np.concatenate(rows).astype(np.int64), np.concatenate(columns), np.concatenate(entries), shape
        )


def convex_starts(problem: Problem, rules: Rules, impulse: Floats) -> Iterator[tuple[Floats, int]]:
    """Yield the impulses of each convex problem, and the number of linear systems that it took."""
    generators = Generators(problem)
    lower, upper = generators.bounds()
    normal = problem.contact_row[generators.contacts]
    velocity = problem._system.multiply(impulse) + problem.rhs
    weights = np.zeros(generators.size)
    shift = np.zeros(problem.row_count)
    factor, planned = None, None
    left = rules.max_sweeps
    for _ in range(ITERATIONS):
        if left <= 0:
            return
        to_impulse = generators.matrix(velocity)
        matrix = to_impulse.T.product(problem._system).product(to_impulse)
        convex = type(problem)._build(
            matrix, to_impulse.T.multiply(problem.rhs + shift), 0.0, lower, upper, None, "", symmetric=problem.symmetric
        )
        data = max(convex._data_square, rules.data_square)
        own = rules._replace(tolerance=CONVEX_GOAL, data_square=data)
        pattern = convex._system.indptr, convex._system.indices
        if planned is None or not all(map(np.array_equal, planned, pattern)):  # zeros come and go with the directions
            planned, factor = pattern, None
        solver = direct_solve(convex, own, weights, factor)
        factor = solver.factor
        solver.goal = CONVEX_GOAL
        solver.proximal_steps(FIRST_EPSILON, weights, min(left, 200 + generators.size))
        left -= solver.used
        before = impulse
        weights = solver.impulse
        impulse = to_impulse.multiply(weights)
        yield impulse, solver.used
        velocity = problem._system.multiply(impulse) + problem.rhs
        shift[:] = 0.0
        for c, row in zip(generators.contacts, normal, strict=True):
            shift[row] = problem.friction[c] * np.linalg.norm(velocity[row + 1 : row + problem.contact_dim[c]])
        scale = problem._row_scale
        if np.linalg.norm(scale * (impulse - before)) <= SETTLED * np.linalg.norm(scale * impulse):
            return
