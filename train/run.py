"""A training run of one seed: its settings, its state, and the files that hold it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsenv.train.checkpoint import write_checkpoint
from gsenv.train.curriculum import Curriculum

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecNormalize


@dataclass(frozen=True)
class Settings:
    """Settings that all algorithms share; each script adds its own."""

    env: str = "GStack-v0"
    arguments: dict[str, Any] = field(default_factory=dict)  # of the environment
    steps: int = 3_000_000
    seed: int = 0
    world_count: int = 64
    discount: float = 0.99
    torch_threads: int = 1  # more threads do not speed up such small networks
    log_every: int = 50_000  # steps between rows of progress.csv, and between checkpoints
    evaluate_every: int = 250_000  # steps between evaluations
    watched_episodes: int = 50  # episodes of an evaluation during training
    test_episodes: int = 100  # episodes of the test after training
    tests: tuple[dict[str, Any], ...] = ({},)  # environment arguments of each test
    lessons: tuple[dict[str, Any], ...] = ()  # of the curriculum: what differs from `arguments`, easiest first
    pass_mark: float = 0.7  # share of successes with which the next lesson begins
    staggered: bool = False  # the worlds' first episodes end at random times; else those of one length stay in step

    def curriculum(self, lesson: int) -> Curriculum:
        """Return the curriculum of a run that has done so many lessons."""
        return Curriculum(self.lessons, self.arguments, self.pass_mark, lesson)


@dataclass
class Run:
    """The training run of one seed."""

    settings: Settings
    folder: Path
    model: BaseAlgorithm
    normalize: VecNormalize
    rows: list[dict[str, Any]]  # of progress.csv

    @property
    def steps(self) -> int:
        return int(self.model.num_timesteps)


def save(run: Run) -> None:
    """Write the policy in all formats and the progress, all files or none."""
    write_checkpoint(run.folder, run.model, run.normalize, notes(run), run.rows)


def notes(run: Run) -> dict[str, Any]:
    """Return what a policy file says about its run."""
    algorithm = type(run.model).__name__
    return {"env": run.settings.env, "algorithm": algorithm, "seed": run.settings.seed, "steps": run.steps}
