"""PPO that also learns from the mirror image of what it sees, for bodies that are symmetric.

Each rollout is followed by its mirror image, in which left and right are swapped, with the same advantages (F.
Abdolhosseini et al., "On learning symmetric locomotion", 2019, "duplicate tuples"). The mirrored actions get the
probability that the policy gave them before the update. Where the policy would hardly ever act so, because it is not
symmetric yet, the tuple is not mirrored: a small update would multiply the probability, without bound.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecNormalize

from gsenv.envs.ragdoll.mirror import ACTION, OBSERVATION, PRIVILEGED, Mirror
from gsenv.train.adaptive import AdaptivePPO

Array = NDArray[np.float32]

UNLIKELY = 10.0  # logarithm of the ratio of probabilities beyond which a tuple is not mirrored


def mirrored(vectors: Array, mirror: Mirror) -> Array:
    """Return the mirror image of vectors (..., entry)."""
    index, sign = mirror
    return vectors[..., index] * sign


class MirroredPPO(AdaptivePPO):
    """PPO for GRagdoll that doubles each rollout by its mirror image.

    Args:
        mirrored_share: share of the run, from its start, with mirror images. A policy that learns from them to the
            end is symmetric: where it stands symmetrically it does the same on both sides, and takes no step.
    """

    def __init__(self, *args: Any, mirrored_share: float = 1.0, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.mirrored_share = mirrored_share

    def train(self) -> None:
        buffer = self.rollout_buffer
        count = buffer.n_envs
        if self.num_timesteps <= self.mirrored_share * self._total_timesteps:
            self._add_mirror_image()
        super().train()
        buffer.n_envs = count  # the next rollout begins with `reset`, which allocates all arrays anew

    def _add_mirror_image(self) -> None:
        buffer = self.rollout_buffer
        observations = self._mirrored_observations(buffer.observations)
        actions = mirrored(buffer.actions, ACTION)
        log_probs = self._log_probs(observations, actions)
        alien = log_probs < buffer.log_probs - UNLIKELY
        observations[alien], actions[alien] = buffer.observations[alien], buffer.actions[alien]
        log_probs[alien] = buffer.log_probs[alien]
        for name, image in (("observations", observations), ("actions", actions), ("log_probs", log_probs)):
            setattr(buffer, name, np.concatenate([getattr(buffer, name), image], axis=1))
        for name in ("values", "advantages", "returns"):
            setattr(buffer, name, np.tile(getattr(buffer, name), (1, 2)))
        buffer.n_envs *= 2

    def _mirrored_observations(self, observations: Array) -> Array:
        """Return the mirror image of normalised observations, normalised; both sides have statistics of their own.

        The statistics are those after the rollout. Its rows were normalised by earlier ones, from which they differ
        by 0.02 after the first three rollouts.
        """
        normalize = self.get_vec_normalize_env()
        assert isinstance(normalize, VecNormalize)
        seen: Any = normalize.obs_rms
        scale = np.sqrt(seen.var + normalize.epsilon)
        mirror = OBSERVATION if len(seen.mean) == len(OBSERVATION[0]) else PRIVILEGED
        image = mirrored(observations * scale + seen.mean, mirror)
        most = normalize.clip_obs
        return np.clip((image - seen.mean) / scale, -most, most).astype(np.float32)

    def _log_probs(self, observations: Array, actions: Array) -> Array:
        with torch.no_grad():
            _, log_probs, _ = self.policy.evaluate_actions(
                torch.as_tensor(observations.reshape(-1, observations.shape[-1])),
                torch.as_tensor(actions.reshape(-1, actions.shape[-1])),
            )
        return np.asarray(log_probs.numpy(), np.float32).reshape(observations.shape[:2])
