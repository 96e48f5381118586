"""Random scenes in space; ``python -m benchmarks.stress --dim 3`` runs as many as are asked for."""

from __future__ import annotations

import pytest

from tests.stress.measure import problems, run_case
from tests.stress.spatial import CATEGORIES, random_spatial_case

CASES = 48
STEPS = 300


@pytest.mark.parametrize("seed", range(CASES))
def test_random_spatial_scenes(seed: int) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds."""
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


def test_a_case_is_a_function_of_its_seed() -> None:
    for seed in range(len(CATEGORIES)):
        one, other = (random_spatial_case(seed) for _ in range(2))
        assert one.scene.compile().digest == other.scene.compile().digest
        assert one.category == CATEGORIES[seed]
