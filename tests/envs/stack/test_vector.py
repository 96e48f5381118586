"""StackVectorEnv: bit-equal to single environments, in all modes."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode

from gsenv.envs.stack.env import StackEnv, StackVectorEnv
from gsenv.envs.stack.policy import build_tower
from tests.envs.stack.worlds import IDLE, assert_equal, mixed_actions

MODES = list(AutoresetMode)
LIMIT = 60  # steps, so that episodes end in both ways
IDLE_3 = np.tile(IDLE, (3, 1))


class Reference:
    """A vector environment as Gymnasium defines it, made of single ones."""

    def __init__(self, count: int, mode: AutoresetMode, seed: int) -> None:
        self.envs = [StackEnv(blocks=2) for _ in range(count)]
        self.mode = mode
        self.resets = [env.reset(seed=seed + i) for i, env in enumerate(self.envs)]
        self.elapsed = [0] * count
        self.finished = [False] * count

    def step(self, i: int, action: Any) -> tuple[Any, ...]:
        """(observation, reward, terminated, truncated, info, final observation, final info)."""
        env = self.envs[i]
        if self.finished[i] and self.mode != AutoresetMode.SAME_STEP:
            observation, info = env.reset()
            self.elapsed[i], self.finished[i] = 0, False
            return observation, 0.0, False, False, info, None, None
        observation, reward, terminated, _, info = env.step(action)
        self.elapsed[i] += 1
        truncated = self.elapsed[i] >= LIMIT
        final = (None, None)
        if (terminated or truncated) and self.mode == AutoresetMode.SAME_STEP:
            final = (observation, info)  # type: ignore[assignment]
            observation, info = env.reset()
            self.elapsed[i] = 0
        else:
            self.finished[i] = terminated or truncated
        return observation, reward, terminated, truncated, info, *final


def assert_info(infos: dict[str, Any], info: dict[str, Any], i: int) -> None:
    for key, value in info.items():
        assert infos[f"_{key}"][i]
        if isinstance(value, dict):
            assert_info(infos[key], value, i)
        else:
            assert infos[key][i] == value


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("count", "threads"), [(1, 1), (3, 1), (5, 2)])
def test_equals_single_environments(mode: AutoresetMode, count: int, threads: int) -> None:
    vector = StackVectorEnv(count, blocks=2, max_episode_steps=LIMIT, autoreset_mode=mode, threads=threads)
    observations, infos = vector.reset(seed=40)
    reference = Reference(count, mode, 40)
    for i, (observation, info) in enumerate(reference.resets):
        np.testing.assert_array_equal(observations[i], observation)
        assert_info(infos, info, i)
    ends = {"terminated": 0, "truncated": 0}
    builders = np.arange(count) % 2 == 1
    for actions in mixed_actions(4, (200, count)):
        actions[builders] = build_tower(observations[builders])
        if mode == AutoresetMode.DISABLED:
            _reset_finished(vector, reference, observations)
        observations, rewards, terminated, truncated, infos = vector.step(actions)
        assert rewards.dtype == np.float64
        for i in range(count):
            one = reference.step(i, actions[i])
            np.testing.assert_array_equal(observations[i], one[0])
            assert (rewards[i], terminated[i], truncated[i]) == one[1:4]
            assert_info(infos, one[4], i)
            if mode == AutoresetMode.SAME_STEP and (one[2] or one[3]):
                np.testing.assert_array_equal(infos["final_obs"][i], one[5])
                assert infos["_final_obs"][i]
                assert infos["_final_info"][i]
                assert_info(infos["final_info"], one[6], i)
            elif "final_obs" in infos:
                assert infos["final_obs"][i] is None
                assert not infos["_final_info"][i]
        ends["terminated"] += int(terminated.sum())
        ends["truncated"] += int(truncated.sum())
    assert ends["terminated"] > 0
    assert count == 1 or ends["truncated"] > 0


def _reset_finished(vector: StackVectorEnv, reference: Reference, observations: Any) -> None:
    """Partial reset of both; the others' observations stay."""
    mask = np.array(reference.finished)
    if not mask.any():
        return
    options = {"reset_mask": mask}
    begun, infos = vector.reset(options=options)
    assert options == {"reset_mask": mask}
    for i, env in enumerate(reference.envs):
        assert infos["_success"][i] == mask[i]
        if mask[i]:
            observation, info = env.reset()
            np.testing.assert_array_equal(begun[i], observation)
            assert_info(infos, info, i)
            reference.elapsed[i], reference.finished[i] = 0, False
        else:
            np.testing.assert_array_equal(begun[i], observations[i])
    observations[:] = begun


def test_partial_reset_with_a_seed() -> None:
    vector = StackVectorEnv(3, autoreset_mode="Disabled")
    vector.reset(seed=0)
    for actions in mixed_actions(0, (20, 3)):
        vector.step(actions * np.float32(0.1) + IDLE)
    mask = np.array([False, True, False])
    observations, _ = vector.reset(seed=[5, 6, None], options={"reset_mask": mask, "blocks": 3})
    np.testing.assert_array_equal(observations[1], StackEnv().reset(seed=6, options={"blocks": 3})[0])
    again = vector.step(IDLE_3)[0]
    other = StackVectorEnv(3, autoreset_mode="Disabled")
    other.reset(seed=[0, 6, 2])
    assert (again != other.step(IDLE_3)[0])[[0, 2]].any()


def test_next_step_ignores_the_action_of_a_finished_world() -> None:
    vector = StackVectorEnv(2, max_episode_steps=2)
    vector.reset(seed=0)
    both = np.tile(IDLE, (2, 1))
    vector.step(both)
    assert vector.step(both)[3].all()
    observations, rewards, terminated, truncated, _ = vector.step(np.full((2, 4), np.nan))
    single = StackEnv()
    single.reset(seed=0)
    np.testing.assert_array_equal(observations[0], single.reset()[0])
    assert not rewards.any()
    assert not (terminated | truncated).any()


