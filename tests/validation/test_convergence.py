"""Observed orders of convergence in the timestep, against closed forms and Runge-Kutta: docs/convergence.md."""

from __future__ import annotations

import pytest

from benchmarks.convergence import CASES, Case, observed_order

RATES = (60, 120, 240, 480)


@pytest.mark.parametrize("case", [case for case in CASES if case.order is None], ids=lambda case: case.scene)
def test_exact(case: Case) -> None:
    assert max(case.measure(rate) for rate in RATES) < 1e-11


@pytest.mark.parametrize("case", [case for case in CASES if case.order is not None], ids=lambda case: case.scene)
def test_order(case: Case) -> None:
    errors = [case.measure(rate) for rate in RATES]
    order = observed_order(RATES, errors)
    assert order is not None
    assert case.order is not None
    assert order > case.order - 0.2
