"""The environment checkers of gymnasium and Stable-Baselines3, warnings included."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.envs.registered import IDS, make

VARIANTS: list[dict[str, Any]] = [
    {},
    {"observation": "pixels"},
    {"observation": "state+pixels", "split": "test"},
    {"diagnostics": True, "randomize": {"friction": (0.5, 0.9)}},
]
each_variant = pytest.mark.parametrize("arguments", VARIANTS, ids=["state", "pixels", "both", "diagnostics"])


@each_variant
@pytest.mark.parametrize("env_id", IDS)
def test_gymnasium_has_no_complaint(env_id: str, arguments: dict[str, Any]) -> None:
    pytest.importorskip("pygame")  # the checker renders in every mode, "human" too
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make(env_id, render_mode="rgb_array", width=64, height=48, **arguments).unwrapped)


@each_variant
@pytest.mark.parametrize("env_id", IDS)
def test_stable_baselines_has_no_complaint(env_id: str, arguments: dict[str, Any]) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")  # of the extra "train"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(make(env_id, **arguments).unwrapped, warn=True)


@pytest.mark.parametrize("env_id", IDS)
def test_passive_checker_of_make_has_no_complaint(env_id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = make(env_id, render_mode="rgb_array", width=64, height=48)
        env.reset(seed=0, options={})
        for _ in range(3):
            observation = env.step(env.action_space.sample())[0]
        frame: Any = env.render()
        env.close()
    assert env.observation_space.contains(observation)
    assert frame.shape == (48, 64, 3)


@pytest.mark.parametrize("env_id", IDS)
def test_infos_are_plain_and_have_the_same_keys_in_reset_and_step(env_id: str) -> None:
    env = make(env_id, diagnostics=True)
    _, first = env.reset(seed=0)
    second = env.step(np.zeros_like(env.action_space.sample()))[4]

    def types(info: dict[str, Any]) -> dict[str, Any]:
        return {key: types(value) if isinstance(value, dict) else type(value) for key, value in info.items()}

    assert types(first) == types(second)
    groups = [group if isinstance(group, dict) else {"": group} for group in types(second).values()]
    assert {kind for group in groups for kind in group.values()} <= {bool, int, float}


@pytest.mark.parametrize("env_id", IDS)
def test_made_by_its_prefixed_name_as_single_and_vector(env_id: str) -> None:
    single = gymnasium.make(f"gsenv:{env_id}")
    vector = gymnasium.make_vec(f"gsenv:{env_id}", num_envs=2, diagnostics=True)
    assert vector.spec is not None
    assert vector.single_observation_space == single.observation_space
    assert vector.single_action_space == single.action_space
    assert vector.unwrapped.max_episode_steps == gymnasium.spec(env_id).max_episode_steps  # type: ignore[attr-defined]
    assert "diagnostic_residual" in vector.reset(seed=0)[1]
