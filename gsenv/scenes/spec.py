"""SceneSpec: how a named scene is built and recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gsenv.solver import Scene

Point = tuple[float, float, float]


@dataclass(frozen=True)
class SceneSpec:
    """A scene that can be recorded.

    Attributes:
        build: returns the Scene.
        summary: one line for lists.
        duration: s, length of a recording.
        view: m, (left, bottom, right, top) that a 2D camera shows; None fits the bodies in the first picture.
        follow: name of a body that a 2D camera follows instead.
        camera: m, (eye, target) of the camera in a 3D scene.
    """

    build: Callable[[], Scene]
    summary: str
    duration: float
    view: tuple[float, float, float, float] | None = None
    follow: str | None = None
    camera: tuple[Point, Point] | None = None

    @property
    def dim(self) -> int:
        """Dimension of the scene: 3 if it has a `camera`, else 2."""
        return 2 if self.camera is None else 3
