"""Experiments of a few hundred steps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from gsenv.train import experiment, ppo
from gsenv.train.run import Settings

_TINY: dict[str, Any] = {
    "steps": 256,
    "world_count": 2,
    "layers": (16,),
    "batch_size": 64,
    "log_every": 64,
    "evaluate_every": 128,
    "watched_episodes": 2,
    "test_episodes": 2,
    "tests": ({"blocks": 1},),
}
PPO = replace(ppo.settings_for("GStack-v0"), rollout=64, epochs=1, **_TINY)


@dataclass(frozen=True)
class SacSettings(Settings):
    """Of an algorithm that the package does not have; policies of SAC are read, and any algorithm can be trained."""

    batch_size: int = 64
    layers: tuple[int, ...] = (16,)


def _make_sac(settings: SacSettings, envs: Any) -> Any:
    from stable_baselines3 import SAC

    return SAC(
        "MlpPolicy",
        envs,
        buffer_size=1000,
        batch_size=settings.batch_size,
        learning_starts=64,
        train_freq=1,
        policy_kwargs={"net_arch": list(settings.layers)},
        seed=settings.seed,
        device="cpu",
    )


SAC = SacSettings(env="GStack-v0", arguments=PPO.arguments, lessons=PPO.lessons, **_TINY)
SAC_EXPERIMENT = experiment.Experiment("sac", lambda _: SAC, _make_sac)
EXPERIMENTS: list[Any] = [(ppo.EXPERIMENT, PPO), (SAC_EXPERIMENT, SAC)]
