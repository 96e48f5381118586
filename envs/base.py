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

from gsenv.envs.arguments import (
    DIAGNOSTICS,
    DIAGNOSTICS_DTYPE,
    Quantity,
    Setting,
    check_options,
    check_ranges,
    check_settings,
    read_diagnostics,
)
from gsenv.envs.pixels import make_pixels
from gsenv.envs.spec_tables import (
    Entry,
    RewardTerm,
    argument_table,
    box_of,
    entry_table,
    fill_docstring,
    quantity_table,
    reward_table,
    table,
)
from gsenv.solver import Options, Scene, Snapshot, World
from gsenv.solver.options import FIDELITIES

Array = NDArray[Any]
Frame = NDArray[np.uint8]


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
    `_judge`, which read `world`, `records` and `physics` and write the outputs.

    Args:
        world_count: how many worlds; threads: that they are shared out over.
        settings: the task's own arguments, of `arguments`; defaults of resets.
        fidelity: "fast", "balanced" or "accurate", of the physics.
        randomize: (low, high) of quantities that each reset draws anew; the others stay nominal.
        diagnostics: whether each step says how exact it was.

    Attributes:
        world: the physics.
        physics: (world, quantity) float64, of `quantities` in this episode.
        reports: (world,) diagnostics of the last step; zeros after a reset, and where not asked for.
        low, high: float32, bounds of the observations.
        records: (world,) task state, of `record_fields`.
        observation: (world, entry) float32.
        reward: (world,) float64, the sum of `terms`, added from left to right.
        terms: (world,) reward terms by name.
        facts: (world,) what goes into the info, of `fact_fields`.
        terminated: (world,) bool.

    Where a task has `agents`, actions, observation, reward and terms are (world, agent, ...).
    """

    actions: ClassVar[tuple[Entry, ...]]
    observations: ClassVar[tuple[Entry, ...]]
    reward_terms: ClassVar[tuple[RewardTerm, ...]]
    record_fields: ClassVar[Sequence[tuple[Any, ...]]] = ()
    fact_fields: ClassVar[Sequence[tuple[str, Any]]] = ()
    draw_count: ClassVar[int]  # uniform numbers in [0, 1) that one start uses up
    engine_steps: ClassVar[int] = 2  # per control step
    agents: ClassVar[tuple[str, ...]] = ()  # names, where several act in one world
    arguments: ClassVar[tuple[Setting, ...]] = ()
    quantities: ClassVar[tuple[Quantity, ...]] = ()

    def __init__(
        self,
        world_count: int = 1,
        threads: int = 1,
        settings: Mapping[str, Any] | None = None,
        fidelity: str = "balanced",
        randomize: Mapping[str, Any] | None = None,
        diagnostics: bool = False,
    ) -> None:
        self.threads = threads
        self.settings = check_settings(settings or {}, self.arguments, type(self).__name__)
        self.fidelity = check_fidelity(fidelity)
        self.randomize = check_ranges(randomize, self.quantities)
        if not isinstance(diagnostics, (bool, np.bool_)):
            raise ValueError(f"diagnostics must be True or False, got {diagnostics!r}.")
        self.diagnostics = bool(diagnostics)
        nominal = np.array([quantity.nominal for quantity in self.quantities])
        ranges = [self.randomize.get(q.name, (q.nominal, q.nominal)) for q in self.quantities]
        self._physics_low, physics_high = np.array(ranges).reshape(-1, 2).T
        self._physics_span = physics_high - self._physics_low
        self.physics = np.tile(nominal, (world_count, 1))
        self.reports = np.zeros(world_count, DIAGNOSTICS_DTYPE)
        self.low = np.array([entry.low for entry in self.observations], np.float32)
        self.high = np.array([entry.high for entry in self.observations], np.float32)
        self.world = World(self.build_scene(), world_count, threads, self.solver_options())
        self.records = np.zeros(world_count, np.dtype(list(self.record_fields), align=True))
        each = (world_count, len(self.agents)) if self.agents else (world_count,)
        self.observation = np.zeros((*each, len(self.observations)), np.float32)
        self.reward = np.zeros(each)
        self.terms = np.zeros(each, [(term.name, "f8") for term in self.reward_terms])
        self.facts = np.zeros(world_count, list(self.fact_fields))
        self.terminated = np.zeros(world_count, np.bool_)
        self._actions = np.zeros((*each, len(self.actions)), np.float32)
        self._term_names = self.terms.dtype.names or ()
        self._fact_names = self.facts.dtype.names or ()

    @property
    def world_count(self) -> int:
        return len(self.records)

    @property
    def reset_draws(self) -> int:
        """Uniform numbers that a reset uses up in each world."""
        return self.draw_count + len(self.quantities)

    # ------------------------------------------------- what a task must say

    @abstractmethod
    def build_scene(self) -> Scene:
        """The scene of one world."""

    def solver_options(self) -> Options:
        """How the world is stepped."""
        return Options.preset(self.fidelity)

    def check_options(self, options: Mapping[str, Any]) -> Mapping[str, Any]:
        """Options of a reset, complete and valid.

        Raises:
            ValueError: an option that the task does not know or accept.
        """
        return check_options(options, self.arguments, self.settings)

    @abstractmethod
    def _start(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        """Begin episodes in worlds that are back at the authored state, and observe them."""

    def _act(self, actions: Array) -> int:
        """Pass actions on to the engine; or change nothing and return a world where they are bad.

        Returns -1 where all actions are finite. As it stands, each action drives the actuator of its
        number: -1 to 1 is that one's range.
        """
        bad = ~np.isfinite(actions).all(axis=1)
        if bad.any():
            return int(bad.argmax())
        ranges = self.world.model.actuators
        share = 0.5 + 0.5 * np.clip(actions, -1.0, 1.0)
        self.world.control = ranges["lower"] + share * (ranges["upper"] - ranges["lower"])
        return -1

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

    def reset(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        """New episodes in `worlds`; `options` as `check_options` returns them.

        `draws` is (chosen world, `reset_draws`), uniform in [0, 1). Quantities take theirs whether or
        not they are randomised: equal seeds give equal courses either way.
        """
        self.physics[worlds] = self._physics_low + self._physics_span * draws[:, self.draw_count :]
        self.world.reset(worlds)
        self.records[worlds] = np.zeros((), self.records.dtype)
        self.terms[worlds] = np.zeros((), self.terms.dtype)
        self.facts[worlds] = np.zeros((), self.facts.dtype)
        self.reward[worlds] = 0.0
        self.terminated[worlds] = False
        self.reports[worlds] = np.zeros((), DIAGNOSTICS_DTYPE)
        self._start(worlds, np.ascontiguousarray(draws[:, : self.draw_count]), options)

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
        if self.diagnostics:
            read_diagnostics(self.world, self.reports)
        self._judge()

    def info(self, world: int, agent: int | None = None) -> dict[str, Any]:
        """Info of one world, or of one agent in it, in Python's own types."""
        at = (world,) if agent is None else (world, agent)
        info = dict(zip(self._fact_names, self.facts.item(world), strict=True))
        info["reward_terms"] = dict(zip(self._term_names, self.terms.item(*at), strict=True))
        if self.diagnostics:
            names = DIAGNOSTICS_DTYPE.names or ()
            info["diagnostics"] = dict(zip(names, self.reports.item(world), strict=True))
        return info

    # ------------------------------------------------- snapshots

    _SAVED = (
        "records", "physics", "observation", "reward", "terms", "facts", "terminated", "reports",
    )  # fmt: skip

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
            "arguments": (
                self.world_count, self.threads, self.settings, self.fidelity, self.randomize,
                self.diagnostics,
            ),
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
        argument_table=argument_table(task.arguments),
        quantity_table=quantity_table(task.quantities),
        diagnostics_table=table(("Diagnostic", "Meaning"), DIAGNOSTICS),
    )


