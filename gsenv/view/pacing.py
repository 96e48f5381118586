"""Steady frame rates."""

from __future__ import annotations

import time


class Pacer:
    """Waits until the next frame is due.

    fps: frames per second
    """

    def __init__(self, fps: float) -> None:
        self.interval = 1.0 / fps
        self._due: float | None = None

    def wait(self) -> None:
        """Wait until the next frame is due; frames that are late delay the later ones, they do not speed them up."""
        now = time.perf_counter()
        if self._due is None or now > self._due:
            self._due = now
        elif self._due > now:
            time.sleep(self._due - now)
        self._due += self.interval
