"""The direct method against enumeration, scipy and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from gsenv.solver.problem import cones
from gsenv.solver.problem.cones import convex_starts
from gsenv.solver.problem.csr import CsrMatrix
from gsenv.solver.problem.direct import direct_solve
from gsenv.solver.problem.kernels import Rules
from gsenv.solver.problem.problem import ContactRows, Problem, Solution, solve
from gsenv.solver.problem.sparse_lu import Rows, factorise, plan_factor, substitute
from tests.solver.problem import oracle
from tests.solver.problem.problems import STEP, G, degenerate_problem, p_problem, pyramid, spatial_tower, tower

Array = NDArray[np.float64]
METHODS = ("direct", "auto")


def breach(problem: Problem, impulse: Array) -> float:
    """Largest breach of the conditions, relative to the sizes of impulses and velocities."""
    A = problem.delassus.toarray() + np.diag(problem.softness)
    contacts = (problem.contact_row, problem.contact_dim, problem.friction)
    worst = oracle.violation(A, problem.rhs, impulse, *contacts, problem.lower, problem.upper)
    size = max(1.0, float(np.abs(impulse).max(initial=0.0)), float(np.abs(A @ impulse + problem.rhs).max(initial=0.0)))
    return worst / size**2


def check(problem: Problem, solution: Solution, tolerance: float = 1e-8) -> None:
    assert solution.converged, solution.reason
    assert solution.reason == ""
    assert breach(problem, solution.impulse) <= tolerance


def random_box(rng: np.random.Generator, count: int, rank: int | None = None) -> Problem:
    """Bounds of every kind: none, one, both, equal."""
    A, b = oracle.random_delassus(rng, count, rank)
    lower = np.where(rng.random(count) < 0.3, -np.inf, rng.normal(size=count))
    upper = np.where(rng.random(count) < 0.3, np.inf, np.maximum(lower, -9.0) + 2.0 * rng.random(count))
    upper = np.where(np.isfinite(lower) & (rng.random(count) < 0.1), lower, upper)
    return Problem.from_delassus(A, b, 0, lower, upper)


# ---------------------------------------------------------------- the sparse factor


@pytest.mark.parametrize("seed", range(5))
def test_factor_of_random_rows(seed: int) -> None:
    """Oracle: numpy's dense solution of G (W + P) + H, with blocks of one to three rows."""
    rng = np.random.default_rng(seed)
    dims = np.array([3, 1, 2, 1, 3, 1])
    count = int(dims.sum())
    J = rng.normal(size=(count, 2 * count)) * (rng.random((count, 2 * count)) < 0.15)
    A = J @ J.T + np.diag(1.0 + rng.random(count))
    first = np.cumsum(dims) - dims
    contact = dims > 1
    problem = Problem.from_delassus(
        A, np.zeros(count), friction=np.full(contact.sum(), 0.5), contact_dim=dims[contact], contact_rows=first[contact]
    )
    system = problem._kernel_system()
    factor = plan_factor(system)
    G_part, H_part = np.zeros((2, len(dims), 3, 3))
    big_g, big_h = np.zeros((2, count, count))
    for b, (r, d) in enumerate(zip(first, dims, strict=True)):
        G_part[b, :d, :d] = np.eye(d) + 0.3 * rng.random((d, d))
        H_part[b, :d, :d] = 0.2 * rng.random((d, d))
        big_g[r : r + d, r : r + d], big_h[r : r + d, r : r + d] = G_part[b, :d, :d], H_part[b, :d, :d]
    live = (rng.random(count) < 0.8).astype(np.uint8)
    proximal = rng.random(count)
    assert factorise(system, Rows(G_part, H_part, live, proximal), factor)
    rhs, solution = rng.normal(size=count), np.zeros(count)
    substitute(factor, rhs, solution)
    expected = np.linalg.solve(big_g @ (A * live + np.diag(proximal)) + big_h, rhs)
    assert_allclose(solution, expected, atol=1e-10)


