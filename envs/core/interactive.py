"""Worlds of a task in an interactive window: with a policy, with keys, or with neither."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.steering import Steering, default_controls
from gsenv.envs.core.task import Task
from gsenv.envs.core.vector import NEVER, TaskVectorEnv

Array = NDArray[Any]
Actor = Callable[[NDArray[np.float32]], NDArray[np.float32]]

SHOWN_RESULT = 1.5  # s, for which the end of an episode stays on the screen before the next one begins
LONGEST_RESULT = 4.0  # s, for which it is shown where the physics go on
SUCCESS = ("success", "is_success")


class TaskSimulation:
    """Worlds of a task, which a session (gsenv.view) steps and shows.

    An episode that ends is followed by the next one if something acts; without a policy and keys the physics go on.

    env: its worlds; the autoreset mode plays no part, since episodes begin here
    actor: a policy of observations (world, [agent,] entry), or None; it acts for whom the steering does not
    steering: of world 0, or of its first agents, or None
    """

    def __init__(
        self,
        env: TaskVectorEnv,
        title: str,
        seed: int = 0,
        actor: Actor | None = None,
        steering: Steering | None = None,
    ) -> None:
        self.env = env
        self.title = title
        self.steering = steering
        self._actor = actor
        task = env.task
        self.world = task.world
        self.period = task.engine_steps * self.world.timestep
        count = env.num_envs
        self.seeds = [seed + i for i in range(count)]
        self._elapsed = np.zeros(count, np.int64)
        self._ended_for = np.zeros(count)  # s since the end of the episode
        self._results = [""] * count
        self._returns = np.zeros(task.reward.shape)
        env.reset(seed=seed)
        start = task.save()
        task.step(np.zeros(env.action_space.shape or (), np.float32))  # compiles kernels now, not in the window
        task.restore(start)

    @property
    def task(self) -> Task:
        return self.env.task

    # ------------------------------------------------- episodes

    def restart(self, world: int, seed: int | None) -> None:
        """Begin an episode in a world, of the given seed or of the next one that no world has had."""
        self.seeds[world] = max(self.seeds) + 1 if seed is None else seed
        chosen = np.arange(self.env.num_envs) == world
        self.env.reset(seed=self.seeds, options={"reset_mask": chosen})
        self._elapsed[world] = 0
        self._ended_for[world] = 0.0
        self._results[world] = ""
        self._returns[world] = 0.0
        if self.steering is not None:
            self.steering.rest()

    def advance(self, before_step: Callable[[], None] | None = None) -> None:
        """Advance all worlds by a control step; `before_step` is called before each step of the engine."""
        ended = np.array([bool(result) for result in self._results])
        self._ended_for[ended] += self.period
        if self._actor is not None or self.steering is not None:
            for world in np.flatnonzero(self._ended_for >= SHOWN_RESULT):
                self.restart(int(world), None)
                ended[world] = False
        self.task.before_step = before_step
        self.task.step(self._actions(), ignored=ended)
        self.task.before_step = None
        for world in np.flatnonzero(ended):
            self.task.stay(int(world))  # nothing is earned any more
        running = ~ended
        self._elapsed[running] += 1
        self._returns[running] += self.task.reward[running]
        limit = self.env.max_episode_steps
        late = (self._elapsed >= limit) if limit != NEVER else np.zeros(len(ended), np.bool_)
        for world in np.flatnonzero(running & (self.task.terminated | late)):
            self._results[world] = self._describe_end(int(world))

    def _actions(self) -> Array:
        shape = self.env.action_space.shape
        assert shape is not None
        actions = np.zeros(shape, np.float32)
        if self._actor is not None:
            actions[:] = self._actor(self.task.observation)
        if self.steering is not None:
            steered = self.steering.advance(self.period)
            if self.task.agents:
                actions[0, : len(steered)] = steered
            else:
                actions[0] = steered[0]
        return actions

    def _describe_end(self, world: int) -> str:
        """Return how an episode has ended, and its return."""
        infos = self.task.infos
        names = [name for name in infos.dtype.names or () if infos.dtype[name] == np.bool_]
        if any(infos[name][world] for name in names if name in SUCCESS):
            words = "success"
        elif not self.task.terminated[world]:
            words = "time is up"
        else:
            words = ", ".join(name.replace("_", " ") for name in names if infos[name][world]) or "episode over"
        return f"{words}: return {np.mean(self._returns[world]):.2f}"

    # ------------------------------------------------- what is shown

    def camera(self, world: int, size: tuple[int, int]) -> Any:
        """Return the task's camera for a picture of this size in px, or None."""
        return self.task.camera(world, *size)

    def lines(self, world: int) -> Array | None:
        """Return lines (line, 2, dim) in m to draw."""
        return self.task.lines(world)

    def decor(self, world: int) -> dict[str, Any]:
        """Return further arguments of the renderer's `render`."""
        return self.task.decor(world)

    def captions(self, world: int) -> Sequence[str]:
        """Return the task's lines of text."""
        return self.task.captions(world)

    def result(self, world: int) -> str:
        """Return how the episode has ended, "" if it has not; also "" where the physics have gone on for a while."""
        return self._results[world] if self._ended_for[world] < LONGEST_RESULT else ""

    def score(self, world: int) -> Sequence[tuple[str, str]]:
        """Return (name, value) of the return, the reward and its terms, with a column for each agent."""
        task = self.task
        rows = [("return", self._returns[world], ".2f"), ("reward", task.reward[world], "+.3f")]
        rows += [(term.name, task.terms[term.name][world], "+.3f") for term in task.reward_terms]
        return [
            (name, "  ".join(_written(float(v), form) for v in np.atleast_1d(values))) for name, values, form in rows
        ]


def _written(value: float, form: str) -> str:
    """Return a number in the given format, one that rounds to zero without a sign."""
    text = format(value, form)
    return text.replace("-", " ").replace("+", " ") if float(text) == 0.0 else text


def make_steering(task: Task, agents: int) -> Steering:
    """Return the steering of a task, of its first agents where it has several."""
    names = [entry.name for entry in task.actions]
    controls = task.controls or (default_controls(names),)
    return Steering(names, controls[: max(agents, 1)])
