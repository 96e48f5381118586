"""Pairs against a brute-force oracle in numpy, in 2D and 3D."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver.core import broadphase
from gsenv.solver.core.broadphase import broadphase_dtype, broadphase_scratch, encode_exclusion, find_pairs
from gsenv.solver.records.model import Array, shape_model_dtype
from gsenv.solver.records.scratch_dtypes import PAIR_DTYPE, shape_geometry_dtype


def scene(count: int, dim: int, seed: int = 0, spread: float = 1.0) -> tuple[Array, Array]:
    """Boxes of mixed sizes: asleep, awake, static, switched off, some on the same body."""
    rng = np.random.default_rng(seed)
    geometry = np.zeros(count, shape_geometry_dtype(dim))
    center = rng.uniform(0, spread * count ** (1 / dim), (count, dim))
    half = rng.uniform(0.2, 0.8, (count, dim)) * np.where(rng.random(count) < 0.02, 20.0, 1.0)[:, None]
    geometry["lower"], geometry["upper"] = center - half, center + half
    geometry["active"] = rng.random(count) < 0.95
    geometry["dynamic"] = (rng.random(count) < 0.8) & (geometry["active"] == 1)
    geometry["awake"] = (rng.random(count) < 0.6) & (geometry["dynamic"] == 1)
    geometry["awake"] |= (rng.random(count) < 0.05) & (geometry["active"] == 1)  # moving kinematic
    loose = rng.random(count) < 0.01
    geometry["lower"][loose], geometry["upper"][loose] = -np.inf, np.inf
    models = np.zeros(count, shape_model_dtype())
    models["body"] = np.sort(rng.integers(0, max(count // 2, 1), count))
    models["category"] = 1 << rng.integers(0, 3, count)
    models["mask"] = rng.integers(1, 8, count)
    return geometry, models


def oracle(geometry: Array, models: Array, excluded: set[tuple[int, int]] | None = None) -> list[tuple[int, int]]:
    wanted = []
    for a in range(len(geometry)):
        g, h = geometry[a], geometry[a + 1 :]
        meet = ((g["lower"] <= h["upper"]) & (h["lower"] <= g["upper"])).all(axis=1)
        meet &= (g["active"] & h["active"] & (g["awake"] | h["awake"]) & (g["dynamic"] | h["dynamic"])) != 0
        m, n = models[a], models[a + 1 :]
        meet &= (m["body"] != n["body"]) & (m["category"] & n["mask"] != 0) & (n["category"] & m["mask"] != 0)
        for b in np.flatnonzero(meet) + a + 1:
            bodies = tuple(sorted((int(m["body"]), int(models[b]["body"]))))
            if not excluded or bodies not in excluded:
                wanted.append((a, int(b)))
    return wanted


def found(geometry: Array, models: Array, exclusions: Array, room: int = 100000) -> list[tuple[int, int]]:
    pairs = np.zeros(room, PAIR_DTYPE)
    scratch = broadphase_scratch(len(geometry), geometry["lower"].shape[1])
    count = find_pairs(geometry, models, exclusions, scratch, pairs)
    return listed(pairs[:count])


def listed(pairs: Array) -> list[tuple[int, int]]:
    return list(zip(pairs["shape_a"].tolist(), pairs["shape_b"].tolist(), strict=True))


NOTHING = np.zeros(0, np.int64)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("count", [0, 1, 2, 50, 161, 700])
def test_against_brute_force(count: int, dim: int) -> None:
    for seed in range(3):
        geometry, models = scene(count, dim, seed)
        wanted = oracle(geometry, models)
        assert found(geometry, models, NOTHING) == wanted
        assert count < 50 or len(wanted) > 5


def test_without_exclusions() -> None:
    geometry, models = scene(80, 2)
    pairs = np.zeros(1000, PAIR_DTYPE)
    count = find_pairs(geometry, models, None, None, pairs)
    assert listed(pairs[:count]) == oracle(geometry, models)


@pytest.mark.parametrize("count", [100, 400])
def test_exclusions(count: int) -> None:
    geometry, models = scene(count, 2)
    everything = oracle(geometry, models)
    bodies = [(int(models["body"][a]), int(models["body"][b])) for a, b in everything]  # ascending, as made
    excluded = set(bodies[::3])
    codes = np.array(sorted(encode_exclusion(b, a) for a, b in excluded))
    assert found(geometry, models, codes) == oracle(geometry, models, excluded)
    assert len(oracle(geometry, models, excluded)) < len(everything)


@pytest.mark.parametrize("count", [100, 400])
def test_counts_on_when_pairs_are_full(count: int) -> None:
    geometry, models = scene(count, 2)
    wanted = oracle(geometry, models)
    pairs = np.zeros(7, PAIR_DTYPE)
    scratch = broadphase_scratch(count, 2)
    assert find_pairs(geometry, models, NOTHING, scratch, pairs) == len(wanted)


def test_scratch_holds_no_history() -> None:
    """Whatever an earlier scene has left in it, and whatever its length."""
    geometry, models = scene(400, 2, seed=1)
    other, other_models = scene(400, 2, seed=2)
    scratch = broadphase_scratch(400, 2)
    pairs, again = np.zeros(5000, PAIR_DTYPE), np.zeros(9000, PAIR_DTYPE)
    count = find_pairs(geometry, models, NOTHING, scratch, pairs)
    find_pairs(other, other_models, NOTHING, scratch, again)
    rubbish = np.zeros(4000, broadphase_dtype(2))
    rubbish["key"], rubbish["order"], rubbish["lower"] = 12345, 7, np.nan
    assert find_pairs(geometry, models, NOTHING, rubbish, again) == count
    assert listed(again[:count]) == listed(pairs[:count])
    assert find_pairs(geometry, models, NOTHING, scratch, again) == count
    assert listed(again[:count]) == listed(pairs[:count])


def test_one_shape_far_away_and_broken_numbers() -> None:
    geometry, models = scene(500, 2, seed=3)
    geometry["lower"][5] += 1e9
    geometry["upper"][5] += 1e9
    assert found(geometry, models, NOTHING) == oracle(geometry, models)
    geometry["lower"][9], geometry["upper"][9] = np.nan, np.nan
    assert found(geometry, models, NOTHING) == oracle(geometry, models)


def test_all_at_one_place() -> None:
    geometry, models = scene(300, 2)
    geometry["lower"], geometry["upper"] = -1.0, 1.0
    assert found(geometry, models, NOTHING) == oracle(geometry, models)


def test_all_asleep_costs_no_pairs() -> None:
    geometry, models = scene(300, 2)
    geometry["awake"] = 0
    assert found(geometry, models, NOTHING) == []


def test_few_shapes_need_no_tree() -> None:
    assert broadphase_scratch(broadphase.BRUTE_FORCE_COUNT, 2) is None
    assert broadphase_scratch(broadphase.BRUTE_FORCE_COUNT + 1, 2) is not None


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("count", [100, 400])
def test_few_awake_among_many_asleep(count: int, dim: int) -> None:
    total = 0
    for seed in range(5):
        geometry, models = scene(count, dim, seed)
        x = geometry["lower"][:, 0]
        geometry["awake"][x < np.quantile(x, 0.8)] = 0
        wanted = oracle(geometry, models)
        assert found(geometry, models, NOTHING) == wanted
        total += len(wanted)
        broken = np.flatnonzero(geometry["awake"])[::2]  # NaN in the box around all that is awake
        geometry["lower"][broken] = np.nan
        assert found(geometry, models, NOTHING) == oracle(geometry, models)
    assert total > 20


@pytest.mark.parametrize("dim", [2, 3])
def test_one_shape_under_all_others(dim: int) -> None:
    geometry, models = scene(600, dim)
    for k in (0, 300, 599):
        geometry["lower"][k], geometry["upper"][k] = -1e3, 1e3
        geometry["active"][k] = 1
        models["category"][k], models["mask"][k] = 7, 7
    assert found(geometry, models, NOTHING) == oracle(geometry, models)
