"""PPO on one environment, with all worlds in one batch.

    python -m gsenv.train.ppo --env GStack-v0 --seeds 0 1 2

Writes to runs/ppo/ENV/seed-SEED; see gsenv.train.experiment for the files. Ctrl-C stops early and keeps the policy
trained so far; `--resume` continues.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from gsenv.train import experiment

if TYPE_CHECKING:
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize


@dataclass(frozen=True)
class Settings(experiment.Settings):
    """Settings of one PPO run."""

    rollout: int = 128  # steps of each world per update
    batch_size: int = 2048
    epochs: int = 6
    learning_rate: float = 5e-4  # decreases linearly to 5 % of this
    gae_lambda: float = 0.95
    clip: float = 0.2
    entropy_weight: float = 0.0
    layers: tuple[int, ...] = (128, 128)
    log_std: float = -0.5  # logarithm of the actions' initial standard deviation


DEFAULTS = Settings()
STACK = replace(
    DEFAULTS,
    world_count=256,
    rollout=32,
    batch_size=1024,
    epochs=5,
    learning_rate=1e-3,
    layers=(64, 64),
    log_std=-1.0,
    evaluate_every=200_000,
)


def _frailer(few: int, more: int) -> tuple[tuple[float, dict[str, float]], ...]:
    """Return a curriculum of towers of `few`, then `more` blocks, which crack more and more easily.

    Blocks that crack at once are never released, and blocks that never crack are dropped at once.
    """
    return (
        (0.07, {"blocks": few, "crack_speed": 2.0}),
        (0.14, {"blocks": more, "crack_speed": 1.4}),
        (0.21, {"blocks": more, "crack_speed": 1.0}),
        (0.28, {"crack_speed": 0.7}),
        (0.35, {"crack_speed": 0.5}),
    )


RAGDOLL = replace(
    DEFAULTS,
    steps=1_500_000,
    world_count=128,
    rollout=64,
    epochs=5,
    learning_rate=1e-3,
    log_std=-1.0,
    arguments={"push": 0.8},  # more than the environment's own, so that it learns to step
    curriculum=((0.12, {"push": 0.3}), (0.3, {"push": 0.5})),
    tests=({"push": 0.3}, {"push": 0.6}, {"push": 1.0}),
)
SETTINGS = {
    "GStack-v0": replace(
        STACK,
        steps=2_500_000,
        arguments={"blocks": 5, "crack_speed": 0.4},
        curriculum=_frailer(2, 3),
        tests=({},),
    ),
    "GStack3D-v0": replace(
        STACK,
        steps=3_000_000,
        arguments={"blocks": 3, "crack_speed": 0.4},
        curriculum=_frailer(2, 2),
        tests=({},),
    ),
    "tower_v0": replace(
        STACK,
        steps=8_000_000,
        world_count=128,
        arguments={"blocks": 4, "crack_speed": 0.4},
        curriculum=_frailer(2, 2),
        tests=({},),
    ),
    "GCar-v0": replace(DEFAULTS, steps=1_500_000, arguments={"difficulty": 0.3}, tests=({"difficulty": 0.3},)),
    "GRagdoll2D-v0": RAGDOLL,
    "GRagdoll2D-hardcore-v0": replace(RAGDOLL, arguments={"push": 1.2}),
}


def settings_for(env_id: str) -> Settings:
    name = env_id.rpartition(":")[2]
    return replace(SETTINGS.get(name, DEFAULTS), env=name)


def make_model(settings: Settings, envs: VecNormalize) -> PPO:
    """Return an untrained agent; equal settings give equal agents."""
    from stable_baselines3 import PPO

    return PPO(
        "MlpPolicy",
        envs,
        learning_rate=experiment.Linear(settings.learning_rate),
        n_steps=settings.rollout,
        batch_size=min(settings.batch_size, settings.rollout * settings.world_count),
        n_epochs=settings.epochs,
        gamma=settings.discount,
        gae_lambda=settings.gae_lambda,
        clip_range=settings.clip,
        ent_coef=settings.entropy_weight,
        policy_kwargs={"net_arch": list(settings.layers), "log_std_init": settings.log_std},
        seed=settings.seed,
        device="cpu",
    )


EXPERIMENT = experiment.Experiment("ppo", settings_for, make_model)


def main(arguments: Sequence[str] | None = None) -> int:
    """Train as the command line says; return the exit code."""
    return experiment.main(EXPERIMENT, arguments)


if __name__ == "__main__":
    sys.exit(main())
