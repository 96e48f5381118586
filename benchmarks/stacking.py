"""How often policies from doing nothing to the trained one build the towers of each tier, on 100 unseen episodes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.envs.core.policies import make_batch, scripted_actions, trained_actions
from gsenv.envs.stack import policy as planar
from gsenv.envs.stack3d import policy as spatial
from gsenv.envs.tower import policy as together
from gsenv.train.evaluate import Actor, evaluate

EPISODES, QUICK_EPISODES = 100, 10
CONSTANTS, QUICK_CONSTANTS = 20, 4  # constant actions, the best of which counts
CONSTANT_EPISODES = 10
TIERS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("GStack-v0", {"blocks": 3}),
    ("GStack-v0", {}),
    ("GStack-hardcore-v0", {}),
    ("GStack3D-v0", {}),
    ("GStack3D-hardcore-v0", {}),
    ("tower_v0", {}),
)
NAIVE: dict[str, Actor] = {
    "GStack-v0": planar.drop_blocks,
    "GStack-hardcore-v0": planar.drop_blocks,
    "GStack3D-v0": spatial.drop_blocks,
    "GStack3D-hardcore-v0": spatial.drop_blocks,
    "tower_v0": together.drop_together,
}
POLICIES = ("zero", "random", "constant", "naive", "scripted", "trained")


@dataclass(frozen=True)
class Outcome:
    """Success of a policy, of 1, and its mean return."""

    tier: str
    policy: str
    success: float
    returns: float


def constant(action: NDArray[np.float32]) -> Actor:
    """Return a policy that always acts alike."""
    return lambda observations: np.broadcast_to(action, (*observations.shape[:-1], len(action)))


def random_actions(count: int) -> Actor:
    """Return a policy with uniform actions."""
    generator = np.random.default_rng(0)
    return lambda seen: generator.uniform(-1.0, 1.0, (*seen.shape[:-1], count)).astype(np.float32)


def trained(env_id: str) -> Actor | None:
    try:
        return trained_actions(env_id)
    except LookupError:
        return None


def best_constant(env_id: str, arguments: Mapping[str, Any], tries: int) -> tuple[float, float]:
    """Return the success and the return of the constant action that succeeds most often, of `tries` drawn ones."""
    generator = np.random.default_rng(1)
    count = len(make_batch(env_id, 1).task.actions)
    results = []
    for _ in range(tries):
        action = generator.uniform(-1.0, 1.0, count).astype(np.float32)
        result = evaluate(constant(action), env_id, CONSTANT_EPISODES, arguments=arguments)
        results.append((result.success_rate, result.mean_return))
    return max(results)


def play(env_id: str, arguments: Mapping[str, Any], policy: str, run: Run) -> tuple[float, float] | None:
    """Return success and mean return of a policy, or None where there is no such policy."""
    if policy == "constant":
        return best_constant(env_id, arguments, QUICK_CONSTANTS if run.quick else CONSTANTS)
    count = len(make_batch(env_id, 1).task.actions)
    makers: dict[str, Callable[[], Actor | None]] = {
        "zero": lambda: constant(np.zeros(count, np.float32)),
        "random": lambda: random_actions(count),
        "naive": lambda: NAIVE[env_id],
        "scripted": lambda: scripted_actions(env_id),
        "trained": lambda: trained(env_id),
    }
    actor = makers[policy]()
    if actor is None:
        return None
    result = evaluate(actor, env_id, QUICK_EPISODES if run.quick else EPISODES, arguments=arguments)
    return result.success_rate, result.mean_return


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: this benchmark has no options of its own."""


def measure(run: Run) -> dict[str, Any]:
    outcomes = []
    for env_id, arguments in track(TIERS, "tiers", len(TIERS)):
        name = ", ".join([env_id, *(f"{key} {value}" for key, value in arguments.items())])
        for policy in POLICIES:
            result = play(env_id, arguments, policy, run)
            if result is not None:
                outcomes.append(Outcome(name, policy, *result))
    return {"episodes": QUICK_EPISODES if run.quick else EPISODES, "outcomes": packed(outcomes)}


def report(results: Mapping[str, Any]) -> Report:
    outcomes = unpacked(Outcome, results["outcomes"])
    tiers = list(dict.fromkeys(outcome.tier for outcome in outcomes))
    rows = []
    for tier in tiers:
        cells = {o.policy: o for o in outcomes if o.tier == tier}
        rows.append([tier, *(_cell(cells.get(policy)) for policy in POLICIES)])
    header = ["tier", "zero", "random", "best constant", "naive: drops", "scripted", "trained"]
    return Report(f"success and mean return, {results['episodes']} unseen episodes", [Table(header, rows, words=1)])


def _cell(outcome: Outcome | None) -> str:
    return "-" if outcome is None else f"{outcome.success:.0%} ({outcome.returns:.2f})"
