"""A task with no more than what it must say: a driven pendulum."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.task import Task
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Revolute
from tests.envs.single_worlds import SingleWorlds
from tests.envs.stack.worlds import assert_equal


class PendulumTask(Task):
    actions = (Entry("torque, of 2 N m up to 6 N m", "torque", -1, 1),)
    observations = (Entry("sine of the angle", "sine", -1, 1), Entry("rate", "rate", -20, 20, "rad/s"))
    reward_terms = (RewardTerm("height", "of the tip"),)
    draw_count = 1

    def build_scene(self) -> Scene:
        scene = Scene()
        scene.add_body("post", "static", [Box(half_extents=(0.1, 0.1), mask=0)])
        scene.add_body("rod", shapes=[Capsule(half_length=0.5, radius=0.05, angle=np.pi / 2)], position=(0.0, -0.5))
        joint = scene.add_joint("pin", Revolute("post", "rod", anchor=(0.0, 0.0), motor_effort=6.0))
        scene.add_actuator("torque", joint, mode="torque", lower=2.0, upper=6.0)
        return scene

    def initialize_episode(self, worlds: Any, draws: Any, options: Mapping[str, Any]) -> None:
        self.world.set_velocity("rod", angular=draws[:, 0], worlds=worlds)
        self._observe()

    def evaluate(self) -> None:
        self.terms["height"] = -self.world.state.bodies["rotation"][:, 1, 0]
        self.reward[:] = self.terms["height"]
        self.terminated[:] = self.world.state.bodies["angle"][:, 1] > 6.0
        self._observe()

    def _observe(self) -> None:
        rod = self.world.state.bodies[:, 1]
        seen = np.stack([rod["rotation"][:, 1], rod["velocity"][:, 2]], axis=1)
        self.observation[:] = np.clip(seen, self.low, self.high)


class PendulumEnv(TaskEnv):
    task_class = PendulumTask


class PendulumVectorEnv(TaskVectorEnv):
    task_class = PendulumTask


def test_passes_the_checker() -> None:
    check_env(PendulumEnv(), skip_render_check=True)


@pytest.mark.parametrize("name", ["reward_height", "diagnostic_energy"])
def test_info_fields_may_not_hide_reward_terms(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PendulumTask, "info_fields", ((name, "f8"),))
    with pytest.raises(ValueError, match=f"names of the base class: .'{name}'"):
        PendulumEnv()


def test_actions_fill_the_actuators_range() -> None:
    env = PendulumEnv()
    env.reset(seed=0)
    for action, torque in ((-1.0, 2.0), (0.0, 4.0), (1.0, 6.0), (9.0, 6.0)):
        env.step(np.array([action], np.float32))
        assert env.task.world.control[0, 0] == torque


def test_bad_actions_are_refused_and_change_nothing() -> None:
    vector = PendulumVectorEnv(3)
    vector.reset(seed=0)
    before = vector.save()
    with pytest.raises(ValueError, match=r"finite, got .* in world 2"):
        vector.step(np.array([[0.0], [1.0], [np.nan]], np.float32))
    assert_equal(vector.save(), before)


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_equals_single_environments(mode: AutoresetMode) -> None:
    vector = PendulumVectorEnv(3, max_episode_steps=50, autoreset_mode=mode)
    observations, _ = vector.reset(seed=4)
    singles = SingleWorlds(PendulumEnv, 3, mode, 4, 50)
    ended = np.zeros(2, int)
    for actions in np.random.default_rng(0).uniform(-1.0, 1.0, (120, 3, 1)).astype(np.float32):
        actions[:, :2] = np.abs(actions[:, :2])
        observations, terminated, truncated = singles.compare_step(vector, observations, actions)
        ended += terminated, truncated
    assert ended.sum() > 3


@pytest.mark.parametrize("way", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_bit_for_bit(way: Any) -> None:
    env = PendulumEnv()
    env.reset(seed=0)
    action = np.array([0.3], np.float32)
    for _ in range(3):
        env.step(action)
    other = way(env)
    assert_equal([env.step(action), env.reset()], [other.step(action), other.reset()])


def test_has_no_settings_and_no_quantities() -> None:
    with pytest.raises(
        TypeError,
        match="unexpected keyword argument 'length'; it has none of its own; all environments have render_mode, ",
    ):
        PendulumEnv(length=2.0)
    with pytest.raises(ValueError, match="unknown quantity 'length'; known are none"):
        PendulumEnv(randomize={"length": (1.0, 2.0)})
    with pytest.raises(ValueError, match="unknown option 'length'; this environment has none"):
        PendulumEnv().reset(options={"length": 2.0})


def test_staggered_episodes_end_apart_and_stay_so() -> None:
    count, limit = 8, 10
    worlds = PendulumVectorEnv(count, max_episode_steps=limit, autoreset_mode=AutoresetMode.SAME_STEP)
    worlds.reset(seed=0)
    worlds.stagger(np.random.default_rng(1))
    left = limit - np.random.default_rng(1).integers(0, limit, count)  # of the first episodes
    assert len(set(left)) > 3
    action = np.zeros((count, 1), np.float32)
    for step in range(1, 3 * limit):
        truncated = worlds.step(action)[3]
        np.testing.assert_array_equal(truncated, (step >= left) & ((step - left) % limit == 0))


def test_staggering_makes_no_episode_longer() -> None:
    worlds = PendulumVectorEnv(8, max_episode_steps=10, autoreset_mode=AutoresetMode.SAME_STEP)
    worlds.reset(seed=0)
    action = np.zeros((8, 1), np.float32)
    for _ in range(7):
        worlds.step(action)
    worlds.stagger(np.random.default_rng(1))
    ended = np.zeros(8, bool)
    for _ in range(3):
        ended |= worlds.step(action)[3]
    assert ended.all()


def test_without_a_time_limit_nothing_can_be_staggered() -> None:
    worlds = PendulumVectorEnv(2, max_episode_steps=-1)
    worlds.reset(seed=0)
    with pytest.raises(ValueError, match="stagger: this environment has no time limit"):
        worlds.stagger(np.random.default_rng(0))
