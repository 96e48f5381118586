"""Frames of a task's worlds, and the window that shows them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.window import Window

if TYPE_CHECKING:
    from gsenv.envs.core.task import Task

Frame = NDArray[np.uint8]
Size = tuple[int, int]

RENDER_MODES = ("human", "rgb_array")
SIZE = (640, 480)  # px, width and height of a frame by default
LEAST_SIDE, MOST_SIDE = 16, 8192  # px
MOST_SHOWN = 16  # worlds in the window
LOST, PLAIN = ("numbers of this world overflowed",), 64  # text and grey of the frame of a world that is lost


def check_size(width: int | None, height: int | None, default: Size) -> Size:
    """Return (width, height) in px, the default where one is None; raises ValueError for a bad one."""
    for name, value in (("width", width), ("height", height)):
        whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
        if value is not None and (not whole or not LEAST_SIDE <= value <= MOST_SIDE):
            raise ValueError(f"{name} must be {LEAST_SIDE} to {MOST_SIDE} px or None, got {value!r}.")
    return (default[0] if width is None else int(width), default[1] if height is None else int(height))


class Painter:
    """What an environment renders in its render mode; the renderer and the window are loaded at the first frame.

    Args:
        render_mode: None, "human" or "rgb_array".
        width, height: px of a frame, or None for 640 and 480.
        title: of the window; fps: frames per second that it shows.

    Raises:
        ValueError: a bad render mode or size.
    """

    def __init__(self, render_mode: str | None, width: int | None, height: int | None, title: str, fps: float) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise ValueError(f"render_mode must be one of {[None, *RENDER_MODES]}, got {render_mode!r}.")
        self.render_mode = render_mode
        self.width, self.height = check_size(width, height, SIZE)
        self._window = Window(title, fps)
        self._renderer: Any = None

    def paint(self, task: Task, world: int, size: Size | None = None) -> Frame:
        """Return a frame (height, width, 3) of a world."""
        from gsenv.render import make_renderer
        from gsenv.render.checks import checked_hud
        from gsenv.render.hud import draw_hud

        width, height = size or (self.width, self.height)
        if task.is_lost(world):
            frame: Frame = np.full((height, width, 3), PLAIN, np.uint8)
            draw_hud(frame, LOST)
            return frame
        renderer = self._renderer
        if renderer is None or renderer.world is not task.world or (renderer.width, renderer.height) != (width, height):
            self._renderer = renderer = make_renderer(task.world, width, height)
        camera = task.camera(world, width, height)
        if camera is not None:
            renderer.camera = camera
        frame = renderer.render(world, lines=task.lines(world), **task.decor(world))
        texts = checked_hud(task.captions(world))
        if texts:
            draw_hud(frame, texts, below=task.captions_below)
        return frame

    def render(self, task: Task) -> tuple[Frame, ...] | None:
        """Return a frame of each world in the mode "rgb_array", else None, with a warning where there is no mode."""
        if self.render_mode is None:
            gymnasium.logger.warn("render: make the environment with render_mode='rgb_array' or 'human'.")
        if self.render_mode != "rgb_array":
            return None
        return tuple(self.paint(task, world) for world in range(task.world_count))

    def show(self, task: Task) -> None:
        """Show the worlds in the window in the mode "human"; else do nothing."""
        if self.render_mode == "human" and not self._window.closed_by_user:
            self._window.show(self._tile(task))

    def _tile(self, task: Task) -> Frame:
        """Return one frame with the first 16 worlds side by side, about as large as that of one world."""
        count = min(task.world_count, MOST_SHOWN)
        side = math.isqrt(count - 1) + 1
        size = max(self.width // side // 16, 1) * 16, max(self.height // side // 16, 1) * 16
        cells = [self.paint(task, world, size) for world in range(count)]
        cells += [np.zeros_like(cells[0])] * (-count % side)
        rows = [np.concatenate(cells[k : k + side], axis=1) for k in range(0, len(cells), side)]
        return np.concatenate(rows)

    def close(self) -> None:
        self._window.close()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_renderer": None}


def render_metadata(**others: Any) -> dict[str, Any]:
    """Return the metadata of an environment that renders with a Painter."""
    return {"render_modes": list(RENDER_MODES), "render_fps": 30, **others}
