"""The window of render_mode="human"; needs pygame-ce, which is loaded at the first frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gsenv.view.pacing import Pacer
    from gsenv.view.window import Window as Screen


class Window:
    """Shows frames at a steady rate. The user may resize and close it; the environment then goes on without it."""

    def __init__(self, title: str, fps: float) -> None:
        self.title = title
        self.fps = fps
        self.closed_by_user = False
        self._screen: Screen | None = None
        self._pacer: Pacer | None = None

    def show(self, frame: NDArray[np.uint8]) -> None:
        """Show a (height, width, 3) frame when it is due; do nothing once the user has closed the window.

        Raises:
            ImportError: pygame-ce is missing.
            WindowError: there is no display.
        """
        from gsenv.view.events import Closed
        from gsenv.view.pacing import Pacer
        from gsenv.view.window import Window as Screen

        if self.closed_by_user:
            return
        if self._screen is None or self._pacer is None:
            self._screen = Screen(self.title, (frame.shape[1], frame.shape[0]))
            self._pacer = Pacer(self.fps)
        if any(isinstance(event, Closed) for event in self._screen.take_events()):
            self.close()
            self.closed_by_user = True
            return
        self._pacer.wait()
        self._screen.show(frame)

    def close(self) -> None:
        """Close the window; the next frame opens it again."""
        if self._screen is not None:
            self._screen.close()
        self._screen = None
        self.closed_by_user = False

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_screen": None, "_pacer": None}
