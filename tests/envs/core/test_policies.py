import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from benchmarks import tiers
from gsenv.envs.core.policies import scripted_policy, trained_actions, trained_policy
from gsenv.envs.ragdoll2d.lying import FILE as LYING
from gsenv.envs.ragdoll2d.motion import FILE as RISES
from gsenv.envs.stack.env import StackEnv, StackVectorEnv
from gsenv.envs.stack.policy import build_tower
from gsenv.train.evaluate import UNSELECTED_SEED, evaluate
from tests.envs.registered import COSTLY, IDS

ROOT = Path(__file__).parents[3]
TRAINED = sorted(path.stem for path in (ROOT / "assets").glob("*.npz") if path.name not in (LYING, RISES))


@pytest.mark.parametrize(("blocks", "count", "least"), [(1, 12, 11), (3, 100, 90), (5, 100, 95), (8, 12, 11)])
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


def published(env_id: str) -> dict[str, Any]:
    """What docs/tiers.md says of the trained policy."""
    results = json.loads((ROOT / "benchmarks/results/tiers.json").read_text())
    columns, *outcomes = results["outcomes"]
    rows = [dict(zip(columns, outcome, strict=True)) for outcome in outcomes]
    (row,) = (row for row in rows if (row["tier"], row["policy"]) == (env_id, "trained"))
    return row


@pytest.mark.parametrize("env_id", IDS)
def test_published_returns_exceed_the_reward_thresholds(env_id: str) -> None:
    threshold = gymnasium.spec(env_id).reward_threshold
    assert threshold is not None
    assert published(env_id)["returns"] > threshold


NIGHTLY = (*COSTLY, "GStack3D-hardcore-v0")


@pytest.mark.parametrize("env_id", [pytest.param(i, marks=pytest.mark.slow) if i in NIGHTLY else i for i in TRAINED])
def test_trained_policies_reach_what_docs_tiers_says(env_id: str) -> None:
    said = published(env_id)
    reached = evaluate(trained_actions(env_id), env_id, tiers.EPISODES, UNSELECTED_SEED)
    # the same 100 episodes: only the last bits of the network's sums differ between machines
    assert abs(reached.success_rate - said["success"]) <= 0.05
    assert reached.mean_return == pytest.approx(said["returns"], rel=0.05)


def test_trained_policy_acts_in_single_and_vector_environments_alike() -> None:
    env = StackEnv()
    observation, _ = env.reset(seed=0)
    action = trained_policy("GStack-v0")(env)
    assert env.action_space.contains(action)
    np.testing.assert_allclose(trained_actions("GStack-v0")(observation[None])[0], action, atol=1e-6)


@pytest.mark.parametrize("env_id", ["GStack-v0", "GCar-v0"])
def test_trained_policy_needs_no_torch(env_id: str) -> None:
    code = (
        "import sys; sys.modules['torch'] = sys.modules['stable_baselines3'] = None\n"
        f"from gsenv.envs.core.policies import trained_policy; trained_policy('{env_id}')"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("find", [scripted_policy, trained_policy])
def test_unknown_policies_are_refused(find: object) -> None:
    with pytest.raises(LookupError, match="GNothing-v0 has no"):
        find("GNothing-v0")  # type: ignore[operator]
