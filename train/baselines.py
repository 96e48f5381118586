"""How far policies without skill get, beside scripted and trained ones: a table for each environment.

    python -m gsenv.train.baselines GCar-v0 GCar-hardcore-v0

Each policy plays one episode on each of 100 seeds of the split "test". The best constant is the best of constant
actions on the diagonal of the action space and of others drawn at random; the best naive script is the best of
`NAIVE`, such as a driver that holds a speed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from importlib import import_module
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.spec_tables import table
from gsenv.train.evaluate import EPISODES, Actor, Evaluation, PolicyError, check_env_id, evaluate, make_actor, positive

DIAGONAL = (-1.0, -0.5, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0)
RANDOM_CONSTANTS = 10
NAIVE: dict[str, tuple[str, str, tuple[float, ...]]] = {  # function, its argument, the values that are tried
    "GCar-v0": ("car.policy:hold_speed", "speed", (4.0, 5.0, 5.5, 6.0, 6.5, 7.0)),
    "GCar-hardcore-v0": ("car.policy:hold_speed", "speed", (4.0, 5.0, 5.5, 6.0, 6.5, 7.0)),
    "GCar3D-v0": ("car3d.policy:hold_speed", "speed", (5.0, 6.0, 7.0, 8.0)),
}


def constant(action: NDArray[Any]) -> Actor:
    """Return the policy of one action (action,)."""
    return lambda observations: np.tile(action.astype(np.float32), (len(observations), 1))


def constants(env_id: str) -> dict[str, Actor]:
    """Return the constant policies that are tried, by what the table says of them."""
    (size,) = gymnasium.spec(env_id).make().action_space.shape or (0,)
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (RANDOM_CONSTANTS, size)).round(2)
    actions = [np.full(size, value) for value in DIAGONAL] + list(drawn)
    return {" ".join(f"{value:g}" for value in action): constant(action) for action in actions}


def naive(env_id: str) -> dict[str, Actor]:
    """Return the naive scripts that are tried, by what the table says of them."""
    if env_id not in NAIVE:
        return {}
    where, argument, values = NAIVE[env_id]
    module, _, function = where.partition(":")
    script: Callable[..., Any] = getattr(import_module(f"gsenv.envs.{module}"), function)
    return {f"{function}, {argument} {value:g}": partial(script, **{argument: value}) for value in values}


def best(env_id: str, actors: dict[str, Actor], episodes: int) -> tuple[str, Evaluation]:
    """Return the name and the figures of the policy with the most successes, and among those the largest return."""
    results = {name: evaluate(actor, env_id, episodes) for name, actor in actors.items()}
    return max(results.items(), key=lambda item: (item[1].success_rate, item[1].mean_return))


def rows(env_id: str, episodes: int = EPISODES) -> Iterable[tuple[str, Evaluation]]:
    """Yield the rows of an environment's table: name and figures."""
    (size,) = gymnasium.spec(env_id).make().action_space.shape or (0,)
    yield "zero actions", evaluate(constant(np.zeros(size)), env_id, episodes)
    yield "random actions", evaluate(make_actor("random", env_id), env_id, episodes)
    for title, actors in (("best constant", constants(env_id)), ("naive script", naive(env_id))):
        if actors:
            name, result = best(env_id, actors, episodes)
            yield f"{title} ({name})", result
    for title in ("scripted", "trained"):
        try:
            yield title, evaluate(make_actor(title, env_id), env_id, episodes)
        except PolicyError:
            continue


def text(env_id: str, episodes: int = EPISODES) -> str:
    """Return the table in Markdown."""
    lines = (
        (
            name,
            f"{result.success_rate:.0%}".replace("%", " %"),
            f"{result.mean_return:.2f}",
            f"{result.mean_length:.0f}",
        )
        for name, result in rows(env_id, episodes)
    )
    return table((env_id, "success", "return", "steps"), lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables that the command line asks for; return the exit code."""
    parser = argparse.ArgumentParser(prog="baselines", description="Compare policies with and without skill.")
    parser.add_argument("env", nargs="+", help="ids of environments")
    parser.add_argument("--episodes", type=positive, default=EPISODES, help="episodes (default: %(default)s)")
    given = parser.parse_args(arguments)
    for env_id in given.env:
        check_env_id(parser, env_id)
    for env_id in given.env:
        print(text(env_id, given.episodes), end="\n\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
