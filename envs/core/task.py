"""Task: the rules of an environment for many worlds, independent of Gymnasium.

A task builds the scene of its worlds and has three hooks that each handle all worlds at once:
`initialize_episode` (after a reset), `apply_action` (before the physics) and `evaluate` (after it:
rewards, terminations, observations). Single and vector environments run the same hooks, so their worlds
agree bit for bit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gsenv.envs.core.arguments import (
    DIAGNOSTIC_NAMES,
    DIAGNOSTICS,
    DIAGNOSTICS_DTYPE,
    Quantity,
    Setting,
    check_fidelity,
    check_options,
    check_ranges,
    check_settings,
    read_diagnostics,
)
from gsenv.envs.core.spec_tables import (
    Entry,
    RewardTerm,
    argument_table,
    entry_table,
    fill_docstring,
    quantity_table,
    reward_table,
    table,
)
from gsenv.envs.core.steering import Control
from gsenv.solver import Options, Scene, Snapshot, World
from gsenv.solver.api.one_thread import one_thread
from gsenv.solver.records.bundle import Bundle, per_world
from gsenv.solver.records.plain import as_bytes, rows
from gsenv.solver.records.text import shown

Array = NDArray[Any]

of_environment = one_thread("environment")


@dataclass(frozen=True)
class TaskSnapshot:
    """A bit-exact copy of chosen worlds of a Task: physics, task state and last outputs. It can be pickled."""

    rules: str  # name of the Task's class
    world: Snapshot
    arrays: dict[str, Array]


class Task(ABC):
    """The rules of one environment for `world_count` worlds, independent of Gymnasium.

    Subclasses define the tables below, build the scene, and override `initialize_episode`,
    `apply_action` and `evaluate`, which read `world`, `task_state` and `physics` and write the outputs.

    Args:
        world_count: number of worlds; threads: number of threads that step them.
        settings: the task's own arguments by name, which `arguments` declares; defaults of resets.
        fidelity: "fast", "balanced" or "accurate", the solver's options.
        randomize: {quantity: (low, high)}, ranges from which each reset draws; the others stay nominal.
        diagnostics: whether each step fills `diagnostics`.

    Attributes:
        world: the simulated worlds.
        physics: (world, quantity) float64, values of `quantities` in this episode.
        with_diagnostics: whether each step fills `diagnostics`.
        diagnostics: (world,) errors and counters of the last step; zeros after a reset, and where not requested.
        low, high: float32, bounds of the observations.
        task_state: (world,) records of `task_state_fields`, which persist from step to step.
        observation: (world, entry) float32.
        reward: (world,) float64, the sum of `terms`, added from left to right.
        terms: (world,) records of the reward terms, by name.
        infos: (world,) records of `info_fields`, entries of Gymnasium's info beside `reward_<term>` of each term.
        terminated: (world,) bool.
        before_step: function that is called before each step of the engine, such as one that applies forces, or None;
            copies and pickles of the task do not have it.
        term_names: names of the terms in the info, `reward_<term>`.

    Where a task has `agents`, the shapes of actions, observation, reward and terms are (world, agent, ...).

    Raises:
        TypeError: an unknown setting.
        ValueError: a bad value of a setting, a fidelity or a range.
    """

    actions: ClassVar[tuple[Entry, ...]]
    observations: ClassVar[tuple[Entry, ...]]
    reward_terms: ClassVar[tuple[RewardTerm, ...]]
    task_state_fields: ClassVar[Sequence[tuple[Any, ...]]] = ()
    info_fields: ClassVar[Sequence[tuple[str, Any]]] = ()
    draw_count: ClassVar[int]  # uniform numbers in [0, 1) that the start of an episode uses
    engine_steps: ClassVar[int] = 2  # per control step
    agents: ClassVar[tuple[str, ...]] = ()  # names, where several act in one world
    arguments: ClassVar[tuple[Setting, ...]] = ()
    quantities: ClassVar[tuple[Quantity, ...]] = ()
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {}  # of quantities, where `randomize` is None
    controls: ClassVar[Sequence[Sequence[Control]]] = ()  # keys of each agent in `gsenv play`; none: two for each entry
    captions_below: ClassVar[bool] = False  # whether captions are in the lower left corner instead of the upper one
    max_episode_steps: ClassVar[int | None] = None  # after which a VectorEnv or ParallelEnv truncates; None: never

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
        self.settings = check_settings(settings or {}, self.arguments)
        self._checked: dict[str, tuple[Any, Any]] = {}
        self.fidelity = check_fidelity(fidelity)
        self.randomize = check_ranges(self.ranges if randomize is None else randomize, self.quantities)
        if not isinstance(diagnostics, (bool, np.bool_)):
            raise ValueError(f"diagnostics must be True or False, got {diagnostics!r}.")
        self.with_diagnostics = bool(diagnostics)
        nominal = np.array([quantity.nominal for quantity in self.quantities])
        ranges = [self.randomize.get(q.name, (q.nominal, q.nominal)) for q in self.quantities]
        self._physics_low, physics_high = np.array(ranges).reshape(-1, 2).T
        self._physics_span = physics_high - self._physics_low
        self.physics = np.tile(nominal, (world_count, 1))
        self.diagnostics = np.zeros(world_count, DIAGNOSTICS_DTYPE)
        self.low = np.array([entry.low for entry in self.observations], np.float32)
        self.high = np.array([entry.high for entry in self.observations], np.float32)
        self.world = World(self.build_scene(), world_count, threads, self.solver_options())
        self.task_state = np.zeros(world_count, np.dtype(list(self.task_state_fields), align=True))
        each = (world_count, len(self.agents)) if self.agents else (world_count,)
        self.observation = np.zeros((*each, len(self.observations)), np.float32)
        self.reward = np.zeros(each)
        self.terms = np.zeros(each, [(term.name, "f8") for term in self.reward_terms])
        self.infos = np.zeros(world_count, list(self.info_fields))
        self.terminated = np.zeros(world_count, np.bool_)
        self._actions = np.zeros((*each, len(self.actions)), np.float32)
        self._kernel_world: Bundle | None = None
        self._bundled_contacts: Array | None = None
        self.before_step: Callable[[], None] | None = None
        self.term_names = tuple(f"reward_{term.name}" for term in self.reward_terms)
        self._info_names = self.infos.dtype.names or ()
        reserved = {*self.term_names, *DIAGNOSTIC_NAMES}
        if clashes := reserved.intersection(self._info_names):
            raise ValueError(f"{type(self).__name__}.info_fields has names of the base class: {sorted(clashes)}.")

    @property
    def world_count(self) -> int:
        return len(self.task_state)

    @property
    def kernel_world(self) -> Bundle:
        """All worlds as one bundle, the argument `world` of the task's kernels; `select_world(world, w)` selects one.

        `world.state` and `world.parameters` are then the physics of world w (bodies, shapes, joints,
        contacts, ...), and `world.task` has the task's own part of it: state, info, terms, observation,
        physics. `world.task.rewards` and `terminated` have all worlds; `low` and `high` are the bounds.
        """
        if self._kernel_world is None or self._bundled_contacts is not self.world.state.contacts:
            self._kernel_world = self._bundle()
            self._bundled_contacts = self.world.state.contacts  # they grow where a step needs more
        return self._kernel_world

    def _bundle(self) -> Bundle:
        model, state, parameters = self.world.model, self.world.state, self.world.parameters
        return Bundle(
            "TaskWorld",
            model.dim,
            model=Bundle("Model", model.dim, shapes=model.shapes),
            state=Bundle(
                "State",
                model.dim,
                world=per_world(state.worlds),
                bodies=per_world(state.bodies),
                joints=per_world(state.joints),
                contacts=per_world(state.contacts),
                control=per_world(state.control),
            ),
            parameters=Bundle(
                "Parameters",
                model.dim,
                world=per_world(parameters.worlds),
                bodies=per_world(parameters.bodies),
                shapes=per_world(parameters.shapes),
                joints=per_world(parameters.joints),
                vertices=per_world(parameters.vertices) if model.needs_vertices else None,
            ),
            task=Bundle(
                "Task",
                model.dim,
                state=per_world(self.task_state),
                info=per_world(self.infos),
                terms=per_world(self.terms),
                observation=per_world(self.observation),
                physics=per_world(self.physics),
                rewards=self.reward,
                terminated=self.terminated,
                low=self.low,
                high=self.high,
            ),
        ).seal()

    @property
    def reset_draws(self) -> int:
        """Number of uniform numbers that a reset uses in each world."""
        return self.draw_count + len(self.quantities)

    # ------------------------------------------------- what a task defines

    @abstractmethod
    def build_scene(self) -> Scene:
        """Return the scene of one world."""

    def solver_options(self) -> Options:
        """Return the options of the simulation."""
        return Options.preset(self.fidelity)

    def check_options(self, options: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return all settings of an episode by name, checked.

        Raises:
            ValueError: an option that the task does not have, or a bad value.
        """
        return check_options(options, self.arguments, self.settings, self._checked)

    @abstractmethod
    def initialize_episode(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        """Begin episodes in worlds that have been reset to the scene's initial state, and fill their observations.

        Args:
            worlds: int (chosen world,), indices.
            draws: (chosen world, `draw_count`), uniform in [0, 1); the only source of randomness.
            options: settings of the episode by name, checked.
        """

    def apply_action(self, actions: Array) -> int:
        """Apply actions (world, action) before the physics step.

        By default action k drives actuator k, and [-1, 1] is mapped to its range.

        Returns:
            -1, or the first world whose actions are not finite; nothing has changed then.
        """
        bad = ~np.isfinite(actions).all(axis=1)
        if bad.any():
            return int(bad.argmax())
        ranges = self.world.model.actuators
        share = 0.5 + 0.5 * np.clip(actions, -1.0, 1.0)
        self.world.control = ranges["lower"] + share * (ranges["upper"] - ranges["lower"])
        return -1

    def simulate(self) -> None:
        """Advance the physics by one control step, `engine_steps` steps of the engine; calls `before_step` in each."""
        if self.before_step is None:
            self.world.step(self.engine_steps)
            return
        for _ in range(self.engine_steps):
            self.before_step()
            self.world.step()

    @abstractmethod
    def evaluate(self) -> None:
        """Fill `reward`, `terms`, `terminated`, `infos` and `observation` of all worlds, after the physics."""

    def camera(self, world: int, width: int, height: int) -> Any:
        """Return a gsenv.render camera for the picture of a world, or None for the renderer's own choice."""
        return None

    def lines(self, world: int) -> Array | None:
        """Return lines (line, 2, dim) in m, from where to where, that frames and pixels of a world show; None: none."""
        return None

    def decor(self, world: int) -> dict[str, Any]:
        """Return further arguments of the renderer's `render`, what frames and pixels show beside bodies and lines."""
        return {}

    def captions(self, world: int) -> Sequence[str]:
        """Return the lines of text in the upper left corner of the picture of a world, see `captions_below`."""
        return ()

    # ------------------------------------------------- stepping

    def reset(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        """Begin new episodes in `worlds`; `options` are those that `check_options` returns.

        `draws` is (chosen world, `reset_draws`), uniform in [0, 1). Quantities use theirs whether or
        not they are randomised, so equal seeds give equal episodes either way.
        """
        chosen = rows(worlds)
        self.physics[chosen] = self._physics_low + self._physics_span * draws[:, self.draw_count :]
        self.world.reset(worlds)
        for records in (self.task_state, self.terms, self.infos, self.diagnostics):
            as_bytes(records)[chosen] = 0
        self.reward[chosen] = 0.0
        self.terminated[chosen] = False
        self.initialize_episode(worlds, np.ascontiguousarray(draws[:, : self.draw_count]), options)

    def step(self, actions: ArrayLike, ignored: Array | None = None) -> None:
        """Advance all worlds by one control step.

        Args:
            actions: (world, action), clipped to [-1, 1].
            ignored: bool (world,), worlds whose actions are replaced by zeros.

        Raises:
            ValueError: actions of a wrong shape, or not finite; nothing has changed then.
        """
        buffer = self._actions
        try:
            given = np.asarray(actions, np.float32)
        except (OverflowError, TypeError, ValueError):  # OverflowError: a whole number beyond all floats
            raise ValueError(f"step: actions must be numbers, got {shown(actions)}.") from None
        if given.shape != buffer.shape:
            raise ValueError(f"step: actions must have the shape {buffer.shape}, got {given.shape}.")
        buffer[:] = given
        if ignored is not None:
            buffer[ignored] = 0.0
        bad = self.apply_action(buffer)
        if bad >= 0:
            raise ValueError(f"step: actions must be finite, got {buffer[bad]} in world {bad}.")
        self.simulate()
        if self.with_diagnostics:
            read_diagnostics(self.world, self.diagnostics)
        self.evaluate()
        if self.world.lost is not None:
            self._end_lost(self.world.lost)

    def is_lost(self, world: int) -> bool:
        """Whether the numbers of a world are not finite, so that nothing of it can be drawn."""
        lost = self.world.lost
        return lost is not None and bool(lost[world])

    def _end_lost(self, lost: Array) -> None:
        """End the episodes of worlds, bool (world,), whose numbers are not finite: one NaN would spoil a learner."""
        self.terminated[lost] = True
        self.reward[lost] = 0.0
        self.observation[lost] = np.clip(np.float32(0.0), self.low, self.high)
        for records in (self.terms, self.infos):
            records[lost] = np.zeros((), records.dtype)

    def info(self, world: int, agent: int | None = None) -> dict[str, Any]:
        """Return the info dict of one world, or of one agent in it: plain Python numbers by name.

        It is flat, because TorchRL, PettingZoo's clients and CSV loggers read no dict within a dict.
        """
        at = (world,) if agent is None else (world, agent)
        info = dict(zip(self._info_names, self.infos.item(world), strict=True))
        info |= zip(self.term_names, self.terms.item(*at), strict=True)
        if self.with_diagnostics:
            info |= zip(DIAGNOSTIC_NAMES, self.diagnostics.item(world), strict=True)
        return info

    def stay(self, world: int) -> None:
        """Begin a step of a world whose episode is over: nothing happens any more, and nothing is earned."""
        self.reward[world] = 0.0
        self.terms[world] = np.zeros((), self.terms.dtype)

    # ------------------------------------------------- snapshots

    _SAVED = (
        "task_state", "physics", "observation", "reward", "terms", "infos", "terminated", "diagnostics",
    )  # fmt: skip

    def save(self, worlds: Any = None) -> TaskSnapshot:
        chosen = slice(None) if worlds is None else worlds
        arrays = {name: getattr(self, name)[chosen].copy() for name in self._SAVED}
        return TaskSnapshot(self._rules(), self.world.save(worlds), arrays)

    def restore(self, snapshot: TaskSnapshot, worlds: Any = None) -> None:
        if snapshot.rules != self._rules():
            raise ValueError(f"restore: the snapshot is of {snapshot.rules}, not of {self._rules()}.")
        self.world.restore(snapshot.world, worlds)  # refuses a snapshot that does not fit
        chosen = slice(None) if worlds is None else worlds
        for name, array in snapshot.arrays.items():
            getattr(self, name)[chosen] = array

    @classmethod
    def _rules(cls) -> str:
        return f"{cls.__module__}.{cls.__qualname__}"

    def __getstate__(self) -> dict[str, Any]:
        return {
            "arguments": (
                self.world_count,
                self.threads,
                self.settings,
                self.fidelity,
                self.randomize,
                self.with_diagnostics,
            ),
            "snapshot": self.save(),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(*state["arguments"])  # type: ignore[misc]
        self.restore(state["snapshot"])


SHARED_ARGUMENTS = """\
- `split`: "train" (default) or "test". The two draw from different random streams, whatever the seeds, so success is
  judged with "test" on scenes that training never sees.
- `observation`: "state" (default), "pixels": the picture of the world without captions,
  `Box(0, 255, (height, width, 3), uint8)`, or "state+pixels": a Dict of both.
- `render_mode`: None, "rgb_array", or "human" (a window, needs pygame-ce).
- `width`, `height`: of frames and of observed pixels, 16 to 8192 px; 640 x 480 for frames and 84 x 84 for
  observed pixels where they are not given. An MP4 video needs even ones.
- `fidelity`: "fast", "balanced" (default) or "accurate", the accuracy of the solver."""

_EnvClass = TypeVar("_EnvClass", bound="type[Any]")


def documented(cls: _EnvClass) -> _EnvClass:
    """Fill the tables of an environment's docstring from its task's definitions; a class decorator."""
    task: type[Task] = cls.task_class
    return fill_docstring(
        cls,
        action_table=entry_table("Action", task.actions),
        observation_table=entry_table("Observation", task.observations),
        reward_table=reward_table(task.reward_terms),
        argument_table=argument_table(task.arguments),
        quantity_table=quantity_table(task.quantities),
        diagnostics_table=table(
            ("Entry of info", "Meaning"), zip(DIAGNOSTIC_NAMES, (text for _, text in DIAGNOSTICS), strict=True)
        ),
        shared_arguments=SHARED_ARGUMENTS,
    )
