"""Bad input is named in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver.problem.csr import CsrMatrix
from gsenv.solver.problem.problem import ContactRows, Problem, solve

J = [[1.0, 0.0], [-1.0, 1.0]]
A = [[1.0, -1.0], [-1.0, 2.0]]
NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"jacobian": [1.0, 2.0]}, r"jacobian has shape \(2,\)"),
        ({"jacobian": [[1.0, NAN]]}, r"jacobian\[0, 1\] is nan"),
        ({"jacobian": [[1.0], [1.0, 2.0]]}, r"jacobian must be an array of real numbers"),
        ({"jacobian": [[1.0, 1.0j]]}, r"jacobian must be an array of real numbers"),
        ({"velocity": [1.0]}, r"velocity has shape \(1,\), expected a scalar or \(2,\)"),
        ({"velocity": [1.0, INF]}, r"velocity\[1\] is inf"),
        ({"velocity": "fast"}, r"velocity must be an array"),
        ({"inverse_mass": [1.0, -1.0]}, r"inverse_mass\[1\] is -1"),
        ({"inverse_mass": [1.0, NAN]}, r"inverse_mass\[1\] is nan"),
        ({"inverse_mass": -1.0}, r"inverse_mass\[0\] is -1"),
        ({"inverse_mass": [1.0, 1.0, 1.0]}, r"inverse_mass has shape \(3,\)"),
        ({"inverse_mass": np.eye(3)}, r"inverse_mass has shape \(3, 3\), expected \(2, 2\)"),
        ({"inverse_mass": [[1.0, 2.0], [0.0, 1.0]]}, r"inverse_mass\[0, 1\] differs from"),
        ({"inverse_mass": [[1.0, 0.0], [0.0, -1.0]]}, r"inverse_mass\[1, 1\] is -1"),
        ({"inverse_mass": [[1.0, 3.0], [3.0, 1.0]]}, r"inverse_mass gives row 1 a negative"),
        ({"bias": [1.0, 2.0, 3.0]}, r"bias has shape \(3,\)"),
        ({"bias": NAN}, r"bias is nan"),
        ({"softness": [0.0, -0.5]}, r"softness\[1\] is -0.5"),
        ({"lower": [0.0, 3.0], "upper": [1.0, 2.0]}, r"lower\[1\] is 3, above upper\[1\]"),
        ({"lower": [NAN, 0.0]}, r"lower\[0\] is nan, expected a number"),
        ({"lower": INF}, r"lower\[0\] is inf"),
        ({"upper": [0.0, -INF]}, r"upper\[1\] is -inf"),
        ({"contacts": ContactRows([0.5], dim=4)}, r"contacts.dim is 4, expected 1, 2 or 3"),
        ({"contacts": ContactRows([-0.5], dim=2)}, r"contacts.friction\[0\] is -0.5"),
        ({"contacts": ContactRows([NAN], dim=2)}, r"contacts.friction\[0\] is nan"),
        ({"contacts": ContactRows(0.5, dim=3)}, r"contacts.dim 3 does not divide 2 rows"),
        ({"contacts": ContactRows([0.5, 0.5], dim=2)}, r"contacts.rows\[1\] is 2, its 2 rows"),
        ({"contacts": ContactRows(0.5, [0, 1], 2)}, r"contacts.rows\[1\] is 1, its 2 rows"),
        ({"contacts": ContactRows(0.5, [0, 0], 1)}, r"contacts.rows\[1\] is 0, inside the contact"),
        ({"contacts": ContactRows(0.5, [0.5], 1)}, r"contacts.rows must hold whole numbers"),
        ({"contacts": ContactRows(0.5, 0, 1)}, r"contacts.rows has shape \(\)"),
        (
            {"contacts": ContactRows([0.5], dim=2), "lower": [0.0, -1.0]},
            r"lower\[1\] is -1 on a contact row",
        ),
        (
            {"contacts": ContactRows([0.5], dim=2), "upper": [5.0, INF]},
            r"upper\[0\] is 5 on a contact row",
        ),
    ],
)
def test_from_rows(change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"inverse_mass": 1.0, "jacobian": J, "velocity": [0.0, 0.0]}
    with pytest.raises(ValueError, match=message) as caught:
        Problem.from_rows(**(arguments | change))
    text = str(caught.value)
    assert "\n" not in text
    assert text.endswith(".")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"A": [[1.0, 0.0], [0.0, -1.0]]}, r"A\[1, 1\] is -1"),
        ({"A": [[1.0, 0.0]]}, r"A has shape \(1, 2\), expected a square matrix"),
        ({"A": [[1.0, INF], [INF, 1.0]]}, r"A\[0, 1\] is inf"),
        ({"A": 3.0}, r"A has shape \(\)"),
        ({"b": [0.0, NAN]}, r"b\[1\] is nan"),
        ({"b": [0.0]}, r"b has shape \(1,\)"),
        ({"softness": -1.0}, r"softness\[0\] is -1"),
        ({"lower": 1.0, "upper": 0.0}, r"lower\[0\] is 1, above upper\[0\]"),
        ({"friction": -0.1, "contact_dim": 2}, r"friction\[0\] is -0.1"),
        ({"friction": [0.5], "contact_dim": 0}, r"contact_dim is 0"),
        ({"friction": [0.5]}, r"contact_rows\[0\] is 0, its 3 rows don't fit into 2 rows"),
        ({"friction": [0.5, 0.5], "contact_dim": 2, "contact_rows": [0]}, r"friction has shape"),
        ({"friction": 0.5, "contact_dim": 1, "contact_rows": [-1]}, r"contact_rows\[0\] is -1"),
    ],
)
def test_from_delassus(change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"A": A, "b": [0.0, 0.0]}
    with pytest.raises(ValueError, match=message):
        Problem.from_delassus(**(arguments | change))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"method": "newton"}, r"Unknown method 'newton', expected one of auto, pgs, nncg, apgd, direct, lemke\."),
        ({"tolerance": -1.0}, r"tolerance is -1"),
        ({"tolerance": NAN}, r"tolerance is nan"),
        ({"max_sweeps": -1}, r"max_sweeps is -1"),
        ({"max_sweeps": 2.5}, r"max_sweeps is 2.5"),
        ({"max_sweeps": INF}, r"max_sweeps is inf"),
        ({"start": [0.0, NAN]}, r"start\[1\] is nan"),
        ({"start": [0.0]}, r"start has shape \(1,\)"),
    ],
)
def test_solve(change: dict[str, Any], message: str) -> None:
    problem = Problem.from_delassus(A, [-10.0, 0.0], lower=0)
    with pytest.raises(ValueError, match=message):
        solve(problem, **change)


def test_solve_takes_a_problem() -> None:
    with pytest.raises(TypeError, match=r"solve takes a Problem, not int: Problem\.from_rows makes one"):
        solve(3)  # type: ignore[arg-type]


@pytest.mark.parametrize("method", ["pgs", "nncg", "apgd"])
def test_sweeps_need_symmetry(method: str) -> None:
    problem = Problem.from_delassus([[1.0, 0.5], [0.0, 1.0]], [-1.0, -1.0], lower=0)
    with pytest.raises(ValueError, match=f"A is not symmetric and method '{method}' needs symmetry"):
        solve(problem, method)


def test_lemke_refuses_circular_cones() -> None:
    problem = Problem.from_delassus(np.eye(5), -np.ones(5), friction=[0.5, 0.5], contact_dim=[2, 3])
    with pytest.raises(ValueError, match=r"Contact 1 has two tangents under a circular cone"):
        solve(problem, "lemke")


@pytest.mark.parametrize(("method", "rows"), [("direct", 8001), ("lemke", 2001)])
def test_too_many_rows_for_a_method(method: str, rows: int) -> None:
    problem = Problem.from_rows(np.ones(rows), CsrMatrix.from_diagonal(np.ones(rows)), -1.0, lower=0)
    with pytest.raises(ValueError, match=rf"has {rows} \w+ for .*expected at most {rows - 1}"):
        solve(problem, method)


def test_residual_checks_its_impulse() -> None:
    problem = Problem.from_delassus(A, [-10.0, 0.0], lower=0)
    with pytest.raises(ValueError, match=r"impulse has shape \(3,\)"):
        problem.residual([1.0, 2.0, 3.0])
