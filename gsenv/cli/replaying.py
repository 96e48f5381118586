"""`gsenv record --out FILE.npz` and `gsenv replay`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.files import check_writable

from .errors import FAILED, INTERRUPTED, OK, WRONG_USAGE, CliError
from .interrupts import delayed, say
from .names import SCENE_PREFIX, find_actor, suggestion
from .progress import make_progress

if TYPE_CHECKING:
    from gsenv.replay import Recording


def record_states(options: argparse.Namespace) -> int:
    """Write the states of a run."""
    from gsenv import replay
    from gsenv.envs.core.policies import named_task

    _check_states(options)
    target, own = named_task(options.target, dict(options.set))
    is_scene = target.startswith(SCENE_PREFIX)
    actor = None if is_scene else find_actor(options.policy or "random", target, options.seed, own)
    with _bar(target) as follow:
        try:
            recording = replay.record(target, options.steps, options.seed, actor, own, follow)
        except (TypeError, ValueError) as error:  # a bad --set or --seed
            raise CliError(str(error), WRONG_USAGE) from error
    interrupted, is_saved = recording.interrupted, False
    try:
        with _writing(options.out), delayed(0 if interrupted else 1):  # a second Ctrl-C gives it up
            recording.save(options.out)
            is_saved = True
    except KeyboardInterrupt:
        interrupted = True
    if not is_saved:
        print("gsenv: interrupted; nothing was written", file=sys.stderr)
        return INTERRUPTED
    say(f"{options.out}: {_contents(recording)}")
    return INTERRUPTED if interrupted else OK


def _check_states(options: argparse.Namespace) -> None:
    """Refuse what is wrong with the command line of a recording of states, and a file that cannot be written."""
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
    with _writing(options.out):
        check_writable(options.out)


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
    found = [] if parting is None else [str(parting)]
    found += replay.differences(one, other)
    made = f"made by {one.made_by}\nand by  {other.made_by}"
    say("\n".join([made, *(found or [f"{_contents(one)}: equal bit for bit"])]))
    return FAILED if found else OK


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
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise CliError(f"cannot write {path}: {error.strerror or error}", FAILED) from error


@contextmanager
def _bar(name: str) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar, and yield what moves it."""
    with make_progress() as progress:
        task = progress.add_task(name, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
