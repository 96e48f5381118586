"""Native vector environments equal gymnasium's own over single environments, bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode

from tests.envs.registered import MODES, TASK_IDS, assert_same_infos, make, make_sync, make_vector, random_actions

LIMIT = 25  # steps: several episodes in each run


def assert_same_step(result: tuple[Any, ...], expected: tuple[Any, ...]) -> None:
    for one, other in zip(result[:-1], expected[:-1], strict=True):
        if isinstance(other, dict):
            assert data_equivalence(one, other, exact=True)
            continue
        np.testing.assert_array_equal(one, other, strict=True)
    assert_same_infos(result[-1], expected[-1])


@pytest.mark.parametrize(("count", "threads"), [(1, 1), (3, 2), (7, 1), (7, 3)])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", TASK_IDS)
def test_equals_the_single_environments(env_id: str, mode: AutoresetMode, count: int, threads: int) -> None:
    vector = make_vector(env_id, count, autoreset_mode=mode, threads=threads, max_episode_steps=LIMIT)
    expected = make_sync(env_id, count, mode, max_episode_steps=LIMIT)
    assert_same_step(vector.reset(seed=40), expected.reset(seed=40))
    ended = np.zeros(count, int)
    for actions in random_actions(env_id, count, 70, count):
        result = vector.step(actions)
        assert_same_step(result, expected.step(actions))
        done = result[2] | result[3]
        ended += done
        if mode == AutoresetMode.DISABLED and done.any():
            begun = vector.reset(options={"reset_mask": done})
            assert_same_step(begun, expected.reset(options={"reset_mask": done.copy()}))
    assert (ended >= 2).all()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", TASK_IDS)
def test_equals_them_after_partial_resets(env_id: str, mode: AutoresetMode) -> None:
    """Of running and of ended worlds, seeded and not; gymnasium defines masks for DISABLED alone."""
    count = 5
    vector = make_vector(env_id, count, autoreset_mode=mode, threads=2)
    singles = [make(env_id) for _ in range(count)]
    observations, _ = vector.reset(seed=7)
    expected = np.array([env.reset(seed=7 + i)[0] for i, env in enumerate(singles)])
    np.testing.assert_array_equal(observations, expected)
    rng = np.random.default_rng(3)
    age = np.zeros(count, int)  # steps at the end of the round: 12 are too few to end an episode
    for k in range(12):
        mask = rng.random(count) < 0.5
        mask[k % count] = True
        mask |= age == 12
        age = np.where(mask, 4, age + 4)
        choices: list[list[int | None] | None] = [None, [None] * count, [100 * k + i for i in range(count)]]
        seeds = choices[k % 3]
        options = {"reset_mask": mask}
        kept = mask.copy()
        observations, infos = vector.reset(seed=seeds, options=options)
        assert options.keys() == {"reset_mask"}
        np.testing.assert_array_equal(mask, kept)
        for i in np.flatnonzero(mask):
            expected[i] = singles[i].reset(seed=None if seeds is None else seeds[i])[0]
        np.testing.assert_array_equal(observations, expected)
        np.testing.assert_array_equal(infos[next(key for key in infos if key.startswith("_reward_"))], mask)
        for actions in random_actions(env_id, k, 4, count):
            observations, rewards, terminated, _, _ = vector.step(actions)
            results = [env.step(action) for env, action in zip(singles, actions, strict=True)]
            assert not terminated.any()
            expected = np.array([result[0] for result in results])
            np.testing.assert_array_equal(observations, expected)
            np.testing.assert_array_equal(rewards, [result[1] for result in results])


@pytest.mark.parametrize("observation", ["pixels", "state+pixels"])
@pytest.mark.parametrize("env_id", TASK_IDS)
def test_equals_them_with_all_the_trimmings(env_id: str, observation: str) -> None:
    """Randomised physics, diagnostics, pixels, the split for tests, the lowest fidelity."""
    arguments: dict[str, Any] = {
        "randomize": {"friction": (0.4, 0.9)},
        "diagnostics": True,
        "observation": observation,
        "split": "test",
        "fidelity": "fast",
        "max_episode_steps": 6,
    }
    mode = AutoresetMode.SAME_STEP
    vector = make_vector(env_id, 3, autoreset_mode=mode, threads=2, **arguments)
    expected = make_sync(env_id, 3, mode, **arguments)
    assert_same_step(vector.reset(seed=1), expected.reset(seed=1))
    for actions in random_actions(env_id, 9, 14, 3):
        assert_same_step(vector.step(actions), expected.step(actions))


@pytest.mark.parametrize("env_id", TASK_IDS)
def test_a_batch_of_300_worlds_equals_some_of_its_singles(env_id: str) -> None:
    vector = make_vector(env_id, 300, threads=2)
    start, _ = vector.reset(seed=1000)
    actions = random_actions(env_id, 5, 12, 300)
    history = [vector.step(a)[0] for a in actions]
    for i in (0, 149, 150, 299):
        env = make(env_id)
        np.testing.assert_array_equal(env.reset(seed=1000 + i)[0], start[i])
        for action, observations in zip(actions[:, i], history, strict=True):
            observation, _, terminated, _, _ = env.step(action)
            np.testing.assert_array_equal(observation, observations[i])
            if terminated:
                break


@pytest.mark.parametrize("env_id", TASK_IDS)
def test_seeds_are_spent_one_for_each_world(env_id: str) -> None:
    vector = make_vector(env_id, 3)
    first, _ = vector.reset(seed=[5, 5, 6])
    np.testing.assert_array_equal(first[0], first[1])
    assert (first[0] != first[2]).any()
    assert vector.np_random_seed == (5, 5, 6)
    again, _ = vector.reset()
    assert (again != first).any(axis=1).all()
    for bad in ([1, 2], [1, 2, 3, 4]):
        with pytest.raises(ValueError, match="seeds"):
            vector.reset(seed=bad)
