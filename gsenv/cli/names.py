"""Names on the command line: environments, scenes and policies."""

from collections.abc import Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

from gsenv.envs import ENVS, PARALLEL_ENVS

from .errors import FAILED, WRONG_USAGE, CliError

if TYPE_CHECKING:
    from gsenv.train.evaluate import Actor

SCENE_PREFIX = "scene:"


def suggestion(wrong: str, names: list[str]) -> str:
    spellings = {name.lower(): name for name in names}
    spellings |= {name.removeprefix(SCENE_PREFIX).lower(): name for name in names}
    close = get_close_matches(wrong.lower(), spellings, n=1)
    return f"did you mean {spellings[close[0]]}?" if close else "`gsenv list` shows them all"


def find_actor(policy: str, env_id: str, seed: int, arguments: Mapping[str, Any]) -> "Actor":
    from gsenv.train.evaluate import PolicyError, make_actor

    try:
        return make_actor(policy, env_id, seed, arguments)
    except PolicyError as error:
        raise CliError(str(error), FAILED) from error


def check_env(name: str) -> None:
    names = [entry.id for entry in ENVS] + [entry.name for entry in PARALLEL_ENVS]
    if name.startswith(SCENE_PREFIX):
        raise CliError(
            f"{name} is a scene, and this needs an environment; `gsenv view` and `record` take scenes", WRONG_USAGE
        )
    if name not in names:
        raise CliError(f"no environment is called {name!r}; {suggestion(name, names)}", WRONG_USAGE)
