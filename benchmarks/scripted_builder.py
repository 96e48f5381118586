"""How often the scripted builder of GStack-v0 succeeds, beside random actions, on 100 seeds.

python benchmarks/scripted_builder.py
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from gsenv.envs.policies import build_tower
from gsenv.envs.stack import StackVectorEnv

SEEDS = 100
FIRST_SEED = 0
STEP_LIMIT = 600
HEIGHTS = (1, 2, 3, 4, 5, 6, 7, 8)
TARGETS = {3: 0.90, 5: 0.60}  # of the builder


def measure(blocks: int, policy: Callable[[Any], Any]) -> dict[str, float]:
    """One episode on each seed: rates of success and of falls, mean steps and return."""
    envs = StackVectorEnv(SEEDS, blocks=blocks, max_episode_steps=STEP_LIMIT)
    observations, _ = envs.reset(seed=FIRST_SEED)
    running, success = np.ones(SEEDS, bool), np.zeros(SEEDS, bool)
    fallen, steps, returns = np.zeros(SEEDS, bool), np.zeros(SEEDS), np.zeros(SEEDS)
    while running.any():
        observations, rewards, terminated, truncated, infos = envs.step(policy(observations))
        steps += running
        returns += np.where(running, rewards, 0.0)
        success |= running & infos["success"]
        fallen |= running & terminated & ~infos["success"]
        running &= ~(terminated | truncated)
    names = ("success", "fallen", "steps", "return")
    values = (success, fallen, steps, returns)
    return {name: float(value.mean()) for name, value in zip(names, values, strict=True)}


def main() -> None:
    generator = np.random.default_rng(0)

    def random_policy(observations: Any) -> Any:
        return generator.uniform(-1.0, 1.0, (len(observations), 4)).astype(np.float32)

    table = Table(title=f"GStack-v0, {SEEDS} seeds from {FIRST_SEED}")
    for column in ("blocks", "builder", "target", "fallen", "steps", "return", "random"):
        table.add_column(column, justify="right")
    for blocks in HEIGHTS:
        built = measure(blocks, build_tower)
        random = measure(blocks, random_policy)
        target = f"{TARGETS[blocks]:.0%}" if blocks in TARGETS else ""
        table.add_row(
            str(blocks), f"{built['success']:.0%}", target, f"{built['fallen']:.0%}",
            f"{built['steps']:.0f}", f"{built['return']:.2f}", f"{random['success']:.0%}",
        )  # fmt: skip
    Console().print(table)


if __name__ == "__main__":
    main()
