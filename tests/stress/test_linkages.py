"""Random linkages in 3D, in joint coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gsenv.solver import World
from tests.stress.batches import batches
from tests.stress.measure import problems, run_case
from tests.stress.spatial_linkages import CATEGORIES, STEPS, random_linkage_case

OPEN_CASES = [(81, "soft limits")]


@batches(count=300, size=15, nightly_from=30)
def test_random_linkages(seeds: range) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds."""
    broken = [problems(run_case(random_linkage_case(seed), STEPS)) for seed in seeds]
    assert not any(broken), "\n".join(filter(None, broken))


@pytest.mark.parametrize("category", ["soft limits", "contradictory"])
@batches(count=60, size=15, nightly_from=15)
def test_random_linkages_of_further_categories(seeds: range, category: str) -> None:
    broken = [problems(run_case(random_linkage_case(seed, category), STEPS)) for seed in seeds]
    assert not any(broken), "\n".join(filter(None, broken))


@pytest.mark.parametrize("articulated", [True, False])
def test_a_free_linkage_on_stiff_springs_falls_with_gravity(articulated: bool) -> None:
    """By rows, mass scaling of links that are too light for their springs slowed the fall to a fifth."""
    case = random_linkage_case(7, "springs")
    world = World(case.scene, options=replace(case.options, articulated=articulated))
    free = list(range(5))  # no joint holds the first linkage
    mass = world.parameters.bodies["mass"][0, free]
    world.step(120)
    speed = float(mass @ world.linear_velocity[0, free, 2]) / float(mass.sum())
    assert speed == pytest.approx(float(world.parameters.worlds["gravity"][0, 2]) * float(world.time[0]), rel=0.01)
    assert np.isfinite(world.position).all()


@pytest.mark.xfail(reason="soft limits at the gimbal lock of a fast universal joint")
@pytest.mark.parametrize(("seed", "category"), OPEN_CASES)
def test_open_cases(seed: int, category: str) -> None:
    broken = problems(run_case(random_linkage_case(seed, category), STEPS))
    assert not broken, broken


def test_a_case_is_a_function_of_its_seed() -> None:
    for seed in range(len(CATEGORIES)):
        one, other = (random_linkage_case(seed) for _ in range(2))
        assert one.scene.compile().digest == other.scene.compile().digest
        assert one.category == CATEGORIES[seed]
