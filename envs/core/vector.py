"""The native vector environment: all worlds of a task in one batch, in all autoreset modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from gsenv.envs.core.arguments import DIAGNOSTIC_NAMES, add_settings, mapping_of
from gsenv.envs.core.fixed import RENDER_MODE, SPLIT, check_fixed
from gsenv.envs.core.painter import Frame, Painter, render_metadata
from gsenv.envs.core.pixels import Observer
from gsenv.envs.core.spec_tables import box_of
from gsenv.envs.core.splits import check_same_split, check_split, make_generator
from gsenv.envs.core.streams import Streams
from gsenv.envs.core.task import Array, Task, TaskSnapshot, of_environment
from gsenv.solver.api.one_thread import OneThread
from gsenv.solver.records.text import shown

Step = tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


NEVER = -1  # as a number of steps: no limit, as for gymnasium.make
_FIXED = ("render_mode", "num_envs", "autoreset_mode", "observation_space", "action_space")  # the rest depends on them
# What `call` divides among the worlds. Anything else belongs to all of them, even where it has as many entries.
_OF_EACH_WORLD = ("np_random", "np_random_seed", "finished", "physics", "observe", "render")
_OF_ONE_WORLD = {"observation_space": "single_observation_space", "action_space": "single_action_space"}


@dataclass(frozen=True)
class VectorSnapshot:
    """Everything that a bit-exact continuation of a vector environment needs."""

    task: TaskSnapshot
    split: str
    seeds: list[int | None]  # the last that resets were given
    streams: Array
    elapsed: Array
    finished: Array
    begun: Array
    settings: dict[str, Any]  # defaults of later resets


class TaskVectorEnv(VectorEnv[Any, NDArray[np.float32], Array]):
    """N worlds of a task as a Gymnasium vector environment.

    World i of `reset(seed=s)` equals the single environment's `reset(seed=s + i)`, bit for bit, for
    every number of worlds, of threads, and in every autoreset mode.

    Args:
        num_envs: number of worlds.
        render_mode: None, "human" or "rgb_array", as for a TaskEnv; the window shows the first 16 worlds.
        max_episode_steps: number of steps after which an episode is truncated; None: the task's own, -1: never, as
            for `gymnasium.make`.
        autoreset_mode: one of Gymnasium's three modes, or its value as a string.
        threads: number of threads that step the worlds; results do not depend on it.
        width, height, observation, split, fidelity, randomize, diagnostics, settings: see TaskEnv; settings can be set
            (`set_attr("blocks", 3)`) for episodes to come.

    Attributes:
        agent_observation_space: of one agent, equal to `single_observation_space` where one acts in each world.
    """

    task_class: type[Task]  # of the class; an environment of several tasks has its own
    metadata: dict[str, Any] = render_metadata(autoreset_mode=AutoresetMode.NEXT_STEP)
    split: str = SPLIT
    render_mode: str | None = RENDER_MODE

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        add_settings(cls)

    def __init__(
        self,
        num_envs: int = 1,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        width: int | None = None,
        height: int | None = None,
        threads: int = 1,
        observation: str = "state",
        split: str = "train",
        fidelity: str = "balanced",
        randomize: Mapping[str, tuple[float, float]] | None = None,
        diagnostics: bool = False,
        **settings: Any,
    ) -> None:
        self._use = OneThread()
        if not _is_positive(num_envs):
            raise ValueError(f"num_envs must be a positive whole number, got {num_envs!r}.")
        self.max_episode_steps = check_limit("max_episode_steps", max_episode_steps, self.task_class)
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            known = [mode.value for mode in AutoresetMode]
            raise ValueError(f"autoreset_mode must be one of {known}, got {autoreset_mode!r}.") from None
        self.metadata = dict(type(self).metadata, autoreset_mode=self.autoreset_mode)
        self.num_envs = int(num_envs)
        self._painter = Painter(render_mode, width, height, type(self).__name__, self.metadata["render_fps"])
        self._observer = Observer(observation, self.task_class, width, height)
        self.agent_observation_space = self._observer.agent_space
        self.single_observation_space = self._observer.space
        self.single_action_space = box_of(self.task_class.actions, self.task_class.agents)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.task = self.task_class(self.num_envs, threads, settings, fidelity, randomize, diagnostics)
        self._split = check_split(split)
        self._streams = Streams([make_generator(None, self._split)[0] for _ in range(self.num_envs)])
        self._seeds: list[int | None] = [None] * self.num_envs
        self._elapsed = np.zeros(self.num_envs, np.int64)
        self._finished = np.zeros(self.num_envs, np.bool_)
        self._begun = np.zeros(self.num_envs, np.bool_)

    # ------------------------------------------------- reset

    @of_environment
    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Begin new episodes of the split.

        Args:
            seed: an int s, which gives world i the seed s + i, or one seed for each world.
            options: `reset_mask`, bool (num_envs,), selects worlds; the other options go to the task.

        Raises:
            ValueError: a bad option or number of seeds, or a seed of 2**128 or more; nothing has changed then.
        """
        mask = self.begin_episodes(seed, options)
        return self.observe(), self._infos(mask)

    @of_environment
    def begin_episodes(
        self, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> NDArray[np.bool_]:
        """Begin new episodes as `reset` does, but observe no world, as pictures take long.

        Returns:
            bool (num_envs,), in which worlds.

        Raises:
            ValueError: as `reset` does.
        """
        rest = mapping_of(options)
        mask = self._reset_mask(rest.pop("reset_mask", None))
        checked = self.task.check_options(rest)
        self._seed(seed, mask)
        self._begin(np.flatnonzero(mask), checked)
        self._painter.show(self.task)
        return mask

    def _reset_mask(self, given: Any) -> NDArray[np.bool_]:
        if given is None:
            return np.ones(self.num_envs, np.bool_)
        mask = np.asarray(given)
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(
                f"reset: reset_mask must be a bool array of the shape ({self.num_envs},) with at "
                f"least one True, got {given!r}."
            )
        return mask

    def _seed(self, seed: int | Sequence[int | None] | None, mask: NDArray[np.bool_]) -> None:
        if seed is None:
            return
        if _is_whole(seed):
            seeds: Sequence[Any] = [int(seed) + i for i in range(self.num_envs)]  # type: ignore[arg-type]
        elif isinstance(seed, (Sequence, np.ndarray)) and not isinstance(seed, (str, bytes)):
            seeds = seed
        else:
            wanted = f"a whole number, a list of {self.num_envs}, or None"
            raise ValueError(f"reset: seed must be {wanted}, got {shown(seed)}.")
        if len(seeds) != self.num_envs:
            raise ValueError(f"reset: {self.num_envs} seeds are needed, got {len(seeds)}.")
        for i, one in enumerate(seeds):
            if one is not None and not _is_whole(one):
                raise ValueError(f"reset: a seed must be a whole number or None, got {shown(one)} for world {i}.")
        made = [None if s is None else make_generator(int(s), self._split) for s in seeds]
        for i, pair in enumerate(made):
            if pair is not None and mask[i]:
                self._streams.seed(i, pair[0])
                self._seeds[i] = pair[1]

    def _begin(self, worlds: Array, options: Mapping[str, Any]) -> None:
        draws = np.empty((len(worlds), self.task.reset_draws))
        self._streams.draw(worlds, draws)
        self.task.reset(worlds, draws, options)
        self._elapsed[worlds] = 0
        self._finished[worlds] = False
        self._begun[worlds] = True

    # ------------------------------------------------- step

    @of_environment
    def step(self, actions: NDArray[np.float32]) -> Step:
        """Advance all worlds by one control step of 1/30 s.

        Raises:
            ValueError: actions of a wrong shape, or not finite; nothing has changed then.
            ResetNeeded: a world has not been reset yet, or, where autoreset is disabled, its episode is over.
        """
        self._check_ready()
        result = self._advance(actions)
        self._painter.show(self.task)
        return result

    def _advance(self, actions: NDArray[np.float32]) -> Step:
        if self.autoreset_mode == AutoresetMode.NEXT_STEP and self._finished.any():
            return self._step_and_begin(actions, self._finished.copy())
        self.task.step(actions)
        terminated, truncated = self._end()
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._finished.any():
            return self._end_and_begin(terminated, truncated)
        infos = self._infos(np.ones(self.num_envs, np.bool_))
        return self.observe(), self.task.reward.copy(), terminated, truncated, infos

    def _check_ready(self) -> None:
        if not self._begun.all():
            raise ResetNeeded("step: some worlds have not been reset yet, call reset first.")
        if self.autoreset_mode == AutoresetMode.DISABLED and self._finished.any():
            worlds = np.flatnonzero(self._finished).tolist()
            raise ResetNeeded(f"step: worlds {worlds} are finished, reset them with options['reset_mask'] first.")

    def _end(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which episodes have ended in this step: (terminated, truncated)."""
        self._elapsed += 1
        terminated = self.task.terminated.copy()
        if self.max_episode_steps == NEVER:
            truncated = np.zeros(self.num_envs, np.bool_)
        else:
            truncated = self._elapsed >= self.max_episode_steps
        self._finished = terminated | truncated
        return terminated, truncated

    def _step_and_begin(self, actions: NDArray[np.float32], begin: NDArray[np.bool_]) -> Step:
        """Step in the mode NEXT_STEP: worlds that ended in the last step begin anew instead of acting."""
        self.task.step(actions, ignored=begin)
        terminated, truncated = self._end()
        self._begin(np.flatnonzero(begin), self.task.check_options({}))
        terminated[begin] = False
        truncated[begin] = False
        infos = self._infos(np.ones(self.num_envs, np.bool_))
        return self.observe(), self.task.reward.copy(), terminated, truncated, infos

    def _end_and_begin(self, terminated: NDArray[np.bool_], truncated: NDArray[np.bool_]) -> Step:
        """Finish a step in the mode SAME_STEP: worlds that ended begin anew; `final_*` keep their last step."""
        ended = self._finished.copy()
        reward = self.task.reward.copy()
        last = np.full(self.num_envs, None, object)
        last[ended] = self._observer.observe_worlds(self.task, np.flatnonzero(ended))
        final_info = self._infos(ended)
        self._begin(np.flatnonzero(ended), self.task.check_options({}))
        infos = self._infos(np.ones(self.num_envs, np.bool_))
        infos |= {"final_obs": last, "_final_obs": ended.copy()}
        infos |= {"final_info": final_info, "_final_info": ended}
        return self.observe(), reward, terminated, truncated, infos

    def observe(self) -> Any:
        """Return a copy of the present observations."""
        return self._observer.observe(self.task)

    def observe_world(self, world: int) -> Any:
        """Return a copy of the present observation of one world."""
        return self._observer.observe_world(self.task, world)

    def _infos(self, mask: NDArray[np.bool_]) -> dict[str, Any]:
        """Return the infos of the worlds of `mask`, with zeros and a False mask elsewhere."""
        task = self.task
        infos = _columns(task.infos, task.infos.dtype.names or (), mask) | _columns(task.terms, task.term_names, mask)
        return infos | _columns(task.diagnostics, DIAGNOSTIC_NAMES, mask) if task.with_diagnostics else infos

    @property
    def finished(self) -> NDArray[np.bool_]:
        """(world,) a copy: which episodes have ended and have not begun anew."""
        return self._finished.copy()

    # ------------------------------------------------- pictures and snapshots

    @of_environment
    def render(self) -> tuple[Frame, ...] | None:
        """Return a frame (height, width, 3) of each world in the mode "rgb_array", else None."""
        return self._painter.render(self.task)

    def close_extras(self, **kwargs: Any) -> None:
        """Close the window, if there is one."""
        self._painter.close()

    @of_environment
    def save(self) -> VectorSnapshot:
        """Return a snapshot for a bit-exact continuation: physics, task state, random generators and settings."""
        return VectorSnapshot(
            self.task.save(),
            self._split,
            list(self._seeds),
            self._streams.words.copy(),
            self._elapsed.copy(),
            self._finished.copy(),
            self._begun.copy(),
            deepcopy(self.task.settings),  # a setting may be a dict
        )

    @of_environment
    def restore(self, snapshot: VectorSnapshot) -> None:
        """Continue bit for bit from a snapshot of this or an equal environment, in any process.

        Raises:
            ValueError: the snapshot is of another environment, split or number of worlds; nothing is changed.
        """
        if not isinstance(snapshot, VectorSnapshot):
            raise ValueError(f"restore: this needs what save() returned, got a {type(snapshot).__name__}.")
        if len(snapshot.elapsed) != self.num_envs:
            raise ValueError(f"restore: the snapshot has {len(snapshot.elapsed)} worlds, not {self.num_envs}.")
        check_same_split(snapshot.split, self._split)
        self.task.restore(snapshot.task)
        self._seeds[:] = snapshot.seeds
        self._streams.words[:] = snapshot.streams
        self._elapsed[:] = snapshot.elapsed
        self._finished[:] = snapshot.finished
        self._begun[:] = snapshot.begun
        self.task.settings.update(deepcopy(snapshot.settings))

    @of_environment
    def stagger(self, generator: np.random.Generator) -> None:
        """Let each episode that is running be truncated after a random part of the time limit, none later than now.

        Episodes that all run to the time limit begin and end together for ever; short rollouts then see one stretch of
        them at a time. Once staggered they stay so. `generator` draws the parts uniformly.

        Raises:
            ValueError: there is no time limit.
        """
        if self.max_episode_steps == NEVER:
            raise ValueError("stagger: this environment has no time limit.")
        drawn = generator.integers(0, self.max_episode_steps, self.num_envs)
        np.maximum(self._elapsed, drawn, out=self._elapsed)

    # ------------------------------------------------- Gymnasium's other accessors

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """Copies of the worlds' random generators."""
        return tuple(map(self._streams.generator, range(self.num_envs)))

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """The worlds' seeds; None where a world was never seeded."""
        return tuple(self._seeds)

    @property
    def physics(self) -> dict[str, Array]:
        """The task's quantities in the worlds' episodes, (world,) by name."""
        names = [quantity.name for quantity in self.task.quantities]
        return {name: self.task.physics[:, k].copy() for k, name in enumerate(names)}

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Return a method's result, or an attribute, once for each world.

        Each world has its own part of `np_random`, `np_random_seed`, `finished`, `physics`, `observe` and `render`, and
        the spaces are those of one world. Anything else is the same for all worlds, whatever its length.

        `call("reset", seed=s, options=o)` resets every world with the seed s, as Gymnasium's own vector environments
        do, and returns (observation, info) of each.

        Raises:
            AttributeError: there is nothing of this name.
            ValueError: the method is `step`, as autoreset is of all worlds at once; nothing has changed then.
        """
        if name == "reset":
            return self._reset_each(*args, **kwargs)
        if name == "step":
            raise ValueError("call: worlds cannot be stepped one by one; use step, with an action for each world.")
        value = getattr(self, _OF_ONE_WORLD.get(name, name))
        if callable(value) and not isinstance(value, type):
            value = value(*args, **kwargs)
        if name not in _OF_EACH_WORLD or value is None:
            return (value,) * self.num_envs
        return tuple(_part(value, world) for world in range(self.num_envs))

    def _reset_each(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, ...]:
        """Reset all worlds as single environments with equal arguments; return (observation, info) of each."""
        self.task.check_options(mapping_of(options))  # refuses `reset_mask`, which no single environment knows
        observations, infos = self.reset(seed=None if seed is None else [seed] * self.num_envs, options=options)
        own = {name: values for name, values in infos.items() if not name.startswith("_")}  # without the masks
        return tuple((_part(observations, world), _part(own, world)) for world in range(self.num_envs))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute, once for each world, see `call`."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute, to one value or to a list of equal ones: the worlds share it.

        Raises:
            AttributeError: there is no such attribute.
            ValueError: different values, or not one for each world, or what is fixed when the environment is made, or
                what each world has its own of.
        """
        if name in _OF_EACH_WORLD:
            raise ValueError(f"set_attr: {name!r} cannot be set, as each world has its own.")
        present = getattr(self, _OF_ONE_WORLD.get(name, name))
        if isinstance(values, (list, tuple)):
            if len(values) != self.num_envs or any(v is not values[0] and v != values[0] for v in values):
                raise ValueError(f"set_attr: {name!r} is shared; give one value, or {self.num_envs} equal ones.")
            values = values[0]
        if name in _FIXED:
            check_fixed(f"set_attr: {name!r}", values, present)
            return
        setattr(self, name, values)


def check_limit(name: str, limit: Any, task_class: type[Task]) -> int:
    """Return the number of steps after which episodes are truncated, or NEVER; raises ValueError for a bad one."""
    if limit is None:
        limit = task_class.max_episode_steps
        return NEVER if limit is None else limit
    if not _is_positive(limit) and not (_is_whole(limit) and limit == NEVER):
        raise ValueError(f"{name} must be a positive whole number, None or -1 for no limit, got {limit!r}.")
    return int(limit)


def _is_whole(value: Any) -> bool:
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def _is_positive(value: Any) -> bool:
    """Whether it is a whole number of at least 1."""
    return _is_whole(value) and int(value) >= 1


def _part(values: Any, world: int) -> Any:
    """Return what one world has of values (world, ...), or of a dict of such; numbers are those of Python."""
    if isinstance(values, dict):
        return {name: _part(value, world) for name, value in values.items()}
    value = values[world]
    return value.item() if isinstance(value, np.generic) else value


def _columns(records: Array, names: Sequence[str], mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return the fields of records (world, ...) as arrays of the given names, each with its mask `_name`."""
    columns: dict[str, Any] = {}
    chosen = mask.reshape(-1, *(1,) * (records.ndim - 1))
    for field, name in zip(records.dtype.names or (), names, strict=True):
        columns[name] = np.where(chosen, records[field], np.zeros((), records.dtype[field]))
        columns[f"_{name}"] = mask.copy()
    return columns
