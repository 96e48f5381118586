"""A critic that sees more than its policy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

import torch
from numpy.typing import NDArray

from gsenv.envs.ragdoll import mirror
from gsenv.envs.ragdoll.env import RagdollTask, RagdollVectorEnv
from gsenv.envs.ragdoll.policy import balance
from gsenv.envs.ragdoll2d import shared_rules as shared
from gsenv.envs.ragdoll2d.env import RagdollVectorEnv as PlanarVectorEnv
from gsenv.envs.ragdoll2d.policy import balance as planar_balance
from gsenv.train import experiment, ppo
from gsenv.train.export import export, load_zip, read_normalize, save_normalize

OWN = len(RagdollTask.observations)
ENTRIES = RagdollTask.privileged
NAMES = [entry.name for entry in ENTRIES]
SETTINGS = replace(
    ppo.settings_for("GRagdoll-v0"),
    steps=96, world_count=3, rollout=16, batch_size=32, epochs=1, layers=(16,), log_every=48, evaluate_every=10**9,
    tests=(),
)  # fmt: skip


def entry(seen: NDArray[np.float32], *names: str) -> NDArray[np.float32]:
    return seen[:, [NAMES.index(name) for name in names]]


def turned(level: NDArray[Any], angle: NDArray[Any]) -> NDArray[Any]:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * level[:, 0] - s * level[:, 1], s * level[:, 0] + c * level[:, 1]], 1)


def test_pushes_come_when_and_as_they_were_foreseen() -> None:
    """A push is given in the directions of the pelvis, which turns while the figure steps, and acts in space."""
    envs = RagdollVectorEnv(8, push=0.5, autoreset_mode="Disabled")
    observations, _ = envs.reset(seed=3)
    task: Any = envs.task
    pushed = np.zeros(8, int)
    turns = set()
    for _ in range(200):
        seen = task.privileged_observations()
        facing = _heading(task)
        foreseen = turned(entry(seen, "push_x", "push_y"), facing)
        due = entry(seen, "push_time")[:, 0] == 0.0
        count = task.task_state["push_count"].copy()
        observations, _, terminated, _, _ = envs.step(balance(observations))
        assert not terminated.any()
        began = task.task_state["push_count"] > count
        np.testing.assert_array_equal(began, due)
        now = task.privileged_observations()
        later = ~began & (entry(seen, "push_time")[:, 0] < 4.0)
        passed = entry(seen, "push_time")[later] - entry(now, "push_time")[later]
        np.testing.assert_allclose(passed, shared.CONTROL_TIME, atol=1e-5)
        push, heading = task.task_state["push"], task.task_state["heading"]
        given = push[:, None] * np.stack([np.cos(heading), np.sin(heading)], 1)
        np.testing.assert_allclose(foreseen[began], given[began], atol=1e-6)
        rest = turned(entry(now, "rest_x", "rest_y"), _heading(task))
        np.testing.assert_allclose(rest[began], 2.0 / 3.0 * given[began], atol=1e-6)  # a third has acted
        pushed += began
        turns |= set(np.round(facing[began], 2))
    assert (pushed >= 1).all()
    assert len(turns) > 1
    np.testing.assert_array_equal(seen[:, 5:-1], task.physics.astype(np.float32))


def _heading(task: Any) -> NDArray[Any]:
    """By the formula for quaternions; the code under test turns an axis."""
    w, x, y, z = task.world.state.bodies["rotation"][:, task.figure.parts["pelvis"]].T
    return np.asarray(np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)))


def test_the_planar_figure_foresees_pushes_too() -> None:
    envs = PlanarVectorEnv(8, push=0.5, autoreset_mode="Disabled")
    observations, _ = envs.reset(seed=3)
    task: Any = envs.task
    names = [entry.name for entry in task.privileged]
    pushed = np.zeros(8, int)
    for _ in range(130):
        seen = dict(zip(names, task.privileged_observations().T, strict=True))
        count = task.task_state["push_count"].copy()
        observations, *_ = envs.step(planar_balance(observations))
        began = task.task_state["push_count"] > count
        np.testing.assert_array_equal(began, seen["push_time"] == 0.0)
        np.testing.assert_allclose(seen["push_x"][began], task.task_state["push"][began], rtol=1e-6)
        rest = dict(zip(names, task.privileged_observations().T, strict=True))["rest_x"]
        np.testing.assert_allclose(rest[began], 2.0 / 3.0 * task.task_state["push"][began], rtol=1e-6)
        pushed += began
    assert (pushed >= 1).all()


def test_without_pushes_none_are_foreseen() -> None:
    envs = RagdollVectorEnv(2, push=0.0)
    envs.reset(seed=0)
    seen = envs.task.privileged_observations()  # type: ignore[attr-defined]
    np.testing.assert_array_equal(entry(seen, "push_time", "push_x", "push_y", "push_soon"), [[4.0, 0.0, 0.0, 0.0]] * 2)


def test_the_mirror_image_swaps_the_sides_of_pushes() -> None:
    index, sign = mirror.PRIVILEGED
    np.testing.assert_array_equal(index[OWN:], np.arange(OWN, OWN + len(ENTRIES)))
    assert [name for name, side in zip(NAMES, sign[OWN:], strict=True) if side < 0.0] == ["push_y", "rest_y"]
    np.testing.assert_array_equal(index[:OWN], mirror.OBSERVATION[0])
    np.testing.assert_array_equal(sign[:OWN], mirror.OBSERVATION[1])


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("privileged")
    assert experiment.run_seed(ppo.EXPERIMENT, SETTINGS, folder) == experiment.OK
    return experiment.prepare(ppo.EXPERIMENT, replace(SETTINGS, steps=192), folder, resume=True)


def test_only_the_critic_sees_them(run: Any) -> None:
    generator = np.random.default_rng(0)
    one = torch.as_tensor(generator.standard_normal((5, OWN + len(ENTRIES))).astype(np.float32))
    other = one.clone()
    other[:, OWN:] += 1.0
    policy = run.model.policy
    with torch.no_grad():
        for k in range(5):
            mean = policy.get_distribution(one[k : k + 1]).distribution.mean
            torch.testing.assert_close(
                policy.get_distribution(other[k : k + 1]).distribution.mean, mean, rtol=0, atol=0
            )
        assert (policy.predict_values(one) != policy.predict_values(other)).all()


def test_the_policy_in_the_files_is_that_of_the_environments_own_observations(run: Any) -> None:
    run.normalize.training = False  # else its statistics go on
    seen = run.normalize.reset()
    run.normalize.training = True
    assert seen.shape == (3, OWN + len(ENTRIES))
    with torch.no_grad():
        mean = run.model.policy.get_distribution(torch.as_tensor(seen)).distribution.mean.numpy()
    own = run.normalize.get_original_obs()[:, :OWN]
    for policy in (export(run.model, run.normalize), load_zip(run.folder / "policy.zip")):
        assert policy.observation_count == OWN
        np.testing.assert_allclose(policy(own), np.clip(mean, -1.0, 1.0), atol=1e-5)


def test_an_episode_ends_with_what_was_foreseen_before(run: Any) -> None:
    envs = run.normalize.venv
    envs.reset()
    generator = np.random.default_rng(1)
    for _ in range(200):
        before = envs.get_attr("task")[0].privileged_observations()
        _, _, dones, infos = envs.step(generator.uniform(-1.0, 1.0, (3, 21)).astype(np.float32))
        if dones.any():
            break
    world = int(np.flatnonzero(dones)[0])
    np.testing.assert_array_equal(infos[world]["terminal_observation"][OWN:], before[world])


def test_a_run_continues(run: Any, tmp_path: Path) -> None:
    assert run.steps == 96
    assert experiment.train(run)
    assert run.steps == 192


def test_statistics_of_other_observations_make_no_policy(run: Any, tmp_path: Path) -> None:
    """Those of the critic are longer than the policy's entries; any other length is refused, a longer one too."""
    (tmp_path / "policy.zip").write_bytes((run.folder / "policy.zip").read_bytes())
    statistics = read_normalize(run.folder / "normalize.npz")
    mean, variance = statistics.observation_mean, statistics.observation_variance
    for count in (OWN - 1, OWN + len(ENTRIES) - 1):
        other = replace(statistics, observation_mean=mean[:count], observation_variance=variance[:count])
        save_normalize(other, tmp_path / "normalize.npz")
        with pytest.raises(ValueError, match="shape"):
            load_zip(tmp_path / "policy.zip")
