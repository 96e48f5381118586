"""`Problem` and `solve`: input forms, degenerate rows, the residual, start values, robustness."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from gsenv.solver.problem.csr import CsrMatrix
from gsenv.solver.problem.problem import ContactRows, Problem, Solution, solve
from tests.solver.problem import oracle

Array = NDArray[np.float64]
METHODS = ("pgs", "nncg", "apgd")


def chain(n: int, mass: Array | float = 1.0) -> Problem:
    """n boxes on each other, g dt = 10; the impulse under a box is 10 times the mass from it up."""
    jacobian = np.eye(n) - np.eye(n, k=-1)
    return Problem.from_rows(1.0 / np.asarray(mass), jacobian, np.full(n, -10.0), lower=0)


def random_contacts(seed: int, contacts: int = 4) -> tuple[Array, Array, Array]:
    """Inverse masses, J and v of 3D contacts on two bodies of six coordinates."""
    rng = np.random.default_rng(seed)
    jacobian = rng.normal(size=(3 * contacts, 12))
    return rng.uniform(0.2, 2.0, 12), jacobian, rng.normal(size=12)


def velocity_of(solution: Solution) -> Array:
    assert solution.body_velocity is not None
    return solution.body_velocity


# Input forms


def test_sparse_input_equals_dense() -> None:
    sparse = pytest.importorskip("scipy.sparse")
    masses, jacobian, velocity = random_contacts(0)
    jacobian[np.abs(jacobian) < 0.5] = 0.0
    dense = Problem.from_rows(np.diag(masses), jacobian, velocity, contacts=ContactRows(0.5))
    expected = solve(dense)
    for form in (sparse.csr_array, sparse.csc_matrix, sparse.coo_array, sparse.lil_array):
        for inverse in (masses, form(np.diag(masses))):
            problem = Problem.from_rows(inverse, form(jacobian), velocity, contacts=ContactRows(0.5))
            assert_array_equal(problem.delassus.toarray(), dense.delassus.toarray())
            assert_array_equal(solve(problem).impulse, expected.impulse)
        A = form(dense.delassus.toarray())
        assembled = Problem.from_delassus(A, dense.rhs, friction=0.5)
        assert_array_equal(solve(assembled).impulse, expected.impulse)
    again = Problem.from_delassus(dense.delassus, dense.rhs, friction=0.5)
    assert_array_equal(again.delassus.toarray(), dense.delassus.toarray())
    assert_array_equal(dense.delassus.to_scipy().toarray(), dense.delassus.toarray())


def test_importing_needs_no_scipy() -> None:
    code = "import sys; sys.modules['scipy'] = None\n"
    code += "from gsenv.solver.problem.problem import Problem; Problem.from_rows(1, [[1]], [1])"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("rank_shape", [(5, 5), (4, 7), (0, 3), (3, 0)])
def test_csr_is_the_dense_algebra(rank_shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(1)
    rows, columns = rank_shape
    left = np.where(rng.random((rows, columns)) < 0.4, rng.normal(size=(rows, columns)), 0.0)
    right = np.where(rng.random((columns, 6)) < 0.4, rng.normal(size=(columns, 6)), 0.0)

    def csr(dense: Array) -> CsrMatrix:
        i, j = np.nonzero(dense)
        return CsrMatrix.from_entries(i, j, dense[i, j], (dense.shape[0], dense.shape[1]))

    a, b = csr(left), csr(right)
    assert_array_equal(a.toarray(), left)
    assert_array_equal(a.T.toarray(), left.T)
    assert_allclose(a.product(b).toarray(), left @ right, atol=1e-14)
    assert_array_equal((a + a).toarray(), 2 * left)
    assert_array_equal(a.diagonal(), np.diagonal(left))
    vector = rng.normal(size=columns)
    assert_allclose(a.multiply(vector), left @ vector, atol=1e-14)
    assert a.nnz == np.count_nonzero(left)


def test_duplicate_sparse_entries_add_up() -> None:
    sparse = pytest.importorskip("scipy.sparse")
    twice = sparse.coo_array(([1.0, 2.0, -1.0], ([0, 0, 0], [0, 0, 1])), shape=(1, 2))
    problem = Problem.from_rows(1, twice, [1, 1])
    assert_array_equal(problem.delassus.toarray(), [[10.0]])
    assert_array_equal(problem.rhs, [2.0])


def test_no_rows() -> None:
    problem = Problem.from_rows(1, np.zeros((0, 3)), [1, 2, 3])
    for method in METHODS:
        solution = solve(problem, method)
        assert solution.converged
        assert solution.residual == 0.0
        assert_array_equal(velocity_of(solution), [1, 2, 3])
        assert solution.impulse.shape == (0,)


def test_contact_rows_may_stand_anywhere() -> None:
    # the same rows in another order, bounded rows between the contacts
    rng = np.random.default_rng(2)
    A, b = oracle.random_delassus(rng, 9)
    lower, upper = np.full(9, -np.inf), np.full(9, np.inf)
    lower[[0, 5, 6]], upper[[0, 5, 6]] = -0.2, 0.2
    friction = [0.4, 0.7, 0.0]
    scattered = Problem.from_delassus(A, b, 0, lower, upper, friction, [2, 3, 1], contact_rows=[7, 2, 1])
    order = [7, 8, 2, 3, 4, 1, 0, 5, 6]
    packed = Problem.from_delassus(
        A[np.ix_(order, order)], b[order], 0, lower[order], upper[order], friction, [2, 3, 1]
    )
    one, other = solve(scattered, tolerance=1e-12), solve(packed, tolerance=1e-12)
    assert one.converged
    assert_allclose(one.impulse[order], other.impulse, atol=1e-9)
    assert one.impulse[1] >= 0.0


def test_bounds_of_a_mixed_problem() -> None:
    # a scalar bound goes to the free rows only; 0 on a normal is what the cone says anyway
    A, b = oracle.random_delassus(np.random.default_rng(3), 5)
    contact: dict[str, Any] = {"friction": [0.5], "contact_dim": 2, "contact_rows": [1]}
    scalar = Problem.from_delassus(A, b, lower=0, **contact)
    vector = Problem.from_delassus(A, b, lower=[0, 0, -np.inf, 0, 0], **contact)
    assert_array_equal(scalar.lower, [0, -np.inf, -np.inf, 0, 0])
    assert_array_equal(solve(scalar).impulse, solve(vector).impulse)


def test_same_input_same_bits() -> None:
    masses, jacobian, velocity = random_contacts(4, 8)
    for method in METHODS:
        problem = Problem.from_rows(masses, jacobian, velocity, contacts=ContactRows(0.6))
        first, second = solve(problem, method), solve(problem, method)
        assert_array_equal(first.impulse, second.impulse)
        assert first.sweeps == second.sweeps


def test_input_is_copied() -> None:
    velocity = np.array([-10.0, -10.0])
    problem = Problem.from_rows(1, [[1, 0], [-1, 1]], velocity, lower=0)
    velocity[:] = 0.0
    assert_allclose(solve(problem).impulse, [20, 10], atol=1e-6)
    with pytest.raises(ValueError, match="read-only"):
        problem.rhs[0] = 1.0


# The residual


def natural_map(problem: Problem, impulse: Array) -> float:
    """nm in numpy, from the formula in `Problem.residual`."""
    W = problem.delassus.toarray() + np.diag(problem.softness)
    u = W @ impulse + problem.rhs
    error, scaled, data = [], [], []
    dims = dict(zip(problem.contact_row, problem.contact_dim, strict=True))
    mus = dict(zip(problem.contact_row, problem.friction, strict=True))
    r = 0
    while r < len(u):
        block = slice(r, r + dims.get(r, 1))
        s = np.sqrt(np.trace(W[block, block]) / len(W[block, block]))
        z = s * impulse[block] - u[block] / s
        if r in dims:
            mu = mus[r]
            z[0] -= mu * np.linalg.norm(u[block][1:]) / s
            length = np.linalg.norm(z[1:])
            if mu * length <= -z[0]:
                z[:] = 0.0
            elif length > mu * z[0]:
                n = (z[0] + mu * length) / (1 + mu**2)
                z = np.array([n, *(mu * n * z[1:] / length)])
        else:
            z = np.clip(z, s * problem.lower[block], s * problem.upper[block])
        error.append(s * impulse[block] - z)
        scaled.append(s * impulse[block])
        data.append(problem.rhs[block] / s)
        r += len(z)
    norms = [float(np.linalg.norm(np.concatenate(part))) for part in (error, scaled, data)]
    return norms[0] / max(norms[1:])


def test_residual_is_the_natural_map() -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        A, b = oracle.random_delassus(rng, 8)
        lower = np.array([*[-np.inf] * 5, -0.5, 0.0, -np.inf])
        problem = Problem.from_delassus(A, b, rng.random(8), lower, np.inf, rng.random(2), [3, 2], [0, 3])
        impulse = rng.normal(size=8)
        assert problem.residual(impulse) == pytest.approx(natural_map(problem, impulse), rel=1e-12)
        solution = solve(problem, max_sweeps=3)
        expected = natural_map(problem, solution.impulse)
        assert solution.residual == pytest.approx(expected, rel=1e-6, abs=1e-14)
        assert np.linalg.norm(solution.row_error) == pytest.approx(solution.residual, rel=1e-12)


def test_residual_keeps_its_value_in_other_units() -> None:
    masses, jacobian, velocity = random_contacts(6)
    jacobian = np.vstack([jacobian, np.random.default_rng(6).normal(size=(2, 12))])
    limit = np.array([*[np.inf] * 12, 0.1, 0.2])
    impulse = np.random.default_rng(7).normal(size=14)
    contacts = ContactRows([0.5] * 4)

    def residual(mass: float, length: float, second: float) -> float:
        """Coordinates in the new length; impulses and bounds in mass length / second."""
        speed = length / second
        problem = Problem.from_rows(
            masses / mass, jacobian, velocity * speed, 0, 0,
            -limit * mass * speed, limit * mass * speed, contacts,
        )  # fmt: skip
        return problem.residual(impulse * mass * speed)

    expected = residual(1, 1, 1)
    assert expected > 1e-3
    for units in ((1e6, 1, 1), (1, 1e3, 1), (1, 1, 1e-3), (1e-3, 1e-2, 60)):
        assert residual(*units) == pytest.approx(expected, rel=1e-12)


def test_residual_ignores_the_scale_of_a_bounded_row() -> None:
    # a row c J with impulse lambda / c is the same row
    A, b = oracle.random_delassus(np.random.default_rng(8), 4)
    scale = np.array([1.0, 1e-3, 1e2, 7.0])
    impulse = np.random.default_rng(9).normal(size=4)
    one = Problem.from_delassus(A, b, lower=-0.5)
    other = Problem.from_delassus(A * np.outer(scale, scale), b * scale, lower=-0.5 / scale)
    assert other.residual(impulse / scale) == pytest.approx(one.residual(impulse), rel=1e-12)


def test_sweeps_do_not_depend_on_units() -> None:
    masses, jacobian, velocity = random_contacts(10)
    for method in METHODS:
        counts = set()
        for mass, speed in ((1.0, 1.0), (2.0**20, 1.0), (1.0, 2.0**-10)):  # exact in binary
            problem = Problem.from_rows(masses / mass, jacobian, velocity * speed, contacts=ContactRows(0.5))
            counts.add(solve(problem, method).sweeps)
        assert len(counts) == 1


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-10])
def test_stops_at_the_tolerance(method: str, tolerance: float) -> None:
    problem = chain(10)
    solution = solve(problem, method, tolerance)
    assert solution.converged
    assert problem.residual(solution.impulse) == solution.residual <= tolerance
    assert len(solution.unsolved_rows) == 0
    if solution.sweeps > 1:
        fewer = solve(problem, method, tolerance, max_sweeps=solution.sweeps // 2)
        assert not fewer.converged
        assert fewer.sweeps == solution.sweeps // 2
        assert len(fewer.unsolved_rows) > 0


def test_acceleration_pays() -> None:
    sweeps = {method: solve(chain(30), method, 1e-6).sweeps for method in METHODS}
    assert sweeps["nncg"] < sweeps["pgs"] / 5
    assert sweeps["apgd"] < sweeps["pgs"] / 5


# Start values


@pytest.mark.parametrize("method", METHODS)
def test_start(method: str) -> None:
    problem = chain(5)
    exact = 10.0 * np.arange(5, 0, -1)
    there = solve(problem, method, start=exact)
    assert there.sweeps == 0
    assert_allclose(there.impulse, exact)
    cold = solve(problem, method)
    near = solve(problem, method, start=exact * (1 + 1e-6))
    assert 0 < near.sweeps < cold.sweeps
    from_outside = solve(problem, method, start=-exact)
    assert_allclose(from_outside.impulse, exact, atol=1e-5)
    assert_array_equal(solve(problem, max_sweeps=0, start=-exact).impulse, np.zeros(5))


# Degenerate rows


@pytest.mark.parametrize("method", METHODS)
def test_redundant_rows_share(method: str) -> None:
    # the same lock three times: what matters is the sum
    problem = Problem.from_rows(1, [[1, -1]] * 3, [3, -1])
    solution = solve(problem, method)
    assert solution.converged
    assert solution.impulse.sum() == pytest.approx(-2, abs=1e-7)
    assert_allclose(velocity_of(solution), [1, 1], atol=1e-7)
    doubled = Problem.from_rows(1, np.repeat(np.eye(10) - np.eye(10, k=-1), 2, 0), -10, lower=0)
    solution = solve(doubled, method)
    assert solution.converged
    pairs = solution.impulse.reshape(10, 2).sum(axis=1)
    assert_allclose(pairs, 10.0 * np.arange(10, 0, -1), atol=1e-3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-8])
def test_contradictory_rows_are_reported(method: str, tolerance: float) -> None:
    # rows 0 and 1 want v = 0 and v = 1 of one mass; row 2 is another mass, and is solved
    problem = Problem.from_rows(1, [[1, 0], [1, 0], [0, 1]], [0, 5], bias=[0, -1, 0])
    solution = solve(problem, method, tolerance)
    assert not solution.converged
    assert set(solution.unsolved_rows) & {0, 1}
    assert 2 not in solution.unsolved_rows
    assert np.abs(solution.impulse).max() < 100.0
    assert solution.impulse[2] == pytest.approx(-5, abs=0.1)
    # softness makes a compromise of them: half way
    soft = Problem.from_rows(1, [[1, 0], [1, 0]], [0, 5], bias=[0, -1], softness=1e-3)
    compromise = solve(soft, method)
    assert compromise.converged
    assert velocity_of(compromise)[0] == pytest.approx(0.5, abs=1e-3)


def test_contact_pinched_between_immovable_walls() -> None:
    # two contacts press one mass from both sides, each asking for 1 m/s
    jacobian = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, 1, 0], [0, 0, 1]])
    problem = Problem.from_rows(1, jacobian, [0, 0.5, 0], bias=[-1, 0, 0] * 2,
                                contacts=ContactRows(0.5))  # fmt: skip
    for method in METHODS:
        solution = solve(problem, method)
        assert not solution.converged
        assert np.all(np.isfinite(solution.impulse))
        assert np.abs(solution.impulse).max() < 1e3


def test_rows_that_nothing_moves() -> None:
    jacobian = [[1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0]]
    # row 1 acts on a pinned coordinate at rest, rows 2 and 3 on nothing: all satisfied
    problem = Problem.from_rows([1, 0, 1], jacobian, [-1, 0, 0], lower=[0, 0, -1, 0])
    solution = solve(problem)
    assert solution.converged
    assert_allclose(solution.impulse, [1, 0, 0, 0])
    # asked to move, a bounded row pushes as hard as it may: a stalled motor
    stalled = Problem.from_rows(0, [[1.0]], [0], bias=-1, lower=-3, upper=3)
    assert_allclose(stalled.rhs, [-1])
    solution = solve(stalled)
    assert solution.converged
    assert_allclose(solution.impulse, [3])
    # unbounded it has no answer
    stuck = Problem.from_rows([1, 0], np.eye(2), [-1, -1], lower=0)
    solution = solve(stuck)
    assert not solution.converged
    assert_array_equal(solution.unsolved_rows, [1])
    assert_allclose(solution.impulse, [1, 0])


def test_immovable_contacts() -> None:
    # both bodies pinned: satisfied where it separates, reported where it closes
    for velocity, converged in ((1.0, True), (0.0, True), (-1.0, False)):
        problem = Problem.from_rows(0, np.eye(3), [velocity, 1, 0], contacts=ContactRows(0.5))
        solution = solve(problem)
        assert_array_equal(solution.impulse, np.zeros(3))
        assert solution.converged == converged
    # massless tangents, movable normal
    problem = Problem.from_rows([1, 0, 0], np.eye(3), [-1, 0, 0], contacts=ContactRows(0.5))
    solution = solve(problem)
    assert solution.converged
    assert_allclose(solution.impulse, [1, 0, 0])
    # a pushed, immovable tangent takes all the friction there is
    problem = Problem.from_rows([1, 0, 0], np.eye(3), [-1, 3, 4], contacts=ContactRows(0.5))
    solution = solve(problem)
    assert solution.converged
    assert_allclose(solution.impulse, [1, -0.3, -0.4])


def test_tangent_that_is_the_normal() -> None:
    # a contact on a slanted track: normal and tangent move one and the same coordinate
    problem = Problem.from_rows(1, [[1.0], [0.5]], [-1], contacts=ContactRows(0.8, dim=2))
    solution = solve(problem)
    assert solution.converged
    assert_allclose(velocity_of(solution), [0], atol=1e-9)


def test_nothing_asked_nothing_given() -> None:
    problem = Problem.from_delassus(np.zeros((3, 3)), np.zeros(3), friction=0.5)
    assert solve(problem, start=[1, 0, 0]).residual == 0.0
    calm = Problem.from_rows(1, np.eye(3), [0, 0, 0])
    assert_array_equal(solve(calm, start=[1, 2, 3]).impulse, np.zeros(3))


@pytest.mark.parametrize("method", METHODS)
def test_light_on_a_million_times_heavier(method: str) -> None:
    solution = solve(chain(2, np.array([1e6, 1.0])), method)
    assert solution.converged
    assert_allclose(solution.impulse, [1e7 + 10, 10], rtol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_heavy_on_a_million_times_lighter(method: str) -> None:
    problem = chain(2, np.array([1.0, 1e6]))
    solution = solve(problem, method, 1e-10, 100_000)
    if method == "pgs":  # gains 10 of 1e7 a sweep, and says so
        assert not solution.converged
        assert 1e5 < solution.impulse[0] < 1e7
    else:
        assert solution.converged
        assert_allclose(solution.impulse, [1e7 + 10, 1e7], rtol=1e-4)


@pytest.mark.parametrize("scale", [1e-150, 1e-30, 1e30, 1e150])
def test_extreme_units(scale: float) -> None:
    A, b = oracle.random_delassus(np.random.default_rng(11), 6)
    expected = solve(Problem.from_delassus(A, b, friction=0.5)).impulse
    solution = solve(Problem.from_delassus(A * scale, b * scale, friction=0.5))
    assert solution.converged
    assert_allclose(solution.impulse, expected, atol=1e-6)


# Whatever comes in: finite, in bounds, honest

exponents = st.integers(-6, 6)


@given(
    seed=st.integers(0, 2**32 - 1),
    rank=st.integers(1, 9),
    contact_count=st.integers(0, 3),
    dim=st.integers(1, 3),
    friction=st.sampled_from([0.0, 0.5, 1.0, 10.0, 1e6]),
    spread=st.integers(0, 8),
    level=exponents,
    zero_share=st.sampled_from([0.0, 0.3, 0.8]),
    consistent=st.booleans(),
    method=st.sampled_from(METHODS),
)
def test_any_input_gives_finite_impulses_in_bounds(
    seed: int,
    rank: int,
    contact_count: int,
    dim: int,
    friction: float,
    spread: int,
    level: int,
    zero_share: float,
    consistent: bool,
    method: str,
) -> None:
    rng = np.random.default_rng(seed)
    rows = contact_count * dim + int(rng.integers(0, 4))
    factor = rng.normal(size=(rows, rank)) * 10.0 ** rng.uniform(-spread, spread, (rows, 1))
    factor[rng.random((rows, rank)) < zero_share] = 0.0
    factor *= 10.0**level
    b = factor @ rng.normal(size=rank) if consistent else rng.normal(size=rows)
    lower, upper = np.full(rows, -np.inf), np.full(rows, np.inf)
    for r in range(contact_count * dim, rows):
        lower[r] = rng.choice([-np.inf, 0.0, -1.0])
        upper[r] = rng.choice([np.inf, 0.0, 2.0])
    problem = Problem.from_delassus(factor @ factor.T, b, 0, lower, upper, np.full(contact_count, friction), dim)
    solution = solve(problem, method, max_sweeps=200)
    impulse = solution.impulse
    assert np.all(np.isfinite(impulse))
    assert not np.isnan(solution.residual)
    assert np.all(impulse >= problem.lower)
    assert np.all(impulse <= problem.upper)
    for c in range(contact_count):
        normal, *tangent = impulse[c * dim : (c + 1) * dim]
        assert normal >= 0.0
        assert np.linalg.norm(tangent) <= friction * normal * (1 + 1e-12) + 1e-300
    if solution.converged:
        assert solution.residual <= 1e-8
