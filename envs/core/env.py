"""TaskEnv: the Gymnasium environment over one world of a task."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from gsenv.envs.core.arguments import add_settings, mapping_of
from gsenv.envs.core.fixed import RENDER_MODE, SPLIT
from gsenv.envs.core.painter import Painter, render_metadata
from gsenv.envs.core.pixels import Observer
from gsenv.envs.core.spec_tables import box_of
from gsenv.envs.core.splits import check_same_split, check_split, make_generator
from gsenv.envs.core.task import Task, TaskSnapshot, of_environment
from gsenv.solver.api.one_thread import OneThread


@dataclass(frozen=True)
class EnvSnapshot:
    """Everything that a bit-exact continuation of a single environment needs."""

    task: TaskSnapshot
    split: str
    seed: int | None  # the last that a reset was given
    generator: dict[str, Any]
    begun: bool
    settings: dict[str, Any]  # defaults of later resets


class TaskEnv(gymnasium.Env[Any, NDArray[np.float32]]):
    """A Gymnasium environment over one world of a task. Pickles and deep-copies with its state.

    Args:
        render_mode: None, "human" (a window, which shows each reset and step) or "rgb_array".
        width, height: px of frames and of observed pixels, 16 to 8192; None: 640 x 480 and 84 x 84.
        observation: "state", "pixels" or "state+pixels", a dict of both.
        split: "train" or "test": two disjoint sets of episodes, see `splits.make_generator`.
        fidelity: "fast", "balanced" or "accurate".
        randomize: {quantity: (low, high)}, ranges from which each reset draws; the task's table lists the quantities.
        diagnostics: whether the info has the solver's errors and counters of each step, as `diagnostic_<name>`.
        settings: the task's own arguments, such as `blocks=3`.

    Raises:
        TypeError: the task has no such argument.
        ValueError: a bad value; the message names the argument.
    """

    task_class: type[Task]  # of the class; an environment of several tasks has its own
    metadata: dict[str, Any] = render_metadata()
    split: str = SPLIT
    render_mode: str | None = RENDER_MODE

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        add_settings(cls)

    def __init__(
        self,
        render_mode: str | None = None,
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
        self._painter = Painter(render_mode, width, height, type(self).__name__, self.metadata["render_fps"])
        self._observer = Observer(observation, self.task_class, width, height)
        self.observation_space = self._observer.space
        self.action_space = box_of(self.task_class.actions)  # type: ignore[assignment]
        self._split = check_split(split)
        self._np_random, self._np_random_seed = make_generator(None, self._split)
        self.task = self.task_class(1, 1, settings, fidelity, randomize, diagnostics)
        self._action_shape = self.action_space.shape
        self._begun = False
        self._warned = False

    @property
    def observation(self) -> NDArray[np.float32]:
        """A copy of the present state observation (entry,), also where `observation` is "pixels"."""
        return self.task.observation[0].copy()

    @property
    def physics(self) -> dict[str, float]:
        """The task's quantities in this episode, by name."""
        return dict(zip([q.name for q in self.task.quantities], self.task.physics[0].tolist(), strict=True))

    @of_environment
    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin a new episode of the split; `options` set arguments of the task for this episode.

        Raises:
            ValueError: an unknown option, a bad value, or a seed of 2**128 or more; nothing has changed then.
        """
        checked = self.task.check_options(mapping_of(options))
        if seed is not None:
            self._np_random, self._np_random_seed = make_generator(seed, self._split)
        draws = self.np_random.random((1, self.task.reset_draws))
        self.task.reset(np.zeros(1, np.intp), draws, checked)
        self._begun = True
        self._warned = False
        self._painter.show(self.task)
        return self._observer.observe_world(self.task, 0), self.task.info(0)

    @of_environment
    def step(self, action: NDArray[np.float32]) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Advance by one control step of 1/30 s.

        A terminated episode stays in its last state: a further step warns, once, and returns the last observation, the
        reward 0 and terminated=True.

        Returns:
            (observation, reward, terminated, False, info); truncation is left to Gymnasium's TimeLimit.

        Raises:
            ValueError: the action has a wrong shape or is not finite; nothing has changed then.
            ResetNeeded: before the first reset.
            RuntimeError: another thread is in a method of this environment; nothing has changed then.
        """
        if not self._begun:
            raise ResetNeeded("step: no episode has begun, call reset first.")
        if np.shape(action) != self._action_shape:
            raise ValueError(f"step: an action has the shape {self._action_shape}, got {np.shape(action)}.")
        task = self.task
        if task.terminated[0]:
            self._warn_of_the_end()
            task.stay(0)
        else:
            task.step((action,))
        self._painter.show(task)
        observation = self._observer.observe_world(task, 0)
        return observation, float(task.reward[0]), bool(task.terminated[0]), False, task.info(0)

    def _warn_of_the_end(self) -> None:
        if not self._warned:
            gymnasium.logger.warn("step: the episode has terminated; it stays as it is until reset is called.")
        self._warned = True

    @of_environment
    def render(self) -> Any:
        """Return a frame (height, width, 3) in the mode "rgb_array", else None; "human" shows each reset and step."""
        frames = self._painter.render(self.task)
        return None if frames is None else frames[0]

    def close(self) -> None:
        self._painter.close()

    @of_environment
    def save(self) -> EnvSnapshot:
        """Return a snapshot for a bit-exact continuation: physics, task state, random generator and settings.

        What wrappers count is not in it, such as the steps of the time limit that `gymnasium.make` adds; `pickle` and
        `copy.deepcopy` of the whole environment keep that, too.
        """
        generator = dict(self.np_random.bit_generator.state)
        settings = deepcopy(self.task.settings)  # one may be a dict
        return EnvSnapshot(self.task.save(), self._split, self._np_random_seed, generator, self._begun, settings)

    @of_environment
    def restore(self, snapshot: EnvSnapshot) -> None:
        """Continue bit for bit from a snapshot of this or an equal environment, in any process.

        Raises:
            ValueError: the snapshot is of another environment or of another split; nothing is changed.
        """
        if not isinstance(snapshot, EnvSnapshot):
            raise ValueError(f"restore: this needs what save() returned, got a {type(snapshot).__name__}.")
        check_same_split(snapshot.split, self._split)
        self.task.restore(snapshot.task)
        self._np_random_seed = snapshot.seed
        self.np_random.bit_generator.state = snapshot.generator
        self._begun = snapshot.begun
        self._warned = False
        self.task.settings.update(deepcopy(snapshot.settings))