def test_chain_has_no_fill() -> None:
    """Tridiagonal in a random order: minimum degree finds an order in which L has one entry for each row but one."""
    order = np.random.default_rng(0).permutation(50)
    jacobian = (np.eye(50) - np.eye(50, k=-1))[order]
    factor = plan_factor(Problem.from_rows(1.0, jacobian, 0.0)._kernel_system())
    assert len(factor.lower) == len(factor.upper) == 49


# ---------------------------------------------------------------- bounded rows


@pytest.mark.parametrize("method", METHODS)
def test_random_boxes_have_the_enumerated_solution(method: str) -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        problem = random_box(rng, int(rng.integers(1, 7)))
        solution = solve(problem, method, 1e-12)
        check(problem, solution)
        found = oracle.box_solutions(problem.delassus.toarray(), problem.rhs, problem.lower, problem.upper)
        assert found
        for expected in found:
            assert_allclose(solution.impulse, expected, atol=1e-8)


def test_boxes_have_scipys_solution() -> None:
    optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(2)
    for count in (20, 60):
        factor = rng.normal(size=(count + 5, count))
        target = rng.normal(size=count + 5)
        lower, upper = -rng.random(count), rng.random(count)
        # |factor x - target|^2 / 2 has the gradient A x + b
        problem = Problem.from_delassus(factor.T @ factor, -factor.T @ target, 0, lower, upper)
        expected = optimize.lsq_linear(factor, target, (lower, upper), method="bvls", tol=1e-14).x
        assert_allclose(solve(problem, "direct").impulse, expected, atol=1e-8)
        positive = Problem.from_delassus(factor.T @ factor, -factor.T @ target, lower=0)
        assert_allclose(solve(positive, "direct").impulse, optimize.nnls(factor, target)[0], atol=1e-8)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 40), rank=st.integers(1, 40), spread=st.integers(0, 4))
@settings(deadline=None)
def test_semidefinite_boxes(seed: int, count: int, rank: int, spread: int) -> None:
    """Redundant rows and masses that differ by up to 8 orders: b is in the image of A, so a solution exists."""
    rng = np.random.default_rng(seed)
    problem = random_box(rng, count, rank)
    scale = 10.0 ** rng.uniform(-spread, spread, count)
    A = problem.delassus.toarray() * np.outer(scale, scale)
    scaled = Problem.from_delassus(A, problem.rhs * scale, 0, problem.lower / scale, problem.upper / scale)
    solution = solve(scaled, "direct")
    assert solution.converged, solution.reason
    assert breach(problem, solution.impulse * scale) < 1e-6


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [2, 10, 100])
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6, 1e9])
def test_tower_carries_the_weight_above(method: str, count: int, ratio: float) -> None:
    problem, weight = tower(count, ratio)
    solution = solve(problem, method)
    assert solution.converged
    assert_allclose(solution.impulse, weight, rtol=1e-5)
    if method == "direct" or ratio > 1.0:
        assert solution.method == "direct"
        assert_allclose(solution.impulse, weight, rtol=1e-6)


def test_tower_of_a_thousand_rows() -> None:
    problem, weight = tower(1000)
    solution = solve(problem)
    assert solution.method == "direct"
    assert_allclose(solution.impulse, weight, rtol=1e-7)
    # from zero impulses all contacts are tried as closed: few systems
    assert solve(problem, "direct").pivots < 10


def test_light_box_on_the_tower_of_heavy_ones() -> None:
    problem, weight = tower(50, 1e-9)
    assert_allclose(solve(problem).impulse, weight, rtol=1e-7)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 60))
@settings(deadline=None)
def test_degenerate_problems(seed: int, count: int) -> None:
    """Rows with neither impulse nor velocity: pivoting must not cycle."""
    problem = degenerate_problem(np.random.default_rng(seed), count)
    solution = solve(problem, "direct")
    check(problem, solution, 1e-7)
    assert solution.pivots < 40 * (count + 2)


