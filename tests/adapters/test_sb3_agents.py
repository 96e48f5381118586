"""Each agent of each world as one environment of a VecEnv."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from gsenv.adapters.sb3_agents import AgentVecEnv
from gsenv.envs.core.policies import make_batch
from tests.envs.stack.worlds import mixed_actions


def test_equals_the_batch() -> None:
    """Environment 2 w + a is agent a of world w; ended worlds are reset in the same step."""
    envs = AgentVecEnv("tower_v0", 3, blocks=2)
    batch = make_batch("tower_v0", 3, blocks=2, autoreset_mode="SameStep")
    envs.seed(5)
    np.testing.assert_array_equal(envs.reset(), batch.reset(seed=5)[0].reshape(6, -1))
    ends = 0
    returns = np.zeros(6)
    for actions in mixed_actions(0, (300, 6)):
        observations, rewards, dones, infos = envs.step(actions)
        expected, gains, terminated, truncated, others = batch.step(actions.reshape(3, 2, 4))
        np.testing.assert_array_equal(observations, expected.reshape(6, -1))
        np.testing.assert_array_equal(rewards, gains.astype(np.float32).ravel())
        np.testing.assert_array_equal(dones, np.repeat(terminated | truncated, 2))
        returns += gains.ravel()
        for i in np.flatnonzero(dones):
            np.testing.assert_array_equal(infos[i]["terminal_observation"], others["final_obs"][i // 2][i % 2])
            assert infos[i]["episode"]["r"] == pytest.approx(returns[i], abs=1e-5)
            assert not infos[i]["TimeLimit.truncated"]
            returns[i] = 0.0
            ends += 1
    assert ends >= 4


def test_settings_are_those_of_the_batch() -> None:
    envs = AgentVecEnv("tower_v0", 2)
    envs.set_attr("blocks", 2)
    assert envs.get_attr("blocks") == [2, 2, 2, 2]
    envs.set_attr("half_width", (0.2, 0.25))  # one value, not one for each of the two worlds
    assert envs.batch.task.settings["half_width"] == (0.2, 0.25)
    with pytest.raises(ValueError, match="shared"):
        envs.set_attr("blocks", 2, indices=[0])
    with pytest.raises(LookupError, match="one agent"):
        AgentVecEnv("GStack-v0", 2)
    with pytest.raises(LookupError, match="no environment"):
        AgentVecEnv("tower_v9", 2)
