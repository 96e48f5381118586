"""tower_v0 as a PettingZoo environment."""

from __future__ import annotations

import copy
import pickle
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

pettingzoo = pytest.importorskip("pettingzoo")

import pettingzoo.test as zoo  # noqa: E402

from gsenv.envs import PARALLEL_ENVS, register_envs, register_parallel_envs, tower_hardcore_v0, tower_v0  # noqa: E402
from gsenv.envs.core.policies import make_batch  # noqa: E402
from gsenv.envs.stack import scene as stack  # noqa: E402
from gsenv.envs.stack import shared_rules as parts  # noqa: E402
from gsenv.envs.stack.settings import HARDCORE_BLOCKS  # noqa: E402
from gsenv.envs.tower import rules, scene  # noqa: E402
from gsenv.envs.tower.env import TowerTask  # noqa: E402
from gsenv.envs.tower.policy import build_together  # noqa: E402
from tests.envs.registered import terms_of  # noqa: E402
from tests.envs.stack.worlds import IDLE, RELEASE, assert_equal, mixed_actions  # noqa: E402

ROOT = Path(__file__).parent.parent.parent
AGENTS = ["gripper_0", "gripper_1"]
IDLE_BOTH = dict.fromkeys(AGENTS, IDLE)


@pytest.fixture
def env() -> tower_v0.TowerParallelEnv:
    return tower_v0.parallel_env()


def each(actions: Any) -> dict[str, Any]:
    return dict(zip(AGENTS, actions, strict=True))


def play(env: tower_v0.TowerParallelEnv, steps: int, seed: int = 0) -> list[Any]:
    """Everything that steps return, until the end of the episode: random actions that hold on for a while."""
    log = []
    for actions in mixed_actions(seed, (steps, 2)):
        log.append(env.step(each(actions)))
        if not env.agents:
            break
    return log


# ---------------------------------------------------------------- PettingZoo's own tests


@pytest.mark.parametrize("make", [tower_v0.env, tower_v0.raw_env])
@pytest.mark.filterwarnings("error::UserWarning")
def test_api(make: Any) -> None:
    zoo.api_test(make(), num_cycles=300)


@pytest.mark.filterwarnings("error::UserWarning")
def test_parallel_api() -> None:
    zoo.parallel_api_test(tower_v0.parallel_env(), num_cycles=300)


def test_seed() -> None:
    zoo.seed_test(tower_v0.env, num_cycles=100)


def test_parallel_seed() -> None:
    zoo.parallel_seed_test(tower_v0.parallel_env, num_cycles=100)


def test_max_cycles() -> None:
    zoo.max_cycles_test(tower_v0)


def test_render() -> None:
    pytest.importorskip("pygame")  # the test insists on the mode "human"
    zoo.render_test(tower_v0.env)


@pytest.mark.filterwarnings("error::UserWarning")
def test_state() -> None:
    zoo.state_test(tower_v0.env(), tower_v0.parallel_env())


def test_save_obs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pygame")
    monkeypatch.chdir(tmp_path)
    zoo.test_save_obs(tower_v0.env(observation="pixels"))
    assert len(list(tmp_path.rglob("*.png"))) == 2


