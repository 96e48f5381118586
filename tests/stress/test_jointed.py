"""Random jointed scenes: chains, ragdolls, rings, ropes, springs, sliders, motors, gears, cars, contradictions.

benchmarks/stability.py runs as many as are asked for.
"""

from __future__ import annotations

import dataclasses

import pytest

from tests.stress.batches import batches
from tests.stress.jointed import random_jointed_case
from tests.stress.measure import problems, run_case

STEPS = 300


@batches(count=280, size=28, nightly_from=112)
def test_random_jointed_scenes(seeds: range) -> None:
    """No NaN, no exception, no energy explosion, bounded speeds."""
    broken = [problems(run_case(random_jointed_case(seed), STEPS)) for seed in seeds]
    assert not any(broken), "\n".join(filter(None, broken))


@pytest.mark.parametrize("seed", [10, 14, 16, 19, 29, 52, 58, 72, 103, 136])
def test_scenes_in_joint_coordinates(seed: int) -> None:
    """Joints that contradict each other, rings whose joints are there twice, chains that turn fast."""
    case = random_jointed_case(seed)
    case = dataclasses.replace(case, options=dataclasses.replace(case.options, articulated=True))
    broken = problems(run_case(case, STEPS))
    assert not broken, broken


@pytest.mark.parametrize("seed", [122, 154, 290, 381, 1192, 1793])
def test_rare_scenes(seed: int) -> None:
    """Of 5,000 seeds: loops that cannot close, a contact whose point joints hold, chains that whip or are taut."""
    broken = problems(run_case(random_jointed_case(seed), STEPS))
    assert not broken, broken
