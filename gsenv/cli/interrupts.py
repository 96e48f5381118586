"""Ctrl-C while a file is being written, and what is printed at the end."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from .errors import FAILED, CliError


@contextmanager
def delayed(most: int | None = None, on_first: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Delay Ctrl-C to the end of the block; in the middle of it, it would spoil a whole file.

    most: times that it is delayed, after which it raises KeyboardInterrupt at once; None: always
    on_first: called when it is first pressed
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread receives signals
        return
    pressed = 0

    def remember(signal_number: int, frame: object) -> None:
        nonlocal pressed
        pressed += 1
        if most is not None and pressed > most:
            raise KeyboardInterrupt
        if pressed == 1:
            on_first()

    previous = signal.signal(signal.SIGINT, remember)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
    if pressed:
        raise KeyboardInterrupt


def say(text: str) -> None:
    """Print a result; a standard output that cannot be written to is an error of one sentence."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        raise
    except OSError as error:
        with suppress(OSError, ValueError):  # or the interpreter complains once more when it ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise CliError(f"cannot print the result: {error.strerror or error}", FAILED) from error
