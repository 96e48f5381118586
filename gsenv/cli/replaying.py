"""`gsenv record --out FILE.npz` and `gsenv replay`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from gsenv.envs import ENVS, PARALLEL_ENVS

from .errors import FAILED, INTERRUPTED, OK, WRONG_USAGE, CliError
from .names import SCENE_PREFIX, find_actor, suggestion
from .progress import make_progress

if TYPE_CHECKING:
    from gsenv.replay import Recording


def record_states(options: argparse.Namespace) -> int:
    """Write the states of a run."""
    from gsenv import replay
    from gsenv.scenes import SCENES

    target = options.target
    names = [entry.id for entry in ENVS] + [entry.name for entry in PARALLEL_ENVS]
    scenes = [f"{SCENE_PREFIX}{name}" for name in SCENES]
    if target not in names + scenes:
        raise CliError(
            f"no environment or scene is called {target!r}; {suggestion(target, names + scenes)}", WRONG_USAGE
        )
    for option in ("policy", "set") if target in scenes else ():
        if getattr(options, option):
            raise CliError(f"{target} is a scene and takes no --{option}", WRONG_USAGE)
    if options.size is not None:
        raise CliError("--size is for videos, not for states", WRONG_USAGE)
    actor = None if target in scenes else find_actor(options.policy or "random", target, options.seed)
    with _bar(target) as follow:
        try:
            recording = replay.record(target, options.steps, options.seed, actor, dict(options.set), follow)
        except (TypeError, ValueError) as error:  # a bad --set
            raise CliError(str(error), WRONG_USAGE) from error
    try:
        recording.save(options.out)
    except OSError as error:
        raise CliError(f"cannot write {options.out}: {error.strerror or error}", FAILED) from error
    print(f"{options.out}: {_contents(recording)}")
    return INTERRUPTED if recording.interrupted else OK


def run_replay(options: argparse.Namespace) -> int:
    from gsenv import replay

    one = _load(options.file)
    try:
        if options.check is not None:
            other = _load(options.check)
        else:
            with _bar(one.target) as follow:
                other = replay.replay(one, follow)
        parting = replay.compare(one, other)
    except (LookupError, TypeError, ValueError) as error:
        raise CliError(str(error.args[0]), FAILED) from error
    shorter = one if len(one.times) <= len(other.times) else other
    print(f"made by {one.made_by}\nand by  {other.made_by}")
    if parting is not None:
        print(f"{parting}")
        return FAILED
    print(f"{_contents(shorter)}: equal bit for bit")
    return OK


def _contents(recording: Recording) -> str:
    return f"{recording.target}, {len(recording.times) - 1} steps of {len(recording.bodies)} bodies"


def _load(path: Path) -> Recording:
    from gsenv.replay import Recording

    try:
        return Recording.load(path)
    except OSError as error:
        raise CliError(f"cannot read {path}: {error.strerror or error}", FAILED) from error
    except ValueError as error:
        raise CliError(str(error), FAILED) from error


@contextmanager
def _bar(name: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar, and yield what moves it."""
    with make_progress() as progress:
        task = progress.add_task(name, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
