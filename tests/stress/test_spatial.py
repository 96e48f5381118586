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


@pytest.mark.parametrize("seed", [80014040, 80020856, 80022200])
def test_what_starts_in_a_funnel_is_raised_by_no_more_than_its_depth(seed: int) -> None:
    """Bowls of four steep walls, and bodies that start up to 1 m under them, one of them behind the surface."""
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


def test_loads_at_rest_throw_nothing_up() -> None:
    """173 kg on 1 kg, with solves that end at the limit of sweeps."""
    broken = problems(run_case(random_spatial_case(80026115), STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [80023066, 80018782])
def test_tumbling_welds_and_falls_into_the_void(seed: int) -> None:
    """Two bodies on a spring that is as good as rigid; a body that is pushed off the ground and falls for 10 s."""
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [80061401, 80033961, 80041369])
def test_links_whose_masses_are_scaled_make_no_energy(seed: int) -> None:
    """Light links on taut joints that swing faster than the substeps follow."""
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [80056010, 80075898, 80043146])
def test_springs_in_long_steps_and_unfinished_solves_make_no_energy(seed: int) -> None:
    broken = problems(run_case(random_spatial_case(seed), STEPS))
    assert not broken, broken


def test_joints_that_contradict_each_other_store_no_impulses() -> None:
    """Two welds and a ball joint close a loop of three bodies with different spins."""
    broken = problems(run_case(random_spatial_case(80043289), STEPS))
    assert not broken, broken


def test_a_case_is_a_function_of_its_seed() -> None:
    for seed in range(len(CATEGORIES)):
        one, other = (random_spatial_case(seed) for _ in range(2))
        assert one.scene.compile().digest == other.scene.compile().digest
        assert one.category == CATEGORIES[seed]
