"""Arguments that all environments share: a task's settings, domain randomisation, diagnostics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import World
from gsenv.solver.api.options import FIDELITIES
from gsenv.solver.records.text import shown

Array = NDArray[Any]
SHARED = (  # arguments of all environments
    "render_mode", "width", "height", "observation", "split", "fidelity", "randomize", "diagnostics",
)  # fmt: skip
_TIME_LIMITS = {  # the other name of the same thing
    "max_episode_steps": "max_cycles in parallel environments, and elsewhere what gymnasium.make and make_vec take",
    "max_cycles": "max_episode_steps, which gymnasium.make, make_vec and vector environments take",
}
_OF_SOME = {  # arguments that some environments have
    "task": "GRagdoll-v0 and GRagdoll2D-v0 have",
    "threads": "vector environments have",
    "max_cycles": "parallel environments have",
    "max_episode_steps": "gymnasium.make and vector environments have",
}


@dataclass(frozen=True)
class Setting:
    """A number or choice that an environment takes as an argument, and that a reset option sets for one episode."""

    name: str
    default: Any
    check: Callable[[Any], Any]  # the value as it is kept, or ValueError naming it
    text: str = ""  # for the table of arguments


@dataclass(frozen=True)
class Quantity:
    """A physical quantity that may be drawn anew for each world and episode."""

    name: str
    text: str
    nominal: float
    low: float  # limits of the ranges that users may give
    high: float
    unit: str = "-"


def with_defaults(settings: tuple[Setting, ...], **defaults: Any) -> tuple[Setting, ...]:
    """Return settings with other defaults of some."""
    return tuple(replace(s, default=defaults.pop(s.name)) if s.name in defaults else s for s in settings)


def check_settings(given: Mapping[str, Any], known: Sequence[Setting]) -> dict[str, Any]:
    """Return all settings by name, checked, with the default of each that is not given.

    Raises:
        TypeError: the environment has no argument of this name.
        ValueError: a bad value.
    """
    names = [setting.name for setting in known]
    for name in given:
        if name not in names:
            # Python's own words: TorchRL and others look for them and try again without the argument
            raise TypeError(f"the environment got an unexpected keyword argument {name!r}; {_hint(name, names)}")
    return {s.name: s.check(given.get(s.name, s.default)) for s in known}


def _hint(name: str, names: Sequence[str]) -> str:
    """Return what the arguments of an environment are that has none of this name; ends the sentence."""
    has = f"its own are {', '.join(names)}" if names else "it has none of its own"
    text = f"{has}; all environments have {', '.join(SHARED)}"
    if name in _TIME_LIMITS:
        return f"{text}; the time limit is {_TIME_LIMITS[name]}."
    near = get_close_matches(name, [*names, *SHARED, *_OF_SOME], 1)
    if not near:
        return f"{text}."
    who = f", which {_OF_SOME[near[0]]}" if near[0] in _OF_SOME else ""
    return f"{text}; did you mean {near[0]!r}{who}?"


def mapping_of(options: Any) -> dict[str, Any]:
    """Return the options of a reset as a dict, empty for None; raises ValueError for what is no mapping of names."""
    if options is None:
        return {}
    if not isinstance(options, Mapping) or not all(isinstance(name, str) for name in options):
        raise ValueError(f"reset: options must be a dict of options by name, or None, got {shown(options)}.")
    return dict(options)


def check_options(
    given: Mapping[str, Any],
    known: Sequence[Setting],
    defaults: Mapping[str, Any],
    checked: dict[str, tuple[Any, Any]] | None = None,
) -> dict[str, Any]:
    """Return all settings of an episode: the given options, and `defaults` for the others.

    All are checked, since users may have assigned any value to an attribute of the environment.  `checked` has the
    numbers of the last episode, before and after their checks, which are not checked again, and receives those of this
    one.

    Raises:
        ValueError: an unknown option, or a bad value.
    """
    names = [setting.name for setting in known]
    for name in given:
        if name not in names:
            has = f"known are {', '.join(map(repr, names))}" if names else "this environment has none"
            raise ValueError(f"reset: unknown option {name!r}; {has}.")
    kept = {} if checked is None else checked
    settings = {}
    for setting in known:
        value = given.get(setting.name, defaults[setting.name])
        last = kept.get(setting.name)
        if last is None or last[0] is not value:
            last = (value, setting.check(value))
            if _never_changes(value):
                kept[setting.name] = last
        settings[setting.name] = last[1]
    return settings


def _never_changes(value: Any) -> bool:
    """Whether a value that is still the same object is still the same."""
    values = value if type(value) is tuple else (value,)
    return all(type(part) in (bool, float, int, str) for part in values)


def check_ranges(given: Mapping[str, Any] | None, known: Sequence[Quantity]) -> dict[str, tuple[float, float]]:
    """Return the ranges (low, high) that quantities are drawn from, by name.

    Raises:
        ValueError: not a mapping, an unknown quantity, or a range beyond the quantity's limits.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise ValueError(f"randomize must map names to (low, high), got {given!r}.")
    quantities = {quantity.name: quantity for quantity in known}
    ranges = {}
    for name, pair in given.items():
        if name not in quantities:
            has = ", ".join(quantities) or "none"
            raise ValueError(f"randomize: unknown quantity {name!r}; known are {has}.")
        ranges[name] = _range(quantities[name], pair)
    return ranges


