"""PPO whose critic sees more than its policy (L. Pinto et al., "Asymmetric actor critic", 2018).

When and how hard a figure is pushed next decides much of its return, and no action has a part in it. A critic that
knows it takes this noise out of the advantages and leaves them unbiased (H. Mao et al., "Variance reduction for
reinforcement learning in input-driven environments", 2019). The policy sees the environment's own observations, which
come first; what is exported is that of the policy alone.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from torch import Tensor, nn


class PrivilegedVecEnv(VecEnvWrapper):
    """Worlds whose observations (world, entry) are followed by the privileged ones of their task.

    Those of the last state of an episode are of the state before: its world has begun the next episode.
    """

    def __init__(self, envs: VecEnv) -> None:
        own = envs.observation_space
        assert isinstance(own, spaces.Box)
        self._task: Any = envs.get_attr("task")[0]
        more = self._task.privileged
        low = np.concatenate([own.low, [entry.low for entry in more]])
        high = np.concatenate([own.high, [entry.high for entry in more]])
        super().__init__(envs, spaces.Box(low.astype(np.float32), high.astype(np.float32)))
        self._seen: NDArray[np.float32] = self._task.privileged_observations()

    def reset(self) -> Any:
        return self._extended(self.venv.reset())

    def step_wait(self) -> Any:
        observations, rewards, dones, infos = self.venv.step_wait()
        for world in np.flatnonzero(dones).tolist():
            last = infos[world]["terminal_observation"]
            infos[world]["terminal_observation"] = np.concatenate([last, self._seen[world]])
        return self._extended(observations), rewards, dones, infos

    def _extended(self, observations: Any) -> NDArray[np.float32]:
        self._seen = self._task.privileged_observations()
        return np.concatenate([observations, self._seen], 1)


class AsymmetricPolicy(ActorCriticPolicy):
    """Stable-Baselines3's "MlpPolicy" whose actor sees the first `actor_entries` observations, its critic all."""

    def __init__(self, *args: Any, actor_entries: int, **kwargs: Any) -> None:
        self.actor_entries = actor_entries
        super().__init__(*args, **kwargs)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return super()._get_constructor_parameters() | {"actor_entries": self.actor_entries}

    def _build_mlp_extractor(self) -> None:
        layers: Any = self.net_arch
        self.mlp_extractor: Any = _Networks(self.actor_entries, self.features_dim, layers, self.activation_fn)


class _Networks(nn.Module):
    """Two networks with layers of the same sizes; the names are those that `gsenv.train.export` reads."""

    def __init__(self, actor_entries: int, critic_entries: int, layers: list[int], activation: type[nn.Module]) -> None:
        super().__init__()
        self.actor_entries = actor_entries
        self.policy_net = _network([actor_entries, *layers], activation)
        self.value_net = _network([critic_entries, *layers], activation)
        self.latent_dim_pi = self.latent_dim_vf = layers[-1]

    def forward(self, features: Tensor) -> tuple[Tensor, Tensor]:
        return self.forward_actor(features), self.forward_critic(features)

    def forward_actor(self, features: Tensor) -> Tensor:
        latent: Tensor = self.policy_net(features[..., : self.actor_entries])
        return latent

    def forward_critic(self, features: Tensor) -> Tensor:
        latent: Tensor = self.value_net(features)
        return latent


def _network(sizes: list[int], activation: type[nn.Module]) -> nn.Sequential:
    modules: list[nn.Module] = []
    for before, after in itertools.pairwise(sizes):
        modules += [nn.Linear(before, after), activation()]
    return nn.Sequential(*modules)
