"""GStack-v0 as a Gymnasium environment."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

import gsenv
from gsenv.envs.stack.env import StackEnv, StackTask
from gsenv.envs.stack.policy import build_tower
from tests.envs.registered import terms_of
from tests.envs.stack.worlds import IDLE, RELEASE, assert_equal, mixed_actions

ROOT = Path(__file__).parents[3]


@pytest.fixture
def env() -> StackEnv:
    return StackEnv()


def play(env: StackEnv, actions: Any) -> list[Any]:
    """Everything that steps return, until the end of the episode."""
    log = []
    for action in actions:
        result = env.step(action)
        log.append(result)
        if result[2]:
            break
    return log


@pytest.mark.parametrize("make", ["gym.make", "class"])
def test_gymnasium_checker_has_no_complaint(make: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = gymnasium.make("gsenv:GStack-v0").unwrapped if make == "gym.make" else StackEnv()
        check_env(made, skip_render_check=True)


def test_stable_baselines_checker_has_no_complaint() -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(gymnasium.make("GStack-v0").unwrapped, warn=True)


def test_version_is_registered_with_600_steps() -> None:
    assert gsenv.__version__
    env = gymnasium.make("GStack-v0")
    env.reset(seed=0)
    steps = 0
    truncated = False
    while not truncated:
        _, _, terminated, truncated, _ = env.step(IDLE)
        assert not terminated
        steps += 1
    assert steps == 600


def test_seeds_decide_the_start(env: StackEnv) -> None:
    starts = [env.reset(seed=seed)[0] for seed in (0, 0, 1)]
    np.testing.assert_array_equal(starts[0], starts[1])
    assert (starts[0] != starts[2]).sum() > 5
    again = env.reset()[0]
    assert (again != starts[2]).any()


def test_blocks_differ_from_one_another_and_from_seed_to_seed(env: StackEnv) -> None:
    masses = []
    for seed in range(20):
        env.reset(seed=seed)
        masses.append(env.task.world.parameters.mass[0, 4:].copy())
    values = np.array(masses)
    assert (values.std(axis=0) > 1.0).all()
    assert (values.std(axis=1) > 1.0).all()
    assert values.min() > 1.9
    assert values.max() < 16.9


def test_equal_seeds_give_equal_blocks_for_any_number_of_them(env: StackEnv) -> None:
    env.reset(seed=3)
    five = env.task.world.parameters.shapes["size"].copy()
    env.reset(seed=3, options={"blocks": 2})
    np.testing.assert_array_equal(five, env.task.world.parameters.shapes["size"])


def test_python_types(env: StackEnv) -> None:
    _, info = env.reset(seed=0)
    observation, reward, terminated, truncated, step_info = env.step(IDLE)
    assert observation.dtype == np.float32
    assert type(reward) is float
    assert type(terminated) is bool
    assert type(truncated) is bool
    for given in (info, step_info):
        assert type(given["success"]) is bool
        assert type(given["is_success"]) is bool
        assert type(given["placed"]) is int
        assert {type(value) for value in terms_of(given).values()} == {float}


def test_reset_and_step_infos_have_the_same_keys(env: StackEnv) -> None:
    _, info = env.reset(seed=0)
    step_info = env.step(IDLE)[4]
    assert info.keys() == step_info.keys()
    assert tuple(terms_of(info)) == tuple(term.name for term in StackTask.reward_terms)


def test_results_are_fresh(env: StackEnv) -> None:
    first, info = env.reset(seed=0)
    kept, kept_info = first.copy(), copy.deepcopy(info)
    second = env.step(np.ones(4, np.float32))[0]
    second_kept = second.copy()
    env.step(IDLE)
    np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(second, second_kept)
    assert info == kept_info


def test_reward_is_the_sum_of_its_terms(env: StackEnv) -> None:
    seen: set[str] = set()
    for seed, policy in ((0, "random"), (1, "random"), (0, "builder")):
        crack_speed = 100.0 if seed == 1 else 0.4  # a block that does not crack falls
        observation, _ = env.reset(seed=seed, options={"blocks": 2, "crack_speed": crack_speed})
        for action in mixed_actions(seed, (300,)):
            if policy == "builder":
                action = build_tower(observation)
            observation, reward, terminated, _, info = env.step(action)
            assert sum(terms_of(info).values()) == reward
            seen |= {name for name, value in terms_of(info).items() if value}
            if terminated:
                break
    assert seen == {term.name for term in StackTask.reward_terms}


def test_observations_stay_in_bounds_and_every_entry_varies(env: StackEnv) -> None:
    low = np.full(32, np.inf)
    high = -low
    for seed in range(15):
        observation, _ = env.reset(seed=seed, options={"crack_speed": 100.0})
        for action in mixed_actions(seed, (600,)):
            assert env.observation_space.contains(observation)
            low, high = np.minimum(low, observation), np.maximum(high, observation)
            observation, _, terminated, _, _ = env.step(action)
            if terminated:
                assert env.observation_space.contains(observation)
                break
    names = [entry.name for entry in StackTask.observations]
    constant = [name for name, a, b in zip(names, low, high, strict=True) if not b - a > 1e-4]
    assert not constant


@pytest.mark.parametrize(
    ("action", "complaint"),
    [
        ([0, np.nan, 0, 0], "finite"),
        ([0, np.inf, 0, 0], "finite"),
        ([0, 0, 0], "shape"),
        ([[0, 0, 0, 0]], "shape"),
        (0.0, "shape"),
        (["a", "b", "c", "d"], "numbers"),
    ],
)
def test_bad_actions_are_refused_and_change_nothing(env: StackEnv, action: Any, complaint: str) -> None:
    env.reset(seed=0)
    env.step(IDLE)
    before = env.save()
    with pytest.raises(ValueError, match=complaint) as error:
        env.step(np.array(action))
    assert "\n" not in str(error.value)
    assert_equal(env.save(), before)


def test_actions_are_clipped_and_left_alone(env: StackEnv) -> None:
    env.reset(seed=0)
    action = np.array([7, -9, 0.5, -3], np.float32)
    given = action.copy()
    wide = env.step(action)
    np.testing.assert_array_equal(action, given)
    env.reset(seed=0)
    assert_equal([wide], [env.step(np.array([1, -1, 0.5, -1], np.float32))])


def test_float64_and_lists_do_as_actions(env: StackEnv) -> None:
    env.reset(seed=0)
    first = env.step(np.array([0.25, 0, 0, -1]))
    env.reset(seed=0)
    assert_equal([first], [env.step([0.25, 0, 0, -1])])  # type: ignore[arg-type]


def test_step_needs_a_reset_before_an_episode(env: StackEnv) -> None:
    with pytest.raises(ResetNeeded):
        env.step(IDLE)
    env.reset(seed=0)
    results = play(env, [*[np.array([1, 1, 0, -1], np.float32)] * 60, *[RELEASE] * 60])
    if not results[-1][2]:
        env.task.world.set_pose("block_0", angle=1.5)
        assert env.step(IDLE)[2]


@pytest.mark.parametrize("options", [{"blocks": 0}, {"blocks": 9}, {"blocks": 2.5}, {"bloks": 3}])
def test_bad_options_are_refused(env: StackEnv, options: dict[str, Any]) -> None:
    env.reset(seed=0)
    before = env.save()
    with pytest.raises(ValueError, match="blo"):
        env.reset(options=options)
    assert_equal(env.save(), before)


@pytest.mark.parametrize("arguments", [
    {"blocks": 0}, {"blocks": True}, {"width": 15}, {"height": 0}, {"render_mode": "ascii"},
])  # fmt: skip
def test_bad_arguments_are_refused(arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(arguments))):
        StackEnv(**arguments)


def test_blocks_option_holds_for_one_episode(env: StackEnv) -> None:
    def to_go(observation: Any) -> float:
        names = [entry.name for entry in StackTask.observations]
        return round(float(observation[names.index("to_go")]) * 8)

    assert to_go(env.reset(seed=0, options={"blocks": 8})[0]) == 8
    assert to_go(env.reset()[0]) == 5
    env.blocks = 2
    assert to_go(env.reset()[0]) == 2


# ---------------------------------------------------------------- snapshots


def at_contact() -> tuple[StackEnv, Any]:
    """An environment in the middle of an episode, its second block just on the first."""
    env = StackEnv()
    observation, _ = env.reset(seed=5)
    while not (observation[11] < 0.02 and env.task.task_state["arrived"][0] == 2):
        observation = env.step(build_tower(observation))[0]
    return env, mixed_actions(9, (150,)) * np.float32(0.7)


@pytest.mark.parametrize("way", ["save", "pickle", "deepcopy", "other env"])
def test_goes_on_bit_for_bit(way: str) -> None:
    env, actions = at_contact()
    if way == "save":
        saved = env.save()
        expected = [*play(env, actions), env.reset()]
        env.restore(saved)
        other = env
    else:
        if way == "pickle":
            other = pickle.loads(pickle.dumps(env))
        elif way == "deepcopy":
            other = copy.deepcopy(env)
        else:
            other = StackEnv()
            other.reset(seed=77)
            other.restore(env.save())
        expected = [*play(env, actions), env.reset()]
    assert_equal(expected, [*play(other, actions), other.reset()])


def test_goes_on_bit_for_bit_in_another_process(tmp_path: Path) -> None:
    env, actions = at_contact()
    (tmp_path / "env").write_bytes(pickle.dumps((env, actions)))
    code = (
        "import pickle, sys, hashlib; from pathlib import Path\n"
        "env, actions = pickle.loads(Path(sys.argv[1]).read_bytes())\n"
        "from tests.envs.stack.test_env import play\n"
        "print(hashlib.sha256(pickle.dumps(play(env, actions)[-1])).hexdigest())"
    )
    import hashlib

    expected = hashlib.sha256(pickle.dumps(play(env, actions)[-1])).hexdigest()
    command = [sys.executable, "-c", code, str(tmp_path / "env")]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == expected


def test_wrapped_env_pickles() -> None:
    env = gymnasium.make("GStack-v0")
    env.reset(seed=0)
    other = pickle.loads(pickle.dumps(env))
    assert_equal([env.step(IDLE)], [other.step(IDLE)])


# ---------------------------------------------------------------- pictures


def test_render() -> None:
    env = gymnasium.make("GStack-v0", render_mode="rgb_array", width=320, height=240)
    env.reset(seed=0)
    before = env.unwrapped.save()  # type: ignore[attr-defined]
    frame: Any = env.render()
    assert frame.shape == (240, 320, 3)
    assert frame.dtype == np.uint8
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 50
    assert_equal(env.unwrapped.save(), before)  # type: ignore[attr-defined]
    env.step(np.ones(4, np.float32))
    assert (env.render() != frame).any()


def test_render_without_a_mode_warns(env: StackEnv) -> None:
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="render_mode"):
        assert env.render() is None
