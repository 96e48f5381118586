"""What each kind of policy reaches at each tier of all tasks, from doing nothing to the trained one.

Each policy plays one episode on each of 100 seeds of the split "test", by which no policy of the package was chosen.
The best constant action and the best naive script are selected on other seeds, too.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common.files import packed, unpacked
from benchmarks.common.progress import track
from benchmarks.common.report import Report
from benchmarks.common.run import Run
from benchmarks.common.tables import Table
from gsenv.envs.car import policy as car
from gsenv.envs.car3d import policy as car3d
from gsenv.envs.core.policies import make_batch
from gsenv.envs.ragdoll import policy as ragdoll
from gsenv.envs.ragdoll2d import policy as ragdoll2d
from gsenv.envs.stack import policy as stack
from gsenv.envs.stack3d import policy as stack3d
from gsenv.envs.tower import policy as tower
from gsenv.train.evaluate import UNSELECTED_SEED, VALIDATION_SEED, Actor, Evaluation, PolicyError, evaluate, make_actor

EPISODES, QUICK_EPISODES = 100, 5
DIAGONAL = (-1.0, -0.5, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0)  # constant actions with equal entries
DRAWN, QUICK_DRAWN = 10, 0  # further constant actions, drawn at random
SELECTION_EPISODES = 20
TIERS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("GStack-v0", {"blocks": 3}),
    ("GStack-v0", {}),
    ("GStack-hardcore-v0", {}),
    ("GStack3D-v0", {}),
    ("GStack3D-hardcore-v0", {}),
    ("tower_v0", {}),
    ("tower_hardcore_v0", {}),
    ("GCar-v0", {}),
    ("GCar-hardcore-v0", {}),
    ("GCar3D-v0", {}),
    ("GCar3D-hardcore-v0", {}),
    ("GRagdoll2D-v0", {"push": 0.3}),
    ("GRagdoll2D-v0", {}),
    ("GRagdoll2D-hardcore-v0", {}),
    ("GRagdoll2D-get-up-v0", {}),
    ("GRagdoll-v0", {"push": 0.3}),
    ("GRagdoll-v0", {}),
    ("GRagdoll-hardcore-v0", {}),
    ("GRagdoll-get-up-v0", {}),
)


def at_speeds(
    script: Callable[..., NDArray[np.float32]], speeds: Iterable[float], does: str = "holds"
) -> dict[str, Actor]:
    return {f"{does} {speed:g} m/s": partial(script, speed=speed) for speed in speeds}


LOWERING = (0.08, 0.12, 0.16, 0.2, 0.26, 0.32)  # m/s


NAIVE: dict[str, dict[str, Actor]] = {  # by id, or the first part of it
    "GStack": at_speeds(stack.lower_blocks, LOWERING, "lowers at") | {"drops from 0.5 m": stack.drop_blocks},
    "GStack3D": at_speeds(stack3d.lower_blocks, LOWERING, "lowers at") | {"drops from 0.5 m": stack3d.drop_blocks},
    "tower": {"drops from 0.5 m": tower.drop_together},
    "GCar": at_speeds(car.hold_speed, (4.0, 5.0, 5.5, 6.0, 6.5, 7.0)),
    "GCar3D": at_speeds(car3d.hold_speed, (5.5, 6.0, 6.25, 6.5, 6.75, 7.0)),
    "GRagdoll2D": {"ankles": ragdoll2d.lean},
    "GRagdoll": {"ankles": ragdoll.lean},
    "GRagdoll2D-get-up-v0": {"squats, then stands": ragdoll2d.squat_and_stand},
    "GRagdoll-get-up-v0": {"squats, then stands": ragdoll.squat_and_stand},
}
POLICIES = ("zero", "random", "constant", "naive", "scripted", "trained")


@dataclass(frozen=True)
class Outcome:
    """What a policy reaches at a tier: share of successes and mean return; ``name``: of the selected one."""

    tier: str
    policy: str
    name: str
    success: float
    returns: float


def constant(action: NDArray[np.float32]) -> Actor:
    """Return a policy that always acts alike."""
    return lambda observations: np.broadcast_to(action, (*observations.shape[:-1], len(action)))


def constants(size: int, drawn: int) -> dict[str, Actor]:
    """Return the constant policies that are tried, by their actions (size,)."""
    generator = np.random.default_rng(0)
    actions = [np.full(size, value) for value in DIAGONAL]
    actions += list(generator.uniform(-1.0, 1.0, (drawn, size)))
    return {str(action.round(2).tolist()): constant(action.astype(np.float32)) for action in actions}


def select(actors: Mapping[str, Actor], env_id: str, arguments: Mapping[str, Any], episodes: int) -> str:
    """Return the name of the policy with the most successes, and among those the largest return, on other seeds."""
    if len(actors) == 1:
        return next(iter(actors))
    results: dict[str, Evaluation] = {
        name: evaluate(actor, env_id, episodes, VALIDATION_SEED, arguments) for name, actor in actors.items()
    }
    return max(results, key=lambda name: (results[name].success_rate, results[name].mean_return))


def find(policy: str, env_id: str, arguments: Mapping[str, Any], run: Run) -> tuple[str, Actor] | None:
    """Return name and actor of a policy, or None where there is none."""
    size = len(make_batch(env_id, 1).task.actions)
    if policy in ("constant", "naive"):
        actors = constants(size, QUICK_DRAWN if run.quick else DRAWN)
        if policy == "naive":
            actors = NAIVE[env_id if env_id in NAIVE else re.split("[-_]", env_id)[0]]
        name = select(actors, env_id, arguments, QUICK_EPISODES if run.quick else SELECTION_EPISODES)
        return name, actors[name]
    try:
        return "", make_actor(policy, env_id)
    except PolicyError:
        return None


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the environments to measure."""
    known = sorted({env_id for env_id, _ in TIERS})
    parser.add_argument("--env", nargs="+", choices=known, metavar="ID", help="measure only these environments")


