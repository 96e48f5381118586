"""CarVectorEnv: bit-equal to single environments, in all modes."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gsenv.envs import time_limit
from gsenv.envs.car.env import CarEnv, CarVectorEnv
from gsenv.envs.car.policy import drive
from tests.envs.single_worlds import SingleWorlds, assert_info
from tests.envs.stack.worlds import assert_equal

LIMIT = 45  # steps, so that episodes end in both ways
HARD: dict[str, Any] = {
    "difficulty": 1.0,
    "diagnostics": True,
    "randomize": {"friction": (0.6, 1.2), "mass": (60.0, 140.0), "gravity": (7.0, 12.0)},
}


def mixed_actions(seed: int, steps: int, count: int) -> Any:
    """Full throttle, with random brakes in every third world."""
    actions = np.ones((steps, count, 2), np.float32)
    generator = np.random.default_rng(seed)
    actions[:, 2::3] = generator.uniform(-0.6, 1.0, actions[:, 2::3].shape)
    return actions


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize(("count", "threads"), [(1, 1), (6, 1), (5, 2)])
def test_equals_single_environments(mode: AutoresetMode, count: int, threads: int) -> None:
    vector = CarVectorEnv(count, max_episode_steps=LIMIT, autoreset_mode=mode, threads=threads, **HARD)
    observations, infos = vector.reset(seed=40)
    singles = SingleWorlds(lambda: CarEnv(**HARD), count, mode, 40, LIMIT)
    for i, (observation, info) in enumerate(singles.resets):
        np.testing.assert_array_equal(observations[i], observation)
        assert_info(infos, info, i)
    ended = np.zeros(2, int)
    for actions in mixed_actions(4, 400, count):
        observations, terminated, truncated = singles.compare_step(vector, observations, actions)
        ended += terminated, truncated
    assert ended[1] > 0
    assert count == 1 or ended[0] > 0


def test_courses_differ_from_world_to_world_and_from_episode_to_episode() -> None:
    vector = CarVectorEnv(3, difficulty=1.0)
    vector.reset(seed=0)
    first = vector.task.world.parameters.vertices["position"].copy()
    vector.reset(options={"reset_mask": np.array([False, True, False])})
    second = vector.task.world.parameters.vertices["position"]
    assert abs(first[0] - first[1]).max() > 1.0
    assert abs(first[1] - first[2]).max() > 1.0
    assert abs(first[1] - second[1]).max() > 1.0
    np.testing.assert_array_equal(first[[0, 2]], second[[0, 2]])


def test_partial_reset_with_a_seed_and_a_difficulty() -> None:
    vector = CarVectorEnv(3, autoreset_mode="Disabled", difficulty=1.0)
    vector.reset(seed=0)
    for actions in 0.2 * mixed_actions(0, 30, 3):
        vector.step(actions)
    mask = np.array([False, True, False])
    observations, _ = vector.reset(seed=[5, 6, None], options={"reset_mask": mask, "difficulty": 0.5})
    single = CarEnv()
    np.testing.assert_array_equal(observations[1], single.reset(seed=6, options={"difficulty": 0.5})[0])
    for actions in 0.2 * mixed_actions(1, 60, 3):
        observations = vector.step(actions)[0]
        np.testing.assert_array_equal(observations[1], single.step(actions[1])[0])


@pytest.mark.parametrize("way", ["save", "pickle", "deepcopy"])
def test_goes_on_bit_for_bit(way: str) -> None:
    vector = CarVectorEnv(4, max_episode_steps=LIMIT, threads=2, **HARD)
    observations, _ = vector.reset(seed=0)
    for _ in range(100):
        observations = vector.step(drive(observations))[0]
    other = vector
    saved = vector.save()
    if way == "pickle":
        other = pickle.loads(pickle.dumps(vector))
    elif way == "deepcopy":
        other = copy.deepcopy(vector)
    actions = mixed_actions(1, 150, 4)
    expected = [vector.step(a) for a in actions]
    if way == "save":
        other.restore(saved)
    assert_equal([other.step(a) for a in actions], expected)


@pytest.mark.parametrize("actions", [np.full((3, 2), np.nan), np.zeros((2, 2)), np.zeros(2)])
def test_bad_actions_are_refused_and_change_nothing(actions: Any) -> None:
    vector = CarVectorEnv(3)
    vector.reset(seed=0)
    before = vector.save()
    with pytest.raises(ValueError, match="actions must"):
        vector.step(actions)
    assert_equal(vector.save(), before)


def test_make_vec_gives_the_native_class_and_its_limit() -> None:
    vector = gymnasium.make_vec("gsenv:GCar-v0", num_envs=2, difficulty=0.7)
    assert isinstance(vector, CarVectorEnv)
    assert vector.max_episode_steps == time_limit("GCar-v0")
    assert vector.get_attr("difficulty") == (0.7, 0.7)
    vector.set_attr("difficulty", 0.2)
    assert vector.difficulty == 0.2
    assert vector.single_observation_space == CarEnv().observation_space
    assert vector.observation_space.shape == (2, 40)


def test_frames_of_all_worlds() -> None:
    vector = CarVectorEnv(2, render_mode="rgb_array", width=64, height=48, difficulty=1.0)
    vector.reset(seed=0)
    frames = vector.render()
    assert frames is not None
    assert (frames[0] != frames[1]).any()
