"""Child processes of tests."""

from __future__ import annotations

import signal


def hear_interrupts() -> None:
    """As preexec_fn: a child answers Ctrl-C even where the tests run in the background of a shell,
    which ignores it and hands that on."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
