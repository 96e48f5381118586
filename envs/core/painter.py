"""Frames of a task's worlds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gsenv.envs.core.task import Task

Frame = NDArray[np.uint8]


class Painter:
    """Pictures of a task's worlds; the renderer is loaded at the first one."""

    def __init__(self, width: int, height: int) -> None:
        for name, value in (("width", width), ("height", height)):
            if not isinstance(value, (int, np.integer)) or value < 16 or value % 16:
                raise ValueError(f"{name} must be a positive multiple of 16, got {value!r}.")
        self.width = int(width)
        self.height = int(height)
        self._renderer: Any = None

    def paint(self, task: Task, world: int) -> Frame:
        from gsenv.render import make_renderer

        if self._renderer is None or self._renderer.world is not task.world:
            self._renderer = make_renderer(task.world, self.width, self.height)
        camera = task.camera(world, self.width, self.height)
        if camera is not None:
            self._renderer.camera = camera
        frame: Frame = self._renderer.render(world, hud=task.captions(world))
        return frame

    def __getstate__(self) -> dict[str, Any]:
        return {"width": self.width, "height": self.height, "_renderer": None}


def check_render_mode(render_mode: str | None, known: Sequence[str]) -> str | None:
    if render_mode is not None and render_mode not in known:
        raise ValueError(f"render_mode must be one of {[None, *known]}, got {render_mode!r}.")
    return render_mode
