"""Lemke's method and problems without symmetry."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from gsenv.solver.problem.problem import Problem, solve
from tests.solver.problem import oracle
from tests.solver.problem.problems import degenerate_problem, murty_problem, p_matrix, p_problem

Array = NDArray[np.float64]


def complementary_solutions(problem: Problem) -> list[Array]:
    """Every solution with regular free rows, by all 3^n states."""
    A, b = problem.delassus.toarray(), problem.rhs
    bounds = (problem.lower, problem.upper)
    found = []
    for states in itertools.product((0, 1, None), repeat=len(b)):
        if any(s is not None and not np.isfinite(bounds[s][r]) for r, s in enumerate(states)):
            continue
        free = np.array([s is None for s in states])
        impulse = np.array([0.0 if s is None else bounds[s][r] for r, s in enumerate(states)])
        if abs(np.linalg.det(A[np.ix_(free, free)])) < 1e-12:
            continue
        impulse[free] = np.linalg.solve(A[np.ix_(free, free)], -(b + A @ impulse)[free])
        if np.abs(impulse - np.clip(impulse - A @ impulse - b, *bounds)).max() < 1e-9:
            found.append(impulse)
    return found


@pytest.mark.parametrize("method", ["lemke", "direct", "auto"])
@pytest.mark.parametrize("boxed", [False, True])
def test_p_matrices_have_the_enumerated_solution(method: str, boxed: bool) -> None:
    rng = np.random.default_rng(1)
    for _ in range(25):
        problem = p_problem(rng, int(rng.integers(1, 6)), boxed)
        solution = solve(problem, method)
        assert solution.converged
        expected = complementary_solutions(problem)
        assert expected
        for one in expected:  # exactly one, perhaps found in several states
            assert_allclose(solution.impulse, one, atol=1e-9)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 50), boxed=st.booleans())
@settings(deadline=None)
def test_lemke_solves_p_matrices(seed: int, count: int, boxed: bool) -> None:
    problem = p_problem(np.random.default_rng(seed), count, boxed)
    solution = solve(problem, "lemke")
    assert solution.converged, solution.reason
    assert solution.residual < 1e-11


def test_p_matrix_that_is_not_definite() -> None:
    """All principal minors are 1 or more, but the symmetric part is indefinite: here careless pivots cycle."""
    A = np.array([[1.0, 0.0, 2.0], [2.0, 1.0, 0.0], [0.0, 2.0, 1.0]])
    assert np.linalg.eigvalsh(A + A.T).min() < 0.0
    for b in itertools.product((-1.0, 0.0, 1.0), repeat=3):
        problem = Problem.from_delassus(A, b, lower=0)
        for method in ("lemke", "direct", "auto"):
            solution = solve(problem, method)
            assert solution.converged, (b, method)
            for expected in complementary_solutions(problem):
                assert_allclose(solution.impulse, expected, atol=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("count", [3, 5])
def test_murtys_example(count: int) -> None:
    """Lemke's method takes 2^n - 1 pivots, block pivoting about n."""
    problem = murty_problem(count)
    lemke, direct, auto = (solve(problem, method) for method in ("lemke", "direct", "auto"))
    for solution in (lemke, direct, auto):
        assert solution.converged
        assert_allclose(solution.impulse, [1.0, *[0.0] * (count - 1)], atol=1e-12)
    assert lemke.pivots == 2**count - 1
    assert direct.pivots < 4 * count
    assert auto.method == "direct"


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 40), symmetric=st.booleans())
@settings(deadline=None)
def test_degenerate_problems(seed: int, count: int, symmetric: bool) -> None:
    """Many ties: the lexicographic rule must not cycle. Linear programs have a zero diagonal."""
    problem = degenerate_problem(np.random.default_rng(seed), count, symmetric)
    for method in ("lemke", "auto"):
        solution = solve(problem, method)
        assert solution.converged, (method, solution.reason)
        impulse = solution.impulse
        w = problem.delassus.multiply(impulse) + problem.rhs
        size = max(1.0, np.abs(impulse).max(), np.abs(w).max())
        assert w.min() >= -1e-6 * size
        assert abs(impulse @ w) <= 1e-6 * size**2


def test_a_ray_is_no_solution() -> None:
    """A game of two players, whose matrix is not semidefinite: a solution exists, and the path misses it."""
    costs = np.random.default_rng(4).uniform(1.0, 2.0, (2, 4, 3))
    A = np.zeros((7, 7))
    A[:4, 4:], A[4:, :4] = costs[0], costs[1].T
    problem = Problem.from_delassus(A, -np.ones(7), lower=0)
    assert complementary_solutions(problem)
    solution = solve(problem, "lemke")
    assert not solution.converged
    assert "semidefinite" in solution.reason


@pytest.mark.nojit
def test_rows_with_every_kind_of_bound() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        A, b = p_matrix(rng, 5), 3.0 * rng.normal(size=5)
        lower, upper = [-np.inf, -np.inf, 0.0, -1.0, 0.3], [np.inf, 0.2, np.inf, 1.0, 0.3]
        problem = Problem.from_delassus(A, b, 0, lower, upper)
        (expected, *_) = complementary_solutions(problem)
        for method in ("lemke", "direct"):
            assert_allclose(solve(problem, method).impulse, expected, atol=1e-10)


@pytest.mark.parametrize("mu", [0.3, 1.0])
def test_planar_contacts(mu: float) -> None:
    rng = np.random.default_rng(6)
    for _ in range(25):
        contacts = int(rng.integers(1, 4))
        A, b = oracle.random_delassus(rng, 2 * contacts)
        friction = np.full(contacts, mu)
        problem = Problem.from_delassus(A, b, friction=friction, contact_dim=2)
        solution = solve(problem, "lemke")
        assert solution.converged, solution.reason
        open_ended = np.full(2 * contacts, np.inf)
        found = oracle.planar_solutions(A, b, friction, -open_ended, open_ended)
        assert min(np.abs(solution.impulse - one).max() for one in found) < 1e-9


def test_problems_without_solution() -> None:
    # w = (-1, 1) x - 1 can't be >= 0 for x >= 0 in a skew, hence positive semidefinite, matrix
    infeasible = Problem.from_delassus([[0.0, -1.0], [1.0, 0.0]], [-1.0, 1.0], lower=0)
    for method in ("lemke", "auto"):
        solution = solve(infeasible, method)
        assert not solution.converged
        assert "ray" in solution.reason
        assert np.all(np.isfinite(solution.impulse))
    dependent = Problem.from_delassus(np.ones((2, 2)), [1.0, 2.0])
    assert "linearly dependent" in solve(dependent, "lemke").reason


def test_pivot_limit() -> None:
    solution = solve(murty_problem(20), "lemke", max_sweeps=100)
    assert not solution.converged
    assert "max_sweeps = 100" in solution.reason
    assert solution.pivots == 100


def test_scale_of_rows_does_not_matter() -> None:
    rng = np.random.default_rng(7)
    A, b = p_matrix(rng, 12), rng.normal(size=12)
    expected = solve(Problem.from_delassus(A, b, lower=0), "lemke")
    scale = 10.0 ** rng.uniform(-6, 6, 12)
    other = solve(Problem.from_delassus(A * np.outer(scale, scale), b * scale, lower=0), "lemke")
    assert other.pivots == expected.pivots
    assert_allclose(other.impulse * scale, expected.impulse, atol=1e-10)
