"""SAC on one environment, with all worlds in one batch.

    python -m gsenv.train.sac --env GStack-v0 --seeds 0 1 2

Writes to runs/sac/ENV/seed-SEED; see gsenv.train.experiment for the files. Ctrl-C stops early and keeps the policy
trained so far; `--resume` continues, with an empty replay buffer.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from gsenv.train import experiment, ppo

if TYPE_CHECKING:
    from stable_baselines3 import SAC
    from stable_baselines3.common.vec_env import VecNormalize


@dataclass(frozen=True)
class Settings(experiment.Settings):
    """Settings of one SAC run."""

    steps: int = 1_200_000
    world_count: int = 64
    discount: float = 0.995
    buffer_size: int = 500_000
    batch_size: int = 512
    learning_rate: float = 7e-4  # decreases linearly to 5 % of this
    learning_starts: int = 10_000
    target_update: float = 0.005  # weight of the new parameters in the target network's moving average
    gradient_steps: int = 8  # updates after each step of all worlds
    layers: tuple[int, ...] = (64, 64)


DEFAULTS = Settings()
# the curricula of PPO: what a task is, and what is easier, does not depend on the algorithm
SETTINGS = {
    name: replace(DEFAULTS, arguments=task.arguments, lessons=task.lessons, tests=task.tests)
    for name, task in ppo.SETTINGS.items()
}


def settings_for(env_id: str) -> Settings:
    name = env_id.rpartition(":")[2]
    return replace(SETTINGS.get(name, DEFAULTS), env=name)


def make_model(settings: Settings, envs: VecNormalize) -> SAC:
    """Return an untrained agent; equal settings give equal agents."""
    from stable_baselines3 import SAC

    return SAC(
        "MlpPolicy",
        envs,
        learning_rate=experiment.Linear(settings.learning_rate),
        buffer_size=settings.buffer_size,
        batch_size=settings.batch_size,
        learning_starts=settings.learning_starts,
        tau=settings.target_update,
        gamma=settings.discount,
        train_freq=1,
        gradient_steps=settings.gradient_steps,
        stats_window_size=max(settings.world_count, 100),
        policy_kwargs={"net_arch": list(settings.layers), "optimizer_kwargs": {"fused": True}},
        seed=settings.seed,
        device="cpu",
    )


EXPERIMENT = experiment.Experiment("sac", settings_for, make_model)


def main(arguments: Sequence[str] | None = None, prog: str | None = None) -> int:
    """Train as the command line says; return the exit code."""
    return experiment.main(EXPERIMENT, arguments, prog)


if __name__ == "__main__":
    sys.exit(main())
