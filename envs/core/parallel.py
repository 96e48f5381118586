"""PettingZoo: the parallel environment over one world of a task with several agents."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from gsenv.envs.core.arguments import add_settings, mapping_of
from gsenv.envs.core.fixed import RENDER_MODE, SPLIT
from gsenv.envs.core.painter import Frame, Painter
from gsenv.envs.core.pixels import Observer
from gsenv.envs.core.spec_tables import box_of
from gsenv.envs.core.splits import check_same_split, check_split, make_generator
from gsenv.envs.core.task import Array, Task, TaskSnapshot, of_environment
from gsenv.envs.core.vector import NEVER, check_limit
from gsenv.solver.api.one_thread import OneThread


@dataclass(frozen=True)
class ParallelSnapshot:
    """Everything that a bit-exact continuation of a parallel environment needs."""

    task: TaskSnapshot
    split: str
    seed: int  # the last that a reset was given, or that was drawn
    generator: dict[str, Any]
    begun: bool
    agents: list[str]
    elapsed: int
    settings: dict[str, Any]  # defaults of later resets


Step = tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]


def check_action(action: Any, agent: str, count: int) -> Array:
    """Return the action of an agent as an array; raises ValueError for anything but `count` numbers."""
    if action is None:
        raise ValueError(f"step: the action of {agent!r} must be {count} numbers, got None, which is for ended agents.")
    if np.shape(action) != (count,):
        raise ValueError(f"step: the action of {agent!r} must have the shape {(count,)}, got {np.shape(action)}.")
    return np.asarray(action)


class TaskParallelEnv(ParallelEnv):
    """One world whose agents act at once. Pickles and deep-copies with its state.

    Args:
        max_cycles: number of steps after which the episode is truncated; None: the task's own, -1: never.
        render_mode, width, height, observation, split, fidelity, randomize, diagnostics, settings: as in TaskEnv.
    """

    split: str = SPLIT
    render_mode: str | None = RENDER_MODE
    task_class: ClassVar[type[Task]]
    metadata: dict[str, Any]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        add_settings(cls)

    def __init__(
        self,
        render_mode: str | None = None,
        max_cycles: int | None = None,
        width: int | None = None,
        height: int | None = None,
        observation: str = "state",
        split: str = "train",
        fidelity: str = "balanced",
        randomize: Mapping[str, tuple[float, float]] | None = None,
        diagnostics: bool = False,
        **settings: Any,
    ) -> None:
        self._use = OneThread()
        self.max_cycles = check_limit("max_cycles", max_cycles, self.task_class)
        self._painter = Painter(render_mode, width, height, self.metadata["name"], self.metadata["render_fps"])
        self._observer = Observer(observation, self.task_class, width, height)
        self.task = self.task_class(1, 1, settings, fidelity, randomize, diagnostics)
        self.possible_agents = list(self.task_class.agents)
        self.agents: list[str] = []
        both = box_of(self.task_class.observations, self.possible_agents)
        self.state_space = spaces.Box(both.low.ravel(), both.high.ravel(), dtype=np.float32)
        # deep copies, because sampling from a space advances its own generator
        self.observation_spaces = {agent: deepcopy(self._observer.agent_space) for agent in self.possible_agents}
        self.action_spaces = {agent: box_of(self.task_class.actions) for agent in self.possible_agents}
        self._split = check_split(split)
        self.np_random, self.np_random_seed = make_generator(None, self._split)
        self._begun = False
        self._elapsed = 0

    def observation_space(self, agent: str) -> spaces.Space[Any]:
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

    @of_environment
    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Begin a new episode of the split; `options` set arguments of the task for this episode.

        Raises:
            ValueError: an unknown option, a bad value, or a seed of 2**128 or more; nothing has changed then.
        """
        # PettingZoo's own API test passes an option of the name "options".
        given = {name: value for name, value in mapping_of(options).items() if name != "options"}
        checked = self.task.check_options(given)
        if seed is not None:
            self.np_random, self.np_random_seed = make_generator(seed, self._split)
        self.task.reset(np.zeros(1, np.intp), self.np_random.random((1, self.task.reset_draws)), checked)
        self.agents = list(self.possible_agents)
        self._begun = True
        self._elapsed = 0
        self._painter.show(self.task)
        return self._observe(), self._infos()

    @of_environment
    def step(self, actions: Mapping[str, Array]) -> Step:
        """Advance by one control step; the episode ends for all agents at once.

        After its end there are no agents: a further step warns and returns empty dicts, as PettingZoo's own do.

        Raises:
            ValueError: actions of a wrong shape, not finite, or not of exactly the agents; nothing has
                changed then.
            ResetNeeded: before the first reset.
            RuntimeError: another thread is in a method of this environment; nothing has changed then.
        """
        if not self._begun:
            raise ResetNeeded("step: no episode has begun, call reset first.")
        if not self.agents:
            gymnasium.logger.warn("step: the episode is over; nothing happens until reset is called.")
            return {}, {}, {}, {}, {}
        self.task.step((self._ordered(actions),))
        self._elapsed += 1
        terminated = bool(self.task.terminated[0])
        # All agents end by the same signal: a success in the last step is no truncation.
        truncated = not terminated and self.max_cycles != NEVER and self._elapsed >= self.max_cycles
        rewards = dict(zip(self.agents, self.task.reward[0].tolist(), strict=True))
        ends = dict.fromkeys(self.agents, terminated), dict.fromkeys(self.agents, truncated)
        result = self._observe(), rewards, *ends, self._infos()
        if terminated or truncated:
            self.agents = []
        self._painter.show(self.task)
        return result

    def _ordered(self, actions: Mapping[str, Array]) -> list[Array]:
        if not isinstance(actions, Mapping) or set(actions) != set(self.agents):
            given = list(actions) if isinstance(actions, Mapping) else actions
            raise ValueError(f"step: actions must be of exactly the agents {self.agents}, got {given!r}.")
        return [check_action(actions[agent], agent, len(self.task.actions)) for agent in self.agents]

    def _observe(self) -> dict[str, Any]:
        return dict(zip(self.possible_agents, self._observer.observe_agents(self.task), strict=True))

    def _infos(self) -> dict[str, dict[str, Any]]:
        return {agent: self.task.info(0, a) for a, agent in enumerate(self.possible_agents)}

    # ------------------------------------------------- pictures

    @of_environment
    def render(self) -> Frame | None:
        """Return a frame (height, width, 3) in the mode "rgb_array", else None; "human" shows each reset and step."""
        frames = self._painter.render(self.task)
        return None if frames is None else frames[0]

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
        self._painter.close()

    # ------------------------------------------------- snapshots

    @of_environment
    def save(self) -> ParallelSnapshot:
        """Return a snapshot for a bit-exact continuation: physics, task state, random generator and settings."""
        generator = dict(self.np_random.bit_generator.state)
        settings = deepcopy(self.task.settings)  # one may be a dict
        return ParallelSnapshot(
            self.task.save(), self._split, self.np_random_seed, generator, self._begun, list(self.agents),
            self._elapsed, settings,
        )  # fmt: skip

    @of_environment
    def restore(self, snapshot: ParallelSnapshot) -> None:
        """Continue bit for bit from a snapshot of this or an equal environment, in any process.

        Raises:
            ValueError: the snapshot is of another environment or of another split; nothing is changed.
        """
        if not isinstance(snapshot, ParallelSnapshot):
            raise ValueError(f"restore: this needs what save() returned, got a {type(snapshot).__name__}.")
        check_same_split(snapshot.split, self._split)
        self.task.restore(snapshot.task)
        self.np_random_seed = snapshot.seed
        self.np_random.bit_generator.state = snapshot.generator
        self._begun = snapshot.begun
        self.agents = list(snapshot.agents)
        self._elapsed = snapshot.elapsed
        self.task.settings.update(deepcopy(snapshot.settings))
