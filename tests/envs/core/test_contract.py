"""What clients of the environments rely on, in the same words for single, vector and parallel environments."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import VectorEnv

from gsenv import warmup
from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.envs.core.painter import MOST_SHOWN
from gsenv.envs.core.window import Window
from gsenv.train.evaluate import evaluate, make_actor
from tests.envs.registered import IDS, make, make_vector, random_actions, terms_of

each_id = pytest.mark.parametrize("env_id", IDS)
ENTRIES = {entry.id: entry for entry in ENVS}


def tower(**arguments: Any) -> Any:
    pytest.importorskip("pettingzoo")
    from gsenv.envs import tower_v0

    return tower_v0.parallel_env(**arguments)


def tower_vector(count: int, **arguments: Any) -> Any:
    from gsenv.envs.tower.env import TowerVectorEnv

    return TowerVectorEnv(count, **arguments)


def idle(env: Any) -> dict[str, Any]:
    return {agent: np.zeros(4, np.float32) for agent in env.agents}


def nested(info: dict[str, Any]) -> list[str]:
    return [key for key, value in info.items() if isinstance(value, dict)]


# ---------------------------------------------------------------- arguments and classes


@each_id
def test_an_unknown_argument_is_refused_in_the_words_of_python(env_id: str) -> None:
    """TorchRL passes frameskip=1, and tries again without it where these words are in the message."""
    words = "unexpected keyword argument 'frameskip'"
    with pytest.raises(TypeError, match=words):
        gymnasium.make(f"gsenv:{env_id}", frameskip=1)
    with pytest.raises(TypeError, match=words):
        make_vector(env_id, 2, frameskip=1)


def test_parallel_environments_refuse_it_in_the_same_words() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'frameskip'"):
        tower(frameskip=1)


@each_id
def test_classes_name_what_they_are_among_their_direct_bases(env_id: str) -> None:
    """skrl looks at `__bases__`, not at the whole order of resolution."""
    assert gymnasium.Env in type(make(env_id).unwrapped).__bases__
    assert VectorEnv in type(make_vector(env_id, 1)).__bases__


def test_classes_with_agents_do_too() -> None:
    pettingzoo = pytest.importorskip("pettingzoo")
    assert pettingzoo.ParallelEnv in type(tower()).__bases__
    assert VectorEnv in type(tower_vector(1)).__bases__


# ---------------------------------------------------------------- observations


@each_id
def test_every_entry_varies_and_uses_its_range(env_id: str) -> None:
    count, steps = 12, 300
    vector = make_vector(env_id, count)
    script = make_actor("scripted", env_id)
    actions = random_actions(env_id, 3, steps, count)
    actions[:, 0], actions[:, 1], actions[:, 2] = 1.0, -1.0, 0.0
    seen, _ = vector.reset(seed=3)
    least, most = seen.min(0), seen.max(0)
    for given in actions:
        given[6:] = script(seen)[6:]
        seen = vector.step(given)[0]
        least, most = np.minimum(least, seen.min(0)), np.maximum(most, seen.max(0))
    names = np.array([entry.name for entry in vector.task.observations])
    still = set(names[most - least < 1e-3 * (vector.task.high - vector.task.low)])
    assert still <= {"rear_below"}  # of a car that rears up at a gate alone


# ---------------------------------------------------------------- infos


@each_id
def test_infos_are_flat_and_have_the_reward_terms(env_id: str) -> None:
    env, vector = make(env_id, diagnostics=True), make_vector(env_id, 2, diagnostics=True)
    (_, first), (_, infos) = env.reset(seed=0), vector.reset(seed=0)
    actions = random_actions(env_id, 0, 2)
    _, reward, _, _, second = env.step(actions[0])
    later = vector.step(actions)[4]
    for info in (first, second, infos, later):
        assert not nested(info)
    names = [term.name for term in env.unwrapped.task.reward_terms]  # type: ignore[attr-defined]
    assert list(terms_of(first)) == list(terms_of(second)) == list(terms_of(later)) == names
    assert sum(terms_of(second).values()) == reward
    assert first["diagnostic_residual"] == 0.0
    assert later["_diagnostic_residual"].all()


def test_infos_of_agents_are_flat() -> None:
    env = tower(diagnostics=True)
    _, infos = env.reset(seed=0)
    result = env.step(idle(env))
    for agent in env.possible_agents:
        assert not nested(infos[agent])
        assert sum(terms_of(result[4][agent]).values()) == result[1][agent]
        assert result[4][agent]["diagnostic_sweeps"] > 0


# ---------------------------------------------------------------- ends of episodes


@each_id
def test_vector_environments_truncate_where_gymnasium_make_does(env_id: str) -> None:
    limit = ENTRIES[env_id].max_episode_steps
    env = make(env_id).unwrapped
    assert make_vector(env_id, 1).max_episode_steps == env.task.max_episode_steps == limit  # type: ignore[attr-defined]
    assert gymnasium.make_vec(env_id, 2, max_episode_steps=7).unwrapped.max_episode_steps == 7  # type: ignore[attr-defined]


def test_environments_with_agents_truncate_by_default() -> None:
    limit = next(entry.max_cycles for entry in PARALLEL_ENVS if entry.name == "tower_v0")
    assert tower().max_cycles == tower_vector(1).max_episode_steps == limit == 900
    vector = tower_vector(2)
    vector.reset(seed=0)
    for step in range(limit):
        _, _, terminated, truncated, _ = vector.step(np.zeros((2, 2, 4), np.float32))
        assert not terminated.any()
        assert truncated.all() == truncated.any() == (step == limit - 1)


def test_minus_one_is_no_limit() -> None:
    env, vector = tower(max_cycles=-1), tower_vector(1, max_episode_steps=-1)
    env.reset(seed=0)
    vector.reset(seed=0)
    for _ in range(905):
        assert not any(env.step(idle(env))[3].values())
        assert not vector.step(np.zeros((1, 2, 4), np.float32))[3].any()
    for bad in (0, -2, 2.5, True, "9"):
        with pytest.raises(ValueError, match="None or -1 for no limit"):
            tower_vector(1, max_episode_steps=bad)


@each_id
def test_a_terminated_episode_stays_as_it_is_and_warns_once(env_id: str) -> None:
    env: Any = make(env_id).unwrapped
    env.reset(seed=0)
    env.task.terminated[0] = True  # as the last step would leave it
    last, info = env.observation, env.task.info(0)
    action = np.ones(env.action_space.shape, np.float32)
    with pytest.warns(UserWarning, match="the episode has terminated"):
        first = env.step(action)
    second = env.step(action)
    for observation, reward, terminated, truncated, after in (first, second):
        np.testing.assert_array_equal(observation, last)
        assert (reward, terminated, truncated) == (0.0, True, False)
        assert not any(terms_of(after).values())
        assert after.keys() == info.keys()
    np.testing.assert_array_equal(env.reset(seed=0)[0], make(env_id).reset(seed=0)[0])
    assert not env.step(action)[2]


BEYOND_SCRIPTS = (
    "GCar-v0", "GCar-hardcore-v0", "GCar3D-hardcore-v0",
    "GRagdoll2D-hardcore-v0", "GRagdoll-hardcore-v0", "GRagdoll2D-get-up-v0", "GRagdoll-get-up-v0",
)  # fmt: skip
SCRIPTED = [i for i in IDS if ENTRIES[i].scripted_policy]
NIGHTLY = ("GCar3D-v0", "GCar3D-hardcore-v0", "GRagdoll-hardcore-v0")


@pytest.mark.parametrize("env_id", [pytest.param(i, marks=pytest.mark.slow) if i in NIGHTLY else i for i in SCRIPTED])
def test_a_scripted_policy_exceeds_the_reward_threshold_and_random_actions_do_not(env_id: str) -> None:
    threshold = gymnasium.spec(env_id).reward_threshold
    assert threshold is not None
    solves = env_id not in BEYOND_SCRIPTS
    assert (evaluate(make_actor("scripted", env_id), env_id).mean_return > threshold) == solves  # on 100 episodes
    assert evaluate(make_actor("random", env_id), env_id, 20).mean_return < 0.5 * threshold


# ---------------------------------------------------------------- the window


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The frames that windows get."""
    frames: list[Any] = []
    monkeypatch.setattr(Window, "show", lambda self, frame: frames.append(frame))
    return frames