@pytest.mark.nojit
def test_redundant_rows_share_equally() -> None:
    problem = Problem.from_rows(1, [[1.0, -1.0]] * 3, [3, -1])
    assert_allclose(solve(problem, "direct").impulse, [-2 / 3] * 3, atol=1e-6)
    doubled = Problem.from_rows(1, np.repeat(np.eye(10) - np.eye(10, k=-1), 2, 0), -10, lower=0)
    solution = solve(doubled, "direct")
    assert_allclose(solution.impulse, np.repeat(5.0 * np.arange(10, 0, -1), 2), atol=1e-5)
    assert solution.residual < 1e-12


def test_over_determined_joints() -> None:
    """A square of bars pinned at all corners, two pins at each: velocities as from a least-norm impulse."""
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(6, 12))
    jacobian = np.vstack([rows, rows, rows[::-1] * 2.0])  # each thrice, in another scale
    velocity = rng.normal(size=12)
    solution = solve(Problem.from_rows(1.0, jacobian, velocity), "direct")
    assert solution.converged
    expected = velocity - rows.T @ np.linalg.solve(rows @ rows.T, rows @ velocity)
    assert solution.body_velocity is not None
    assert_allclose(solution.body_velocity, expected, atol=1e-11)
    least = -np.linalg.pinv(jacobian @ jacobian.T) @ (jacobian @ velocity)
    assert np.linalg.norm(solution.impulse) < 1.5 * np.linalg.norm(least)


@pytest.mark.parametrize("method", ["direct", "auto"])
def test_contradictory_rows_are_reported(method: str) -> None:
    problem = Problem.from_rows(1, [[1, 0], [1, 0], [0, 1]], [0, 5], bias=[0, -1, 0])
    solution = solve(problem, method)
    assert not solution.converged
    assert solution.reason.endswith(".")
    assert set(solution.unsolved_rows) & {0, 1}
    assert np.abs(solution.impulse).max() < 1e3
    assert solution.body_velocity is not None
    if method == "direct":  # half way between what they ask for
        assert_allclose(solution.body_velocity, [0.5, 0.0], atol=0.1)


@pytest.mark.parametrize("method", ["direct", "auto"])
def test_pinched_contact_is_reported(method: str) -> None:
    jacobian = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, 1, 0], [0, 0, 1]])
    problem = Problem.from_rows(1, jacobian, [0, 0.5, 0], bias=[-1, 0, 0] * 2, contacts=ContactRows(0.5))
    solution = solve(problem, method)
    assert not solution.converged
    assert np.abs(solution.impulse).max() < 1e3


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 40), boxed=st.booleans())
@settings(deadline=None)
def test_p_matrices(seed: int, count: int, boxed: bool) -> None:
    problem = p_problem(np.random.default_rng(seed), count, boxed)
    solution = solve(problem, "direct")
    check(problem, solution, 1e-9)


# ---------------------------------------------------------------- contacts


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
        solution = solve(problem, method, 1e-12)
        check(problem, solution)
        found = oracle.planar_solutions(A, b, friction, lower, upper)
        assert min(np.abs(solution.impulse - expected).max() for expected in found) <= 1e-8
        compared += len(found) == 1
    assert compared > 30


def test_spatial_contacts_agree_with_an_independent_iteration() -> None:
    rng = np.random.default_rng(6)
    for contacts in (1, 2, 3, 4):
        A, b = oracle.random_delassus(rng, 3 * contacts, 6 * contacts)
        mu = rng.uniform(0.1, 0.4, contacts)
        expected = oracle.de_saxce_impulse(A, b, mu)
        assert_allclose(solve(Problem.from_delassus(A, b, friction=mu), "direct").impulse, expected, atol=1e-8)


