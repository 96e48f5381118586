"""PPO that also learns from mirror images."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

import torch
from stable_baselines3.common.vec_env import VecNormalize

from gsenv.envs.ragdoll import mirror
from gsenv.train import experiment, ppo
from gsenv.train.mirror import MirroredPPO


@pytest.fixture(scope="module")
def model() -> Any:
    settings = replace(
        ppo.settings_for("GRagdoll-v0"),
        steps=48,
        world_count=3,
        rollout=16,
        batch_size=32,
        epochs=1,
        layers=(16,),
        mirrored=1.0,
    )
    return ppo.make_model(settings, VecNormalize(ppo.wrap(settings, experiment.make_envs(settings))))


def test_a_rollout_is_followed_by_its_mirror_image(model: Any) -> None:
    """Where actions and normalised observations are undone, the second half is the image of the first."""
    _, callback = model._setup_learn(48, None)
    model.collect_rollouts(model.env, callback, model.rollout_buffer, 16)
    buffer = model.rollout_buffer
    seen = model.get_vec_normalize_env().unnormalize_obs(buffer.observations.copy())
    actions, log_probs = buffer.actions.copy(), buffer.log_probs.copy()
    model._add_mirror_image()
    assert buffer.n_envs == 6
    index, sign = mirror.PRIVILEGED
    image = model.get_vec_normalize_env().unnormalize_obs(buffer.observations.copy())
    inside = abs(buffer.observations[:, 3:]) < 9.9  # the rest is clipped
    assert inside.mean() > 0.95
    np.testing.assert_allclose(image[:, 3:][inside], (seen[..., index] * sign)[inside], atol=1e-4)
    index, sign = mirror.ACTION
    np.testing.assert_array_equal(buffer.actions[:, 3:], actions[..., index] * sign)
    for name in ("advantages", "returns"):
        np.testing.assert_array_equal(getattr(buffer, name)[:, 3:], getattr(buffer, name)[:, :3])
    np.testing.assert_array_equal(buffer.log_probs[:, :3], log_probs)
    with torch.no_grad():
        _, expected, _ = model.policy.evaluate_actions(
            torch.as_tensor(buffer.observations[4, 3:]), torch.as_tensor(buffer.actions[4, 3:])
        )
    np.testing.assert_allclose(buffer.log_probs[4, 3:], expected.numpy(), atol=1e-5)
    buffer.n_envs = 3


def test_what_the_policy_would_hardly_do_is_not_mirrored() -> None:
    """With a strong and not symmetric bias all mirrored actions are out of reach; the originals come twice instead."""
    settings = replace(
        ppo.settings_for("GRagdoll-v0"), steps=48, world_count=3, rollout=16, batch_size=32, layers=(16,), log_std=-4.0
    )
    model: Any = ppo.make_model(settings, VecNormalize(ppo.wrap(settings, experiment.make_envs(settings))))
    index, sign = mirror.ACTION
    bias = np.linspace(-0.9, 0.9, len(index)).astype(np.float32)
    assert abs(bias[index] * sign - bias).max() > 0.5
    model.policy.action_net.bias.data[:] = torch.as_tensor(bias)
    _, callback = model._setup_learn(48, None)
    model.collect_rollouts(model.env, callback, model.rollout_buffer, 16)
    model._add_mirror_image()
    for name in ("observations", "actions", "log_probs", "advantages"):
        values = getattr(model.rollout_buffer, name)
        np.testing.assert_array_equal(values[:, 3:], values[:, :3])
    model.rollout_buffer.n_envs = 3
    model.learn(96)
    assert all(torch.isfinite(weight).all() for weight in model.policy.parameters())


def test_it_learns_for_some_rollouts(model: Any) -> None:
    before = [weight.detach().clone() for weight in model.policy.parameters()]
    model.learn(144)
    assert model.rollout_buffer.n_envs == 3
    assert len(model.rollout_buffer.observations) == 2 * 16 * 3  # flat after an update
    assert any((weight != old).any() for weight, old in zip(model.policy.parameters(), before, strict=True))


def test_mirror_images_end_after_their_share_of_the_run(model: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    monkeypatch.setattr(MirroredPPO, "_add_mirror_image", lambda self: seen.append(self.num_timesteps))
    monkeypatch.setattr(model, "mirrored_share", 0.5)
    model.learn(192)
    assert seen == [48, 96]
