"""How often the scripted builder of GStack-v0 succeeds, beside random actions, on 100 seeds."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.envs.stack.env import StackVectorEnv
from gsenv.envs.stack.policy import build_tower

SEEDS, QUICK_SEEDS = 100, 16
FIRST_SEED = 0
STEP_LIMIT = 600
HEIGHTS, QUICK_HEIGHTS = (1, 2, 3, 4, 5, 6, 7, 8), (1, 3)
TARGETS = {3: 0.90, 5: 0.60}  # of the builder


@dataclass(frozen=True)
class Outcome:
    """Shares of the episodes, and means over them."""

    blocks: int
    policy: str
    success: float
    fallen: float
    steps: float
    returns: float


def play(blocks: int, name: str, policy: Callable[[Any], Any], seeds: int) -> Outcome:
    """Play one episode on each seed."""
    envs = StackVectorEnv(seeds, blocks=blocks, max_episode_steps=STEP_LIMIT)
    observations, _ = envs.reset(seed=FIRST_SEED)
    running, success = np.ones(seeds, bool), np.zeros(seeds, bool)
    fallen, steps, returns = np.zeros(seeds, bool), np.zeros(seeds), np.zeros(seeds)
    while running.any():
        observations, rewards, terminated, truncated, infos = envs.step(policy(observations))
        steps += running
        returns += np.where(running, rewards, 0.0)
        success |= running & infos["success"]
        fallen |= running & terminated & ~infos["success"]
        running &= ~(terminated | truncated)
    means = (float(values.mean()) for values in (success, fallen, steps, returns))
    return Outcome(blocks, name, *means)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: this benchmark has no options of its own."""


def measure(run: Run) -> dict[str, Any]:
    generator = np.random.default_rng(0)

    def random_policy(observations: Any) -> Any:
        return generator.uniform(-1.0, 1.0, (len(observations), 4)).astype(np.float32)

    seeds, heights = (QUICK_SEEDS, QUICK_HEIGHTS) if run.quick else (SEEDS, HEIGHTS)
    outcomes = []
    for blocks in track(heights, "towers", len(heights)):
        outcomes.append(play(blocks, "builder", build_tower, seeds))
        outcomes.append(play(blocks, "random", random_policy, seeds))
    return {"seeds": seeds, "outcomes": packed(outcomes)}


def report(results: Mapping[str, Any]) -> Report:
    outcomes = unpacked(Outcome, results["outcomes"])
    rows = []
    for built, random in zip(outcomes[::2], outcomes[1::2], strict=True):
        target = f"{TARGETS[built.blocks]:.0%}" if built.blocks in TARGETS else ""
        rows.append(
            [
                str(built.blocks), f"{built.success:.0%}", target, f"{built.fallen:.0%}",
                f"{built.steps:.0f}", f"{built.returns:.2f}", f"{random.success:.0%}",
            ]
        )  # fmt: skip
    header = ["blocks", "builder", "target", "fallen", "steps", "return", "random actions"]
    return Report(f"GStack-v0, {results['seeds']} seeds from {FIRST_SEED}", [Table(header, rows, words=0)])
