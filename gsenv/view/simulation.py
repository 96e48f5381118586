"""What a session shows and steps: worlds of a scene, or of an environment (gsenv.envs.core.interactive)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gsenv.render.camera import Bounds, Camera, FollowCamera
from gsenv.render.spatial.camera import SpatialCamera
from gsenv.solver.api.world import World

FloatArray = NDArray[np.float64]


class Steering(Protocol):
    """What turns keys and a gamepad into actions."""

    def takes(self, key: str) -> bool:
        """Whether a key steers; the session does nothing else with it then."""

    def press(self, key: str) -> None: ...

    def release(self, key: str) -> None: ...

    def move_axis(self, axis: str, value: float) -> None:
        """Set a gamepad's axis, -1 to 1."""

    def press_button(self, button: str) -> bool:
        """Press a gamepad's button and return whether it steers."""

    def release_button(self, button: str) -> None: ...

    def release_all(self) -> None: ...

    def help(self) -> Sequence[tuple[str, str]]:
        """Return (keys, what they do) for the help."""


class Simulation(Protocol):
    """Worlds that a session steps and shows.

    title: of the window
    world: the World, whose `world_count` worlds are stepped together
    period: s, what `advance` advances the worlds by
    seeds: of the worlds, None where nothing is random
    steering: of an environment that is played, else None
    """

    title: str
    world: World
    period: float

    @property
    def seeds(self) -> Sequence[int] | None: ...

    @property
    def steering(self) -> Steering | None: ...

    def advance(self, before_step: Callable[[], None] | None = None) -> None:
        """Advance all worlds by a period; `before_step` is called before each step of the engine."""

    def restart(self, world: int, seed: int | None) -> None:
        """Begin anew in a world, with the given seed or the next one."""

    def camera(self, world: int, size: tuple[int, int]) -> Any:
        """Return the camera of a picture of this size in px, or None for one that shows all bodies."""

    def lines(self, world: int) -> FloatArray | None:
        """Return lines (line, 2, dim) in m to draw."""

    def decor(self, world: int) -> dict[str, Any]:
        """Return further arguments of the renderer's `render`: what there is to draw beside the bodies."""

    def captions(self, world: int) -> Sequence[str]:
        """Return the lines of text at the upper left."""

    def score(self, world: int) -> Sequence[tuple[str, str]]:
        """Return (name, value) of what is at the upper right: the return and the terms of the reward."""

    def result(self, world: int) -> str:
        """Return how the episode has ended, "" if it has not."""


class SceneSimulation:
    """Worlds of a scene that nothing controls.

    view, follow, camera: as in gsenv.scenes.SceneSpec
    """

    steering: Steering | None = None
    seeds: Sequence[int] | None = None

    def __init__(
        self,
        world: World,
        title: str,
        *,
        view: tuple[float, float, float, float] | None = None,
        follow: str | None = None,
        camera: Any = None,
    ) -> None:
        self.world = world
        self.title = title
        self.period = world.timestep
        self._view = view
        self._camera = camera
        world.step(0)  # compiles the kernel now, not in the window
        self._follow = None if follow is None else FollowCamera([world.model.body_names.index(follow)])

    def advance(self, before_step: Callable[[], None] | None = None) -> None:
        """Advance all worlds by a step of the engine."""
        if before_step is not None:
            before_step()
        self.world.step()

    def restart(self, world: int, seed: int | None) -> None:
        """Set a world to the initial state; scenes have no seeds."""
        self.world.reset(world)

    def camera(self, world: int, size: tuple[int, int]) -> Any:
        width, height = size
        if self._camera is not None:
            eye, target = self._camera
            return SpatialCamera(eye, target, width=width, height=height)
        if self._follow is not None:
            return self._follow.update(self.world.position[world], float(self.world.time[world]), width, height)
        return None if self._view is None else Camera.fit(Bounds(*self._view), width, height, margin=0.0)

    def lines(self, world: int) -> FloatArray | None:
        return None

    def decor(self, world: int) -> dict[str, Any]:
        return {}

    def captions(self, world: int) -> Sequence[str]:
        return ()

    def score(self, world: int) -> Sequence[tuple[str, str]]:
        return ()

    def result(self, world: int) -> str:
        return ""
