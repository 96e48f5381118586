"""Writing files: whole or not at all. Everything in gsenv that writes a file uses this module.

The new content goes to a temporary file beside the old one, which is replaced in a single step once all of it is on
the disk. A full disk, an error, Ctrl-C, SIGTERM and SIGHUP leave the old file as it was, and nothing else.
"""

from __future__ import annotations

import itertools
import os
import shutil
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn

_numbers = itertools.count()
_ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))  # not all have both


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside ``path``, with its suffix; the file there replaces it when the block ends.

    A block that raises changes nothing. The folder of ``path`` is made if it is missing, a symbolic link is followed,
    and the permissions of an old file stay.

    Raises:
        OSError: ``path`` is a folder or a device, or it cannot be written to; nothing has changed then.
    """
    with replacing_all([path]) as (partial,):
        yield partial


@contextmanager
def replacing_all(paths: Sequence[str | os.PathLike[str]]) -> Iterator[list[Path]]:
    """Yield a temporary path for each path, as ``replacing`` does; the files there replace them all, or none.

    All are on the disk before the first is replaced, as a full disk may only be noticed there, and signals wait until
    the last one is: Ctrl-C, SIGTERM and SIGHUP leave files of one time.
    """
    targets = [checked_target(path) for path in paths]
    for target in targets:
        target.parent.mkdir(parents=True, exist_ok=True)
    with terminable():
        partials = [
            target.with_name(f".{target.stem[:100]}-{os.getpid()}-{next(_numbers)}{target.suffix}")
            for target in targets
        ]
        at = paths[0]
        try:
            yield partials
            for path, partial, target in zip(paths, partials, targets, strict=True):
                at = path
                _complete(partial, target)
            with _signals_waiting():
                for partial, target in zip(partials, targets, strict=True):
                    os.replace(partial, target)
        except OSError as error:
            names: dict[str | None, str | os.PathLike[str]] = dict(zip(map(str, partials), paths, strict=True))
            names[None] = at
            if error.errno is None or error.filename not in names:
                raise
            raise OSError(error.errno, error.strerror, str(names[error.filename])) from error  # not the temporary name
        finally:
            for partial in partials:
                partial.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Replace a file by a text, in UTF-8 and with "\\n" at the ends of lines."""
    write_bytes(path, text.encode())


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Replace a file by bytes."""
    with replacing(path) as partial:
        partial.write_bytes(content)


def checked_target(path: str | os.PathLike[str]) -> Path:
    """Return where a file is written to, behind symbolic links.

    Raises:
        OSError: there is a folder or a device.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise IsADirectoryError(f"{path} is a folder.")
    if target.exists() and not target.is_file():
        raise OSError(f"{path} is not a regular file.")
    return target


def check_writable(path: str | os.PathLike[str]) -> Path:
    """Return ``checked_target``, before work whose result is to be written there; nothing is made or changed.

    Raises:
        OSError: a folder or a device is there, or a file cannot be made: it is to lie in what is no folder, or in one
            that cannot be written to. Missing folders are no error.
    """
    target = checked_target(path)
    folder = next(parent for parent in target.parents if parent.exists())
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is no folder.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"the folder {folder} cannot be written to.")
    return target


def replace(partial: Path, target: Path) -> None:
    """Replace ``target`` by the file ``partial`` once all of it is on the disk."""
    _complete(partial, target)
    os.replace(partial, target)


def _complete(partial: Path, target: Path) -> None:
    """Make a file ready to replace another one: all of it on the disk, with the permissions of the old one."""
    with partial.open("r+b") as file:
        os.fsync(file.fileno())  # a full disk may only be noticed here
    if target.exists():
        shutil.copymode(target, partial)


@contextmanager
def _signals_waiting() -> Iterator[None]:
    """Handle signals that would end the program at the end of the block; only the main thread receives any."""
    waiting: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, *_ENDING) if is_main}
    handlers = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in handlers:
        signal.signal(number, lambda number, frame: waiting.append(number))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    for number in waiting:
        signal.raise_signal(number)


@contextmanager
def terminable() -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise SystemExit within the block, so that temporary files are removed.

    Nothing changes for a signal that the program handles or ignores, and in threads, which receive no signals.
    """
    is_main = threading.current_thread() is threading.main_thread()
    numbers = [number for number in _ENDING if is_main and signal.getsignal(number) is signal.SIG_DFL]
    for number in numbers:
        signal.signal(number, _exit)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)


def _exit(number: int, frame: FrameType | None) -> NoReturn:
    for each in _ENDING:
        if signal.getsignal(each) is _exit:
            signal.signal(each, signal.SIG_IGN)  # a second one must not stop the removal
    sys.exit(128 + number)  # as a shell reports a process that a signal has ended
