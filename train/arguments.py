"""Options and types that the command lines share."""

from __future__ import annotations

import argparse
import ast
from typing import Any

from gsenv.envs import ENVS, PARALLEL_ENVS


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


def positive(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive whole number")
    return int(text)


def not_negative(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 0")
    return int(text)


def _assignment(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form NAME=VALUE")
    try:
        return name, ast.literal_eval(value)
    except (SyntaxError, ValueError):
        return name, value  # not a literal: a string