def check_fidelity(fidelity: Any) -> str:
    if not isinstance(fidelity, str) or fidelity not in FIDELITIES:
        raise ValueError(f"fidelity must be one of {list(FIDELITIES)}, got {fidelity!r}.")
    return str(fidelity)


def _setting_property(name: str) -> property:
    """A setting as an attribute of an environment, for episodes to come."""

    def read(env: Any) -> Any:
        return env.task.settings[name]

    def write(env: Any, value: Any) -> None:
        setting = next(s for s in env.task.arguments if s.name == name)
        env.task.settings[name] = setting.check(value)

    return property(read, write, doc=f"`{name}` from the next reset on, unless its options say otherwise.")


def add_settings(cls: type[Any]) -> None:
    """Give an environment class an attribute for each setting of its task."""
    task = cls.__dict__.get("task_class")
    for setting in task.arguments if task is not None else ():
        setattr(cls, setting.name, _setting_property(setting.name))


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
        from gsenv.render import make_renderer

        if self._renderer is None or self._renderer.world is not task.world:
            self._renderer = make_renderer(task.world, self.width, self.height)
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


class TaskEnv(gymnasium.Env[Array, NDArray[np.float32]]):
    """A Gymnasium environment over one world of a task. Pickles and deep-copies with its state.

    Args:
        render_mode: None or "rgb_array"; width, height: px of a frame, multiples of 16.
        observation: "state" or "pixels".
        fidelity: "fast", "balanced" or "accurate".
        randomize: {quantity: (low, high)}, drawn anew at each reset; see the task's table.
        diagnostics: whether `info["diagnostics"]` says how exact each step was.
        settings: the task's own.
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
        """A copy of the present state observation, which scripted policies read in any case."""
        return self.task.observation[0].copy()

    @property
    def physics(self) -> dict[str, float]:
        """The task's quantities in this episode, by name."""
        return dict(zip([q.name for q in self.task.quantities], self.task.physics[0].tolist(), strict=True))

    def _observe(self) -> Array:
        return self.observation if self._pixels is None else self._pixels.draw(self.task, 0)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        checked = self.task.check_options({} if options is None else options)
        super().reset(seed=seed)
        draws = self.np_random.random((1, self.task.reset_draws))
        self.task.reset(np.zeros(1, np.intp), draws, checked)
        self._ready = True
        return self._observe(), self.task.info(0)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Array, float, bool, bool, dict[str, Any]]:
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
        return self._observe(), float(task.reward[0]), terminated, False, info

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