def test_performance_benchmark(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    module = sys.modules[zoo.performance_benchmark.__module__]  # the function hides it by its name

    class Clock:  # the benchmark runs for five seconds of it
        now = 0.0

        @classmethod
        def time(cls) -> float:
            cls.now += 0.1
            return cls.now

    monkeypatch.setattr(module, "time", Clock)
    zoo.performance_benchmark(tower_v0.env())
    assert "cycles per second" in capsys.readouterr().out


# ---------------------------------------------------------------- module and registry


@pytest.mark.skipif(not hasattr(pettingzoo, "make"), reason="PettingZoo's registry came with 1.27")
def test_registry(recwarn: pytest.WarningsRecorder) -> None:
    assert [entry.name for entry in PARALLEL_ENVS] == ["tower_v0", "tower_hardcore_v0"]
    made = pettingzoo.make("parallel", "gsenv/tower_v0")
    assert isinstance(made, tower_v0.TowerParallelEnv)
    assert made.max_cycles == 900
    assert pettingzoo.make("parallel", "gsenv/tower_v0", max_cycles=-1, blocks=2).max_cycles == 900
    assert pettingzoo.make("aec", "gsenv/tower_v0", max_cycles=5).unwrapped.max_cycles == 5
    register_parallel_envs()
    register_envs()
    assert not [w for w in recwarn if "Overriding" in str(w.message)]


def test_the_hardcore_tier_is_the_same_with_other_defaults() -> None:
    zoo.parallel_api_test(tower_hardcore_v0.parallel_env(), num_cycles=100)
    zoo.api_test(tower_hardcore_v0.env(), num_cycles=100)
    hard = tower_hardcore_v0.parallel_env()
    assert str(hard) == str(tower_hardcore_v0.env()) == "tower_hardcore_v0"
    assert (hard.blocks, hard.max_cycles) == (6, 900)
    same = tower_v0.parallel_env(blocks=6, **HARDCORE_BLOCKS)
    assert_equal(hard.reset(seed=4), same.reset(seed=4))
    assert_equal(play(hard, 200), play(same, 200))
    batch = make_batch("tower_hardcore_v0", 2)
    observations, _ = batch.reset(seed=4)
    for agent, own in zip(AGENTS, observations[0], strict=True):
        np.testing.assert_array_equal(own, hard.reset(seed=4)[0][agent])


@pytest.mark.parametrize("first", ["pettingzoo, gsenv", "gsenv.envs.tower_v0, pettingzoo"])
@pytest.mark.skipif(not hasattr(pettingzoo, "make"), reason="PettingZoo's registry came with 1.27")
def test_name_is_known_after_the_import(first: str) -> None:
    code = f"import {first}; print(pettingzoo.spec('parallel', 'gsenv/tower_v0').max_cycles)"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert result.stdout.split() == ["900"], result.stderr


def test_metadata_and_agents(env: tower_v0.TowerParallelEnv) -> None:
    assert env.metadata["name"] == str(env) == str(tower_v0.env()) == "tower_v0"
    assert env.metadata["is_parallelizable"] is True
    assert env.metadata["render_fps"] == 30
    assert env.possible_agents == AGENTS
    for agent in AGENTS:
        assert env.observation_space(agent) is env.observation_space(agent)
        assert env.action_space(agent) is env.action_space(agent)
    assert env.observation_space(AGENTS[0]) == env.observation_space(AGENTS[1])
    assert env.observation_space(AGENTS[0]).shape == (45,)


# ---------------------------------------------------------------- episodes


def test_seeds_decide_the_start(env: tower_v0.TowerParallelEnv) -> None:
    starts = [env.reset(seed=seed)[0][AGENTS[0]] for seed in (0, 0, 1)]
    np.testing.assert_array_equal(starts[0], starts[1])
    assert (starts[0] != starts[2]).sum() > 5
    assert (env.reset()[0][AGENTS[0]] != starts[2]).any()


def test_equal_seeds_give_equal_blocks_for_any_number_of_them(env: tower_v0.TowerParallelEnv) -> None:
    env.reset(seed=3)
    four = env.task.world.parameters.shapes["size"].copy()
    env.reset(seed=3, options={"blocks": 8})
    np.testing.assert_array_equal(four, env.task.world.parameters.shapes["size"])


def test_types_keys_and_sums(env: tower_v0.TowerParallelEnv) -> None:
    observations, infos = env.reset(seed=0)
    results: Any = env.step(each(mixed_actions(0, (2,))))
    assert all(list(given) == AGENTS for given in (observations, infos, *results))
    for agent in AGENTS:
        observation, reward, terminated, truncated, info = (given[agent] for given in results)
        assert env.observation_space(agent).contains(observation)
        assert [type(value) for value in (reward, terminated, truncated)] == [float, bool, bool]
        assert tuple(terms_of(info)) == tuple(term.name for term in TowerTask.reward_terms)
        assert sum(terms_of(info).values()) == reward
        assert infos[agent].keys() == info.keys()
        assert type(info["bump"]) is type(info["is_success"]) is bool
    assert results[1][AGENTS[0]] != results[1][AGENTS[1]]
    assert results[4][AGENTS[0]] is not results[4][AGENTS[1]]


def test_results_are_fresh(env: tower_v0.TowerParallelEnv) -> None:
    first, infos = env.reset(seed=0)
    kept, kept_infos, state = copy.deepcopy(first), copy.deepcopy(infos), env.state()
    env.step(each(np.ones((2, 4), np.float32)))
    assert data_equivalence(first, kept)
    assert infos == kept_infos
    assert (env.state() != state).any()


def test_state_is_both_observations(env: tower_v0.TowerParallelEnv) -> None:
    observations, _ = env.reset(seed=0)
    np.testing.assert_array_equal(env.state(), np.concatenate([observations[agent] for agent in AGENTS]))
    assert env.state_space.contains(env.state())


def test_truncation_ends_both(env: tower_v0.TowerParallelEnv) -> None:
    env.reset(seed=0)
    for step in range(900):
        assert env.agents == AGENTS
        _, _, terminated, truncated, _ = env.step(IDLE_BOTH)
        assert not any(terminated.values())
        assert truncated == dict.fromkeys(AGENTS, step == 899)
    assert env.agents == []
    with pytest.warns(UserWarning, match="the episode is over"):
        assert env.step(IDLE_BOTH) == ({}, {}, {}, {}, {})


def test_termination_ends_both_and_is_no_truncation() -> None:
    env = tower_v0.parallel_env(max_cycles=-1)
    env.reset(seed=0)
    env.step({AGENTS[0]: RELEASE, AGENTS[1]: IDLE})
    for _ in range(100):
        _, _, terminated, truncated, infos = env.step(IDLE_BOTH)
        if not env.agents:
            break
    assert terminated == dict.fromkeys(AGENTS, True)
    assert truncated == dict.fromkeys(AGENTS, False)
    assert infos[AGENTS[1]]["reward_crack"] == -0.2
    assert not infos[AGENTS[1]]["success"]


def test_aec_goes_through_the_same_states(env: tower_v0.TowerParallelEnv) -> None:
    turns = tower_v0.env()
    turns.reset(seed=2)
    env.reset(seed=2)
    for actions in mixed_actions(2, (8, 2)):
        observations, rewards, *_ = env.step(each(actions))
        for a, agent in enumerate(AGENTS):
            assert turns.agent_selection == agent
            turns.step(actions[a])
        for agent in AGENTS:
            np.testing.assert_array_equal(turns.observe(agent), observations[agent])
        assert turns.rewards == rewards


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (None, "'gripper_0' must be 4 numbers, got None"),
        ([0.0], r"'gripper_0' must have the shape \(4,\), got \(1,\)"),
        (list("abcd"), "'gripper_0' must be numbers, got"),
        ([0.0, 0.0, np.nan, 0.0], "'gripper_0' must be finite, got"),
        (np.full(4, 1e300), "'gripper_0' must be finite, got"),
    ],
)
def test_a_bad_action_is_refused_in_its_own_turn(action: Any, message: str) -> None:
    turns = tower_v0.env(blocks=2)
    turns.reset(seed=2)
    with pytest.raises(ValueError, match=message):
        turns.step(action)
    assert turns.agent_selection == AGENTS[0]
    for _ in range(4):
        turns.step([0.0, 0.0, 0.0, -1.0])  # a list is an action, too
    assert turns.unwrapped._elapsed == 2


