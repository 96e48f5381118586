"""Reference motions: which frame is followed, the actions of both tasks, what the file holds, and how many get up."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest

from gsenv.envs import rises
from gsenv.envs.core.policies import make_batch, scripted_actions
from gsenv.envs.ragdoll import env as spatial_env
from gsenv.envs.ragdoll import figure, mirror
from gsenv.envs.ragdoll import policy as spatial
from gsenv.envs.ragdoll2d import env as planar_env
from gsenv.envs.ragdoll2d import policy as planar
from gsenv.envs.ragdoll2d import scene
from gsenv.envs.ragdoll2d.motion import Motion, follow, over_limits, reference_motion, select


class Script(NamedTuple):
    """One of the two scripts, with what belongs to its figure."""

    env_id: str
    module: ModuleType
    envs: Any
    axes: Any
    get_up: Callable[..., Any]
    fewest: float  # share that gets up, at least


SCRIPTS = [
    Script("GRagdoll2D-get-up-v0", planar, planar_env, scene.AXES, planar.get_up, 0.6),
    Script("GRagdoll-get-up-v0", spatial, spatial_env, figure.AXES, spatial.get_up, 0.3),
]
each_script = pytest.mark.parametrize("script", SCRIPTS, ids=["2D", "3D"])


def test_the_nearest_frame_is_followed() -> None:
    motion = Motion(np.array([[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]]), np.array([[0.1], [0.2], [0.3]]))
    seen = np.array([[0.4, 0.0], [0.6, 0.0], [3.0, 3.1], [-9.0, 0.0]])
    np.testing.assert_allclose(follow(motion, seen)[:, 0], [0.1, 0.2, 0.3, 0.1], rtol=1e-6)
    np.testing.assert_array_equal(follow(motion, seen.reshape(2, 2, 2))[..., 0], follow(motion, seen).reshape(2, 2))


def test_features_are_the_named_entries_times_their_weights() -> None:
    names = {"a": 0, "b": 1, "c": 2}
    observations = np.array([[1.0, 2.0, 3.0]], np.float32)
    np.testing.assert_array_equal(select(observations, names, {"c": 0.5, "a": 2.0}), [[1.5, 2.0]])


@each_script
def test_the_actions_of_the_balance_ask_for_the_same_angles_over_the_limits(script: Script) -> None:
    balancing = script.envs.RagdollVectorEnv(1, randomize={})
    rising = script.envs.RagdollVectorEnv(1, task="get_up", randomize={})
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, balancing.task._actions.shape)
    targets = []
    for vector, given in ((balancing, actions), (rising, over_limits(actions, script.axes))):
        vector.reset(seed=0)
        vector.step(given.astype(np.float32))
        targets.append(vector.task.world.control[:, : len(script.axes)].copy())
    balancing_targets, rising_targets = targets
    np.testing.assert_allclose(balancing_targets, rising_targets, atol=1e-6)


@each_script
def test_the_file_has_motions_of_the_figure(script: Script) -> None:
    motion = reference_motion(script.env_id)
    assert motion.seen.shape == (len(motion.actions), len(script.module.FEATURES))
    assert motion.actions.shape[1] == len(script.axes)
    assert 100 < len(motion.actions) < 1500
    assert np.isfinite(motion.seen).all()
    assert (np.abs(motion.actions) <= 1.0).all()
    heights = motion.seen[:, list(script.module.FEATURES).index("height")] / script.module.FEATURES["height"]
    assert heights.min() < -3.5  # lying
    assert heights.max() > -0.15  # standing


def test_a_motion_in_space_has_its_mirror_image() -> None:
    motion = reference_motion("GRagdoll-get-up-v0")
    index, sign = mirror.ACTION
    images = {row.tobytes() for row in (motion.actions[:, index] * sign + 0.0)}
    assert images == {row.tobytes() for row in motion.actions + 0.0}


@each_script
def test_figures_get_up_from_back_and_front(script: Script) -> None:
    """On seeds on which no motion was tried."""
    count = 48
    batch, actor = make_batch(script.env_id, count, split="test"), scripted_actions(script.env_id)
    seen, _ = batch.reset(seed=0)
    lies_on_back = next(figure.lies_on_back for figure in rises.FIGURES if figure.id == script.env_id)
    back = lies_on_back(seen)
    for _ in range(300):
        seen, _, _, _, infos = batch.step(actor(seen))
    for side in (back, ~back):
        assert infos["is_success"][side].mean() > script.fewest


@pytest.mark.slow
def test_the_command_makes_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rises, "ROUNDS", ((3, 4), (1, 8)))
    monkeypatch.setattr(rises, "MOTIONS", 1)
    out = tmp_path / "rises.npz"
    assert rises.main(["--starts", "24", "--out", str(out)]) == 0
    with np.load(out) as made:
        for script in SCRIPTS:
            seen, actions = made[f"{script.env_id} seen"], made[f"{script.env_id} actions"]
            assert seen.shape == (len(actions), len(script.module.FEATURES))
            assert actions.shape[1] == len(script.axes)