def test_disabled_mode_refuses_to_step_a_finished_world() -> None:
    vector = StackVectorEnv(3, max_episode_steps=1, autoreset_mode=AutoresetMode.DISABLED)
    vector.reset(seed=0)
    vector.step(IDLE_3)
    with pytest.raises(ResetNeeded, match=r"\[0, 1, 2\]"):
        vector.step(IDLE_3)
    vector.reset(options={"reset_mask": np.array([True, True, False])})
    with pytest.raises(ResetNeeded, match=r"\[2\]"):
        vector.step(IDLE_3)


def test_step_needs_a_reset_of_every_world() -> None:
    vector = StackVectorEnv(3)
    with pytest.raises(ResetNeeded):
        vector.step(IDLE_3)
    vector.reset(options={"reset_mask": np.array([True, False, False])})
    with pytest.raises(ResetNeeded):
        vector.step(IDLE_3)


@pytest.mark.parametrize("mask", [np.zeros(3, bool), np.ones(2, bool), np.ones(3, int), np.ones((3, 1), bool)])
def test_bad_reset_masks_are_refused(mask: Any) -> None:
    vector = StackVectorEnv(3)
    with pytest.raises(ValueError, match="reset_mask"):
        vector.reset(options={"reset_mask": mask})


@pytest.mark.parametrize("actions", [np.full((3, 4), np.nan), np.zeros((2, 4)), np.zeros(4)])
def test_bad_actions_are_refused_and_change_nothing(actions: Any) -> None:
    vector = StackVectorEnv(3)
    vector.reset(seed=0)
    before = vector.save()
    with pytest.raises(ValueError, match="actions must"):
        vector.step(actions)
    assert_equal(vector.save(), before)


@pytest.mark.parametrize("way", ["save", "pickle", "deepcopy"])
def test_goes_on_bit_for_bit(way: str) -> None:
    vector = StackVectorEnv(4, blocks=2, max_episode_steps=LIMIT, threads=2)
    observations, _ = vector.reset(seed=0)
    for _ in range(50):
        observations = vector.step(build_tower(observations))[0]
    other = vector
    saved = vector.save()
    if way == "pickle":
        other = pickle.loads(pickle.dumps(vector))
    elif way == "deepcopy":
        other = copy.deepcopy(vector)
    actions = mixed_actions(1, (60, 4))
    expected = [vector.step(a) for a in actions]
    other.restore(saved)
    assert_equal([other.step(a) for a in actions], expected)


def test_results_are_fresh() -> None:
    vector = StackVectorEnv(2)
    kept = vector.reset(seed=0)
    copied = copy.deepcopy(kept)
    results = vector.step(np.ones((2, 4), np.float32))
    results_copied = copy.deepcopy(results)
    vector.step(-np.ones((2, 4), np.float32))
    assert_equal(kept, copied)
    assert_equal(results, results_copied)


def test_every_leaf_of_the_infos_is_an_array_with_a_mask() -> None:
    vector = StackVectorEnv(3, max_episode_steps=1, autoreset_mode="SameStep")
    _, infos = vector.reset(seed=0)

    def check(infos: dict[str, Any]) -> None:
        for key, value in infos.items():
            if not key.startswith("_"):
                assert infos[f"_{key}"].dtype == np.bool_
            if key == "final_info":
                check(value)
            else:
                assert isinstance(value, np.ndarray)
                assert len(value) == 3

    check(infos)
    check(vector.step(IDLE_3)[4])


def test_make_vec_gives_the_native_class_and_its_limit() -> None:
    vector = gymnasium.make_vec("gsenv:GStack-v0", num_envs=2, blocks=3)
    assert isinstance(vector, StackVectorEnv)
    assert vector.max_episode_steps == 600
    assert vector.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert vector.single_observation_space == StackEnv().observation_space
    assert vector.observation_space.shape == (2, 32)
    assert vector.action_space.shape == (2, 4)


def test_call_and_attributes() -> None:
    vector = StackVectorEnv(2, render_mode="rgb_array", width=64, height=48)
    vector.reset(seed=0)
    assert vector.get_attr("render_mode") == ("rgb_array",) * 2
    vector.set_attr("blocks", 3)
    assert vector.call("blocks") == (3, 3)
    vector.set_attr("blocks", [4, 4])
    assert vector.get_attr("blocks") == (4, 4)
    with pytest.raises(ValueError, match="shared"):
        vector.set_attr("blocks", [4, 5])
    with pytest.raises(AttributeError):
        vector.set_attr("bloks", 3)
    assert len(vector.call("np_random")) == 2
    frames = vector.render()
    assert frames is not None
    assert [frame.shape for frame in frames] == [(48, 64, 3)] * 2
    assert (frames[0] != frames[1]).any()
    assert len(vector.call("render")) == 2


def test_normalising_wrappers_of_gymnasium_run() -> None:
    vector = gymnasium.make_vec("GStack-v0", num_envs=2)
    wrapped = gymnasium.wrappers.vector.NormalizeObservation(gymnasium.wrappers.vector.RecordEpisodeStatistics(vector))
    wrapped.reset(seed=0)
    seen = np.array([wrapped.step(actions)[0] for actions in mixed_actions(0, (30, 2))])
    assert seen.shape == (30, 2, *vector.single_observation_space.shape)  # type: ignore[misc]
    assert np.isfinite(seen).all()
    assert seen.std() > 0.1  # normalised, not left as zeros
