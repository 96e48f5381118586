"""Observations as users ask for them: the state, a small RGB picture without captions, or both."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from gsenv.envs.core.painter import check_size
from gsenv.envs.core.spec_tables import box_of

if TYPE_CHECKING:
    from gsenv.envs.core.task import Task

Array = NDArray[Any]

SIDE = 84  # px, width and height by default
OBSERVATIONS = ("state", "pixels", "state+pixels")


class Observer:
    """Makes observations of a task's worlds; the renderer is loaded at the first picture.

    "state" gives the task's float32 entries, "pixels" pictures (height, width, 3) uint8, "state+pixels" a dict of both.
    Where a task has agents, the arrays of a world are (agent, ...), and of two agents the right one sees the mirror
    image of what the left one sees.

    Args:
        observation: one of the three; task_class: the Task.
        width, height: px of a picture, or None for 84.

    Attributes:
        space: of the observation of one world.
        agent_space: of the observation of one agent, equal to `space` where there are none.

    Raises:
        ValueError: `observation` is none of the three, or a bad size.
    """

    def __init__(
        self, observation: Any, task_class: type[Task], width: int | None = None, height: int | None = None
    ) -> None:
        if not isinstance(observation, str) or observation not in OBSERVATIONS:
            raise ValueError(f"observation must be one of {list(OBSERVATIONS)}, got {observation!r}.")
        self.kind = observation
        self.width, self.height = check_size(width, height, (SIDE, SIDE))
        self._agents = task_class.agents
        self.space = self._space(task_class, self._agents)
        self.agent_space = self._space(task_class, ())
        self._renderer: Any = None

    def _space(self, task_class: type[Task], agents: tuple[str, ...]) -> Any:
        state = box_of(task_class.observations, agents)
        each = (len(agents),) if agents else ()
        pixels = spaces.Box(0, 255, (*each, self.height, self.width, 3), np.uint8)
        both = spaces.Dict({"pixels": pixels, "state": state})
        return {"state": state, "pixels": pixels, "state+pixels": both}[self.kind]

    def observe_world(self, task: Task, world: int) -> Any:
        """Return the present observation of one world, a copy."""
        if self.kind == "state":
            return task.observation[world].copy()
        pixels = self._draw(task, world)
        return pixels if self.kind == "pixels" else {"pixels": pixels, "state": task.observation[world].copy()}

    def observe(self, task: Task) -> Any:
        """Return the present observations of all worlds, copies: (world, ...), or a dict of such arrays."""
        if self.kind == "state":
            return task.observation.copy()
        pixels = np.stack([self._draw(task, world) for world in range(task.world_count)])
        return pixels if self.kind == "pixels" else {"pixels": pixels, "state": task.observation.copy()}

    def observe_worlds(self, task: Task, worlds: Array) -> Array:
        """Return the present observations of some worlds as an array (chosen world,) of objects, copies."""
        if self.kind == "state":
            rows: Any = task.observation[worlds]
        else:
            rows = [self.observe_world(task, world) for world in worlds.tolist()]
        return np.fromiter(rows, object, len(rows))

    def observe_agents(self, task: Task) -> list[Any]:
        """Return the present observation of each agent of world 0, copies."""
        world = self.observe_world(task, 0)
        return [take(world, a) for a in range(len(self._agents))]

    def _draw(self, task: Task, world: int) -> Array:
        if task.is_lost(world):
            picture: Array = np.zeros((self.height, self.width, 3), np.uint8)
        else:
            picture = self._render(task, world)
        return np.stack([picture, picture[:, ::-1]]) if self._agents else picture

    def _render(self, task: Task, world: int) -> Array:
        from gsenv.render import make_renderer

        if self._renderer is None or self._renderer.world is not task.world:
            self._renderer = make_renderer(task.world, self.width, self.height, small=True)
        camera = task.camera(world, self.width, self.height)
        if camera is not None:
            self._renderer.camera = camera
        picture: Array = self._renderer.render(world, lines=task.lines(world), **task.decor(world))
        return picture

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_renderer": None}


def take(observations: Any, index: int) -> Any:
    """Return a copy of one of many observations, an array or a dict of arrays."""
    if isinstance(observations, dict):
        return {name: array[index].copy() for name, array in observations.items()}
    return observations[index].copy()


def put(observations: Any, index: int, observation: Any) -> None:
    """Replace one of many observations."""
    if isinstance(observations, dict):
        for name, array in observations.items():
            array[index] = observation[name]
    else:
        observations[index] = observation
