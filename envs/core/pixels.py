"""Observations as pictures: small RGB frames without captions, drawn by the renderer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

if TYPE_CHECKING:
    from gsenv.envs.core.task import Task

SIDE = 84  # px
OBSERVATIONS = ("state", "pixels")


def make_pixels(observation: Any, agents: Sequence[str] = ()) -> Pixels | None:
    """Return the object that draws the observations "pixels" (of each agent if there are several), or None for "state".

    Raises:
        ValueError: `observation` is neither of the two.
    """
    if not isinstance(observation, str) or observation not in OBSERVATIONS:
        raise ValueError(f"observation must be 'state' or 'pixels', got {observation!r}.")
    if observation == "state":
        return None
    return MirroredPixels() if agents else Pixels()


class Pixels:
    """Draws worlds of a task as (84, 84, 3) uint8; the renderer is loaded at the first one."""

    def __init__(self) -> None:
        self.space = spaces.Box(0, 255, (SIDE, SIDE, 3), np.uint8)
        self._renderer: Any = None

    def draw(self, task: Task, world: int) -> NDArray[np.uint8]:
        from gsenv.render import make_renderer

        if self._renderer is None or self._renderer.world is not task.world:
            self._renderer = make_renderer(task.world, SIDE, SIDE, small=True)
        camera = task.camera(world, SIDE, SIDE)
        if camera is not None:
            self._renderer.camera = camera
        picture: NDArray[np.uint8] = self._renderer.render(world)
        return picture

    def draw_all(self, task: Task) -> NDArray[np.uint8]:
        """Return the pictures of all worlds, (world, ...)."""
        return np.stack([self.draw(task, w) for w in range(task.world_count)])

    def __getstate__(self) -> dict[str, Any]:
        return {"space": self.space, "_renderer": None}


class MirroredPixels(Pixels):
    """(2, 84, 84, 3): the world as its left agent sees it, and its mirror image for the right one."""

    def __init__(self) -> None:
        super().__init__()
        self.space = spaces.Box(0, 255, (2, SIDE, SIDE, 3), np.uint8)

    def draw(self, task: Task, world: int) -> NDArray[np.uint8]:
        picture = super().draw(task, world)
        return np.stack([picture, picture[:, ::-1]])
