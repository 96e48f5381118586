"""Evaluation of a policy: one episode on each of many seeds of the split "test", which training never sees.

    python -m gsenv.train.evaluate GStack-v0 --policy trained --set blocks=3

Needs Stable-Baselines3 only for its own policy files (policy.zip).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.envs.core.policies import make_batch, named_task, scripted_actions, trained_actions
from gsenv.envs.core.spec_tables import box_of
from gsenv.train.arguments import Parser, add_set_option, check_env_id, check_episodes, not_negative, positive
from gsenv.train.progress import counting

SPLIT = "test"  # of all evaluations; training has the other one
TEST_SEED = 0  # first seed of the test after training
UNSELECTED_SEED = 20_000  # first seed of published figures by which no policy is chosen; runs are compared below 6000
VALIDATION_SEED = 1_000_000  # first seed of evaluations during training, which also are of the split "test"
EPISODES = 100
BATCH = 1000  # largest number of episodes that run side by side
POLICIES = ("trained", "scripted", "random", "zero")

Actor = Callable[[NDArray[np.float32]], NDArray[np.float32]]


@dataclass(frozen=True)
class Evaluation:
    """Means over the episodes of an evaluation."""

    episodes: int
    success_rate: float
    mean_return: float
    mean_length: float

    def __str__(self) -> str:
        return (
            f"success {self.success_rate:.0%} of {self.episodes} episodes, return {self.mean_return:.2f}, "
            f"{self.mean_length:.0f} steps"
        )


class PolicyError(Exception):
    """A policy does not exist or does not fit the environment; the message is one sentence."""


def evaluate(
    actor: Actor,
    env_id: str,
    episodes: int = EPISODES,
    seed: int = TEST_SEED,
    arguments: Mapping[str, Any] | None = None,
    on_episodes: Callable[[int], None] = lambda ended: None,
) -> Evaluation:
    """Run one episode on each of the seeds `seed` .. `seed + episodes - 1`; return the means.

    Where an environment has several agents, the actor acts for each of them, and the return is the mean of theirs.

    The seeds are of the split "test", unless `arguments` of the environment say otherwise. `on_episodes` is called with
    the number of episodes that have ended, at each step.

    Raises:
        TypeError: an unknown name in `arguments`.
        ValueError: a bad value there, or observations that are pixels.
    """
    env_id, own = named_task(env_id, arguments or {})
    given = {"split": SPLIT} | own
    check_episodes(given, "an evaluation")
    batches = []
    for first in range(0, episodes, BATCH):

        def count_ended(ended: int, before: int = first) -> None:
            on_episodes(before + ended)

        batches.append(_run_batch(actor, env_id, min(BATCH, episodes - first), seed + first, given, count_ended))
    success, returns, lengths = (np.concatenate(parts) for parts in zip(*batches, strict=True))
    return Evaluation(episodes, float(success.mean()), float(returns.mean()), float(lengths.mean()))


def _run_batch(
    actor: Actor,
    env_id: str,
    count: int,
    seed: int,
    arguments: Mapping[str, Any],
    on_episodes: Callable[[int], None],
) -> tuple[NDArray[np.bool_], NDArray[np.float64], NDArray[np.int64]]:
    """Run `count` episodes side by side; return success, return and length of each."""
    envs = make_batch(env_id, count, **arguments)
    observations, _ = envs.reset(seed=seed)
    returns, lengths = np.zeros(count), np.zeros(count, np.int64)
    running, success = np.ones(count, np.bool_), np.zeros(count, np.bool_)
    while running.any():
        observations, rewards, terminated, truncated, infos = envs.step(actor(observations))
        returns += np.where(running, rewards.reshape(count, -1).mean(axis=1), 0.0)  # mean over the agents
        lengths += running
        ended = running & (terminated | truncated)
        success |= ended & infos.get("is_success", np.zeros(count, np.bool_))
        running &= ~ended
        on_episodes(int(count - running.sum()))
    envs.close()
    return success, returns, lengths


def make_actor(policy: str, env_id: str, seed: int = 0, arguments: Mapping[str, Any] | None = None) -> Actor:
    """Return an actor: "trained", "scripted", "random", "zero", or from a file, policy.npz or SB3's policy.zip.

    `arguments` are those of the environment: a `task` among them has policies of its own.

    Files are only read; whatever is in them, none of it is run.

    Raises:
        PolicyError: there is no such policy, or it does not fit this environment.
    """
    from gsenv.envs.core.mlp import MlpPolicy

    env_id, _ = named_task(env_id, arguments or {})
    if policy == "random":
        return _random_actor(env_id, seed)
    if policy == "zero":
        size = len(make_batch(env_id, 1).task.actions)
        return lambda observations: np.zeros((*observations.shape[:-1], size), np.float32)
    try:
        if policy == "scripted":
            return scripted_actions(env_id)
        if policy == "trained":
            return trained_actions(env_id)
    except LookupError as error:
        raise PolicyError(str(error.args[0])) from None
    path = Path(policy)
    if path.suffix not in (".npz", ".zip"):
        raise PolicyError(f"a policy is {', '.join(POLICIES)}, an .npz or a .zip file, not {policy!r}.")
    try:
        mlp = MlpPolicy.load(path) if path.suffix == ".npz" else _load_zip(path)
    except OSError as error:
        raise PolicyError(f"cannot read {path}: {error.strerror or error}.") from None
    except ValueError as error:
        raise PolicyError(str(error)) from None
    task = make_batch(env_id, 1).task
    for what, count, entries in (
        ("observations", mlp.observation_count, task.observations),
        ("actions", mlp.action_count, task.actions),
    ):
        if len(entries) != count:
            raise PolicyError(f"{path} is for {count} {what}, and {env_id} has {len(entries)}.")
    trained_in = str(getattr(mlp, "notes", {}).get("env", "")).rpartition(":")[2]
    known = {entry.id for entry in ENVS} | {entry.name for entry in PARALLEL_ENVS}
    if trained_in in known and _without_tier(trained_in) != _without_tier(env_id):
        raise PolicyError(f"{path} was trained in {trained_in}: what it sees and does means other things in {env_id}.")
    return mlp


def _without_tier(env_id: str) -> str:
    """Return the id of the task of which an environment is a tier; all tiers see and do the same."""
    return re.sub("[-_]hardcore", "", env_id.rpartition(":")[2])


def _random_actor(env_id: str, seed: int) -> Actor:
    space = box_of(make_batch(env_id, 1).task.actions)
    generator = np.random.default_rng((seed, 1))  # not the stream of the episode of this seed

    def act(observations: NDArray[np.float32]) -> NDArray[np.float32]:
        return generator.uniform(space.low, space.high, (*observations.shape[:-1], *space.shape)).astype(np.float32)

    return act


def _load_zip(path: Path) -> Any:
    try:
        from gsenv.train.export import load_zip
    except ImportError as error:
        raise PolicyError(f"{error.name} is missing for {path}; pip install 'gsenv[train]' brings it.") from None
    return load_zip(path)


def main(arguments: Sequence[str] | None = None) -> int:
    """Evaluate as the command line says; return the exit code."""
    parser = Parser(prog="evaluate", description="Evaluate a policy on unseen episodes.")
    parser.add_argument("env", help="id of the environment")
    parser.add_argument(
        "--policy", default="trained", help=f"{', '.join(POLICIES)}, or a .npz or .zip file (default: trained)"
    )
    parser.add_argument("--episodes", type=positive, default=EPISODES, help="number of episodes (default: %(default)s)")
    parser.add_argument(
        "--seed",
        type=not_negative,
        default=TEST_SEED,
        help="seed of the first episode, in the split 'test' (default: %(default)s)",
    )
    add_set_option(parser)
    given = parser.parse_args(arguments)
    check_env_id(parser, given.env)
    try:
        actor = make_actor(given.policy, given.env, given.seed, dict(given.set))
        with counting(f"{given.env}, {given.episodes} episodes", given.episodes) as follow:
            result = evaluate(actor, given.env, given.episodes, given.seed, dict(given.set), follow)
    except (PolicyError, TypeError, ValueError) as error:
        print(f"evaluate: {error}", file=sys.stderr)
        return 1
    print(result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
