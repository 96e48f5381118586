"""GRagdoll2D-v0: interface, seeds, continuation, and the docstring as its specification."""

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

from gsenv.envs.ragdoll2d import rules, scene
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.env import RagdollEnv, RagdollHardcoreEnv, RagdollTask, RagdollVectorEnv
from gsenv.envs.ragdoll2d.policy import balance
from gsenv.envs.ragdoll2d.task import RANGES
from tests.envs.registered import terms_of
from tests.envs.single_worlds import SingleWorlds, assert_info
from tests.envs.stack.worlds import assert_equal
from tests.envs.standing import STEPS

LIMIT = 80  # steps, so that episodes end in both ways


def lively_actions(seed: int, steps: int, count: int) -> Any:
    """Zeros, and random actions in every third world."""
    actions = np.zeros((steps, count, 7), np.float32)
    generator = np.random.default_rng(seed)
    actions[:, 2::3] = generator.uniform(-0.4, 0.4, actions[:, 2::3].shape)
    return actions


@pytest.mark.parametrize("env_id", ["GRagdoll2D-v0", "GRagdoll2D-hardcore-v0"])
def test_checkers_have_no_complaint(env_id: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(f"gsenv:{env_id}", render_mode="rgb_array", width=64, height=48).unwrapped)
        checker.check_env(gymnasium.make(env_id).unwrapped, warn=True)


def test_tiers_are_registered_with_600_steps_and_a_threshold() -> None:
    for env_id, push in (("GRagdoll2D-v0", 0.6), ("GRagdoll2D-hardcore-v0", 1.0)):
        spec = gymnasium.spec(env_id)
        assert spec.max_episode_steps == STEPS
        assert spec.reward_threshold is not None
        assert gymnasium.make(env_id).unwrapped.push == push  # type: ignore[attr-defined]
        vector: Any = gymnasium.make_vec(env_id, num_envs=2)
        assert (vector.push, vector.max_episode_steps) == (push, 600)
    assert gymnasium.make("GRagdoll2D-v0", push=0.3).unwrapped.push == 0.3  # type: ignore[attr-defined]


def test_seeds_decide_start_and_pushes() -> None:
    env = RagdollEnv()
    seen = []
    for seed in (0, 0, 1, None):
        env.reset(seed=seed)
        state = env.task.task_state[0]
        seen.append((env.observation, state["pushes"].copy(), state["gaps"].copy(), env.task.physics.copy()))
    for one, same in zip(seen[0], seen[1], strict=True):
        np.testing.assert_array_equal(one, same)
    for first, second in ((0, 2), (2, 3)):
        for one, other in zip(seen[first], seen[second], strict=True):
            assert (one != other).any()


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize(("count", "threads"), [(1, 1), (5, 2)])
def test_equals_single_environments(mode: AutoresetMode, count: int, threads: int) -> None:
    given: dict[str, Any] = {"push": 1.0, "diagnostics": True}
    vector = RagdollVectorEnv(count, max_episode_steps=LIMIT, autoreset_mode=mode, threads=threads, **given)
    observations, infos = vector.reset(seed=40)
    singles = SingleWorlds(lambda: RagdollEnv(**given), count, mode, 40, LIMIT)
    for i, (observation, info) in enumerate(singles.resets):
        np.testing.assert_array_equal(observations[i], observation)
        assert_info(infos, info, i)
    ended = np.zeros(2, int)
    for actions in lively_actions(4, 250, count):
        observations, terminated, truncated = singles.compare_step(vector, observations, actions)
        ended += terminated, truncated
    assert ended[0] > 0


@pytest.mark.parametrize("way", ["save", "pickle", "deepcopy", "other env"])
def test_goes_on_bit_for_bit_amid_a_push(way: str) -> None:
    env = RagdollEnv(push=1.0)
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
        for action in lively_actions(0, 20, 3)[:, 2]:
            log.append(one.step(action))
            if log[-1][2]:
                break
        return [*log, one.reset()]

    expected = play(env)
    if way in ("save", "other env"):
        other.restore(saved)
    assert_equal(play(other), expected)


def test_every_observation_varies_and_stays_in_bounds() -> None:
    vector = RagdollVectorEnv(12, push=1.0, max_episode_steps=300)
    observations, _ = vector.reset(seed=0)
    low, high = observations.min(0), observations.max(0)
    generator = np.random.default_rng(0)
    for _ in range(300):
        actions = balance(observations)
        actions[8:] = generator.uniform(-1.0, 1.0, (4, 7))
        observations = vector.step(actions)[0]
        assert vector.observation_space.contains(observations)
        low, high = np.minimum(low, observations.min(0)), np.maximum(high, observations.max(0))
    names = [entry.name for entry in RagdollTask.observations]
    assert not [name for name, a, b in zip(names, low, high, strict=True) if not b - a > 0.05]


