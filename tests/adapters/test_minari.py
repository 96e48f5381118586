"""Minari's DataCollector, the infos included."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from tests.envs.registered import EACH_TASK, make, random_actions, terms_of

minari = pytest.importorskip("minari")  # of the extra "test"
pytest.importorskip("h5py")  # its storage
LIMIT = 15


@pytest.mark.parametrize("arguments", [{}, {"diagnostics": True}], ids=["plain", "diagnostics"])
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_collects_episodes(
    env_id: str, arguments: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    env = minari.DataCollector(make(env_id, max_episode_steps=LIMIT, **arguments), record_infos=True)
    seen: list[list[Any]] = []
    for seed in (3, 4):
        observation, info = env.reset(seed=seed)
        seen.append([(observation, 0.0, info)])
        for action in random_actions(env_id, seed, LIMIT):
            observation, reward, terminated, truncated, info = env.step(action)
            seen[-1].append((observation, reward, info))
            if terminated or truncated:
                break
    dataset = env.create_dataset(
        dataset_id=f"gsenv/{env_id.lower()}-v0",
        eval_env=gymnasium.spec(env_id),
        algorithm_name="random",
        author="nobody",
        author_email="nobody@example.org",
        code_permalink="https://example.org",
        description="test",
        ref_min_score=0.0,
        ref_max_score=1.0,
    )
    env.close()
    loaded = minari.load_dataset(dataset.spec.dataset_id)
    assert loaded.total_episodes == 2
    for episode, steps in zip(loaded.iterate_episodes(), seen, strict=True):
        np.testing.assert_array_equal(episode.observations, [step[0] for step in steps])
        np.testing.assert_array_equal(episode.rewards, [step[1] for step in steps[1:]])
        np.testing.assert_array_equal(episode.infos["success"], [step[2]["success"] for step in steps])
        assert terms_of(episode.infos)
        for name, values in terms_of(episode.infos).items():
            np.testing.assert_array_equal(values, [step[2][f"reward_{name}"] for step in steps])
    recovered = loaded.recover_environment()
    assert isinstance(recovered, gymnasium.Env)
    assert recovered.spec is not None
    assert recovered.spec.id == env_id
    np.testing.assert_array_equal(recovered.reset(seed=3)[0], seen[0][0][0])
