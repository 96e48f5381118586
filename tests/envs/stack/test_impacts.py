"""Blocks of GStack-v0 crack where they land too fast, and nowhere else."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

from gsenv.envs.core.policies import make_batch, scripted_actions
from gsenv.envs.stack.crack_lines import INNER
from gsenv.envs.stack.env import StackEnv, StackVectorEnv
from gsenv.envs.stack.policy import build_tower, drop_blocks, lower_blocks
from gsenv.envs.stack.scene import FIRST_BLOCK_SHAPE
from gsenv.train.evaluate import evaluate
from tests.envs.stack.worlds import IDLE, RELEASE, block_position, mixed_actions, set_up_tower

UNBREAKABLE = 100.0  # m/s


def fastest_impact(env: Any, steps: int, action: Any = IDLE) -> float:
    """Return the fastest impact in m/s of the next steps."""
    fastest = 0.0
    for _ in range(steps):
        _, _, terminated, _, info = env.step(action)
        fastest = max(fastest, info["impact"])
        if terminated:
            break
    return fastest


def dropped(height: float, crack_speed: float, spin: float = 0.0) -> StackEnv:
    """Return a tower of two, the upper block `height` m above the lower one, falling."""
    env = StackEnv()
    env.reset(seed=3, options={"blocks": 3, "crack_speed": crack_speed})
    set_up_tower(env.task, 2)
    x, y = block_position(env.task, 1)
    env.task.world.set_pose("block_1", position=(x, y + height))
    env.task.world.set_velocity("block_1", angular=spin)
    return env


@pytest.mark.parametrize("height", [0.002, 0.008, 0.02, 0.1, 0.35])
def test_an_impact_has_the_speed_of_a_free_fall(height: float) -> None:
    impact = fastest_impact(dropped(height, UNBREAKABLE), 20)
    assert impact == pytest.approx(math.sqrt(2.0 * 9.81 * height), rel=0.02)


@pytest.mark.parametrize(("height", "cracks"), [(0.007, False), (0.0095, True)])
def test_a_block_cracks_above_the_speed_that_is_set(height: float, cracks: bool) -> None:
    """At 0.4 m/s, a fall of 8.2 mm."""
    env = dropped(height, 0.4)
    for _ in range(10):
        _, _, terminated, _, info = env.step(IDLE)
        if terminated:
            break
    assert info["cracked"] == terminated == cracks
    assert info["reward_crack"] == (-0.2 if cracks else 0.0)
    assert not info["success"]
    lines = env.task.lines(0)
    assert (lines is not None) == cracks
    if lines is not None:  # on both blocks, which met
        half = env.task.world.parameters.shapes["size"][0, FIRST_BLOCK_SHAPE : FIRST_BLOCK_SHAPE + 2, 0]
        assert lines[..., 1].min() < 0.1
        assert np.abs(lines[..., 0]).max() == pytest.approx(INNER * half.max(), rel=0.02)


def test_a_corner_that_slaps_down_is_an_impact_at_its_own_speed() -> None:
    """A block that turns by 2 rad/s about its middle meets the one below with a corner, faster than it falls."""
    env = dropped(0.05, UNBREAKABLE, spin=2.0)
    assert fastest_impact(env, 10) > 1.1 * math.sqrt(2.0 * 9.81 * 0.05)


def test_a_tower_that_stands_has_no_impacts() -> None:
    """The lowest of eight blocks carries up to 100 kg."""
    env = StackEnv()
    env.reset(seed=0, options={"blocks": 8, "success_time": 10.0})
    set_up_tower(env.task, 8)
    fastest_impact(env, 3)
    assert fastest_impact(env, 200) < 0.01


def test_the_gripper_cracks_nothing() -> None:
    """It comes down on a tower of three at 1.5 m/s."""
    env = StackEnv()
    env.reset(seed=0, options={"blocks": 4})
    set_up_tower(env.task, 3)
    env.task.task_state["blocks"] = 3
    assert fastest_impact(env, 25, np.array([0.0, -1.0, 0.0, -1.0], np.float32)) < 0.2
    assert not env.task.infos["cracked"][0]


def test_random_actions_beside_a_tower_crack_nothing() -> None:
    """Of three blocks set down by the builder; 30 worlds, 100 steps of random actions with the empty gripper."""
    envs = StackVectorEnv(30, blocks=3, success_time=10.0, autoreset_mode="Disabled", max_episode_steps=-1)
    observations, _ = envs.reset(seed=0)
    placed = envs.task.task_state["placed"]
    while (placed < 3).any():
        observations, _, terminated, _, _ = envs.step(build_tower(observations))
        assert not terminated.any()
    for _ in range(20):  # up, clear of the tower
        envs.step(np.tile(np.array([0.0, 1.0, 0.0, -1.0], np.float32), (30, 1)))
    fastest = 0.0
    for actions in mixed_actions(0, (100, 30)):
        actions[:, 1] = np.abs(actions[:, 1])
        _, _, _, _, infos = envs.step(actions)
        fastest = max(fastest, float(infos["impact"].max()))
        assert not infos["cracked"].any()
    assert fastest < 0.05


def test_ramming_the_ground_with_a_held_block_cracks_it() -> None:
    env = StackEnv()
    env.reset(seed=0)
    impact = fastest_impact(env, 60, np.array([0.0, -1.0, 0.0, -1.0], np.float32))
    assert env.task.infos["cracked"][0]
    assert 0.4 < impact < 2.5


def test_a_drop_cracks_and_a_soft_landing_does_not() -> None:
    env = StackEnv()
    observation, _ = env.reset(seed=0, options={"blocks": 1})
    _, _, _, _, info = env.step(RELEASE)
    while not info["cracked"]:
        _, _, terminated, _, info = env.step(IDLE)
        assert terminated == info["cracked"]
    observation, _ = env.reset(seed=0, options={"blocks": 1})
    terminated = False
    while not terminated:
        observation, _, terminated, _, info = env.step(build_tower(observation))
    assert info["success"]


# ---------------------------------------------------------------- tiers


def still(observations: Any) -> Any:
    return np.zeros((*observations.shape[:-1], 4), np.float32)


@pytest.mark.parametrize(("env_id", "least"), [("GStack-v0", 0.9), ("GStack-hardcore-v0", 0.7)])
def test_only_careful_builders_build(env_id: str, least: float) -> None:
    generator = np.random.default_rng(0)
    constants = generator.uniform(-1.0, 1.0, (20, 4)).astype(np.float32)

    def random_policy(observations: Any) -> Any:
        return generator.uniform(-1.0, 1.0, (len(observations), 4)).astype(np.float32)

    scripted = evaluate(scripted_actions(env_id), env_id, 30)
    assert scripted.success_rate >= least
    for policy in (still, random_policy, drop_blocks, lambda seen: constants):
        other = evaluate(policy, env_id, 20)
        assert other.success_rate == 0.0
        assert other.mean_return < 0.3 * scripted.mean_return


@pytest.mark.parametrize("speed", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("env_id", ["GStack-v0", "GStack-hardcore-v0"])
def test_to_lower_blocks_at_one_speed_is_not_enough(env_id: str, speed: float) -> None:
    lowered = evaluate(partial(lower_blocks, speed=speed), env_id, 40)
    assert lowered.success_rate < 0.9
    assert lowered.mean_return < evaluate(scripted_actions(env_id), env_id, 40).mean_return


def test_a_gantry_sways_as_it_is_told() -> None:
    """The velocity of the gripper, without actions, once the block has sagged: at most the sway, and not still."""
    envs = make_batch("GStack-hardcore-v0", 10, sway=0.08)
    envs.reset(seed=0)
    speeds = []
    for _ in range(150):
        observations = envs.step(np.tile(IDLE, (10, 1)))[0]
        speeds.append(observations[:, 3:5])
    speeds = speeds[30:]
    assert np.abs(speeds).max() < 0.09
    assert np.std(speeds, axis=0).min() > 0.01
