"""The splits "train" and "test": the same rules, other episodes."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils import seeding

from gsenv.envs.core.splits import MOST_SEED, SPLITS, TEST_KEY, make_generator
from tests.envs.registered import IDS, make, make_vector

each_id = pytest.mark.parametrize("env_id", IDS)


def state(generator: np.random.Generator) -> Any:
    return generator.bit_generator.state


def test_train_is_the_generator_of_gymnasium() -> None:
    for seed in (0, 1, 2**31, MOST_SEED):
        assert state(make_generator(seed, "train")[0]) == state(seeding.np_random(seed)[0])


def test_test_is_what_its_docstring_says() -> None:
    expected = np.random.Generator(np.random.PCG64(np.random.SeedSequence(5, spawn_key=(TEST_KEY,))))
    generator, seed = make_generator(5, "test")
    assert seed == 5
    assert state(generator) == state(expected)


def test_no_stream_is_in_both_splits() -> None:
    seeds = [*range(20_000), *(2**k for k in range(15, 128)), *(2**k - 1 for k in range(15, 129))]
    streams = {split: {str(state(make_generator(seed, split)[0])) for seed in seeds} for split in SPLITS}
    assert len(streams["train"]) == len(streams["test"]) == len(set(seeds))
    assert not streams["train"] & streams["test"]


def test_the_one_way_to_ask_for_the_stream_of_a_test_in_training_is_refused() -> None:
    """A seed of five words, the last of which is the key, would give the stream of the split "test"."""
    twin = 5 + (TEST_KEY << 128)
    assert state(seeding.np_random(twin)[0]) == state(make_generator(5, "test")[0])
    for split in SPLITS:
        with pytest.raises(ValueError, match=r"below 2\*\*128"):
            make_generator(twin, split)
    env = make(IDS[0])
    with pytest.raises(ValueError, match=r"below 2\*\*128"):
        env.reset(seed=twin)


@each_id
def test_equal_seeds_begin_other_episodes_in_the_other_split(env_id: str) -> None:
    starts = {split: make_vector(env_id, 50, split=split).reset(seed=0)[0] for split in SPLITS}
    for row in starts["test"]:
        assert (starts["train"] != row).any(axis=1).all()
    again = make_vector(env_id, 50, split="test").reset(seed=0)[0]
    np.testing.assert_array_equal(again, starts["test"])
    assert make(env_id).unwrapped.split == "train"  # type: ignore[attr-defined]
    np.testing.assert_array_equal(make_vector(env_id, 50).reset(seed=0)[0], starts["train"])


@each_id
def test_single_and_vector_environments_agree_in_it(env_id: str) -> None:
    vector = make_vector(env_id, 3, split="test")
    starts = [vector.reset(seed=9)[0], vector.reset()[0]]
    for w in range(3):
        env = make(env_id, split="test")
        np.testing.assert_array_equal(env.reset(seed=9 + w)[0], starts[0][w])
        np.testing.assert_array_equal(env.reset(seed=np.int64(9 + w))[0], starts[0][w])  # type: ignore[arg-type]
        np.testing.assert_array_equal(env.reset()[0], starts[1][w])
    assert vector.get_attr("split") == ("test",) * 3
    assert gymnasium.make_vec(env_id, 2, split="test").unwrapped.split == "test"  # type: ignore[attr-defined]


@pytest.mark.parametrize("way", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_stay_in_the_split(way: Any) -> None:
    env = make(IDS[0], split="test")
    env.reset(seed=1)
    other = way(env)
    np.testing.assert_array_equal(env.reset()[0], other.reset()[0])
    np.testing.assert_array_equal(env.reset(seed=2)[0], other.reset(seed=2)[0])


def test_unseeded_resets_of_a_test_are_of_the_split(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seeding, "np_random", lambda seed=None: (np.random.default_rng(3), 3))
    expected = np.random.Generator(np.random.PCG64(np.random.SeedSequence(3, spawn_key=(TEST_KEY,))))
    env: Any = make(IDS[0], split="test").unwrapped
    assert state(env.np_random) == state(expected)
    vector = make_vector(IDS[0], 2, split="test")
    assert state(vector.np_random[1])["state"] == state(expected)["state"]


def test_parallel_environments_have_it_too() -> None:
    pytest.importorskip("pettingzoo")
    from gsenv.envs import tower_v0
    from gsenv.envs.tower.env import TowerVectorEnv

    train, test = (tower_v0.parallel_env(split=split).reset(seed=0)[0]["gripper_0"] for split in SPLITS)
    assert (train != test).sum() > 5
    np.testing.assert_array_equal(TowerVectorEnv(1, split="test").reset(seed=0)[0][0, 0], test)


@pytest.mark.parametrize("bad", ["validation", None, 1, ["test"]])
def test_other_splits_are_refused(bad: Any) -> None:
    with pytest.raises(ValueError, match="split must be one of"):
        make(IDS[0], split=bad)
    with pytest.raises(ValueError, match="split must be one of"):
        make_vector(IDS[0], 2, split=bad)
    with pytest.raises(AttributeError):
        make_vector(IDS[0], 2).set_attr("split", "test")
