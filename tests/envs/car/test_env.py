"""GCar-v0 as a Gymnasium environment."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from gsenv.envs import time_limit
from gsenv.envs.car import course, rules, scene
from gsenv.envs.car.env import CarEnv, CarTask, CarVectorEnv
from gsenv.envs.car.policy import drive, drive_steep
from gsenv.envs.core.policies import scripted_policy
from tests.envs.registered import terms_of
from tests.envs.stack.worlds import assert_equal

IDLE = np.zeros(2, np.float32)
FULL = np.ones(2, np.float32)


@pytest.fixture
def env() -> CarEnv:
    return CarEnv()


def play(env: CarEnv, actions: Any) -> list[Any]:
    """Everything that steps return, until the end of the episode."""
    log = []
    for action in actions:
        log.append(env.step(action))
        if log[-1][2]:
            break
    return log


def test_gymnasium_checker_has_no_complaint() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("gsenv:GCar-v0").unwrapped, skip_render_check=True)
        check_env(gymnasium.make("GCar-v0", render_mode="rgb_array", width=64, height=48).unwrapped)


def test_stable_baselines_checker_has_no_complaint() -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(gymnasium.make("GCar-v0").unwrapped, warn=True)


def test_version_is_registered_with_its_limit_and_passes_the_passive_checker() -> None:
    env = gymnasium.make("GCar-v0")
    env.reset(seed=0)
    steps = 0
    truncated = False
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        while not truncated:
            _, _, terminated, truncated, _ = env.step(IDLE)
            assert not terminated
            steps += 1
    assert steps == time_limit("GCar-v0")


def test_seeds_decide_the_course(env: CarEnv) -> None:
    def course() -> Any:
        return env.task.world.parameters.vertices["position"].copy()

    courses = []
    for seed in (0, 0, 1, None):
        env.reset(seed=seed)
        courses.append(course())
    np.testing.assert_array_equal(courses[0], courses[1])
    assert abs(courses[0] - courses[2]).max() > 0.3
    assert abs(courses[2] - courses[3]).max() > 0.3


def test_python_types_and_keys(env: CarEnv) -> None:
    _, info = env.reset(seed=0)
    observation, reward, terminated, truncated, step_info = env.step(IDLE)
    assert observation.dtype == np.float32
    assert (type(reward), type(terminated), type(truncated)) == (float, bool, bool)
    for given in (info, step_info):
        assert type(given["success"]) is bool
        assert type(given["distance"]) is float
        assert tuple(terms_of(given)) == tuple(term.name for term in CarTask.reward_terms)
    assert info.keys() == step_info.keys()


def test_every_observation_varies_and_stays_in_bounds() -> None:
    vector = CarVectorEnv(12, difficulty=0.8, max_episode_steps=400)
    observations, _ = vector.reset(seed=0)
    low, high = observations.min(0), observations.max(0)
    generator = np.random.default_rng(0)
    for k in range(500):
        actions = drive(observations)
        actions[4:8] = 1.0
        actions[8:] = generator.uniform(-1.0, 1.0, (4, 2)) if k % 100 < 50 else -1.0
        observations = vector.step(actions)[0]
        assert vector.observation_space.contains(observations)
        low, high = np.minimum(low, observations.min(0)), np.maximum(high, observations.max(0))
    names = [entry.name for entry in CarTask.observations]
    constant = [name for name, a, b in zip(names, low, high, strict=True) if not b - a > 0.05]
    assert not constant


def test_reward_is_the_sum_of_its_terms_and_each_term_occurs() -> None:
    vector = CarVectorEnv(30, difficulty=0.6)
    vector.reset(seed=0)
    seen: set[str] = set()
    for _ in range(900):
        actions = drive_steep(vector.task.observation)
        actions[15:] = 1.0
        _, rewards, _, _, infos = vector.step(actions)
        terms = terms_of(infos)
        total = sum(terms[term.name] for term in CarTask.reward_terms)
        # a world that begins anew has terms of 0
        np.testing.assert_array_equal(total, rewards)
        seen |= {term.name for term in CarTask.reward_terms if terms[term.name].any()}
        if len(seen) == len(CarTask.reward_terms):
            return
    assert seen == {term.name for term in CarTask.reward_terms}


@pytest.mark.parametrize(
    ("action", "complaint"),
    [([0, np.nan], "finite"), ([np.inf, 0], "finite"), ([0, 0, 0], "shape"), (0.0, "shape"), (["a", "b"], "numbers")],
)
def test_bad_actions_are_refused_and_change_nothing(env: CarEnv, action: Any, complaint: str) -> None:
    env.reset(seed=0)
    env.step(FULL)
    before = env.save()
    with pytest.raises(ValueError, match=complaint) as error:
        env.step(np.array(action))
    assert "\n" not in str(error.value)
    assert_equal(env.save(), before)


def test_actions_are_clipped_and_left_alone(env: CarEnv) -> None:
    env.reset(seed=0)
    action = np.array([7, -9], np.float32)
    wide = env.step(action)
    np.testing.assert_array_equal(action, np.array([7, -9], np.float32))
    env.reset(seed=0)
    assert_equal([wide], [env.step(np.array([1, -1], np.float32))])


def test_step_needs_a_reset_before_an_episode(env: CarEnv) -> None:
    with pytest.raises(ResetNeeded):
        env.step(IDLE)
    env.reset(seed=0)
    env.task.world.set_pose("chassis", position=(scene.FINISH + 1.0, 5.0))
    assert env.step(IDLE)[2]


@pytest.mark.parametrize("value", [-0.1, 1.1, np.nan, "hard", None, True, [0.5]])
def test_bad_difficulties_are_refused_and_change_nothing(env: CarEnv, value: Any) -> None:
    env.reset(seed=0)
    before = env.save()
    for refused in (
        lambda: env.reset(options={"difficulty": value}),
        lambda: CarEnv(difficulty=value),
        lambda: setattr(env, "difficulty", value),
    ):
        with pytest.raises(ValueError, match="difficulty must be a number from 0 to 1"):
            refused()
    assert_equal(env.save(), before)


@pytest.mark.parametrize("way", ["save", "pickle", "deepcopy", "other env"])
def test_goes_on_bit_for_bit_amid_obstacles(way: str) -> None:
    env = CarEnv(difficulty=1.0, diagnostics=True)
    observation, _ = env.reset(seed=3)
    while observation[0] > 0.8:  # beyond the first obstacle
        observation = env.step(drive(observation))[0]
    actions = np.random.default_rng(0).uniform(-0.5, 1.0, (150, 2)).astype(np.float32)
    saved = env.save()
    if way == "pickle":
        other = pickle.loads(pickle.dumps(env))
    elif way == "deepcopy":
        other = copy.deepcopy(env)
    else:
        other = env if way == "save" else CarEnv(diagnostics=True)
    expected = [*play(env, actions), env.reset()]
    if way in ("save", "other env"):
        other.restore(saved)
    assert_equal([*play(other, actions), other.reset()], expected)


def test_scripted_driver_of_a_single_env_gives_legal_actions(env: CarEnv) -> None:
    policy = scripted_policy("gsenv:GCar-v0")
    env.reset(seed=0)
    for _ in range(60):
        action = policy(env)
        assert env.action_space.contains(action)
        env.step(action)


def test_captions_are_where_no_gate_is() -> None:
    env = CarEnv(difficulty=1.0, render_mode="rgb_array")
    env.reset(seed=3)
    env.task.task_state["gaze"][0] = (21.69, 2.91)  # on the way down from a bridge: its gate is high up on the left
    frame: Any = env.render()
    assert env._painter._renderer is not None
    plain = env._painter._renderer.render(0)
    written = (frame != plain).any(axis=2)
    bar = (plain[..., 0] > 150) & (plain[..., 1] < 80) & (plain[..., 2] < 80)
    assert written.sum() > 1000
    assert bar[:60, :60].any()
    assert not (written & bar).any()


def ground_of(env: CarEnv) -> Any:
    """Return the vertices (vertex, 2) of the ground, m."""
    return env.task.world.parameters.vertices["position"][0, : scene.VERTICES]


@pytest.mark.parametrize("difficulty", [0.3, 1.0])
def test_wedges_stand_on_the_ground_below_their_hinges(difficulty: float) -> None:
    env = CarEnv(difficulty=difficulty)
    found = 0
    for seed in range(6):
        env.reset(seed=seed)
        world = env.task.world
        shapes, bodies, parameters = world.model.shapes, world.state.bodies, world.parameters
        for k in range(scene.SEESAWS):
            body = scene.FIRST_FULCRUM + k
            if not parameters.bodies["enabled"][0, body]:
                continue
            found += 1
            (shape,) = np.flatnonzero(shapes["body"] == body)
            first = shapes["vertex_first"][shape]
            corners = parameters.vertices["position"][0, first : first + 3]
            corners = corners + bodies["position"][0, body] - parameters.bodies["center"][0, body]
            low, high = np.sort(corners[:, 1])[[1, 2]]
            ground = np.interp(corners[:, 0], *ground_of(env).T)
            assert np.sort(corners[:, 1] - ground)[:2] == pytest.approx(0.0, abs=1e-9)
            assert 0.3 < high - low < 1.0
            width = np.ptp(corners[:, 0])
            assert width == pytest.approx(0.6 * (high - low))  # the sides are as steep as ever
    assert found >= 3


def test_render() -> None:
    env = gymnasium.make("GCar-v0", render_mode="rgb_array", width=320, height=240)
    env.reset(seed=0)
    before = env.unwrapped.save()  # type: ignore[attr-defined]
    frame: Any = env.render()
    assert frame.shape == (240, 320, 3)
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 50
    assert_equal(env.unwrapped.save(), before)  # type: ignore[attr-defined]
    for _ in range(20):
        env.step(FULL)
    assert (env.render() != frame).mean() > 0.05


@pytest.mark.parametrize("heading", [
    "Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End",
    "Arguments", "Version History",
])  # fmt: skip
def test_docstring_is_the_specification(heading: str) -> None:
    doc = CarEnv.__doc__
    assert doc is not None
    assert f"## {heading}\n" in doc
    assert "{" not in doc.replace('{"difficulty": d}', "")
    for entry in (*CarTask.actions, *CarTask.observations):
        assert f"| {entry.name} " in doc
    named: Any
    for named in (*CarTask.reward_terms, *CarTask.quantities, *CarTask.arguments):
        assert f"| {named.name} " in doc


@pytest.mark.parametrize(
    "text",
    [
        f"a car of {scene.CHASSIS_MASS + 2 * scene.WHEEL_MASS:g} kg",
        f"crosses {scene.FINISH:g} m of hills",
        f"never exceed {np.degrees(np.arctan(course.STEEPEST)):.0f} degrees",
        f"from {1 / course.OFTEN:g} on there are all six",
        f"its torque, {scene.TORQUE:g} N m, up to {scene.TOP_SPEED:g} rad/s ({scene.TOP_SPEED * scene.RADIUS:g} m/s)",
        f"faster than {rules.REVERSE_BELOW:g} m/s",
        f"that fraction of {scene.BRAKE_TORQUE:g} N m",
        f"up to {scene.REVERSE_SPEED:g} rad/s ({scene.REVERSE_SPEED * scene.RADIUS:g} m/s)",
        f"GCar-v0 has {CarTask.arguments[0].default:g} and {time_limit('GCar-v0')} steps",
        f"GCar-hardcore-v0 has 1 and {time_limit('GCar-hardcore-v0')} steps",
        f"exceeds {rules.SHOCK_LIMIT:g} g ({rules.SHOCK_LIMIT * rules.G:g} m/s^2",
        f"the {2 * scene.GATE_HALF:g} m below the bar",
        f"after {time_limit('GCar-v0')} steps",
        "({:g} to {:g}, {:g} to {:g} and {:g} to {:g} m)".format(*np.ravel(course.HILLS)),
        f"the hills begin at {course.FLAT_START:g} m",
        f"for {rules.ROOF_STEPS / 30:g} s",
        f"`Box(low, high, ({len(CarTask.observations)},), float32)`",
    ],
)
def test_docstring_agrees_with_the_constants(text: str) -> None:
    assert text in " ".join((CarEnv.__doc__ or "").split())
