"""What renderers of 2D and 3D refuse, and the threads that they refuse to share a World with."""

from collections.abc import Callable, Sequence
from operator import index
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.api.one_thread import OneThread, one_thread

T = TypeVar("T")


class WorldUse:
    """Keeps other threads out of a World while it is drawn, as the World's own methods do."""

    def __init__(self, world: Any) -> None:
        self._use: OneThread = getattr(world, "_use", None) or OneThread()  # tests have worlds of their own

    @one_thread("World")
    def render(self, draw: Callable[[], T]) -> T:
        """Return what ``draw`` returns; this method's name is in the error."""
        return draw()


def check_dimension(world: Any, dim: int, who: str) -> None:
    """Raise ValueError for a World of another dimension than the renderer's."""
    if world.model.dim != dim:
        raise ValueError(f"a {who} draws {dim}D worlds, got one with dim {world.model.dim}.")


def checked_index(world: Any, number: Any) -> int:
    """Return the index of a world; raises ValueError where there is none."""
    count = len(world.state.bodies)
    try:
        found = -1 if isinstance(number, (bool, np.bool_)) else index(number)
    except TypeError:
        found = -1
    if not 0 <= found < count:
        raise ValueError(f"render: world_index must be a whole number from 0 to {count - 1}, got {number!r}.")
    return found


def checked_hud(hud: Sequence[str]) -> tuple[str, ...]:
    """Return lines of text; raises ValueError for anything else, and for a single text."""
    lines = () if isinstance(hud, str) or not hasattr(hud, "__iter__") else tuple(hud)
    if isinstance(hud, str) or not hasattr(hud, "__iter__") or not all(isinstance(line, str) for line in lines):
        raise ValueError(f"render: hud must be a sequence of lines of text, got {hud!r}.")
    return lines


def checked_lines(lines: Any, dim: int) -> NDArray[np.float64] | None:
    """Return lines (line, 2, dim) in m, or None; raises ValueError for anything else."""
    if lines is None:
        return None
    try:
        found = np.asarray(lines, np.float64)
    except (TypeError, ValueError):
        found = np.full(1, np.nan)
    if found.ndim != 3 or found.shape[1:] != (2, dim):
        raise ValueError(f"render: lines must be an array (line, 2, {dim}) of numbers, got {np.shape(lines)}.")
    if not np.isfinite(found).all():
        raise ValueError("render: lines must be finite.")
    return found


def check_finite(world: Any, number: int) -> None:
    """Raise ValueError where a body that would be drawn is nowhere."""
    bodies = world.state.bodies[number]
    if np.isfinite(bodies["position"]).all() and np.isfinite(bodies["rotation"]).all():
        return
    known = np.isfinite(bodies["position"]).all(axis=-1) & np.isfinite(bodies["rotation"]).all(axis=-1)
    lost = np.flatnonzero(~known & (world.parameters.bodies[number]["enabled"] != 0))
    if len(lost):
        name = world.model.body_names[lost[0]]
        raise ValueError(f"render: the pose of body {name!r} in world {number} is not finite.")


def checked_names(names: Any, known: Sequence[str], what: str) -> tuple[str, ...]:
    """Return names that are all known; raises ValueError for others, and for a single text."""
    if isinstance(names, str):
        raise ValueError(f"{what} must be a sequence of names, such as ({names!r},), got {names!r}.")
    found = tuple(names)
    for name in found:
        if name not in known:
            raise ValueError(f"{what} must be among {known}, got {name!r}.")
    return found


def checked_bodies(bodies: Any, what: str, count: int | None = None) -> list[int]:
    """Return indices of bodies, below ``count`` where it is known; raises ValueError for others."""
    try:
        found = [index(body) for body in bodies]
    except TypeError:
        found = [-1]
    if any(body < 0 or (count is not None and body >= count) for body in found):
        below = "" if count is None else f", below {count}"
        raise ValueError(f"{what} must be indices of bodies{below}, got {bodies!r}.")
    return found
