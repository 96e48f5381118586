"""World: N worlds of one scene, stepped together. The only stateful class of the solver."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from threading import get_ident
from time import perf_counter
from typing import Any

import numpy as np

from ..core.status import MORE_CONTACTS, MORE_PAIRS, NOT_FINITE, OK
from ..core.step import step_worlds
from ..dimension import dimension
from ..jit import entry
from ..readings.overlaps import Overlaps
from ..records.bundle import Bundle
from ..records.kernel_variants import KernelVariant, kernel_variant_of
from ..records.kernel_world import has_restitution, kernel_world
from ..records.model import Array, Model
from ..records.scratch import Scratch, first_contact_capacity
from ..records.state import Snapshot, State, take_snapshot
from ..specification import check
from ..specification.scene import Scene
from . import threads
from .actions import Actions
from .interrupts import FEW_STEPS, Interrupts, Pace
from .kernel_choice import variant_of_step
from .one_thread import OneThread
from .options import Options, refuse_solver
from .parameters import OF_RANGES, Parameters, of_world
from .ranges import RangeWarnings
from .readings import Readings

MOST_WORLDS = 2**31 - 1
MOST_STEPS = 2**53  # of a call; more take longer than the age of the universe

_Call = tuple[Callable[..., tuple[int, int]], Bundle, int, int]  # the kernel and its arguments except the count


class World(Actions, Readings):
    """``world_count`` copies of a scene, stepped together.

    Args:
        scene: a Scene, or a Model that ``Scene.compile`` made.
        world_count: number of worlds.
        threads: number of threads that share the worlds; results do not depend on it, to the last bit.
        options: Options; or fidelity: "fast", "balanced" (the default) or "accurate".

    Attributes:
        control: float64 (world, actuator), read at each step; out-of-range values are clipped.
        parameters: quantities that may differ from world to world.
        state: structured arrays of all that changes in a step.
        model: the compiled scene, shared by all worlds.

    Raises:
        ValueError: bad arguments of any method, in one sentence; nothing is changed then.
        RuntimeError: another thread is in a method of this World; nothing is changed then.
    """

    def __init__(
        self,
        scene: Scene | Model,
        world_count: int = 1,
        threads: int = 1,
        options: Options | None = None,
        fidelity: str | None = None,
    ) -> None:
        if options is not None and fidelity is not None:
            raise ValueError("World: give options or a fidelity, not both; Options.preset has both.")
        self.world_count = check.whole(world_count, 1, "World: world_count", MOST_WORLDS)
        self.threads = min(check.whole(threads, 1, "World: threads"), self.world_count)
        if not isinstance(scene, (Scene, Model)):
            raise ValueError(f"World needs a Scene or a Model, got {scene!r}.")
        self.model = scene.compile() if isinstance(scene, Scene) else scene
        self._dimension = dimension(self.model.dim)
        self._variant = kernel_variant_of(self.model)
        self._use = OneThread()
        self.parameters = Parameters(self.model, self.world_count, self._changed, self._use)
        capacity = first_contact_capacity(self.model)
        self.state = State(self.model, self.world_count, capacity)
        self._ranges = RangeWarnings()
        self._set_options(Options.preset("balanced" if fidelity is None else fidelity) if options is None else options)
        self._scratches: list[Scratch] = []
        self._overlaps: Overlaps | None = None  # made when first read
        self._ranges.check_timestep(self.timestep, 1)
        self._ranges.check_bodies(self.model, self.model.nominal_bodies[None], 1)
        self._until = np.zeros(self.world_count, np.int64)
        self._pace = Pace(-(-self.world_count // self.threads) * len(self.model.bodies))
        self._made_for = (False, False)  # what the prepared calls were compiled for, as _needed returns it

    # ------------------------------------------------------------- stepping

    @property
    def options(self) -> Options:
        """The options of the simulation; a new ``Options`` may be assigned between steps."""
        return self._options

    @options.setter
    @of_world
    def options(self, options: Options) -> None:
        self._set_options(options)
        self._ranges.check_timestep(self.timestep, 2)  # of_world lies between

    def _set_options(self, options: Options) -> None:
        if not isinstance(options, Options):
            raise ValueError(f"World: options must be an Options, got {options!r}.")
        refuse_solver(options.solver, self.model)
        self._options = options
        self._options_record = options.record()
        self._calls: list[_Call] = []
        self._entries: dict[Any, Callable[..., tuple[int, int]]] = {}

    @property
    def control(self) -> Array:
        """float64 (world, actuator), read at each step; entries and the whole array may be assigned."""
        return self.state.control

    @control.setter
    @of_world
    def control(self, values: Any) -> None:
        self.state.control[:] = check.values(values, self.state.control.shape, "World: control")

    @property
    def timestep(self) -> float:
        """Duration of a step in s."""
        return self._options.timestep

    def step(self, count: int = 1) -> None:
        """Advance all worlds by ``count`` timesteps.

        Ctrl-C ends a long call within 0.2 s, or after the present step if that takes longer; all worlds have then
        taken the same number of steps, and continue as if the call had been for that number. A RuntimeWarning tells
        of worlds that have become NaN or infinite; see ``Diagnostics.finite``.

        Raises:
            ValueError: a control is NaN or infinite, or a bad count; no world has been stepped.
            MemoryError: the contacts of a step do not fit into memory.
        """
        use = self._use  # as of_world does, which takes a tenth of the time of a small world's step
        try:
            use.free.pop()
        except IndexError:
            use.check_owner("World", "step")
            self._step(count)
            return
        use.owner = get_ident()
        try:
            self._step(count)
        finally:
            use.owner = 0
            use.free.append(True)

    def _step(self, count: int) -> None:
        count = check.whole(count, 0, "step: count", MOST_STEPS)
        if not self.model.updates:
            self._advance(count)
            return
        self._check_control()
        for _ in range(count):
            self._update_constraints()
            self._advance(1)

    def _check_control(self) -> None:
        if not np.isfinite(self.control).all():
            w, k = np.argwhere(~np.isfinite(self.control))[0]
            raise ValueError(
                f"control of actuator {self.model.actuator_names[k]!r} in world {w} must be "
                f"finite, got {self.control[w, k]!r}."
            )

    def _update_constraints(self) -> None:
        """Write the rows that update functions of constraints return; changes nothing if one is invalid."""
        refreshed = [(j, update(self)) for j, update in self.model.updates]
        checked = [self.parameters.checked_rows(j, values) for j, values in refreshed]
        for rows, values in checked:
            self.parameters.write_rows(rows, values)

    def _advance(self, count: int) -> None:
        """Take ``count`` steps."""
        calls = self._calls or self._prepare_calls()
        at_once = count == 1 or (0 < count <= FEW_STEPS and count <= self._pace.steps)
        if at_once and len(calls) == 1 and self.state.motions is None:
            step, world, first, last = calls[0]
            result = step(world, first, last, count)
            if result[0] != OK or self._ranges.lost is not None:
                with Interrupts():
                    self._continue([result])
        elif count:
            self._take_blocks(count)
        else:
            self._check_control()

    def _take_blocks(self, count: int) -> None:
        """Take ``count`` steps in blocks, between which Ctrl-C takes effect.

        Where a sensor needs the motion over the last step, the last one is a block of its own.
        """
        keeps_motion = self.state.motions is not None
        with Interrupts() as interrupts:
            while count > 0:
                last = keeps_motion and (count == 1 or interrupts.pending)
                steps = 1 if last else min(count - keeps_motion, self._pace.steps)
                start = self.state.bodies.copy() if last else None
                began = perf_counter()
                self._take_steps(steps)
                self._pace.measured(steps, perf_counter() - began)
                count -= steps
                if start is not None:
                    self.state.keep_motion(start)
                if last or not keeps_motion:
                    interrupts.deliver()

    def _take_steps(self, count: int) -> None:
        """Take ``count`` steps at once."""
        results = self._run(count)
        if self._ranges.lost is not None or any(status != OK for status, _ in results):
            self._continue(results)

    def _continue(self, results: list[tuple[int, int]]) -> None:
        """Take the rest of the steps after a buffer was too small; raise ValueError for a bad control."""
        while any(status not in (OK, NOT_FINITE) for status, _ in results):
            self._check_control()
            self._grow(results)
            self._calls = []  # they hold the old buffers
            results = self._run(-1)
        self._ranges.check_finite(self.model, self.state)

    def _run(self, count: int) -> list[tuple[int, int]]:
        """Call the kernel for each thread; -1: continue with the steps of the last call."""
        calls = self._calls or self._prepare_calls()
        return threads.run([partial(step, *arguments, count) for step, *arguments in calls])

    def _prepare_calls(self) -> list[_Call]:
        """Return the kernel and its arguments for each thread, which steps a range of worlds."""
        variant = variant_of_step(self.model, self._bundle)
        self._scratches = self._scratches if variant == self._variant else []
        self._variant = variant
        parts = threads.ranges(self.world_count, self.threads)
        while len(self._scratches) < len(parts):
            self._scratches.append(Scratch(self.model, variant, self.state.contacts.shape[1]))
        calls: list[_Call] = []
        self._made_for = self._needed(variant)
        for (first, last), scratch in zip(parts, self._scratches, strict=False):
            world = self._bundle(variant, scratch)
            kind = world.numba_type
            if kind not in self._entries:
                self._entries[kind] = entry(step_worlds, world, first, last, 0)
            calls.append((self._entries[kind], world, first, last))
        self._calls = calls
        return calls

    def _bundle(self, variant: KernelVariant, scratch: Scratch) -> Bundle:
        restitution, articulated = self._needed(variant)
        return kernel_world(
            self.model,
            self.parameters,
            self.state,
            scratch,
            self._options_record,
            variant,
            restitution,
            self._options.solver,
            self._until,
            articulated,
        )

    def __getstate__(self) -> dict[str, Any]:
        # compiled code and pointers: made again when needed
        return {**self.__dict__, "_calls": [], "_entries": {}, "_overlaps": None}

    def _grow(self, results: list[tuple[int, int]]) -> None:
        """Enlarge the buffers for the step that did not fit and is then repeated."""
        for (status, needed), scratch in zip(results, self._scratches, strict=False):
            if status == MORE_PAIRS:
                scratch.grow_pairs(2 * needed)
        contacts = max((n for s, n in results if s == MORE_CONTACTS), default=0)
        if contacts:
            self._grow_contacts(contacts + contacts // 2)

    def _grow_contacts(self, capacity: int) -> None:
        self._calls = []
        for scratch in self._scratches:
            scratch.grow_contacts(capacity)
        self.state.grow_contacts(capacity)

    def _changed(self, chosen: Array, fields: Iterable[str]) -> None:
        """Wake worlds in which these fields of the parameters have changed, and warn of masses and sizes."""
        if not OF_RANGES.isdisjoint(fields):
            self._ranges.check_bodies(self.model, self.parameters.bodies[chosen], 3)
        self._wake(chosen)
        self._choose_kernel()

    def _choose_kernel(self) -> None:
        """Prepare the calls again where changed parameters need another kernel."""
        if self._calls and self._needed(self._variant) != self._made_for:
            self._calls = []

    def _needed(self, variant: KernelVariant) -> tuple[bool, bool]:
        """Whether the kernel has the code for restitution, and for joint coordinates."""
        in_trees = (variant.all or self.model.has_trees) and self._options.solver != "soft"
        return has_restitution(variant, self.parameters), self._options.articulated and in_trees

    @of_world
    def reset(self, worlds: Any = None, *, parameters: bool = True) -> None:
        """Set the chosen worlds to the initial state.

        Args:
            worlds: None for all, an int, ints or a bool mask.
            parameters: whether to set the parameters to their nominal values as well.
        """
        chosen = check.worlds(worlds, self.world_count, "reset: worlds")
        if check.flag(parameters, "reset: parameters"):
            self.parameters.reset(chosen)
            self._choose_kernel()
        self.state.reset(self.model, chosen)
        self._ranges.forget(chosen)

    # ------------------------------------------------------------- snapshots

    @of_world
    def save(self, worlds: Any = None) -> Snapshot:
        """Return a bit-exact copy of the chosen worlds' State and Parameters, which can be pickled."""
        chosen = check.worlds(worlds, self.world_count, "save: worlds")
        return take_snapshot(self.model, self.parameters, self.state, chosen)

    @of_world
    def restore(self, snapshot: Snapshot, worlds: Any = None) -> None:
        """Copy saved worlds to the chosen ones, or one saved world to all of them.

        Raises:
            ValueError: the snapshot is of another scene, or the counts do not match.
        """
        if not isinstance(snapshot, Snapshot):
            raise ValueError(f"restore needs a snapshot from save(), got {type(snapshot).__name__}.")
        chosen = check.worlds(worlds, self.world_count, "restore: worlds")
        snapshot.check(self.model, len(chosen))
        if snapshot.contact_capacity > self.state.contacts.shape[1]:
            self._grow_contacts(snapshot.contact_capacity)
        snapshot.write(self.parameters, self.state, chosen)
        self._ranges.forget(chosen)
        self._ranges.look(self.state, chosen)
        self._choose_kernel()
