"""What a scene says of how to film it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gsenv.solver import Scene

Point = tuple[float, float, float]


@dataclass(frozen=True)
class SceneSpec:
    """A scene that can be recorded.

    Attributes:
        build: makes the Scene.
        summary: one line for lists.
        duration: s worth watching.
        view: m, (left, bottom, right, top) that the camera shows; None: what is there at the start.
        follow: body that the camera follows instead.
        camera: m, of spatial scenes: (eye, target), where the camera is and what it looks at.
    """

    build: Callable[[], Scene]
    summary: str
    duration: float
    view: tuple[float, float, float, float] | None = None
    follow: str | None = None
    camera: tuple[Point, Point] | None = None

    @property
    def dim(self) -> int:
        """2, or 3 where there is an eye."""
        return 2 if self.camera is None else 3