@given(
    seed=st.integers(0, 2**32 - 1),
    contacts=st.integers(1, 12),
    dim=st.integers(2, 3),
    mu=st.sampled_from([0.0, 0.3, 0.7, 1.0]),
    rank=st.integers(3, 40),
)
@settings(deadline=None)
def test_auto_solves_random_contacts(seed: int, contacts: int, dim: int, mu: float, rank: int) -> None:
    """b = J v with A = J J^T: Coulomb's law has a solution (Acary, Cadoux 2011: Slater's condition at v = 0)."""
    A, b = oracle.random_delassus(np.random.default_rng(seed), dim * contacts, rank)
    problem = Problem.from_delassus(A, b, friction=np.full(contacts, mu), contact_dim=dim)
    solution = solve(problem)
    check(problem, solution, 1e-6)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("mass", [1e-3, 1.0, 1e6])
def test_block_on_an_incline(dim: int, mass: float) -> None:
    """Slides with g (sin - mu cos), or rests where mu >= tan."""
    for angle in (10.0, 30.0, 60.0):
        slope = np.radians(angle)
        velocity = G * STEP * np.array([-np.cos(slope), np.sin(slope), 0.0])[:dim]
        problem = Problem.from_rows(1.0 / mass, np.eye(dim), velocity, contacts=ContactRows(0.5, dim=dim))
        solution = solve(problem, "direct")
        assert solution.body_velocity is not None
        expected = G * STEP * max(np.sin(slope) - 0.5 * np.cos(slope), 0.0)
        assert_allclose(solution.body_velocity, [0.0, expected, 0.0][:dim], atol=1e-14)


@pytest.mark.nojit
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("angle", [10.0, 20.0])
def test_wedge_under_a_block(ratio: float, angle: float) -> None:
    """A wedge of 1 kg is pushed under a block of `ratio` kg that a wall keeps from moving aside.

    With the friction angle phi at ground, face and wall, it moves where the push exceeds
    W tan(alpha + 2 phi) + w tan(phi), with the weights W of the block and w of the wedge.
    """
    phi, alpha = np.arctan(0.3), np.radians(angle)
    normal, along = np.array([-np.sin(alpha), np.cos(alpha)]), np.array([np.cos(alpha), np.sin(alpha)])
    # coordinates: wedge x, y, block x, y; contacts ground-wedge, wedge-block, wall-block. The wedge moves to -x.
    jacobian = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
            [*-normal, *normal],
            [*-along, *along],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    inverse = np.array([1.0, 1.0, 1.0 / ratio, 1.0 / ratio])
    critical = G * ratio * np.tan(alpha + 2.0 * phi) + G * np.tan(phi)
    for factor in (0.5, 0.999, 1.001, 2.0):
        velocity = STEP * np.array([-factor * critical, -G, 0.0, -G])
        solution = solve(Problem.from_rows(inverse, jacobian, velocity, contacts=ContactRows(0.3, dim=2)), "direct")
        assert solution.converged, solution.reason
        assert solution.body_velocity is not None
        rise = wedge_rise(jacobian, inverse, velocity) if factor > 1.0 else 0.0
        assert solution.body_velocity[3] == pytest.approx(rise, rel=1e-5, abs=STEP * (1e-7 * G + 1e-13 * critical))


def wedge_rise(jacobian: Array, inverse: Array, velocity: Array) -> float:
    """Vertical velocity of the block where all three contacts are closed and slide, by the equations of that case."""
    signs = np.array([-1.0, 1.0, 1.0])  # of the sliding velocities at ground, face and wall
    directions = jacobian[::2] - 0.3 * signs[:, None] * jacobian[1::2]
    applied = inverse[:, None] * directions.T
    loads = np.linalg.solve(jacobian[::2] @ applied, -jacobian[::2] @ velocity)
    after = velocity + applied @ loads
    assert np.all(loads > 0.0)
    assert_array_equal(np.sign(jacobian[1::2] @ after), signs)
    return float(after[3])


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6, 1e9])
def test_spatial_tower_with_friction(ratio: float) -> None:
    problem, weight = spatial_tower(8, 0.5, ratio)
    solution = solve(problem)
    assert solution.converged
    load = solution.impulse.reshape(8, 4, 3)[:, :, 0].sum(axis=1)
    assert_allclose(load, weight, rtol=1e-5)


