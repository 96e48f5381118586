"""Recordings of runs: the states of all bodies after each step, to compare machines, versions and changes bit for bit.

``record`` runs an environment or a scene, ``replay`` runs a recording again with its own actions, and ``compare`` finds
the first step and body in which two recordings part.
"""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.mlp import MOST_BYTES, read_arrays
from gsenv.envs.core.splits import MOST_SEED
from gsenv.files import replacing

Array = NDArray[Any]
QUANTITIES = ("position", "rotation", "velocity")
SCENE_PREFIX = "scene:"
UNLIMITED = 1000  # steps of an episode that has no limit
_VERSION = 1
_TEXTS = ("target", "settings", "made_by")
_WIDTHS = (((2,), (2,), (3,)), ((3,), (4,), (6,)))  # of the quantities, in 2D and in 3D


@dataclass
class Recording:
    """A run of one world.

    Attributes:
        target: id of an environment, or "scene:" and the name of a scene.
        seed: of the first episode.
        arguments: of the environment.
        made_by: versions and machine, for people.
        interrupted: whether Ctrl-C ended it early; not saved.
        bodies: names.
        times: (state,) s, of the world.
        states: of each of `QUANTITIES` an array (state, body, numbers) in m, rad, m/s and rad/s; the first state is
            that before the first step.
        actions: (step, number) or (step, agent, number) of environments, (step, 0) of scenes.
    """

    target: str
    seed: int
    arguments: dict[str, Any]
    bodies: list[str]
    times: Array
    states: dict[str, Array]
    actions: Array
    made_by: str
    interrupted: bool = False

    def save(self, path: Path) -> None:
        """Write an .npz file, whole or not at all.

        Raises:
            OSError: it cannot be written.
        """
        with replacing(path) as partial, partial.open("wb") as file:
            settings = {"seed": self.seed, "arguments": self.arguments, "bodies": self.bodies}
            texts = {"target": self.target, "settings": json.dumps(settings), "made_by": self.made_by}
            entries: dict[str, Any] = {"version": _VERSION, "times": self.times, "actions": self.actions}
            np.savez_compressed(file, **entries, **texts, **self.states)  # type: ignore[arg-type]

    @staticmethod
    def load(path: Path) -> Recording:
        """Read a file that ``save`` has written; nothing in it is run.

        Raises:
            OSError: it cannot be read.
            ValueError: it is no recording; the message names the file.
        """
        try:
            return _recording(read_arrays(Path(path)))
        except OSError:
            raise
        except Exception as error:  # whatever a damaged file raises
            raise ValueError(f"{path} is no recording of gsenv that this version reads.") from error


def _recording(arrays: dict[str, Array]) -> Recording:
    """Return the recording that a file's arrays hold.

    Raises:
        Exception: of any kind, where they hold none.
    """
    if int(arrays["version"]) != _VERSION:
        raise ValueError("another version")
    target, settings, made_by = (str(arrays[name]) for name in _TEXTS)
    given = json.loads(settings)
    seed, bodies = given["seed"], given["bodies"]
    if not target.isprintable() or type(seed) is not int or not 0 <= seed <= MOST_SEED:
        raise ValueError("target or seed")
    if not isinstance(bodies, list) or not all(isinstance(name, str) for name in bodies):
        raise ValueError("bodies")
    states = {name: _numbers(arrays[name], np.float64) for name in QUANTITIES}
    times, actions = _numbers(arrays["times"], np.float64), _numbers(arrays["actions"], np.float32)
    places = [states[name].shape[:2] for name in QUANTITIES]
    widths = tuple(states[name].shape[2:] for name in QUANTITIES)
    if times.ndim != 1 or places != [(len(times), len(bodies))] * len(QUANTITIES) or widths not in _WIDTHS:
        raise ValueError("shapes of the states")
    if actions.ndim < 2 or len(actions) != len(times) - 1:
        raise ValueError("shape of the actions")
    return Recording(target, seed, dict(given["arguments"]), bodies, times, states, actions, _printable(made_by))


def _numbers(values: Array, dtype: type) -> Array:
    """Return an array as floats; text and complex numbers are no numbers of a recording."""
    if values.dtype.kind not in "fiu":
        raise ValueError("no numbers")
    return np.asarray(values, dtype)


