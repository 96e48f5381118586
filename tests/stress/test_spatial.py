"""Random scenes in 3D; ``python -m benchmarks stress --dim 3`` runs as many as are asked for."""

from __future__ import annotations

import pytest

from tests.stress.batches import batches
from tests.stress.measure import problems, run_case
from tests.stress.spatial import CATEGORIES, random_spatial_case

STEPS = 300


@batches(count=48, size=4, nightly_from=32)
def test_random_spatial_scenes(seeds: range) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds."""
    broken = [problems(run_case(random_spatial_case(seed), STEPS)) for seed in seeds]
    assert not any(broken), "\n".join(filter(None, broken))


@pytest.mark.parametrize("seed", [1717, 983, 79])
def test_turns_that_are_no_motion_make_no_energy(seed: int) -> None:
    """A spinning capsule in the position pass, a slender one that the sweep puts back, one that bounces."""
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [42, 3898, 4362, 4426])
def test_springs_stiffer_than_the_sweeps_can_solve_make_no_energy(seed: int) -> None:
    """Bodies of grams on springs with arms a hundred times their own size, and few sweeps."""
    broken = problems(run_case(random_spatial_case(seed, "springs"), STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [3973, 4342])
def test_numbers_too_small_to_square_stay_numbers(seed: int) -> None:
    """Spins that friction has slowed down to 1e-157 rad/s."""
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


def test_a_case_is_a_function_of_its_seed() -> None:
    for seed in range(len(CATEGORIES)):
        one, other = (random_spatial_case(seed) for _ in range(2))
        assert one.scene.compile().digest == other.scene.compile().digest
        assert one.category == CATEGORIES[seed]
