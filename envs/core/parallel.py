"""PettingZoo: the parallel environment over one world of a task with several agents."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from gsenv.envs.core.arguments import add_settings
from gsenv.envs.core.painter import Frame, Painter, check_render_mode
from gsenv.envs.core.pixels import make_pixels
from gsenv.envs.core.spec_tables import box_of
from gsenv.envs.core.task import Array, Task, TaskSnapshot
from gsenv.envs.core.window import Window


@dataclass(frozen=True)
class ParallelSnapshot:
    """Everything that a bit-exact continuation of a parallel environment needs."""

    task: TaskSnapshot
    generator: dict[str, Any]
    agents: list[str]
    elapsed: int
    settings: dict[str, Any]  # defaults of later resets


Step = tuple[dict[str, Array], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]


class TaskParallelEnv(ParallelEnv):
    """One world whose agents act at once. Pickles and deep-copies with its state.

    Args:
        render_mode: None, "human" or "rgb_array"; width, height: px of a frame, multiples of 16.
        max_cycles: number of steps after which the episode is truncated; None never truncates.
        observation: "state" or "pixels".
        fidelity, randomize, diagnostics, settings: as in TaskEnv.
    """

    task_class: ClassVar[type[Task]]
    metadata: dict[str, Any]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        add_settings(cls)

    def __init__(
        self,
        render_mode: str | None = None,
        max_cycles: int | None = None,
        width: int = 640,
        height: int = 480,
        observation: str = "state",
        fidelity: str = "balanced",
        randomize: Mapping[str, tuple[float, float]] | None = None,
        diagnostics: bool = False,
        **settings: Any,
    ) -> None:
        whole = isinstance(max_cycles, (int, np.integer)) and not isinstance(max_cycles, bool)
        if max_cycles is not None and not (whole and max_cycles > 0):
            raise ValueError(f"max_cycles must be a positive whole number or None, got {max_cycles!r}.")
        self.max_cycles = max_cycles
        self.render_mode = check_render_mode(render_mode, self.metadata["render_modes"])
        self._painter = Painter(width, height)
        self._window = Window(self.metadata["name"], self.metadata["render_fps"])
        self.task = self.task_class(1, 1, settings, fidelity, randomize, diagnostics)
        self.possible_agents = list(self.task_class.agents)
        self.agents: list[str] = []
        self._make_spaces(observation)
        self._generator = seeding.np_random()[0]
        self._elapsed = 0

    def _make_spaces(self, observation: str) -> None:
        agents = self.task_class.agents
        self._pixels = make_pixels(observation, agents)
        both = box_of(self.task_class.observations, agents)
        self.state_space = spaces.Box(both.low.ravel(), both.high.ravel(), dtype=np.float32)
        self.observation_spaces = {agent: self._observation_space() for agent in agents}
        self.action_spaces = {agent: box_of(self.task_class.actions) for agent in agents}

    def _observation_space(self) -> spaces.Box:
        if self._pixels is None:
            return box_of(self.task_class.observations)
        return spaces.Box(0, 255, self._pixels.space.shape[1:], np.uint8)

    def observation_space(self, agent: str) -> spaces.Box:
        """Return the agent's space, always the same object, as PettingZoo requires."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Box:
        """Return the agent's space, always the same object, as PettingZoo requires."""
        return self.action_spaces[agent]

    @property
    def observations(self) -> NDArray[np.float32]:
        """A copy of the state observations (agent, entry), also where `observation` is "pixels"."""
        return self.task.observation[0].copy()

    @property
    def physics(self) -> dict[str, float]:
        """The task's quantities in this episode, by name."""
        return dict(zip([q.name for q in self.task.quantities], self.task.physics[0].tolist(), strict=True))

    def state(self) -> NDArray[np.float32]:
        """Return all agents' state observations, one after the other, as input of a centralised critic."""
        return self.task.observation[0].ravel().copy()

    # ------------------------------------------------- episodes

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Array], dict[str, dict[str, Any]]]:
        """Begin a new episode; `options` set arguments of the task for this episode.

        Raises:
            ValueError: an unknown option or a bad value; nothing has changed then.
        """
        # PettingZoo's own API test passes an option of the name "options".
        given = {name: value for name, value in (options or {}).items() if name != "options"}
        checked = self.task.check_options(given)
        if seed is not None:
            self._generator = seeding.np_random(seed)[0]
        self.task.reset(np.zeros(1, np.intp), self._generator.random((1, self.task.reset_draws)), checked)
        self.agents = list(self.possible_agents)
        self._elapsed = 0
        self._show()
        return self._observe(), self._infos()

    def step(self, actions: Mapping[str, Array]) -> Step:
        """Advance by one control step; the episode ends for all agents at once.

        Raises:
            ValueError: actions of a wrong shape, not finite, or not of exactly the agents; nothing has
                changed then.
            ResetNeeded: before the first reset, and after the end of an episode.
        """
        if not self.agents:
            raise ResetNeeded("step: the episode is over or has not begun, call reset first.")
        self.task.step((self._ordered(actions),))
        self._elapsed += 1
        terminated = bool(self.task.terminated[0])
        # All agents end by the same signal: a success in the last step is no truncation.
        truncated = not terminated and self.max_cycles is not None and self._elapsed >= self.max_cycles
        rewards = dict(zip(self.agents, self.task.reward[0].tolist(), strict=True))
        ends = dict.fromkeys(self.agents, terminated), dict.fromkeys(self.agents, truncated)
        result = self._observe(), rewards, *ends, self._infos()
        if terminated or truncated:
            self.agents = []
        self._show()
        return result

    def _ordered(self, actions: Mapping[str, Array]) -> list[Array]:
        if not isinstance(actions, Mapping) or set(actions) != set(self.agents):
            given = list(actions) if isinstance(actions, Mapping) else actions
            raise ValueError(f"step: actions must be of exactly the agents {self.agents}, got {given!r}.")
        shape = (len(self.task.actions),)
        for agent in self.agents:
            if np.shape(actions[agent]) != shape:
                raise ValueError(
                    f"step: the action of {agent!r} must have the shape {shape}, got {np.shape(actions[agent])}."
                )
        return [actions[agent] for agent in self.agents]

    def _observe(self) -> dict[str, Array]:
        rows = self.observations if self._pixels is None else self._pixels.draw(self.task, 0)
        return {agent: row.copy() for agent, row in zip(self.possible_agents, rows, strict=True)}

    def _infos(self) -> dict[str, dict[str, Any]]:
        return {agent: self.task.info(0, a) for a, agent in enumerate(self.possible_agents)}

    # ------------------------------------------------- pictures

    def _show(self) -> None:
        if self.render_mode == "human":
            self._window.show(self._painter.paint(self.task, 0))

    def render(self) -> Frame | None:
        """Return a frame (height, width, 3) in the mode "rgb_array", else None; "human" shows each reset and step."""
        if self.render_mode is None:
            gymnasium.logger.warn("render: make the environment with render_mode='rgb_array'.")
        return self._painter.paint(self.task, 0) if self.render_mode == "rgb_array" else None

    def film(
        self,
        policy: Callable[[NDArray[np.float32]], NDArray[np.float32]] | None,
        seed: int,
        step_count: int,
        *,
        one_episode: bool = True,
    ) -> Iterator[Frame | None]:
        """Yield frames of episodes; the policy maps (agent, entry) to (agent, action), None acts at random."""
        for a, agent in enumerate(self.possible_agents):
            self.action_space(agent).seed(seed + a)
        self.reset(seed=seed)
        yield self.render()
        for step in range(step_count):
            rows = [self.action_space(agent).sample() for agent in self.agents]
            actions = rows if policy is None else policy(self.observations)
            self.step(dict(zip(self.agents, actions, strict=True)))
            yield self.render()
            if not self.agents:
                if one_episode or step + 1 == step_count:
                    break
                self.reset()

    def close(self) -> None:
        self._window.close()

    # ------------------------------------------------- snapshots

    def save(self) -> ParallelSnapshot:
        """Return a snapshot for a bit-exact continuation: physics, task state, random generator and settings."""
        generator = dict(self._generator.bit_generator.state)
        return ParallelSnapshot(self.task.save(), generator, list(self.agents), self._elapsed, dict(self.task.settings))

    def restore(self, snapshot: ParallelSnapshot) -> None:
        """Continue bit for bit from a snapshot of this or an equal environment, in any process.

        Raises:
            ValueError: the snapshot is of another environment.
        """
        self.task.restore(snapshot.task)
        self._generator.bit_generator.state = snapshot.generator
        self.agents = list(snapshot.agents)
        self._elapsed = snapshot.elapsed
        self.task.settings.update(snapshot.settings)
