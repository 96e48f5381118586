"""Windows: interactive ones for worlds (`gsenv view`, `gsenv play`), and those of the mode "human" of environments.

`show(world)` opens one on a World of your own. pygame-ce is imported when the first window opens.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gsenv.solver.api.world import World


def show(world: World, title: str = "gsenv", size: tuple[int, int] | None = None, *, paused: bool = False) -> None:
    """Open an interactive window on a World, and return when the user closes it; docs/viewer.md lists the keys.

    The window steps the world, with the controls that `world.control` has.

    Args:
        title: of the window.
        size: px, width and height; None: 640 x 480, or more on a large screen.
        paused: whether to begin paused.

    Raises:
        ImportError: pygame-ce is missing.
        WindowError: there is no display.
    """
    from gsenv.view.loop import run
    from gsenv.view.simulation import SceneSimulation
    from gsenv.view.window import default_size

    size = size or default_size()
    run(SceneSimulation(world, title), size, paused=paused)


__all__ = ["show"]
