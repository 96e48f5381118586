"""`method="auto"`, and what happens to asymmetric matrices."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from gsenv.solver.problem.problem import Problem, solve
from tests.solver.problem import oracle
from tests.solver.problem.problems import p_problem, pyramid, tower

PAGE = Path(__file__).parents[3] / "docs" / "problems.md"


def test_easy_rows_are_swept() -> None:
    solution = solve(tower(5)[0])
    assert solution.method == "nncg"
    assert solution.pivots == 0
    assert 0 < solution.sweeps <= 60


def test_hard_rows_are_solved_directly() -> None:
    for problem in (tower(200)[0], tower(2, 1e6)[0], pyramid(8, 0.3, 1e4)):
        solution = solve(problem)
        assert solution.converged
        assert solution.method == "direct"
        assert solution.sweeps <= 300


def test_rows_without_symmetry() -> None:
    solution = solve(p_problem(np.random.default_rng(0), 20))
    assert solution.converged
    assert solution.method == "direct"
    assert solution.sweeps == 0


def test_ill_conditioned_rows_are_not_left_to_sweeps() -> None:
    """At this residual sweeps stop with impulses that are wrong by 1e-3."""
    problem, weight = tower(2, 1e9)
    assert_allclose(solve(problem, tolerance=1e-2).impulse, weight, rtol=1e-6)


def test_no_sweeps_no_change() -> None:
    problem, weight = tower(4)
    solution = solve(problem, max_sweeps=0, start=0.5 * weight)
    assert_array_equal(solution.impulse, 0.5 * weight)
    assert not solution.converged


@given(
    seed=st.integers(0, 2**32 - 1),
    contacts=st.integers(0, 3),
    dim=st.integers(1, 3),
    friction=st.sampled_from([0.0, 0.5, 1e6]),
    rank=st.integers(1, 9),
    spread=st.integers(0, 8),
    zero_share=st.sampled_from([0.0, 0.3, 0.8]),
    consistent=st.booleans(),
    symmetric=st.booleans(),
    method=st.sampled_from(["auto", "direct", "lemke"]),
)
@settings(deadline=None)
def test_any_input_gives_finite_impulses_in_bounds(
    seed: int, contacts: int, dim: int, friction: float, rank: int, spread: int, zero_share: float, consistent: bool,
    symmetric: bool, method: str,
) -> None:  # fmt: skip
    rng = np.random.default_rng(seed)
    rows = contacts * dim + int(rng.integers(0, 4))
    factor = rng.normal(size=(rows, rank)) * 10.0 ** rng.uniform(-spread, spread, (rows, 1))
    factor[rng.random((rows, rank)) < zero_share] = 0.0
    A = factor @ factor.T
    if not symmetric:
        A = A + np.triu(rng.normal(size=(rows, rows)), 1)
    b = factor @ rng.normal(size=rank) if consistent else rng.normal(size=rows)
    lower, upper = np.full(rows, -np.inf), np.full(rows, np.inf)
    for r in range(contacts * dim, rows):
        lower[r] = rng.choice([-np.inf, 0.0, -1.0])
        upper[r] = rng.choice([np.inf, 0.0, 2.0])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "A.* differs from", UserWarning)
        problem = Problem.from_delassus(A, b, 0, lower, upper, np.full(contacts, friction), dim)
    if method == "lemke" and contacts and dim == 3:
        return
    solution = solve(problem, method, max_sweeps=200)
    impulse = solution.impulse
    assert np.all(np.isfinite(impulse))
    assert not np.isnan(solution.residual)
    assert np.all(impulse >= problem.lower)
    assert np.all(impulse <= problem.upper)
    for c in range(contacts):
        normal, *tangent = impulse[c * dim : (c + 1) * dim]
        assert normal >= 0.0
        assert np.linalg.norm(tangent) <= friction * normal * (1 + 1e-12) + 1e-300
    if solution.converged:
        assert solution.residual <= 1e-8
        assert solution.reason == ""
    else:
        assert solution.reason.endswith(".")


# ---------------------------------------------------------------- asymmetry


def test_slight_asymmetry_is_removed_with_one_warning() -> None:
    A, b = oracle.random_delassus(np.random.default_rng(1), 5)
    skew = np.zeros((5, 5))
    skew[1, 3], skew[3, 1] = 2e-4, -2e-4
    with pytest.warns(
        UserWarning, match=r"^A\[1, 3\] differs from A\[3, 1\] by .*; \(A \+ A\^T\) / 2 is used\.$"
    ) as caught:
        problem = Problem.from_delassus(A + skew * np.sqrt(A[1, 1] * A[3, 3]), b, lower=0)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert problem.symmetric
    assert_allclose(problem.delassus.toarray(), A, atol=1e-13)
    for method in ("pgs", "auto"):
        assert_allclose(solve(problem, method).impulse, solve(Problem.from_delassus(A, b, lower=0)).impulse, atol=1e-6)


def test_slightly_asymmetric_mass() -> None:
    with pytest.warns(UserWarning, match=r"^inverse_mass\[0, 1\] differs from inverse_mass\[1, 0\]") as caught:
        Problem.from_rows([[1.0, 1e-4], [0.0, 1.0]], np.eye(2), 0.0)
    assert caught[0].filename == __file__


def test_rounding_is_removed_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        problem = Problem.from_delassus([[1.0, 0.5 + 1e-8], [0.5, 1.0]], [-1.0, -1.0])
    assert problem.symmetric
    assert_allclose(problem.delassus.toarray(), [[1.0, 0.5 + 5e-9], [0.5 + 5e-9, 1.0]], rtol=1e-15)


def test_larger_asymmetry_is_kept() -> None:
    A = np.array([[1.0, 0.5], [0.0, 1.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        problem = Problem.from_delassus(A, [-1.0, -1.0], lower=0)
    assert not problem.symmetric
    assert_array_equal(problem.delassus.toarray(), A)
    for method in ("auto", "direct", "lemke"):
        solution = solve(problem, method)
        assert solution.converged
        assert_allclose(solution.impulse, [0.5, 1.0], atol=1e-12)


# ---------------------------------------------------------------- documentation


def test_code_of_the_page_runs() -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) > 2
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)


def test_page_and_docstring_name_every_method() -> None:
    from gsenv.solver.problem.choose import METHODS

    for text in (PAGE.read_text(), solve.__doc__ or ""):
        table = [line for line in text.splitlines() if line.lstrip().startswith("|")]
        for method in METHODS:
            assert any(f'"{method}"' in line for line in table), method