def test_turns_of_ended_agents_take_none_alone() -> None:
    turns = tower_v0.env(max_cycles=1)
    turns.reset(seed=2)
    for _ in AGENTS:
        turns.step(np.zeros(4, np.float32))
    with pytest.raises(ValueError, match="the episode of 'gripper_0' is over, so its action must be None"):
        turns.step(np.zeros(4, np.float32))
    for _ in AGENTS:
        turns.step(None)
    assert turns.agents == []


def test_a_last_step_that_succeeds_is_no_truncation(env: tower_v0.TowerParallelEnv) -> None:
    env.reset(seed=0, options={"blocks": 2, "success_time": 0.1})
    steps = 0
    while env.agents:
        env.step(each(build_together(env.observations)))
        steps += 1
    again = tower_v0.parallel_env(max_cycles=steps, blocks=2, success_time=0.1)
    again.reset(seed=0)
    while again.agents:
        _, _, terminated, truncated, infos = again.step(each(build_together(again.observations)))
    assert infos[AGENTS[0]]["is_success"]
    assert (terminated[AGENTS[0]], truncated[AGENTS[0]]) == (True, False)


# ---------------------------------------------------------------- snapshots


@pytest.mark.parametrize("way", ["pickle", "deepcopy", "restore"])
def test_copies_go_on_bit_for_bit(way: str) -> None:
    env = tower_v0.parallel_env(blocks=6, randomize={"friction": (0.5, 1.5)}, diagnostics=True)
    env.reset(seed=5)
    for _ in range(150):
        env.step(each(build_together(env.observations)))
    if way == "restore":
        other = tower_v0.parallel_env(blocks=6, diagnostics=True)
        other.restore(pickle.loads(pickle.dumps(env.save())))
    else:
        other = copy.deepcopy(env) if way == "deepcopy" else pickle.loads(pickle.dumps(env))
    assert other.agents == AGENTS
    assert_equal(play(env, 200, seed=1), play(other, 200, seed=1))
    assert env.agents == other.agents
    if way != "restore":  # the ranges belong to the environment, not to its state
        assert_equal(env.reset(), other.reset())


