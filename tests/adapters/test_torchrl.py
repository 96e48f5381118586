"""TorchRL's wrappers of single, vector and parallel environments."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from tests.envs.registered import EACH_TASK, SETTINGS

pytest.importorskip("torchrl")  # of the extra "test"
torch = pytest.importorskip("torch")
LIMIT = 4

pytestmark = pytest.mark.filterwarnings("ignore")  # its own, of deprecations


@pytest.mark.parametrize("frame_skip", [1, 2])
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_gym_env_makes_every_id(env_id: str, frame_skip: int) -> None:
    """It always passes `frameskip`, and repeats actions itself where that is refused in Python's words."""
    from torchrl.envs.libs.gym import GymEnv

    env = GymEnv(f"gsenv:{env_id}", frame_skip=frame_skip, **SETTINGS[env_id])
    env.set_seed(3)
    data = env.rollout(3)
    plain = gymnasium.make(f"gsenv:{env_id}", **SETTINGS[env_id])
    plain.reset(seed=3)  # what set_seed does; the rollout begins with another reset
    np.testing.assert_array_equal(data["observation"][0].numpy(), plain.reset()[0])
    for k in range(3):
        total = 0.0
        for _ in range(frame_skip):
            observation, reward, *_ = plain.step(data["action"][k].numpy())
            total += float(reward)
        np.testing.assert_allclose(data["next", "observation"][k].numpy(), observation)
        assert float(data["next", "reward"][k, 0]) == pytest.approx(total, abs=1e-6)
    env.close()


@pytest.mark.parametrize("mode", ["SameStep", "Disabled"])  # it refuses NextStep
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_gym_wrapper_of_a_batch(env_id: str, mode: str) -> None:
    """Its reader of final observations and infos expects flat infos."""
    from torchrl.envs.libs.gym import GymWrapper

    vector = gymnasium.make_vec(
        f"gsenv:{env_id}", num_envs=3, autoreset_mode=mode, max_episode_steps=LIMIT, **SETTINGS[env_id]
    )
    env = GymWrapper(vector)
    env.set_seed(0)  # of the random actions, too: others may end an episode early
    data = env.rollout(2 * LIMIT + 1, break_when_any_done=False)
    assert data.shape == (3, 2 * LIMIT + 1)
    done = data["next", "done"][..., 0]
    assert done[:, LIMIT - 1 :: LIMIT].all()
    assert done.sum() == 3 * 2
    env.close()


def test_petting_zoo_wrapper() -> None:
    pytest.importorskip("pettingzoo")
    from torchrl.envs.libs.pettingzoo import PettingZooWrapper

    from gsenv.envs import tower_v0

    env: Any = PettingZooWrapper(tower_v0.parallel_env(max_cycles=LIMIT), use_mask=False)
    data = env.rollout(LIMIT)
    assert data.shape == (LIMIT,)
    assert data["next", "done"][-1].all()
    terms = data["next", "gripper", "info"]
    total = sum(value for key, value in terms.items() if key.startswith("reward_"))
    torch.testing.assert_close(total.flatten().float(), data["next", "gripper", "reward"].flatten())
    env.close()
