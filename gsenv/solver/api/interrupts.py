"""Ctrl-C in long calls: it takes effect between blocks of steps, at states that are whole."""

from __future__ import annotations

import signal
import threading
from importlib import import_module
from types import FrameType, TracebackType
from typing import Any, Self

BLOCK_SECONDS = 0.03  # of a block of steps: Ctrl-C waits for its end
FEW_STEPS = 8  # which are taken at once where a block has as many
MOST_BODY_STEPS = 8000  # of a block, since bodies that all sleep may wake within it and take far longer

try:  # CPython's own module, without the conversion to enums, which takes 20 us
    _signals: Any = import_module("_signal")
except ImportError:
    _signals = signal
SIGINT = int(signal.SIGINT)


class Interrupts:
    """A ``with`` block in which Ctrl-C only sets ``pending``; ``deliver`` and the end of the block then handle it.

    What handles it is the handler of the signal SIGINT that was set before, which raises KeyboardInterrupt unless
    the program has its own. Other threads than the main one receive no signals, so for them nothing changes.
    """

    def __init__(self) -> None:
        self.pending = False
        self._handler = _signals.getsignal(SIGINT)
        self._replaced = False

    def __enter__(self) -> Self:
        if callable(self._handler) and threading.current_thread() is threading.main_thread():
            try:
                _signals.signal(SIGINT, self._remember)
            except ValueError:  # the main thread of a subinterpreter, which receives no signals either
                return self
            self._replaced = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._replaced:
            _signals.signal(SIGINT, self._handler)
        self.deliver()

    def deliver(self) -> None:
        """Handle a pending Ctrl-C, which usually raises KeyboardInterrupt."""
        if self.pending and callable(self._handler):
            self.pending = False
            self._handler(SIGINT, None)

    def _remember(self, number: int, frame: FrameType | None) -> None:
        self.pending = True


class Pace:
    """The number of steps of a block, which follows from the measured time of a step.

    Args:
        bodies: number of bodies that a step moves, of all worlds of a thread.
    """

    def __init__(self, bodies: int) -> None:
        self._most = max(1, MOST_BODY_STEPS // max(bodies, 1))
        self.steps = 1

    def measured(self, steps: int, seconds: float) -> None:
        """Set the length of the next block after one of ``steps`` has taken ``seconds``."""
        self.steps = max(1, min(self._most, int(BLOCK_SECONDS * steps / max(seconds, 1e-9))))
