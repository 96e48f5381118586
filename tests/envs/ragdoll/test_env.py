"""GRagdoll-v0: interface, seeds, continuation."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from numpy.testing import assert_allclose

from gsenv.envs.ragdoll import figure, scene
from gsenv.envs.ragdoll.env import RagdollEnv, RagdollTask, RagdollVectorEnv
from gsenv.envs.ragdoll.policy import balance
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.render.spatial.world_view import multiply, rotate
from tests.envs.registered import terms_of
from tests.envs.single_worlds import SingleWorlds, assert_info
from tests.envs.stack.worlds import assert_equal
from tests.envs.standing import STEPS

LIMIT = 50  # steps, so that episodes end in both ways


def lively_actions(seed: int, steps: int, count: int) -> Any:
    """Zeros, and random actions in every second world."""
    actions = np.zeros((steps, count, 21), np.float32)
    generator = np.random.default_rng(seed)
    actions[:, 1::2] = generator.uniform(-1.0, 1.0, actions[:, 1::2].shape)
    return actions


@pytest.mark.parametrize("env_id", ["GRagdoll-v0", "GRagdoll-hardcore-v0"])
def test_checkers_have_no_complaint(env_id: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(f"gsenv:{env_id}", render_mode="rgb_array", width=64, height=48).unwrapped)
        checker.check_env(gymnasium.make(env_id).unwrapped, warn=True)


def test_tiers_are_registered_with_600_steps_and_their_pushes() -> None:
    for env_id, push in (("GRagdoll-v0", 0.6), ("GRagdoll-hardcore-v0", 1.0)):
        assert gymnasium.spec(env_id).max_episode_steps == STEPS
        assert gymnasium.make(env_id).unwrapped.push == push  # type: ignore[attr-defined]
        vector: Any = gymnasium.make_vec(env_id, num_envs=2)
        assert (vector.push, vector.max_episode_steps) == (push, 600)


def test_seeds_decide_start_and_pushes() -> None:
    env = RagdollEnv()
    seen = []
    for seed in (0, 0, 1, None):
        env.reset(seed=seed)
        state = env.task.task_state[0]
        plan = [state[name].copy() for name in ("pushes", "gaps", "headings")]
        seen.append((env.observation, *plan, env.task.physics.copy()))
    for one, same in zip(seen[0], seen[1], strict=True):
        np.testing.assert_array_equal(one, same)
    for first, second in ((0, 2), (2, 3)):
        for one, other in zip(seen[first], seen[second], strict=True):
            assert (one != other).any()


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize(("count", "threads"), [(1, 1), (4, 2)])
def test_equals_single_environments(mode: AutoresetMode, count: int, threads: int) -> None:
    given: dict[str, Any] = {"push": 1.0, "diagnostics": True}
    vector = RagdollVectorEnv(count, max_episode_steps=LIMIT, autoreset_mode=mode, threads=threads, **given)
    observations, infos = vector.reset(seed=40)
    singles = SingleWorlds(lambda: RagdollEnv(**given), count, mode, 40, LIMIT)
    for i, (observation, info) in enumerate(singles.resets):
        np.testing.assert_array_equal(observations[i], observation)
        assert_info(infos, info, i)
    ended = np.zeros(2, int)
    for actions in lively_actions(4, 160, count):
        observations, terminated, truncated = singles.compare_step(vector, observations, actions)
        ended += terminated, truncated
    assert ended.sum() > 0


@pytest.mark.parametrize("way", ["save", "pickle", "deepcopy", "other env"])
def test_goes_on_bit_for_bit_amid_a_push(way: str) -> None:
    env = RagdollEnv(push=0.5)
    observation, info = env.reset(seed=3)
    while info["pushes"] == 0:
        observation, _, _, _, info = env.step(balance(observation))
    saved = env.save()
    if way == "pickle":
        other = pickle.loads(pickle.dumps(env))
    elif way == "deepcopy":
        other = copy.deepcopy(env)
    else:
        other = env if way == "save" else RagdollEnv()

    def play(one: RagdollEnv) -> list[Any]:
        log: list[Any] = []
        for action in lively_actions(0, 20, 2)[:, 1]:
            log.append(one.step(action))
            if log[-1][2]:
                break
        return [*log, one.reset()]

    expected = play(env)
    if way in ("save", "other env"):
        other.restore(saved)
    assert_equal(play(other), expected)


def test_every_observation_varies_and_stays_in_bounds() -> None:
    vector = RagdollVectorEnv(12, push=1.0, max_episode_steps=200)
    observations, _ = vector.reset(seed=0)
    low, high = observations.min(0), observations.max(0)
    generator = np.random.default_rng(0)
    for _ in range(200):
        actions = balance(observations)
        actions[6:] = generator.uniform(-1.0, 1.0, (6, 21))
        observations = vector.step(actions)[0]
        assert vector.observation_space.contains(observations)
        low, high = np.minimum(low, observations.min(0)), np.maximum(high, observations.max(0))
    names = [entry.name for entry in RagdollTask.observations]
    assert not [name for name, a, b in zip(names, low, high, strict=True) if not b - a > 0.05]


def test_reward_is_the_sum_of_its_terms_and_each_term_occurs() -> None:
    vector = RagdollVectorEnv(6, push=1.0)
    observations, _ = vector.reset(seed=0)
    seen: set[str] = set()
    for _ in range(100):
        observations, rewards, _, _, infos = vector.step(balance(observations))
        terms = terms_of(infos)
        np.testing.assert_array_equal(sum(terms[term.name] for term in RagdollTask.reward_terms), rewards)
        seen |= {term.name for term in RagdollTask.reward_terms if terms[term.name].any()}
    assert seen == {term.name for term in RagdollTask.reward_terms}


def test_randomisation_scales_masses_and_torques() -> None:
    vector = RagdollVectorEnv(100)
    vector.reset(seed=0)
    task: Any = vector.task
    world, physics = task.world, vector.physics
    nominal = world.model.nominal_bodies["mass"]
    masses = world.parameters.bodies["mass"]
    for name in ("left_thigh", "right_foot", "torso", "left_forearm"):
        body = world.model.body_names.index(name)
        quantity = "leg_mass" if name in scene.LEGS else "trunk_mass"
        np.testing.assert_allclose(masses[:, body] / nominal[body], physics[quantity], rtol=1e-12)
    np.testing.assert_allclose(task.task_state["mass"], masses.sum(1), rtol=1e-12)
    efforts = world.parameters.joints["spring_effort"][:, task.figure.joints]
    bounds = [axis.effort for axis in figure.AXES]
    np.testing.assert_allclose(efforts / bounds, np.tile(physics["strength"][:, None], 21), rtol=1e-12)


def test_an_arrow_shows_a_push_in_its_direction() -> None:
    env = RagdollEnv(push=1.0, render_mode="rgb_array", width=320, height=240)
    env.reset(seed=0)
    env.task.task_state["headings"] = 0.4
    body = env.task.world.model.body_names.index("arrow")
    arrow = env.task.world.state.bodies[0, body]
    for _ in range(200):
        task = env.task.task_state[0]
        assert (arrow["position"][2] > 0.0) == (task["steps"] > 0 and task["pushed"] < shared.SHOWN_STEPS)
        if arrow["position"][2] > 0.0:
            w, z = arrow["rotation"][[0, 3]]
            assert 2.0 * np.arctan2(z, w) == pytest.approx(0.4 if task["push"] > 0.0 else 0.4 + np.pi, abs=1e-9)
            break
        env.task.step(np.zeros((1, 21)))
    else:
        raise AssertionError("no push")
    frame: Any = env.render()
    assert frame.shape == (240, 320, 3)
    red = (frame[..., 0] > 120) & (frame[..., 1] < 70) & (frame[..., 2] < 80)
    assert red.sum() > 30


@pytest.mark.parametrize("heading", [0.4, 1.9, 3.0, 4.6])  # rad
@pytest.mark.parametrize("size", [0.1, 0.9])  # m/s
def test_the_arrow_touches_the_hips_and_its_shaft_shows_the_push(heading: float, size: float) -> None:
    env = RagdollEnv(push=1.0, render_mode="rgb_array", width=320, height=240)
    env.reset(seed=0)
    task: Any = env.task
    task.task_state["headings"] = heading
    task.task_state["pushes"] = size
    (arrow,) = task.decor(0)["arrows"]
    assert_allclose(arrow.tip, arrow.tail)
    while task.task_state["pushed"][0] > 1:
        task.step(np.zeros((1, 21)))
    (arrow,) = task.decor(0)["arrows"]
    span = arrow.tip - arrow.tail
    length = np.linalg.norm(span)
    assert_allclose(span / length, [np.cos(heading), np.sin(heading), 0.0], atol=1e-9)
    assert length - arrow.head[0] == pytest.approx(0.9 * size)
    assert arrow.head[0] < 0.7 * length
    pelvis = task.world.state.bodies[0, task.figure.parts["pelvis"]]
    shape = task.world.model.shape_names.index("seat")
    parameters = task.world.parameters
    local = parameters.shapes["local_position"][0, shape] - parameters.bodies["center"][0, task.figure.parts["pelvis"]]
    middle = pelvis["position"] + rotate(pelvis["rotation"], local)
    turn = multiply(pelvis["rotation"], parameters.shapes["local_rotation"][0, shape])
    axis, half = rotate(turn, np.array([0.0, 0.0, 1.0])), parameters.shapes["size"][0, shape, 2]
    to = arrow.tip - middle
    gap = np.linalg.norm(to - np.clip(to @ axis, -half, half) * axis) - parameters.shapes["radius"][0, shape]
    assert abs(gap) < 1e-3
    plain = env._painter.paint(task, 0)
    task.decor = lambda world: {}
    without = env._painter.paint(task, 0)
    redder = (plain[..., 0].astype(int) - plain[..., 2]) - (without[..., 0].astype(int) - without[..., 2]) > 20
    assert redder.sum() > 60  # px, from all sides, also from behind