@pytest.mark.parametrize("mu", [0.2, 0.5])
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6, 1e9])
def test_pyramids_that_sweeps_cannot_solve(mu: float, ratio: float) -> None:
    problem = pyramid(6, mu, ratio)
    solution = solve(problem, tolerance=1e-10 if ratio < 1e9 else 1e-8)
    assert solution.converged, solution.reason
    assert breach(problem, solution.impulse) < 1e-8
    if ratio > 1.0:
        assert not solve(problem, "nncg", max_sweeps=2000).converged
    # the ground carries all weight unless boxes fly off: vertical momentum is conserved
    v = solution.body_velocity
    assert v is not None
    mass = np.ones(21)
    mass[-1] = ratio
    ground = solution.impulse[: 2 * 2 * 6 : 2].sum()
    assert ground == pytest.approx(mass @ (v[1::3] + G * STEP), rel=1e-6)


def test_same_input_same_bits() -> None:
    problem = pyramid(5, 0.3, 1e4)
    one, other = solve(problem), solve(problem)
    assert_array_equal(one.impulse, other.impulse)
    assert (one.method, one.sweeps, one.pivots) == (other.method, other.sweeps, other.pivots)


def test_max_sweeps_limits_the_systems() -> None:
    problem = pyramid(6, 0.2, 1e6)
    solution = solve(problem, "direct", max_sweeps=5)
    assert solution.pivots <= 5 + 2
    assert not solution.converged
    assert "max_sweeps = 5" in solution.reason
    assert solve(problem, "direct", max_sweeps=0).pivots == 0


def test_start_within_the_tolerance_costs_nothing() -> None:
    problem, weight = tower(5)
    assert solve(problem, "direct", start=weight).pivots == 0
    assert solve(problem, "auto", start=weight).sweeps == 0


@pytest.mark.parametrize("scale", [1e-150, 1e-30, 1e30, 1e150])
def test_extreme_units(scale: float) -> None:
    A, b = oracle.random_delassus(np.random.default_rng(11), 6)
    expected = solve(Problem.from_delassus(A, b, friction=0.5), "direct").impulse
    solution = solve(Problem.from_delassus(A * scale, b * scale, friction=0.5), "direct")
    assert solution.converged
    assert_allclose(solution.impulse, expected, atol=1e-9)


def test_large_sparse_problem() -> None:
    """8000 rows in a band: neither time nor memory grow with the square of their number in the factor."""
    count = 4000
    index = np.arange(count)
    jacobian = CsrMatrix.from_entries(
        np.concatenate([index, index[1:]]), np.concatenate([index, index[:-1]]),
        np.concatenate([np.ones(count), -np.ones(count - 1)]), (count, count),
    )  # fmt: skip
    problem = Problem.from_rows(1.0, jacobian, -1.0, lower=0)
    assert_allclose(solve(problem, "direct").impulse, np.arange(count, 0, -1), rtol=1e-6)


def test_convex_problems_plan_their_factor_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sliding along an axis makes zeros in the convex problems of 3D contacts, which later directions fill."""
    A = np.eye(6)
    A[2, 5] = A[5, 2] = 0.5  # between the second tangents
    A[1, 2] = A[2, 1] = 0.3  # turns the first contact's sliding direction away from its first tangent
    problem = Problem.from_delassus(A, [-1.0, -1.0, 0.0, -1.0, -1.0, 0.0], friction=[0.5, 0.5])
    rules = Rules(0, 1e-8, 10_000, problem._data_square, 1e5)
    impulses = [impulse for impulse, _ in convex_starts(problem, rules, np.zeros(6))]
    assert len(impulses) > 2
    monkeypatch.setattr(cones, "direct_solve", lambda problem, rules, impulse, _: direct_solve(problem, rules, impulse))
    for impulse, (expected, _) in zip(impulses, convex_starts(problem, rules, np.zeros(6)), strict=True):
        assert_array_equal(impulse, expected)
