"""Copies, pickles and snapshots go on bit for bit, mid-episode, bodies in contact, also elsewhere."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from gsenv.envs import ENVS, tower_v0
from gsenv.envs.core.vector import TaskVectorEnv
from tests.envs.registered import EACH_TASK, IDS, MODES, digest, make, make_vector, play, random_actions, touching

ROOT = Path(__file__).parents[3]
LIMIT = 30


@pytest.mark.parametrize("way", ["deepcopy", "pickle", "save", "save to another", "later save"])
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_single_goes_on(env_id: str, way: str) -> None:
    env = touching(env_id)
    base: Any = env.unwrapped
    actions = random_actions(env_id, 8, 90)
    before = digest(base.save())
    if way == "deepcopy":
        other = copy.deepcopy(env)
    elif way == "pickle":
        other = pickle.loads(pickle.dumps(env))
    elif way == "save to another":
        other = make(env_id)
        other.reset(seed=99)
        other.step(actions[0])
        other.unwrapped.restore(pickle.loads(pickle.dumps(base.save())))  # type: ignore[attr-defined]
    saved = base.save()
    expected = play(env, actions)
    if way == "later save":  # of an env whose buffers have grown meanwhile
        base.restore(saved)
        saved = base.save()
        play(env, actions[::-1])
    if way in ("save", "later save"):
        assert digest(saved) == before  # nothing in it was shared with the running environment
        base.restore(saved)
        other = env
    assert digest(play(other, actions)) == digest(expected)


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_a_copy_lives_its_own_life(env_id: str) -> None:
    env = touching(env_id)
    other = copy.deepcopy(env)
    before = digest(other.unwrapped.save())  # type: ignore[attr-defined]
    play(env, random_actions(env_id, 1, 20))
    assert digest(other.unwrapped.save()) == before  # type: ignore[attr-defined]
    assert digest(env.unwrapped.save()) != before  # type: ignore[attr-defined]


def under_way(env_id: str, mode: AutoresetMode) -> TaskVectorEnv:
    """Worlds at different points of their episodes, some just ended, some in contact."""
    vector = make_vector(env_id, 4, autoreset_mode=mode, max_episode_steps=LIMIT, threads=2)
    vector.reset(seed=3)
    play(vector, random_actions(env_id, 3, 7, 4))
    vector.reset(options={"reset_mask": np.array([False, True, False, True])})
    play(vector, random_actions(env_id, 4, LIMIT - 8, 4))
    vector.step(random_actions(env_id, 5, 1, 4)[0])
    assert vector.task.world.state.worlds["contact_count"].any()
    return vector


@pytest.mark.parametrize("way", ["deepcopy", "pickle", "save", "save to another"])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", EACH_TASK)
def test_vector_goes_on(env_id: str, mode: AutoresetMode, way: str) -> None:
    vector = under_way(env_id, mode)
    other = vector
    saved = vector.save()
    if way == "deepcopy":
        other = copy.deepcopy(vector)
    elif way == "pickle":
        other = pickle.loads(pickle.dumps(vector))
    elif way == "save to another":
        other = make_vector(env_id, 4, autoreset_mode=mode, max_episode_steps=LIMIT)
        other.restore(pickle.loads(pickle.dumps(saved)))
    expected = carry_on(vector, mode)
    if way == "save":
        vector.restore(saved)
    assert digest(carry_on(other, mode)) == digest(expected)


def carry_on(vector: TaskVectorEnv, mode: AutoresetMode) -> list[Any]:
    begin = []
    if mode == AutoresetMode.DISABLED and vector.finished.any():
        begin = [vector.reset(options={"reset_mask": vector.finished})]
    env_id = next(i for i in IDS if isinstance(vector, type(make_vector(i, 1))))
    return begin + play(vector, random_actions(env_id, 6, 2 * LIMIT, 4))


def continue_all(path: str) -> str:
    """Digest of how all pickled environments go on; also runs in a new process."""
    logs = []
    for env, snapshot, actions in pickle.loads(Path(path).read_bytes()):
        logs.append(play(env, actions))
        env.unwrapped.restore(snapshot)
        logs.append(play(env, actions))
    return digest(logs)


def test_goes_on_in_another_process(tmp_path: Path) -> None:
    cases: list[Any] = []
    for env_id in IDS:
        env: Any = touching(env_id)
        cases.append((env, env.unwrapped.save(), random_actions(env_id, 8, 60)))
        vector = under_way(env_id, AutoresetMode.SAME_STEP)
        cases.append((vector, vector.save(), random_actions(env_id, 9, 40, 4)))
    path = tmp_path / "envs"
    path.write_bytes(pickle.dumps(cases))
    code = "import sys; from tests.envs.core.test_continuation import continue_all; print(continue_all(sys.argv[1]))"
    command = [sys.executable, "-c", code, str(path)]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == continue_all(str(path))


@pytest.mark.parametrize(
    "maker", [lambda: make("GStack-v0").unwrapped, lambda: make_vector("GStack-v0", 2), tower_v0.parallel_env]
)
def test_settings_changed_in_place_are_not_those_of_a_snapshot(maker: Callable[[], Any]) -> None:
    env = maker()
    env.reset(seed=0)
    before = env.reward_weights["placed"]
    saved = env.save()
    for changed in (before + 1.0, before + 2.0):  # the second after a restore, which must share nothing either
        env.reward_weights["placed"] = changed
        assert saved.settings["reward_weights"]["placed"] == before
        env.restore(saved)
        assert env.reward_weights["placed"] == before


def test_snapshots_of_another_split_are_refused_and_change_nothing() -> None:
    makers: list[Callable[..., Any]] = [
        lambda split: make("GStack-v0", split=split).unwrapped,
        lambda split: make_vector("GStack-v0", 2, split=split),
        lambda split: tower_v0.parallel_env(split=split),
    ]
    for maker in makers:
        first, second = maker("train"), maker("test")
        first.reset(seed=5)
        second.reset(seed=7)
        before = digest(second.save())
        with pytest.raises(
            ValueError, match="restore: the snapshot is of the split 'train', this environment is of 'test'"
        ):
            second.restore(first.save())
        assert digest(second.save()) == before
        third = maker("train")
        third.restore(first.save())
        seeds = third.np_random_seed
        assert seeds == first.np_random_seed == ((5, 6) if isinstance(seeds, tuple) else 5)


def task_of(env_id: str) -> str:
    return next(entry.env.partition(".")[0] for entry in ENVS if entry.id == env_id)


@pytest.mark.parametrize("env_id", EACH_TASK)
def test_wrong_snapshots_are_refused_and_change_nothing(env_id: str) -> None:
    vector = make_vector(env_id, 3)
    vector.reset(seed=0)
    before = digest(vector.save())
    with pytest.raises(ValueError, match="2 worlds, not 3"):
        vector.restore(make_vector(env_id, 2).save())
    others = [entry.id for entry in ENVS if task_of(entry.id) != task_of(env_id)]  # tiers of a task share a scene
    assert len(others) >= len({task_of(one) for one in IDS}) - 1
    for other_id in others:
        stranger = make_vector(other_id, 3)
        stranger.reset(seed=0)
        with pytest.raises(ValueError, match="restore: the snapshot is of gsenv"):
            vector.restore(stranger.save())
    assert digest(vector.save()) == before


@pytest.mark.parametrize(
    ("one", "other"),
    [("GRagdoll-v0", "GRagdoll-get-up-v0"), ("GRagdoll2D-v0", "GRagdoll2D-get-up-v0"),
     ("GStack-v0", "GStack-hardcore-v0"), ("GCar-v0", "GCar-hardcore-v0")],
)  # fmt: skip
def test_a_snapshot_of_other_rules_is_refused_and_changes_nothing(one: str, other: str) -> None:
    pairs: list[tuple[Any, Any]] = [(make(one).unwrapped, make(other).unwrapped)]
    pairs.append((make_vector(one, 2), make_vector(other, 2)))
    for first, second in pairs:
        first.reset(seed=0)
        second.reset(seed=1)
        before = digest(second.save())
        with pytest.raises(ValueError, match="restore: the snapshot is of gsenv"):
            second.restore(first.save())
        wrong: list[Any] = [None, 5, {}]
        for bad in wrong:
            with pytest.raises(ValueError, match=r"restore: this needs what save\(\) returned"):
                second.restore(bad)
        assert digest(second.save()) == before