# ---------------------------------------------------------------- pictures


def test_frames_show_both_grippers() -> None:
    env = tower_v0.parallel_env(render_mode="rgb_array", width=320, height=240)
    env.reset(seed=0)
    frame = env.render()
    assert frame is not None
    assert frame.shape == (240, 320, 3)
    for color, half in zip(scene.GRIPPER_COLORS, (frame[:, :160], frame[:, 160:]), strict=True):
        near = np.abs(half.astype(int) - np.array(color)).max(axis=2) < 30
        assert near.sum() > 20


def test_blocks_that_wait_are_within_the_picture() -> None:
    task = TowerTask(20)
    task.reset(np.arange(20), np.random.default_rng(0).random((20, task.reset_draws)), task.check_options({}))
    shapes = slice(scene.FIRST_BLOCK_SHAPE, scene.FIRST_BLOCK_SHAPE + 2)
    bodies = slice(scene.FIRST_BLOCK, scene.FIRST_BLOCK + 2)
    farthest = 0.0
    for k in range(120):
        turn = 1.0 if k < 60 else -1.0
        task.step(np.broadcast_to(np.array([-1.0, 0.0, turn, -1.0]), (20, 2, 4)))  # outwards
        state = task.world.state.bodies[:, bodies]
        half = np.abs(state["rotation"]) * task.world.parameters.shapes["size"][:, shapes]
        reach = np.abs(state["position"][..., 0]) + half.sum(axis=-1)
        farthest = max(farthest, float(reach.max()))
    corners = task.camera(0, 640, 480).to_pixel(np.array([[-farthest, 1.0], [farthest, 1.0]]), 640, 480)
    assert farthest > 2.5
    assert corners[0, 0] > 4.0
    assert corners[1, 0] < 636.0


def test_pixels_are_mirrored() -> None:
    env = tower_v0.parallel_env(observation="pixels")
    observations, _ = env.reset(seed=0)
    left, right = (observations[agent] for agent in AGENTS)
    assert env.observation_space(AGENTS[0]).contains(left)
    np.testing.assert_array_equal(left, right[:, ::-1])
    assert (left != right).any()


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"blocks": 3}, "blocks must be 2, 4, 6 or 8, got 3"),
        ({"blocks": True}, "blocks must be 2, 4, 6 or 8, got True"),
        ({"blocks": "many"}, "blocks must be 2, 4, 6 or 8, got 'many'"),
        ({"blocks": [2]}, r"blocks must be 2, 4, 6 or 8, got \[2\]"),
        ({"max_cycles": 0}, "max_cycles must be a positive whole number, None or -1 for no limit, got 0"),
        ({"max_cycles": "900"}, "max_cycles must be a positive whole number, None or -1 for no limit, got '900'"),
        ({"split": "all"}, r"split must be one of \['train', 'test'\], got 'all'"),
        ({"render_mode": "ansi"}, "render_mode must be one of"),
        ({"observation": "sound"}, "observation must be one of"),
        ({"fidelity": "best"}, "fidelity must be one of"),
        ({"randomize": {"wind": (0, 1)}}, "unknown quantity 'wind'"),
        ({"reward_weights": {"joy": 1.0}}, "unknown term 'joy'"),
        ({"width": 100_000}, "width must be 16 to 8192 px or None"),
    ],
)
def test_bad_arguments(kwargs: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        tower_v0.parallel_env(**kwargs)


def test_unknown_argument() -> None:
    with pytest.raises(
        TypeError,
        match=r"the environment got an unexpected keyword argument 'bloks'; its own are .*mean 'blocks'",
    ):
        tower_v0.parallel_env(bloks=2)


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ({"gripper_0": IDLE}, r"exactly the agents \['gripper_0', 'gripper_1'\], got \['gripper_0'\]"),
        ({**IDLE_BOTH, "robot": IDLE}, "exactly the agents"),
        ([IDLE, IDLE], "exactly the agents"),
        ({**IDLE_BOTH, "gripper_1": IDLE[:3]}, r"of 'gripper_1' must have the shape \(4,\), got \(3,\)"),
        ({**IDLE_BOTH, "gripper_0": IDLE * np.nan}, "actions must be finite"),
        ({**IDLE_BOTH, "gripper_0": ["a"] * 4}, "actions must be numbers"),
        ({**IDLE_BOTH, "gripper_0": None}, "of 'gripper_0' must be 4 numbers, got None"),
    ],
)
def test_bad_actions_change_nothing(env: tower_v0.TowerParallelEnv, actions: Any, message: str) -> None:
    env.reset(seed=0)
    before = env.save()
    with pytest.raises(ValueError, match=message):
        env.step(actions)
    assert_equal(before, env.save())


