"""skrl's `wrap_env` finds out by itself what it is given."""

from __future__ import annotations

import gymnasium
import pytest

from tests.envs.registered import EACH_TASK, make, make_vector

pytest.importorskip("skrl")  # of the extra "test"
torch = pytest.importorskip("torch")

from skrl.envs.wrappers.torch import wrap_env  # noqa: E402


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_single_and_vector_environments(env_id: str) -> None:
    bare = make(env_id).unwrapped
    for env, count in ((make(env_id), 1), (bare, 1), (make_vector(env_id, 3), 3), (gymnasium.make_vec(env_id, 2), 2)):
        wrapped = wrap_env(env, verbose=False)
        assert type(wrapped).__name__ == "GymnasiumWrapper"
        assert wrapped.num_envs == count
        observations, _ = wrapped.reset()
        assert observations.shape == (count, *bare.observation_space.shape)  # type: ignore[misc]
        _, rewards, terminated, truncated, _ = wrapped.step(torch.zeros(count, *wrapped.action_space.shape))
        assert rewards.shape == terminated.shape == truncated.shape == (count, 1)
        wrapped.close()


def test_parallel_environments() -> None:
    pytest.importorskip("pettingzoo")
    from gsenv.envs import tower_v0

    env = wrap_env(tower_v0.parallel_env(), verbose=False)
    assert type(env).__name__ == "PettingZooWrapper"
    env.reset()
    observations, rewards, *_ = env.step({agent: torch.zeros(1, 4) for agent in env.possible_agents})
    assert observations["gripper_0"].shape == (1, 45)
    assert rewards["gripper_1"].shape == (1, 1)
    assert env.state()["gripper_0"].shape == (1, 90)