def _printable(text: str) -> str:
    """Return a text of a file for the terminal, which would obey the control characters in it."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


@dataclass(frozen=True)
class Parting:
    """Where two recordings part: the first state, and its first body and quantity that differ.

    Attributes:
        step: number of steps before the state.
        time: s.
        bodies: how many bodies differ in this state.
        one, other: the first number that differs.
    """

    step: int
    time: float
    body: str
    quantity: str
    one: float
    other: float
    bodies: int

    def __str__(self) -> str:
        others = f", as {self.bodies - 1} other bodies do" if self.bodies > 1 else ""
        return (
            f"they part at step {self.step} ({self.time:.6g} s): {self.quantity} of {self.body!r} "
            f"is {self.one!r} and {self.other!r}{others}"
        )


def machine() -> str:
    """Return the versions and the kind of machine that results could depend on."""
    import numba

    from gsenv import __version__

    python = platform.python_version()
    where = f"{platform.system()} {platform.machine()}"
    return f"gsenv {__version__}, numba {numba.__version__}, NumPy {np.__version__}, Python {python}, {where}"


def record(
    target: str,
    steps: int | None = None,
    seed: int = 0,
    actor: Callable[[Any], Any] | None = None,
    arguments: Mapping[str, Any] | None = None,
    on_step: Callable[[int, int], None] = lambda done, total: None,
) -> Recording:
    """Run an environment or a scene and return the recording; Ctrl-C ends it early.

    Args:
        target: id of an environment, or "scene:" and the name of a scene.
        steps: control steps of an environment, new episodes begin as needed; None: of one episode, or the scene's.
        actor: function of the observations of a batch of one world; None for scenes.
        arguments: of the environment.
        on_step: called with the number of steps so far and that of all.

    Raises:
        LookupError: there is no such environment or scene.
        TypeError, ValueError: a bad argument.
    """
    given = dict(arguments or {})
    run = _Run(target, seed, given)
    total = run.default_steps if steps is None else steps
    run.check_length(total)
    actions: list[Array] = []
    interrupted = False
    try:
        for step in range(total):
            actions.append(run.advance(None if actor is None else actor(run.observations)))
            on_step(step + 1, total)
            if steps is None and run.ended:
                break
    except KeyboardInterrupt:
        interrupted = True
    recording = run.recording(actions)
    recording.interrupted = interrupted
    return recording


def replay(recording: Recording, on_step: Callable[[int, int], None] = lambda done, total: None) -> Recording:
    """Run a recording again, with its own actions, and return the recording of this run.

    Raises:
        LookupError, TypeError, ValueError: this version of gsenv has no such environment, scene or arguments.
    """
    run = _Run(recording.target, recording.seed, recording.arguments)
    actions = recording.actions
    for step, action in enumerate(actions):
        run.advance(action[None])
        on_step(step + 1, len(actions))
    return run.recording(list(actions))


def compare(one: Recording, other: Recording) -> Parting | None:
    """Return where two recordings part, None where all states that both have are equal bit for bit.

    Raises:
        ValueError: they are of different targets or bodies.
    """
    if one.target != other.target:
        raise ValueError(f"the recordings are of {one.target} and of {other.target}.")
    if one.bodies != other.bodies:
        raise ValueError(f"the recordings of {one.target} have different bodies: {_first_names(one, other)}.")
    if any(one.states[name].shape[2:] != other.states[name].shape[2:] for name in QUANTITIES):
        raise ValueError(f"one recording of {one.target} is of 2D and the other of 3D.")
    count = min(len(one.times), len(other.times))
    differs = {name: _bits(one.states[name][:count]) != _bits(other.states[name][:count]) for name in QUANTITIES}
    by_body = np.any([d.any(-1) for d in differs.values()], axis=0)  # (state, body)
    steps = np.flatnonzero(by_body.any(-1))
    if not len(steps):
        return None
    step = int(steps[0])
    body = int(np.flatnonzero(by_body[step])[0])
    quantity = next(name for name in QUANTITIES if differs[name][step, body].any())
    at = int(np.flatnonzero(differs[quantity][step, body])[0])
    mine, theirs = (float(each.states[quantity][step, body, at]) for each in (one, other))
    return Parting(step, float(one.times[step]), one.bodies[body], quantity, mine, theirs, int(by_body[step].sum()))


def differences(one: Recording, other: Recording) -> list[str]:
    """Return a sentence for each other thing in which two recordings of the same bodies differ.

    These are the seeds, the arguments, the actions, the times and the numbers of steps.
    """
    found = [
        f"their {name}s differ: {mine!r} and {theirs!r}"
        for name, mine, theirs in (("seed", one.seed, other.seed), ("argument", one.arguments, other.arguments))
        if mine != theirs
    ]
    count = min(len(one.times), len(other.times))
    steps = np.flatnonzero(_bits(one.times[:count]) != _bits(other.times[:count]))
    if len(steps):
        step = int(steps[0])
        at = [float(each.times[step]) for each in (one, other)]
        found.append(f"their times differ at step {step}: {at[0]!r} and {at[1]!r} s")
    mine, theirs = one.actions[: count - 1], other.actions[: count - 1]
    if mine.shape != theirs.shape:
        found.append(f"their actions have different shapes: {mine.shape[1:]} and {theirs.shape[1:]}")
    elif (_bits(mine) != _bits(theirs)).any():
        unequal = (_bits(mine) != _bits(theirs)).reshape(len(mine), -1).any(-1)
        found.append(f"their actions differ at step {int(np.flatnonzero(unequal)[0])}")
    if len(one.times) != len(other.times):
        found.append(f"their lengths differ: {len(one.times) - 1} and {len(other.times) - 1} steps")
    return found


def _first_names(one: Recording, other: Recording) -> str:
    """Return how many bodies two recordings have, or the first names that differ."""
    if len(one.bodies) != len(other.bodies):
        return f"{len(one.bodies)}, {len(other.bodies)}"
    pairs = zip(one.bodies, other.bodies, strict=True)
    return next(f"{mine!r}, {theirs!r}" for mine, theirs in pairs if mine != theirs)


def _bits(values: Array) -> Array:
    return np.ascontiguousarray(values, np.float64).view(np.uint64)


class _Run:
    """One world of an environment or a scene, and the states that it has had."""

    def __init__(self, target: str, seed: int, arguments: dict[str, Any]) -> None:
        self.target, self.seed, self.arguments = target, seed, arguments
        self.ended = False
        self.observations: Any = None
        self._batch: Any = None
        if target.startswith(SCENE_PREFIX):
            from gsenv.scenes import SCENES, make_world

            name = target.removeprefix(SCENE_PREFIX)
            if name not in SCENES:
                raise LookupError(f"there is no scene {name!r}.")
            self._world = make_world(name)
            self.default_steps = round(SCENES[name].duration / self._world.timestep)
        else:
            from gsenv.envs.core.policies import make_batch

            if arguments.get("render_mode") is not None or arguments.get("observation", "state") != "state":
                raise ValueError(f"{target}: recordings of states take no render_mode, and no observation but 'state'.")
            self._batch = make_batch(target, 1, **arguments)
            self.observations, _ = self._batch.reset(seed=seed)
            self._world = self._batch.task.world
            limit = self._batch.max_episode_steps
            self.default_steps = limit if limit > 0 else UNLIMITED
        self._states: list[tuple[float, dict[str, Array]]] = []
        self._keep()

    def check_length(self, steps: int) -> None:
        """Raise ValueError for a number of steps whose recording no file may hold."""
        _, states = self._states[0]
        most = int(0.9 * MOST_BYTES) // sum(values.nbytes for values in states.values())  # 0.9: actions, times, names
        if steps > most:
            raise ValueError(f"a recording of {self.target} has room for at most {most} steps, got {steps}.")

    def advance(self, actions: Any) -> Array:
        """Take a step with the actions of a batch of one world, which scenes ignore; returns the action."""
        action = np.zeros(0, np.float32)
        if self._batch is None:
            self._world.step()
        else:
            action = np.array(actions, np.float32)[0]
            self.observations, _, terminated, truncated, _ = self._batch.step(action[None])
            self.ended = bool(np.any(terminated) or np.any(truncated))
        self._keep()
        return action

    def _keep(self) -> None:
        bodies = self._world.state.bodies
        self._states.append((float(self._world.time[0]), {name: bodies[name][0].copy() for name in QUANTITIES}))

    def recording(self, actions: list[Array]) -> Recording:
        kept = self._states[: len(actions) + 1]
        return Recording(
            self.target,
            self.seed,
            self.arguments,
            list(self._world.model.body_names),
            np.array([time for time, _ in kept]),
            {name: np.stack([state[name] for _, state in kept]) for name in QUANTITIES},
            np.stack(actions) if actions else np.zeros((0, 0), np.float32),
            machine(),
        )
