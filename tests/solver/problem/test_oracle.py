"""`solve` against dense oracles: hundreds of random problems, every method."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver.problem.problem import Problem, Solution, solve
from tests.solver.problem import oracle

METHODS = ("pgs", "nncg", "apgd")


def check(problem: Problem, solution: Solution, tolerance: float = 1e-8) -> None:
    """The conditions themselves, in numpy, on problems whose data are of order 1."""
    assert solution.converged
    A = problem.delassus.toarray() + np.diag(problem.softness)
    breach = oracle.violation(
        A,
        problem.rhs,
        solution.impulse,
        problem.contact_row,
        problem.contact_dim,
        problem.friction,
        problem.lower,
        problem.upper,
    )
    size = max(1.0, np.abs(solution.impulse).max(), np.abs(solution.row_velocity).max())
    assert breach <= tolerance * size * size


@pytest.mark.parametrize("method", METHODS)
def test_random_lcp(method: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        n = int(rng.integers(1, 11))
        A, b = oracle.random_delassus(rng, n)
        lower, upper = np.zeros(n), np.full(n, np.inf)
        solution = solve(Problem.from_delassus(A, b, lower=0), method, 1e-12, 100_000)
        assert solution.converged
        # positive definite: exactly one solution
        for expected in oracle.box_solutions(A, b, lower, upper):
            assert_allclose(solution.impulse, expected, atol=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_random_boxes(method: str) -> None:
    rng = np.random.default_rng(2)
    for _ in range(60):
        n = int(rng.integers(1, 7))
        A, b = oracle.random_delassus(rng, n)
        softness = np.where(rng.random(n) < 0.3, rng.random(n), 0.0)
        lower = np.where(rng.random(n) < 0.3, -np.inf, rng.normal(size=n))
        upper = np.where(rng.random(n) < 0.3, np.inf, np.maximum(lower, -9) + 2 * rng.random(n))
        problem = Problem.from_delassus(A, b, softness, lower, upper)
        solution = solve(problem, method, 1e-12, 100_000)
        check(problem, solution)
        found = oracle.box_solutions(A + np.diag(softness), b, lower, upper)
        assert found
        for expected in found:
            assert_allclose(solution.impulse, expected, atol=1e-7)
        assert_allclose(solution.row_velocity, A @ solution.impulse + b, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_random_planar_contacts_among_bounded_rows(method: str) -> None:
    rng = np.random.default_rng(3)
    compared = 0
    for _ in range(40):
        contacts, rows = int(rng.integers(1, 4)), int(rng.integers(0, 3))
        n = 2 * contacts + rows
        A, b = oracle.random_delassus(rng, n)
        friction = rng.uniform(0.0, 1.0, contacts)
        lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
        lower[2 * contacts :], upper[2 * contacts :] = -rng.random(rows), rng.random(rows)
        problem = Problem.from_delassus(A, b, lower=lower, upper=upper, friction=friction, contact_dim=2)
        solution = solve(problem, method, 1e-12, 100_000)
        check(problem, solution)
        found = oracle.planar_solutions(A, b, friction, lower, upper)
        distances = [np.abs(solution.impulse - expected).max() for expected in found]
        assert min(distances) <= 1e-7
        compared += len(found) == 1
    assert compared > 30  # most have one solution, so equality says something


@pytest.mark.parametrize("mu", [0.0, 0.3, 1.0, 3.0])
def test_one_contact_has_the_oracles_impulse(mu: float) -> None:
    rng = np.random.default_rng(4)
    slid = 0
    for _ in range(40):
        W, b = oracle.random_delassus(rng, 3, 3)
        solution = solve(Problem.from_delassus(W, b, friction=mu), tolerance=1e-12)
        assert solution.converged
        assert solution.sweeps <= 2  # the one-contact solve is exact
        n, t = solution.impulse[0], np.hypot(*solution.impulse[1:])
        assert t <= mu * n * (1 + 1e-12)
        found = oracle.one_contact_solutions(W, b, mu)
        distances = [np.abs(solution.impulse - one).max() for one in found]
        assert min(distances) <= 1e-7 * max(1.0, n)
        slid += 0.0 < mu * n <= t * (1 + 1e-12)
    assert mu == 0.0 or slid > 3


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("mu", [0.3, 0.8, 1.5])
def test_random_spatial_contacts(method: str, mu: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(40):
        contacts = int(rng.integers(1, 7))
        A, b = oracle.random_delassus(rng, 3 * contacts)
        problem = Problem.from_delassus(A, b, friction=mu)
        check(problem, solve(problem, method, 1e-11, 50_000))


def test_spatial_contacts_agree_with_an_independent_iteration() -> None:
    rng = np.random.default_rng(6)
    for contacts in (1, 2, 3, 4):
        A, b = oracle.random_delassus(rng, 3 * contacts, 6 * contacts)
        mu = rng.uniform(0.1, 0.4, contacts)  # little friction: one solution
        expected = oracle.de_saxce_impulse(A, b, mu)
        for method in METHODS:
            solution = solve(Problem.from_delassus(A, b, friction=mu), method, 1e-12, 50_000)
            assert solution.converged
            assert_allclose(solution.impulse, expected, atol=1e-7)


@pytest.mark.parametrize("dim", [2, 3])
def test_more_contacts_than_freedoms(dim: int) -> None:
    # A is singular, impulses are not unique: the conditions decide
    rng = np.random.default_rng(7)
    for _ in range(20):
        A, b = oracle.random_delassus(rng, 4 * dim, 6)
        problem = Problem.from_delassus(A, b, friction=0.5, contact_dim=dim)
        check(problem, solve(problem, "nncg", 1e-11, 50_000))


@pytest.mark.parametrize("method", METHODS)
def test_strong_friction_where_exact_solves_jump(method: str) -> None:
    # These four have one solution each and made plain block Gauss-Seidel cycle for ever.
    for seed, contacts in ((46, 2), (51, 2), (91, 3), (142, 3)):
        rng = np.random.default_rng(seed)
        A, b = oracle.random_delassus(rng, 2 * contacts)
        friction = np.full(contacts, 2.0)
        problem = Problem.from_delassus(A, b, friction=friction, contact_dim=2)
        solution = solve(problem, method, 1e-10, 50_000)
        check(problem, solution)
        open_ended = np.full(2 * contacts, np.inf)
        (expected,) = oracle.planar_solutions(A, b, friction, -open_ended, open_ended)
        assert_allclose(solution.impulse, expected, atol=1e-6)


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_sliding_follows_the_push_in_every_direction(dim: int) -> None:
    # a unit mass pressed down at 1 m/s and pushed at 2 m/s: friction is exactly opposite
    for angle in np.linspace(0.0, 2.0 * np.pi, 25):
        push = 2.0 * np.array([np.cos(angle), np.sin(angle)])[: dim - 1]
        problem = Problem.from_delassus(np.eye(dim), [-1.0, *push], friction=0.25, contact_dim=dim)
        solution = solve(problem, tolerance=1e-13)
        speed = float(np.linalg.norm(push))
        reach = min(0.25, speed) if speed else 0.0
        expected = [1.0, *(-reach * push / (speed or 1.0))]
        assert_allclose(solution.impulse, expected, atol=1e-12)