def test_bad_option(env: tower_v0.TowerParallelEnv) -> None:
    env.reset(seed=0)
    before = env.save()
    with pytest.raises(ValueError, match="unknown option 'block'"):
        env.reset(options={"block": 2})
    assert_equal(before, env.save())


# ---------------------------------------------------------------- documentation


@pytest.mark.parametrize("heading", [
    "Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End",
    "Arguments", "Version History",
])  # fmt: skip
def test_docstring_is_the_specification(heading: str) -> None:
    doc = tower_v0.TowerParallelEnv.__doc__ or ""
    assert f"## {heading}\n" in doc
    assert not re.search(r"\{\w+\}", doc)  # every placeholder is filled
    rows: list[Any] = [*TowerTask.actions, *TowerTask.observations, *TowerTask.reward_terms, *TowerTask.arguments]
    for row in rows:
        assert f"| {row.name} " in doc


@pytest.mark.parametrize(
    "text",
    [
        f"a body of {stack.GRIPPER_MASS:g} kg",
        f"at most {stack.MAX_FORCE:g} N along each axis and {stack.MAX_TORQUE:g} N m",
        f"slower than {parts.REST_SPEED:g} m/s and {1.5 * parts.REST_SPEED:g} rad/s",
        f"more than {-scene.DEPOT_X:g} m out",
        f"{100 * parts.ARRIVAL_MARGIN:g} cm wider than the block",
        f"a circle {100 * rules.GRIPPER_SIZE:g} cm larger is clear of the other gripper",
        f"between {-scene.REACH_X[0]:g} m outwards and {scene.REACH_X[1]:g} m inwards of the middle, between "
        f"{stack.REACH_Y[0]:g} and {stack.REACH_Y[1]:g} m high, and within {stack.REACH_ANGLE:g} rad",
        f"the plinth up to {scene.PLINTH_X:g} m left or right",
        f"{-scene.START_X[1]:g} to {-scene.START_X[0]:g} m outwards of the middle",
        f"{scene.START_Y[0]:g} to {scene.START_Y[1]:g} m high",
        f"tilted by more than {parts.TIPPED:g} rad",
        f"Box(low, high, ({len(TowerTask.observations)},), float32)",
    ],
)
def test_docstring_agrees_with_the_constants(text: str) -> None:
    assert text in " ".join((tower_v0.TowerParallelEnv.__doc__ or "").split())


# ---------------------------------------------------------------- training


def test_supersuit_and_stable_baselines() -> None:
    supersuit = pytest.importorskip("supersuit")
    pytest.importorskip("stable_baselines3")
    from stable_baselines3 import PPO

    envs = supersuit.pettingzoo_env_to_vec_env_v1(tower_v0.parallel_env())
    envs = supersuit.concat_vec_envs_v1(envs, 2, base_class="stable_baselines3")
    assert envs.num_envs == 4
    PPO("MlpPolicy", envs, n_steps=16, batch_size=32, n_epochs=1, device="cpu").learn(64)