def test_reward_is_the_sum_of_its_terms_and_each_term_occurs() -> None:
    vector = RagdollVectorEnv(6, push=1.0)
    observations, _ = vector.reset(seed=0)
    seen: set[str] = set()
    for _ in range(200):
        actions = balance(observations)
        actions[3:] = 0.0
        observations, rewards, _, _, infos = vector.step(actions)
        terms = terms_of(infos)
        np.testing.assert_array_equal(sum(terms[term.name] for term in RagdollTask.reward_terms), rewards)
        seen |= {term.name for term in RagdollTask.reward_terms if terms[term.name].any()}
    assert seen == {term.name for term in RagdollTask.reward_terms}


@pytest.mark.parametrize("value", [-0.1, 3.1, np.nan, "hard", None, True, [0.5]])
def test_bad_pushes_are_refused_and_change_nothing(value: Any) -> None:
    env = RagdollEnv()
    env.reset(seed=0)
    before = env.save()
    for refused in (
        lambda: env.reset(options={"push": value}),
        lambda: RagdollEnv(push=value),
        lambda: setattr(env, "push", value),
    ):
        with pytest.raises(ValueError, match="push must be a speed from 0 to 3 m/s"):
            refused()
    assert_equal(env.save(), before)


def test_randomisation_stays_within_its_ranges_and_can_be_off() -> None:
    vector = RagdollVectorEnv(200)
    vector.reset(seed=0)
    for name, (low, high) in RANGES.items():
        values = vector.physics[name]
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < values.max() <= high
    masses = vector.task.world.parameters.bodies["mass"][:, scene.FIRST_PART :].sum(1)
    assert (np.abs(masses / scene.MASS - 1.0) < 0.15).all()
    np.testing.assert_allclose(vector.task.task_state["mass"], masses, rtol=1e-12)
    efforts = vector.task.world.parameters.joints["spring_effort"][:, :7] / [axis.effort for axis in scene.AXES]
    np.testing.assert_allclose(efforts, np.tile(vector.physics["strength"][:, None], 7), rtol=1e-12)
    plain = RagdollVectorEnv(3, randomize={})
    plain.reset(seed=0)
    np.testing.assert_array_equal(plain.task.physics, np.tile([q.nominal for q in RagdollTask.quantities], (3, 1)))


def test_an_arrow_shows_a_push_in_its_direction() -> None:
    env = RagdollEnv(push=1.0, render_mode="rgb_array", width=320, height=240)
    env.reset(seed=0)
    arrow = env.task.world.state.bodies[0, scene.ARROW_BODY]
    for _ in range(200):
        task = env.task.task_state[0]
        assert (arrow["position"][1] > 0.0) == (task["steps"] > 0 and task["pushed"] < shared.SHOWN_STEPS)
        if arrow["position"][1] > 0.0:
            assert np.sign(arrow["rotation"][0]) == np.sign(task["push"])
            break
        env.task.step(np.zeros((1, 7)))
    else:
        raise AssertionError("no push")
    frame: Any = env.render()
    assert frame.shape == (240, 320, 3)
    red = (frame[..., 0] > 180) & (frame[..., 1] < 80) & (frame[..., 2] < 90)
    assert red.sum() > 30


def test_python_types_and_keys() -> None:
    env = RagdollHardcoreEnv()
    _, info = env.reset(seed=0)
    _, reward, terminated, truncated, step_info = env.step(np.zeros(7, np.float32))
    assert (type(reward), type(terminated), type(truncated)) == (float, bool, bool)
    for given in (info, step_info):
        assert [type(given[name]) for name in ("success", "fell", "time", "pushes")] == [bool, bool, float, int]
    assert info.keys() == step_info.keys()


@pytest.mark.parametrize("heading", [
    "Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End",
    "Arguments", "Version History",
])  # fmt: skip
def test_docstring_is_the_specification(heading: str) -> None:
    doc = RagdollEnv.__doc__
    assert doc is not None
    assert f"## {heading}\n" in doc
    for entry in (*RagdollTask.actions, *RagdollTask.observations):
        assert f"| {entry.name} " in doc
    names = [term.name for term in RagdollTask.reward_terms] + [one.name for one in RagdollTask.quantities]
    for name in (*names, *(setting.name for setting in RagdollTask.arguments)):
        assert f"| {name} " in doc


@pytest.mark.parametrize(
    "text",
    [
        f"a person of {scene.HEIGHT:g} m and {scene.MASS:g} kg",
        f"every {shared.FEWEST_GAP / 30:g} to {shared.MOST_GAP / 30:g} s",
        f"{scene.REACH:g} of half the joint's range",
        f"`Box(low, high, ({len(RagdollTask.observations)},), float32)`",
        f"within {rules.START_ANGLE:g} rad of the stand",
        f"with up to {rules.START_SPEED:g} m/s",
        f"comes after {shared.FIRST_GAP / 30:g} to {shared.MOST_GAP / 30:g} s",
        f"lasts {shared.PUSH_STEPS / 30:g} s",
        f"below {shared.FALL_HEIGHT:g} of its height",
        f"more than {shared.FALL_TILT:g} rad",
        f"more than {rules.APART:g} m apart for {rules.MOST_APART:g} s",
        f"after {STEPS} steps ({STEPS / 30:g} s)",
        str(RANGES["friction"]),
    ],
)
def test_docstring_agrees_with_the_constants(text: str) -> None:
    assert text in " ".join((RagdollEnv.__doc__ or "").split())