def _range(quantity: Quantity, pair: Any) -> tuple[float, float]:
    where = f"randomize: {quantity.name}"
    ends = numbers(pair)
    if len(ends) != 2:
        raise ValueError(f"{where} must be a pair (low, high) of finite numbers, got {shown(pair)}.")
    low, high = ends
    if low > high:
        raise ValueError(f"{where} must be two numbers, the lower first, got {shown(pair)}.")
    if low < quantity.low or high > quantity.high:
        raise ValueError(f"{where} must lie within {quantity.low:g} and {quantity.high:g}, got {shown(pair)}.")
    return low, high


def number(value: Any) -> float | None:
    """Return a finite float, or None for anything else: texts and truth values are no numbers."""
    real = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    try:
        return float(value) if real and math.isfinite(value) else None
    except OverflowError:  # a whole number beyond all floats
        return None


def numbers(values: Any) -> tuple[float, ...]:
    """Return finite floats, or none at all where `values` are no tuple, list or vector of such."""
    vector = isinstance(values, (tuple, list)) or (isinstance(values, np.ndarray) and values.ndim == 1)
    found = [number(value) for value in values] if vector else [None]
    return () if None in found else tuple(value for value in found if value is not None)


def number_within(value: Any, least: float, most: float, message: str) -> float:
    """Return a number from ``least`` to ``most`` as a float; raises ValueError with the message for anything else."""
    checked = number(value)
    if checked is None or not least <= checked <= most:
        raise ValueError(f"{message}, got {shown(value)}.")
    return checked


def whole_within(value: Any, allowed: range, message: str) -> int:
    """Return a whole number of a range as an int; raises ValueError with the message for anything else."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or int(value) not in allowed:
        raise ValueError(f"{message}, got {shown(value)}.")
    return int(value)


def check_fidelity(fidelity: Any) -> str:
    if not isinstance(fidelity, str) or fidelity not in FIDELITIES:
        raise ValueError(f"fidelity must be one of {list(FIDELITIES)}, got {fidelity!r}.")
    return str(fidelity)


def _setting_property(name: str) -> property:
    """Return a property of an environment that reads and writes a setting, which applies from the next reset on.

    An environment of several tasks has those of its own task only.
    """

    def read(env: Any) -> Any:
        if name not in env.task.settings:
            raise AttributeError(f"{type(env).__name__} has no {name!r} with this task.")
        return env.task.settings[name]

    def write(env: Any, value: Any) -> None:
        read(env)
        setting = next(s for s in env.task.arguments if s.name == name)
        env.task.settings[name] = setting.check(value)

    return property(read, write, doc=f"`{name}` from the next reset on, unless its options say otherwise.")


def add_settings(cls: type[Any]) -> None:
    """Give an environment class an attribute for each setting of its task, or of all that it may have."""
    own = cls.__dict__.get("task_class")
    for task in (*cls.__dict__.get("tasks", {}).values(), *((own,) if own is not None else ())):
        for setting in task.arguments:
            setattr(cls, setting.name, _setting_property(setting.name))


# ---------------------------------------------------------------- diagnostics

DIAGNOSTICS = (  # name, meaning
    ("residual", "distance of the last substep's impulses from the solution, relative; 0 is exact"),
    ("penetration", "m, deepest overlap"),
    ("joint_error", "m, largest gap of a joint"),
    ("energy", "J, kinetic, potential and spring energy"),
    ("contacts", "contact points"),
    ("sweeps", "of the solver, all islands and substeps"),
    ("unconverged", "island substeps that ran out of sweeps, and joints off by over 1 % of their length"),
)
DIAGNOSTIC_NAMES = tuple(f"diagnostic_{name}" for name, _ in DIAGNOSTICS)  # in the info
WHOLE = ("contacts", "sweeps", "unconverged")
DIAGNOSTICS_DTYPE = np.dtype([(name, "i8" if name in WHOLE else "f8") for name, _ in DIAGNOSTICS])


def read_diagnostics(world: World, out: Array) -> None:
    """Write the diagnostics of the last step of all worlds to `out`, (world,) of DIAGNOSTICS_DTYPE."""
    report = world.diagnostics()
    for name, _ in DIAGNOSTICS:
        out[name] = getattr(report, name)
