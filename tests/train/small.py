"""Experiments of a few hundred steps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gsenv.train import ppo, sac

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
SAC = replace(sac.settings_for("GStack-v0"), learning_starts=64, buffer_size=1000, gradient_steps=1, **_TINY)
EXPERIMENTS: list[Any] = [(ppo.EXPERIMENT, PPO), (sac.EXPERIMENT, SAC)]
