"""Random jointed scenes: chains, ragdolls, rings, ropes, springs, sliders, motors, gears, cars, contradictions.

benchmarks/stability.py runs as many as are asked for.
"""

from __future__ import annotations

import pytest

from tests.stress.jointed import random_jointed_case
from tests.stress.measure import problems, run_case

CASES = 280
CASES_A_TEST = 28
STEPS = 300


@pytest.mark.parametrize("first", range(0, CASES, CASES_A_TEST))
def test_random_jointed_scenes(first: int) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds."""
    broken = [problems(run_case(random_jointed_case(seed), STEPS)) for seed in range(first, first + CASES_A_TEST)]
    assert not any(broken), "\n".join(filter(None, broken))
