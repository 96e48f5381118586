"""Environment steps per CPU second on one core: single through gym.make, and batched.

    taskset -c 0 python -m benchmarks.throughput [--env GStack-v0]

Random actions drawn beforehand, resets included, kernels compiled before; median of seven.
"""

from __future__ import annotations

import argparse
import statistics
import time
import warnings
from collections.abc import Callable

import gymnasium as gym
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import gsenv  # noqa: F401  (registers the ids)

ROUNDS = 7


def rate(step: Callable[[int], None], count: int, per_step: int) -> tuple[float, float, float]:
    """(median, lowest, highest) env steps per CPU second."""
    rates = []
    for _ in range(ROUNDS):
        began = time.thread_time()
        for k in range(count):
            step(k)
        rates.append(per_step * count / (time.thread_time() - began))
    return statistics.median(rates), min(rates), max(rates)


def single(env_id: str) -> tuple[float, float, float]:
    env = gym.make(env_id)
    env.reset(seed=0)
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1.0, 1.0, (512, *env.action_space.shape)).astype(np.float32)  # type: ignore[misc]

    def step(k: int) -> None:
        _, _, terminated, truncated, _ = env.step(actions[k % 512])
        if terminated or truncated:
            env.reset()

    for k in range(200):
        step(k)
    return rate(step, 2000, 1)


def batched(env_id: str, worlds: int) -> tuple[float, float, float]:
    envs = gym.make_vec(env_id, num_envs=worlds)
    envs.reset(seed=0)
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1.0, 1.0, (64, *envs.action_space.shape)).astype(np.float32)  # type: ignore[misc]

    def step(k: int) -> None:
        envs.step(actions[k % 64])

    for k in range(max(2, 2000 // worlds)):
        step(k)
    return rate(step, max(4, 6000 // worlds), worlds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env", default="GStack-v0")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    table = Table("how", "env steps / CPU s", "lowest", "highest", title=arguments.env)
    runs: list[tuple[str, Callable[[], tuple[float, float, float]]]] = [
        ("single, gym.make", lambda: single(arguments.env)),
        ("batched, 16", lambda: batched(arguments.env, 16)),
        ("batched, 64", lambda: batched(arguments.env, 64)),
        ("batched, 1024", lambda: batched(arguments.env, 1024)),
    ]
    for name, run in track(runs, "measuring"):
        median, low, high = run()
        table.add_row(name, f"{median:,.0f}", f"{low:,.0f}", f"{high:,.0f}")
    Console().print(table)


if __name__ == "__main__":
    main()
