"""What all tasks share: the batched Task, and the Gymnasium environment over one world of it.

A task says what its worlds are made of and has four jitted passes over them: start (after a reset),
act (before the physics), judge (after it: rewards, ends, observations). Single and vector
environments run the very same passes, so their worlds agree bit for bit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from gsenv.envs.spec_tables import (
    Entry,
    RewardTerm,
    box_of,
    entry_table,
    fill_docstring,
    reward_table,
)
from gsenv.solver import Options, Scene, Snapshot, World

Array = NDArray[Any]
Frame = NDArray[np.uint8]
Generators = Sequence[np.random.Generator]


@dataclass(frozen=True)
class TaskSnapshot:
    """Chosen worlds of a Task: physics, task state and last outputs. Picklable, bit-exact."""

    world: Snapshot
    arrays: dict[str, Array]


@dataclass(frozen=True)
class EnvSnapshot:
    """A single environment: its task and its random generator."""

    task: TaskSnapshot
    generator: dict[str, Any]
    ready: bool
    settings: dict[str, Any]  # defaults of later resets


class Task(ABC):
    """The rules of one environment for `world_count` worlds, with no Gymnasium in them.

    Subclasses give the tables below, build the scene, and run their kernels in `_start`, `_act` and
    `_judge`, which read `world` and `records` and write the outputs.

    Attributes:
        world: the physics.
        records: (world,) task state, of `record_fields`.
        observation: (world, entry) float32.
        reward: (world,) float64, the sum of `terms`, added from left to right.
        terms: (world,) reward terms by name.
        facts: (world,) what goes into the info, of `fact_fields`.
        terminated: (world,) bool.
    """

    actions: ClassVar[tuple[Entry, ...]]
    observations: ClassVar[tuple[Entry, ...]]
    reward_terms: ClassVar[tuple[RewardTerm, ...]]
    record_fields: ClassVar[Sequence[tuple[Any, ...]]]
    fact_fields: ClassVar[Sequence[tuple[str, Any]]]
    draw_count: ClassVar[int]  # uniform numbers in [0, 1) that one start uses up
    engine_steps: ClassVar[int] = 2  # per control step

    def __init__(self, world_count: int, threads: int, settings: Mapping[str, Any]) -> None:
        self.threads = threads
        self.settings = dict(settings)
        self.world = World(self.build_scene(), world_count, threads, self.solver_options())
        self.records = np.zeros(world_count, np.dtype(list(self.record_fields), align=True))
        self.observation = np.zeros((world_count, len(self.observations)), np.float32)
        self.reward = np.zeros(world_count)
        self.terms = np.zeros(world_count, [(term.name, "f8") for term in self.reward_terms])
        self.facts = np.zeros(world_count, list(self.fact_fields))
        self.terminated = np.zeros(world_count, np.bool_)
        self._actions = np.zeros((world_count, len(self.actions)), np.float32)
        self._term_names = self.terms.dtype.names or ()
        self._fact_names = self.facts.dtype.names or ()

    @property
    def world_count(self) -> int:
        return len(self.records)

    # ------------------------------------------------- what a task must say

    @abstractmethod
    def build_scene(self) -> Scene:
        """The scene of one world."""

    def solver_options(self) -> Options:
        """How the world is stepped."""
        return Options()

    def check_options(self, options: Mapping[str, Any]) -> Mapping[str, Any]:
        """Options of a reset, complete and valid.

        Raises:
            ValueError: an option that the task does not know or accept.
        """
        for name in options:
            raise ValueError(f"reset: unknown option {name!r}; this environment has none.")
        return {}

    @abstractmethod
    def _start(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        """Begin episodes in worlds that are back at the authored state, and observe them."""

    @abstractmethod
    def _act(self, actions: Array) -> int:
        """Pass actions on to the engine; or change nothing and return a world where they are bad.

        Returns -1 where all actions are finite.
        """

    @abstractmethod
    def _judge(self) -> None:
        """Rewards, ends, facts and observations of all worlds after the physics."""

    def camera(self, world: int, width: int, height: int) -> Any:
        """A gsenv.render camera for a picture of a world, or None for the renderer's own choice."""
        return None

    def captions(self, world: int) -> Sequence[str]:
        """Lines of text in the corner of a picture."""
        return ()

    # ------------------------------------------------- stepping

    def reset(self, worlds: Array, generators: Generators, options: Mapping[str, Any]) -> None:
        """New episodes in `worlds`; `options` as `check_options` returns them."""
        draws = np.empty((len(worlds), self.draw_count))
        for row, w in zip(draws, worlds, strict=True):
            generators[w].random(out=row)
        self.world.reset(worlds)
        self.records[worlds] = np.zeros((), self.records.dtype)
        self.terms[worlds] = np.zeros((), self.terms.dtype)
        self.facts[worlds] = np.zeros((), self.facts.dtype)
        self.reward[worlds] = 0.0
        self.terminated[worlds] = False
        self._start(worlds, draws, options)

    def step(self, actions: ArrayLike, ignored: Array | None = None) -> None:
        """One control step of all worlds.

        Args:
            actions: (world, action), clipped to [-1, 1].
            ignored: bool (world,), worlds whose actions count as zero, whatever they are.

        Raises:
            ValueError: actions of a wrong shape, or not finite; nothing has changed then.
        """
        buffer = self._actions
        try:
            given = np.asarray(actions, np.float32)
        except (TypeError, ValueError):
            raise ValueError(f"step: actions must be numbers, got {actions!r}.") from None
        if given.shape != buffer.shape:
            raise ValueError(
                f"step: actions must have the shape {buffer.shape}, got {given.shape}."
            )
        buffer[:] = given
        if ignored is not None:
            buffer[ignored] = 0.0
        bad = self._act(buffer)
        if bad >= 0:
            raise ValueError(f"step: actions must be finite, got {buffer[bad]} in world {bad}.")
        self.world.step(self.engine_steps)
        self._judge()

    def info(self, world: int) -> dict[str, Any]:
        """Info of one world, in Python's own types."""
        info = dict(zip(self._fact_names, self.facts.item(world), strict=True))
        info["reward_terms"] = dict(zip(self._term_names, self.terms.item(world), strict=True))
        return info

    # ------------------------------------------------- snapshots

    _SAVED = ("records", "observation", "reward", "terms", "facts", "terminated")

    def save(self, worlds: Any = None) -> TaskSnapshot:
        chosen = slice(None) if worlds is None else worlds
        arrays = {name: getattr(self, name)[chosen].copy() for name in self._SAVED}
        return TaskSnapshot(self.world.save(worlds), arrays)

    def restore(self, snapshot: TaskSnapshot, worlds: Any = None) -> None:
        self.world.restore(snapshot.world, worlds)  # refuses a snapshot that does not fit
        chosen = slice(None) if worlds is None else worlds
        for name, array in snapshot.arrays.items():
            getattr(self, name)[chosen] = array

    def __getstate__(self) -> dict[str, Any]:
        return {
            "arguments": (self.world_count, self.threads, self.settings),
            "snapshot": self.save(),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(*state["arguments"])  # type: ignore[misc]
        self.restore(state["snapshot"])


_EnvClass = TypeVar("_EnvClass", bound="type[Any]")


def documented(cls: _EnvClass) -> _EnvClass:
    """Class decorator: the tables of an environment's docstring, from its task's definitions."""
    task: type[Task] = cls.task_class
    return fill_docstring(
        cls,
        action_table=entry_table("Action", task.actions),
        observation_table=entry_table("Observation", task.observations),
        reward_table=reward_table(task.reward_terms),
    )


class Painter:
    """Pictures of a task's worlds; the renderer is loaded at the first one."""

    def __init__(self, width: int, height: int) -> None:
        for name, value in (("width", width), ("height", height)):
            if not isinstance(value, (int, np.integer)) or value < 16 or value % 16:
                raise ValueError(f"{name} must be a positive multiple of 16, got {value!r}.")
        self.width = int(width)
        self.height = int(height)
        self._renderer: Any = None

    def paint(self, task: Task, world: int) -> Frame:
        from gsenv.render import SceneRenderer

        if self._renderer is None or self._renderer.world is not task.world:
            self._renderer = SceneRenderer(task.world, self.width, self.height)
        camera = task.camera(world, self.width, self.height)
        if camera is not None:
            self._renderer.camera = camera
        frame: Frame = self._renderer.render(world, hud=task.captions(world))
        return frame

    def __getstate__(self) -> dict[str, Any]:
        return {"width": self.width, "height": self.height, "_renderer": None}


def check_render_mode(render_mode: str | None, known: Sequence[str]) -> str | None:
    if render_mode is not None and render_mode not in known:
        raise ValueError(f"render_mode must be one of {[None, *known]}, got {render_mode!r}.")
    return render_mode


class TaskEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A Gymnasium environment over one world of a task. Pickles and deep-copies with its state."""

    task_class: ClassVar[type[Task]]
    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(
        self, settings: Mapping[str, Any], render_mode: str | None, width: int, height: int
    ) -> None:
        self.render_mode = check_render_mode(render_mode, self.metadata["render_modes"])
        self._painter = Painter(width, height)
        self.observation_space: spaces.Box = box_of(self.task_class.observations)  # type: ignore[assignment]
        self.action_space: spaces.Box = box_of(self.task_class.actions)  # type: ignore[assignment]
        self.task = self.task_class(1, 1, settings)
        self._action_shape = self.action_space.shape
        self._ready = False

    @property
    def observation(self) -> NDArray[np.float32]:
        """A copy of the present observation."""
        return self.task.observation[0].copy()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        checked = self.task.check_options({} if options is None else options)
        super().reset(seed=seed)
        self.task.reset(np.zeros(1, np.intp), (self.np_random,), checked)
        self._ready = True
        return self.task.observation[0].copy(), self.task.info(0)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """One control step.

        Raises:
            ValueError: an action of a wrong shape, or not finite; nothing has changed then.
            ResetNeeded: before the first reset, and after an episode has terminated.
        """
        if not self._ready:
            raise ResetNeeded("step: the episode is over or has not begun, call reset first.")
        if np.shape(action) != self._action_shape:
            raise ValueError(
                f"step: an action has the shape {self._action_shape}, got {np.shape(action)}."
            )
        task = self.task
        task.step((action,))
        terminated = bool(task.terminated[0])
        self._ready = not terminated
        info = task.info(0)
        return task.observation[0].copy(), float(task.reward[0]), terminated, False, info

    def render(self) -> Any:
        if self.render_mode is None:
            gymnasium.logger.warn("render: make the environment with render_mode='rgb_array'.")
            return None
        return self._painter.paint(self.task, 0)

    def save(self) -> EnvSnapshot:
        """All that decides how the environment goes on, its random generator included."""
        generator = dict(self.np_random.bit_generator.state)
        return EnvSnapshot(self.task.save(), generator, self._ready, dict(self.task.settings))

    def restore(self, snapshot: EnvSnapshot) -> None:
        """Go on bit for bit from a snapshot of this or an equal environment, in any process.

        Raises:
            ValueError: the snapshot is of another environment.
        """
        self.task.restore(snapshot.task)
        self.np_random.bit_generator.state = snapshot.generator
        self._ready = snapshot.ready
        self.task.settings.update(snapshot.settings)
