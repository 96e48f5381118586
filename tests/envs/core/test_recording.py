"""gymnasium's recorders of videos and of episode statistics."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import gymnasium
import imageio.v3 as iio
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import RecordEpisodeStatistics, RecordVideo

from tests.envs.registered import EACH_TASK, MODES, make, make_vector, random_actions

LIMIT = 6
SIZE = {"render_mode": "rgb_array", "width": 96, "height": 64}


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_video_of_single_episodes(env_id: str, tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    env = RecordVideo(make(env_id, max_episode_steps=LIMIT, **SIZE), str(tmp_path), episode_trigger=lambda k: k != 1)
    frames, lengths = [], []
    for seed in range(3):
        env.reset(seed=seed)
        frames.append(env.render())
        lengths.append(1)
        for action in random_actions(env_id, 0, LIMIT):
            _, _, terminated, truncated, _ = env.step(action)
            lengths[-1] += 1
            if terminated or truncated:
                break
    env.close()
    assert sorted(path.name for path in tmp_path.glob("*.mp4")) == ["rl-video-episode-0.mp4", "rl-video-episode-2.mp4"]
    for k in (0, 2):
        video = iio.imread(tmp_path / f"rl-video-episode-{k}.mp4")
        assert video.shape == (lengths[k], 64, 96, 3)
        assert np.abs(video[0].astype(int) - np.asarray(frames[k])).mean() < 12.0  # lossy
        assert (video[0] != video[-1]).any()
    properties = iio.immeta(tmp_path / "rl-video-episode-0.mp4")
    assert properties["fps"] == env.metadata["render_fps"]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_video_of_a_vector_environment(env_id: str, mode: AutoresetMode, tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    recorder = getattr(gymnasium.wrappers.vector, "RecordVideo", None)
    if recorder is None:
        pytest.skip("this gymnasium has no vector RecordVideo")
    vector = make_vector(env_id, 4, autoreset_mode=mode, max_episode_steps=LIMIT, **SIZE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that SAME_STEP lacks the last frame
        env: Any = recorder(vector, str(tmp_path), episode_trigger=lambda _: True)
    env.reset(seed=0)
    for actions in random_actions(env_id, 0, 2 * LIMIT, 4):
        _, _, terminated, truncated, _ = env.step(actions)
        ended = terminated | truncated
        if mode == AutoresetMode.DISABLED and ended.any():
            env.reset(options={"reset_mask": ended})
    env.close()
    videos = sorted(tmp_path.glob("*.mp4"))
    assert len(videos) >= 2
    first = iio.imread(videos[0])
    assert first.shape[0] >= 2
    assert first.shape[1] * first.shape[2] == 4 * 64 * 96  # four pictures side by side


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_statistics_of_single_episodes(env_id: str) -> None:
    env = RecordEpisodeStatistics(make(env_id, max_episode_steps=LIMIT))
    env.reset(seed=0)
    rewards: list[Any] = []
    for action in random_actions(env_id, 0, LIMIT):
        _, reward, terminated, truncated, info = env.step(action)
        rewards.append(reward)
        if terminated or truncated:
            break
    assert info["episode"]["l"] == len(rewards)
    assert info["episode"]["r"] == pytest.approx(sum(rewards), rel=1e-12)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_statistics_of_a_vector_environment(env_id: str, mode: AutoresetMode) -> None:
    """Returns and lengths as added up here; staggered ends, by partial resets in all modes."""
    if mode == AutoresetMode.SAME_STEP and tuple(map(int, gymnasium.__version__.split(".")[:2])) < (1, 4):
        pytest.skip("this gymnasium does not count the first step after an end in the same step")
    count = 3
    env = gymnasium.wrappers.vector.RecordEpisodeStatistics(
        make_vector(env_id, count, autoreset_mode=mode, max_episode_steps=LIMIT)
    )
    env.reset(seed=0)
    totals, lengths, fresh = np.zeros(count), np.zeros(count, int), np.zeros(count, bool)
    episodes = 0
    for k, actions in enumerate(random_actions(env_id, 0, 4 * LIMIT, count)):
        if k == 3:
            env.reset(options={"reset_mask": np.array([True, False, False])})
            totals[0], lengths[0] = 0.0, 0
        _, rewards, terminated, truncated, infos = env.step(actions)
        acted = ~fresh if mode == AutoresetMode.NEXT_STEP else np.ones(count, bool)
        totals += np.where(acted, rewards, 0.0)
        lengths += acted
        ended = terminated | truncated
        if ended.any():
            np.testing.assert_array_equal(infos["_episode"], ended)
            np.testing.assert_array_equal(infos["episode"]["l"][ended], lengths[ended])
            np.testing.assert_allclose(infos["episode"]["r"][ended], totals[ended], rtol=1e-12)
            episodes += int(ended.sum())
            totals[ended], lengths[ended] = 0.0, 0
        fresh = ended
        if mode == AutoresetMode.DISABLED and ended.any():
            env.reset(options={"reset_mask": ended})
    assert episodes >= 3 * count
