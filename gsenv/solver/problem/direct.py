"""The direct method: states of all rows by pivoting, of contacts by Newton steps, inside proximal steps.

Each proximal step solves W + epsilon S^2 in place of W, from the impulses of the last one (S^2 is the diagonal of W),
so redundant rows have a unique solution and no factor breaks down. The steps converge by epsilon / (epsilon + sigma)
in an eigenvector of eigenvalue sigma: one or two steps for ordinary rows. Where they converge slowly epsilon is
reduced; where pivoting fails, or rows contradict each other, it is increased, and the result is a compromise with
bounded impulses.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .contact_newton import solve_contacts
from .kernels import Floats, Rules, System, measure, natural_map, project
from .pivoting import Limits, Vectors, descend, guess_states, pivot_rows, proximal_velocity
from .sparse_lu import Factor, Rows, plan_factor

if TYPE_CHECKING:
    from .problem import Problem

FIRST_EPSILON = 1e-9
LEAST_EPSILON = 1e-14
LARGER = (1e-6, 1e-2)  # epsilon where pivoting fails or rows contradict each other
PROXIMAL_STEPS = 60
SLOW = 0.3  # reduction of the error in a proximal step above which epsilon is reduced
STAYS = 0.95
ROUNDING = 1e-14  # residual at which no further step is worth it
SHORT_RUN = 10  # linear systems for each row with one epsilon, before the next epsilon
MOST_FAILURES = 4  # proximal steps without a solution
NEWTON_STEPS = 60  # of one proximal step
NEWTON_SOLVED = 1e-10  # relative residual of the proximal step's own equations


@dataclass
class DirectSolve:
    """One run of the direct method; `impulse` is the best so far, within its bounds and cones."""

    system: System
    rules: Rules
    factor: Factor
    row_scale: Floats
    impulse: Floats
    symmetric: bool = True
    goal: float = ROUNDING  # residual at which to stop
    used: int = 0  # linear systems solved
    most: int = 0  # limit of `used` for the present epsilon
    error_square: float = np.inf
    residual: float = np.inf
    error: Floats = field(init=False)
    rows: Rows = field(init=False)
    vectors: Vectors = field(init=False)
    has_contacts: bool = field(init=False)

    def __post_init__(self) -> None:
        count, blocks = len(self.impulse), self.system.blocks
        self.error = np.zeros(count)
        parts = np.zeros((2, len(blocks), 3, 3))
        self.rows = Rows(parts[0], parts[1], np.ones(count, np.uint8), np.zeros(count))
        self.vectors = Vectors(self.row_scale, *np.zeros((6, count)))
        self.has_contacts = bool(np.any(blocks["dim"] > 1))
        project(self.system.lower, self.system.upper, blocks, self.impulse)
        self.error_square, size = natural_map(self.system, self.impulse, self.error)
        self.residual = self._measure(self.error_square, size)

    @property
    def solved(self) -> bool:
        """Whether the best impulses are within the tolerance."""
        return self.residual <= self.rules.tolerance

    def run(self) -> None:
        """Solve from the present impulses."""
        few = SHORT_RUN * (1 + len(self.impulse))
        for epsilon in (FIRST_EPSILON, *LARGER):
            self.proximal_steps(epsilon, self.impulse, self.used + few)
            if self.solved:
                return
        self.proximal_steps(FIRST_EPSILON, self.impulse, self.rules.max_sweeps)

    def proximal_steps(self, epsilon: float, start: Floats, most: int) -> None:
        """Take proximal steps from the impulses `start` until the error stays, or until `most` systems were solved."""
        self.most = min(most, self.rules.max_sweeps)
        start = start.copy()
        centre, guess, previous, failures, least = start, start, np.inf, 0, LEAST_EPSILON
        for _ in range(PROXIMAL_STEPS):
            if self.residual <= self.goal or self.used >= self.most:
                return
            impulse, solved = self._solve_proximal(centre, guess, epsilon)
            if not solved:  # a larger epsilon is easier
                failures += 1
                if failures > MOST_FAILURES or (self.has_contacts and previous == np.inf):
                    return
                epsilon *= 10.0
                if not self.has_contacts:
                    least = epsilon
                    self._offer(impulse)
                continue
            error_square = self._offer(impulse)
            slow = error_square > SLOW * SLOW * previous
            stays = error_square > STAYS * STAYS * previous
            if slow and (epsilon <= least or (stays and epsilon >= LARGER[0])):
                return
            centre = guess = impulse
            if slow:
                epsilon = max((1e-2 if stays else 0.1) * epsilon, least)
            if stays and not np.abs(self.row_scale * impulse).max() < np.sqrt(self._cap()):
                centre = start  # far beyond their data impulses may only grow
            previous = min(previous, error_square)

    def _solve_proximal(self, centre: Floats, guess: Floats, epsilon: float) -> tuple[Floats, bool]:
        """Return the impulses of the proximal step from `centre`, projected, and whether they solve it."""
        impulse = guess.copy()
        self.rows.proximal[:] = epsilon * self.row_scale**2
        self.vectors.centre[:] = centre
        left = self.most - self.used
        solved = self._take_newton_steps(impulse, left) if self.has_contacts else self._pivot(impulse, left)
        finite = bool(np.all(np.isfinite(impulse)))
        if finite:
            project(self.system.lower, self.system.upper, self.system.blocks, impulse)
        return impulse, solved and finite

    def _pivot(self, impulse: Floats, left: int) -> bool:
        """Solve bounded rows in place; returns whether all rows have found their states."""
        state = np.zeros(len(impulse), np.uint8)
        proximal_velocity(self.system, self.rows, self.vectors, impulse)
        guess_states(self.system, self.vectors, impulse, state)
        arguments = (self.system, self.rows, self.vectors, self.factor, state, impulse)
        steps, solved = pivot_rows(*arguments, Limits(left, self.symmetric))
        self.used += steps
        if self.symmetric and not solved and np.all(np.isfinite(impulse)):
            project(self.system.lower, self.system.upper, self.system.blocks, impulse)
            steps, solved = descend(*arguments, Limits(max(left - steps, 0), True))
            self.used += steps
        return bool(solved)

    def _take_newton_steps(self, impulse: Floats, left: int) -> bool:
        """Solve bounded rows and contacts in place; returns whether the steps have converged."""
        best = impulse.copy()
        most = min(left, NEWTON_STEPS)
        steps, square = solve_contacts(self.system, self.rows, self.vectors, self.factor, best, impulse, most)
        self.used += steps
        impulse[:] = best
        size = float(np.sum((self.row_scale * best) ** 2))
        return bool(square <= NEWTON_SOLVED**2 * max(size, self.rules.data_square))

    def _offer(self, impulse: Floats) -> float:
        """Keep the impulses if they are better than the best; returns their |e|^2."""
        error_square, size = natural_map(self.system, impulse, self.error)
        residual = self._measure(error_square, size)
        solved = residual <= self.rules.tolerance
        if error_square < 0.81 * self.error_square and (solved or size <= self._cap()):
            self.impulse[:] = impulse
            self.error_square, self.residual = error_square, residual
        return float(error_square) if np.isfinite(error_square) else np.inf

    def _cap(self) -> float:
        return self.rules.growth**2 * self.rules.data_square

    def _measure(self, error_square: float, size: float) -> float:
        return float(measure(error_square, size, self.rules.data_square, self.rules.growth))


def direct_solve(problem: Problem, rules: Rules, impulse: Floats, factor: Factor | None = None) -> DirectSolve:
    """Return a direct solve of a problem from these impulses, which it changes."""
    system = problem._kernel_system()
    return DirectSolve(system, rules, factor or plan_factor(system), problem._row_scale, impulse, problem.symmetric)
