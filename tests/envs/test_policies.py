import numpy as np
import pytest

from gsenv.envs.policies import build_tower, scripted_policy, trained_policy
from gsenv.envs.stack import StackEnv, StackVectorEnv


@pytest.mark.parametrize(("blocks", "count", "least"), [(1, 12, 11), (3, 100, 90), (5, 100, 60), (8, 12, 11)])
def test_builder_builds(blocks: int, count: int, least: int) -> None:
    vector = StackVectorEnv(count, blocks=blocks, max_episode_steps=600, autoreset_mode="SameStep")
    observations, _ = vector.reset(seed=0)
    done = np.zeros(count, bool)
    built = 0
    for _ in range(600):
        observations, _, terminated, truncated, infos = vector.step(build_tower(observations))
        if "final_info" in infos:
            built += int((infos["final_info"]["success"] & ~done).sum())
        done |= terminated | truncated
        if done.all():
            break
    assert built >= least


def test_random_actions_do_not_build() -> None:
    vector = StackVectorEnv(60, max_episode_steps=600, autoreset_mode="SameStep")
    vector.reset(seed=0)
    generator = np.random.default_rng(0)
    episodes = built = 0
    while episodes < 300:
        actions = generator.uniform(-1.0, 1.0, (60, 4)).astype(np.float32)
        _, _, terminated, truncated, infos = vector.step(actions)
        ended = terminated | truncated
        episodes += int(ended.sum())
        if ended.any():
            built += int(infos["final_info"]["success"].sum())
    assert built / episodes < 0.05


def test_scripted_policy_gives_legal_actions_for_a_single_env() -> None:
    env = StackEnv()
    policy = scripted_policy("gsenv:GStack-v0")
    env.reset(seed=0)
    for _ in range(100):
        action = policy(env)
        assert env.action_space.contains(action)
        env.step(action)


@pytest.mark.parametrize("find", [scripted_policy, trained_policy])
def test_unknown_policies_are_refused(find: object) -> None:
    with pytest.raises(LookupError, match="GNothing-v0 has no"):
        find("GNothing-v0")  # type: ignore[operator]