def test_the_mode_human_shows_each_reset_and_step(shown: list[Any]) -> None:
    size: dict[str, Any] = {"render_mode": "human", "width": 96, "height": 64}
    single, vector = make("GStack-v0", **size), make_vector("GStack-v0", 5, **size)
    both: list[Any] = [single, vector]
    for env, action in zip(both, (np.zeros(4), np.zeros((5, 4))), strict=True):
        assert "human" in env.metadata["render_modes"]
        shown.clear()
        env.reset(seed=0)
        env.step(action)
        env.step(action)
        assert len(shown) == 3
        assert env.render() is None
        env.close()
    alone = make("GStack-v0", render_mode="rgb_array", width=96, height=64)
    alone.reset(seed=0)
    single.reset(seed=0)
    np.testing.assert_array_equal(shown[-1], alone.render())


def test_the_mode_human_of_parallel_environments(shown: list[Any]) -> None:
    env = tower(render_mode="human", width=96, height=64)
    env.reset(seed=0)
    env.step(idle(env))
    assert [frame.shape for frame in shown] == [(64, 96, 3)] * 2
    assert env.render() is None


def test_the_window_has_worlds_side_by_side(shown: list[Any]) -> None:
    for count, side in ((1, 1), (2, 2), (4, 2), (5, 3), (MOST_SHOWN + 4, 4)):
        vector = make_vector("GStack-v0", count, render_mode="human", width=192, height=96)
        vector.reset(seed=0)
        rows = -(-min(count, MOST_SHOWN) // side)
        assert shown[-1].shape == (rows * (96 // side // 16 * 16), side * (192 // side // 16 * 16), 3)


# ---------------------------------------------------------------- pixels


@each_id
def test_pixels_have_the_size_that_is_asked_for(env_id: str) -> None:
    size: dict[str, Any] = {"width": 96, "height": 64}
    env, vector = make(env_id, observation="pixels", **size), make_vector(env_id, 2, observation="pixels", **size)
    assert env.observation_space.shape == env.reset(seed=0)[0].shape == (64, 96, 3)
    assert vector.reset(seed=0)[0].shape == vector.observation_space.shape == (2, 64, 96, 3)
    assert make(env_id, observation="pixels", width=32).observation_space.shape == (84, 32, 3)


@each_id
def test_state_and_pixels_come_as_one_dict(env_id: str) -> None:
    env, vector = make(env_id, observation="state+pixels"), make_vector(env_id, 2, observation="state+pixels")
    observation, _ = env.reset(seed=4)
    assert env.observation_space.contains(observation)
    assert isinstance(env.observation_space, gymnasium.spaces.Dict)
    for name in ("state", "pixels"):
        alone = make(env_id, observation=name)
        np.testing.assert_array_equal(observation[name], alone.reset(seed=4)[0], strict=True)
    batch, _ = vector.reset(seed=3)
    assert vector.observation_space.contains(batch)
    np.testing.assert_array_equal(batch["pixels"][1], observation["pixels"])
    np.testing.assert_array_equal(batch["state"][1], observation["state"])


def test_agents_get_state_and_pixels_as_one_dict() -> None:
    env = tower(observation="state+pixels", width=64, height=48)
    observations, _ = env.reset(seed=0)
    states, _ = tower().reset(seed=0)
    for agent, observation in observations.items():
        assert env.observation_space(agent).contains(observation)
        np.testing.assert_array_equal(observation["state"], states[agent])
        assert observation["pixels"].shape == (48, 64, 3)


@pytest.mark.parametrize(
    "bad", [{"observation": "rgb"}, {"width": 15}, {"width": 10**9}, {"height": 0}, {"width": 96.0}]
)
def test_bad_observations_and_sizes_are_refused(bad: dict[str, Any]) -> None:
    for build in (lambda: make("GStack-v0", **bad), lambda: make_vector("GStack-v0", 1, **bad)):
        with pytest.raises(ValueError, match=f"{next(iter(bad))} must be"):
            build()


def test_warmup_draws_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    import gsenv.render

    small: list[str] = []
    original = gsenv.render.make_renderer

    def noted(world: Any, *size: int, **arguments: Any) -> Any:
        if arguments.get("small"):
            small.append(target)
        return original(world, *size, **arguments)

    monkeypatch.setattr(gsenv.render, "make_renderer", noted)
    targets = [*IDS, *(entry.name for entry in PARALLEL_ENVS)]
    run = dict(warmup.warmup_targets())
    for target in targets:
        if target in run:
            run[target]()
    assert small == [target for target in targets if target in run]


def test_parallel_environments_have_a_generator() -> None:
    """SuperSuit's frame_skip draws from it."""
    env = tower()
    env.reset(seed=7)
    assert env.np_random_seed == 7
    assert isinstance(env.np_random, np.random.Generator)
    supersuit = pytest.importorskip("supersuit")
    skipping = supersuit.frame_skip_v0(tower(), 3)
    skipping.reset(seed=0)
    skipping.step(idle(skipping))
    assert skipping.unwrapped._elapsed == 3
