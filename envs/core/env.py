"""TaskEnv: the Gymnasium environment over one world of a task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from gsenv.envs.core.arguments import add_settings
from gsenv.envs.core.painter import Painter, check_render_mode
from gsenv.envs.core.pixels import make_pixels
from gsenv.envs.core.spec_tables import box_of
from gsenv.envs.core.task import Array, Task, TaskSnapshot


@dataclass(frozen=True)
class EnvSnapshot:
    """Everything that a bit-exact continuation of a single environment needs."""

    task: TaskSnapshot
    generator: dict[str, Any]
    ready: bool
    settings: dict[str, Any]  # defaults of later resets


class TaskEnv(gymnasium.Env[Array, NDArray[np.float32]]):
    """A Gymnasium environment over one world of a task. Pickles and deep-copies with its state.

    Args:
        render_mode: None or "rgb_array"; width, height: px of a frame, multiples of 16.
        observation: "state" or "pixels".
        fidelity: "fast", "balanced" or "accurate".
        randomize: {quantity: (low, high)}, ranges from which each reset draws; the task's table lists the quantities.
        diagnostics: whether `info["diagnostics"]` has the solver's errors and counters of each step.
        settings: the task's own arguments, such as `blocks=3`.

    Raises:
        TypeError: the task has no such argument.
        ValueError: a bad value; the message names the argument.
    """

    task_class: ClassVar[type[Task]]
    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        add_settings(cls)

    def __init__(
        self,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
        observation: str = "state",
        fidelity: str = "balanced",
        randomize: Mapping[str, tuple[float, float]] | None = None,
        diagnostics: bool = False,
        **settings: Any,
    ) -> None:
        self.render_mode = check_render_mode(render_mode, self.metadata["render_modes"])
        self._painter = Painter(width, height)
        self._pixels = make_pixels(observation)
        self.observation_space: spaces.Box = (
            box_of(self.task_class.observations) if self._pixels is None else self._pixels.space
        )
        self.action_space: spaces.Box = box_of(self.task_class.actions)  # type: ignore[assignment]
        self.task = self.task_class(1, 1, settings, fidelity, randomize, diagnostics)
        self._action_shape = self.action_space.shape
        self._ready = False

    @property
    def observation(self) -> NDArray[np.float32]:
        """A copy of the present state observation (entry,), also where `observation` is "pixels"."""
        return self.task.observation[0].copy()

    @property
    def physics(self) -> dict[str, float]:
        """The task's quantities in this episode, by name."""
        return dict(zip([q.name for q in self.task.quantities], self.task.physics[0].tolist(), strict=True))

    def _observe(self) -> Array:
        return self.observation if self._pixels is None else self._pixels.draw(self.task, 0)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        checked = self.task.check_options({} if options is None else options)
        super().reset(seed=seed)
        draws = self.np_random.random((1, self.task.reset_draws))
        self.task.reset(np.zeros(1, np.intp), draws, checked)
        self._ready = True
        return self._observe(), self.task.info(0)

    def step(self, action: NDArray[np.float32]) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Advance by one control step of 1/30 s.

        Returns:
            (observation, reward, terminated, False, info); truncation is left to Gymnasium's TimeLimit.

        Raises:
            ValueError: the action has a wrong shape or is not finite; nothing has changed then.
            ResetNeeded: before the first reset, and after an episode has terminated.
        """
        if not self._ready:
            raise ResetNeeded("step: the episode is over or has not begun, call reset first.")
        if np.shape(action) != self._action_shape:
            raise ValueError(f"step: an action has the shape {self._action_shape}, got {np.shape(action)}.")
        task = self.task
        task.step((action,))
        terminated = bool(task.terminated[0])
        self._ready = not terminated
        info = task.info(0)
        return self._observe(), float(task.reward[0]), terminated, False, info

    def render(self) -> Any:
        if self.render_mode is None:
            gymnasium.logger.warn("render: make the environment with render_mode='rgb_array'.")
            return None
        return self._painter.paint(self.task, 0)

    def save(self) -> EnvSnapshot:
        """Return a snapshot for a bit-exact continuation: physics, task state, random generator and settings."""
        generator = dict(self.np_random.bit_generator.state)
        return EnvSnapshot(self.task.save(), generator, self._ready, dict(self.task.settings))

    def restore(self, snapshot: EnvSnapshot) -> None:
        """Continue bit for bit from a snapshot of this or an equal environment, in any process.

        Raises:
            ValueError: the snapshot is of another environment.
        """
        self.task.restore(snapshot.task)
        self.np_random.bit_generator.state = snapshot.generator
        self._ready = snapshot.ready
        self.task.settings.update(snapshot.settings)
