"""Options, types and checks that the command lines share."""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.envs.core.vector import NEVER

MOST = 2**62  # of whole numbers: sums of two still fit 64 bits
MOST_TRAINING_SEED = 2**32 - 1  # of NumPy's global generator, which Stable-Baselines3 seeds
_LONGEST = 1000  # characters of a value of --set
_COMMANDS_OWN = {  # arguments of the functions that make environments, which are no settings of an environment
    **dict.fromkeys(
        ("id", "env_id", "self", "num_envs", "world_count", "autoreset_mode", "vectorization_mode", "vector_kwargs"),
        "the command sets it itself",
    ),
    "threads": "the commands use one thread",
    "render_mode": "the command sets it itself; `gsenv view` opens a window",
    **dict.fromkeys(("width", "height"), "--size does, where a command draws"),
}


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage text."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def add_set_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        type=_assignment,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set an argument of the environment, such as blocks=3; may be repeated",
    )


def check_env_id(parser: argparse.ArgumentParser, env_id: str) -> None:
    if env_id.rpartition(":")[2] not in {*(entry.id for entry in ENVS), *(entry.name for entry in PARALLEL_ENVS)}:
        parser.error(f"there is no environment {env_id!r}")


def check_training(env_id: str, seeds: Sequence[int], given: Mapping[str, Any]) -> None:
    """Refuse what no run can be trained with: `given` are arguments of the environment.

    Raises:
        TypeError: an unknown argument.
        ValueError: a bad value, or bad seeds.
    """
    from gsenv.envs.core.policies import make_batch

    twice = [seed for seed, count in Counter(seeds).items() if count > 1]
    if twice:
        raise ValueError(f"the seed {twice[0]} is given twice, and each seed is one run")
    if max(seeds) > MOST_TRAINING_SEED:
        raise ValueError(f"a seed of a training must be at most {MOST_TRAINING_SEED}, got {max(seeds)}")
    check_episodes(given, "training")
    if given.get("split", "train") != "train":
        raise ValueError("training takes the split 'train'; 'test' is for evaluation")
    make_batch(env_id, 1, **given)


def check_episodes(given: Mapping[str, Any], who: str) -> None:
    """Refuse pixels, as no policy of gsenv reads them, and no time limit; `given` are arguments of the environment."""
    if given.get("observation", "state") != "state":
        raise ValueError(f"the policies of gsenv observe the state, so {who} needs observation='state'.")
    if given.get("max_episode_steps") == NEVER:
        raise ValueError(f"{who} needs episodes that end, so max_episode_steps must not be -1.")


def positive(text: str) -> int:
    if not (number := _whole(text)):
        raise argparse.ArgumentTypeError(f"{_short(text)!r} is not a positive whole number")
    return number


def not_negative(text: str) -> int:
    number = _whole(text)
    if number is None:
        raise argparse.ArgumentTypeError(f"{_short(text)!r} is not a whole number of at least 0")
    return number


def _whole(text: str) -> int | None:
    """Return a whole number, or None for another text; refuses numbers that no counter holds."""
    if not text.isdecimal():
        return None
    if len(text) > 100 or int(text) > MOST:
        raise argparse.ArgumentTypeError(f"{_short(text)!r} is more than 2**62")
    return int(text)


def _short(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


def _assignment(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"{_short(text)!r} is not of the form NAME=VALUE")
    if name in _COMMANDS_OWN:
        raise argparse.ArgumentTypeError(f"{name!r} is not for --set: {_COMMANDS_OWN[name]}")
    if len(value) > _LONGEST:
        raise argparse.ArgumentTypeError(f"the value of {_short(name)!r} is longer than {_LONGEST} characters")
    try:
        return name, ast.literal_eval(value)
    except (MemoryError, RecursionError, SyntaxError, TypeError, ValueError):
        return name, value  # not a literal: a string