def measure(run: Run) -> dict[str, Any]:
    outcomes = []
    chosen = [tier for tier in TIERS if not run.options.env or tier[0] in run.options.env]
    episodes = QUICK_EPISODES if run.quick else EPISODES
    for env_id, arguments in track(chosen, "tiers", len(chosen)):
        tier = ", ".join([env_id, *(f"{key} {value}" for key, value in arguments.items())])
        for policy in POLICIES:
            found = find(policy, env_id, arguments, run)
            if found is not None:
                result = evaluate(found[1], env_id, episodes, UNSELECTED_SEED, arguments)
                outcomes.append(Outcome(tier, policy, found[0], result.success_rate, result.mean_return))
    return {"episodes": episodes, "outcomes": packed(outcomes)}


def report(results: Mapping[str, Any]) -> Report:
    outcomes = unpacked(Outcome, results["outcomes"])
    rows = []
    for tier in dict.fromkeys(outcome.tier for outcome in outcomes):
        cells = {o.policy: o for o in outcomes if o.tier == tier}
        rows.append([tier, *(_cell(cells.get(policy)) for policy in POLICIES), cells["naive"].name])
    header = ["tier", "zero", "random", "best constant", "naive", "scripted", "trained", "the naive script"]
    text = (
        f'Success and mean return of {results["episodes"]} episodes of the split "test", seeds {UNSELECTED_SEED} and '
        "on, by which no policy was chosen. The best constant action, of 20, and the best naive script are selected on "
        "other seeds. A naive builder of GStack and GStack3D centres each block while it lowers it at one speed, or "
        "drops it; a naive driver holds one speed. Trained policies are those that come with the package, with their "
        "mean action."
    )
    return Report("Policies at each tier", [text, Table(header, rows, words=1)])


def _cell(outcome: Outcome | None) -> str:
    return "-" if outcome is None else f"{outcome.success:.0%} ({outcome.returns:.2f})"
