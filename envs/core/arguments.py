"""Arguments that all environments share: a task's settings, domain randomisation, diagnostics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import World
from gsenv.solver.api.options import FIDELITIES

Array = NDArray[Any]


@dataclass(frozen=True)
class Setting:
    """A number or choice that an environment takes as an argument, and a reset for one episode."""

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
    low: float  # what makes sense at all
    high: float
    unit: str = "-"


def check_settings(given: Mapping[str, Any], known: Sequence[Setting], who: str) -> dict[str, Any]:
    """All settings, checked, defaults where none is given.

    Raises:
        TypeError: an argument that the environment does not have.
        ValueError: a bad value.
    """
    names = [setting.name for setting in known]
    for name in given:
        if name not in names:
            has = f"its own are {', '.join(names)}" if names else "it has none of its own"
            raise TypeError(f"{who}: unknown argument {name!r}; {has}.")
    return {s.name: s.check(given.get(s.name, s.default)) for s in known}


def check_options(given: Mapping[str, Any], known: Sequence[Setting], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a reset on top of the settings in force, all checked again: they may be set freely."""
    names = [setting.name for setting in known]
    for name in given:
        if name not in names:
            has = f"known are {', '.join(map(repr, names))}" if names else "this environment has none"
            raise ValueError(f"reset: unknown option {name!r}; {has}.")
    return {s.name: s.check(given.get(s.name, defaults[s.name])) for s in known}


def check_ranges(given: Mapping[str, Any] | None, known: Sequence[Quantity]) -> dict[str, tuple[float, float]]:
    """Ranges to draw quantities from.

    Raises:
        ValueError: not a mapping, an unknown quantity, or a range that makes no sense.
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
    try:
        low, high = (float(end) for end in pair)
    except (TypeError, ValueError):
        raise ValueError(f"{where} must be a pair (low, high), got {pair!r}.") from None
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        raise ValueError(f"{where} must be two finite numbers, the lower first, got {pair!r}.")
    if low < quantity.low or high > quantity.high:
        raise ValueError(f"{where} must lie within {quantity.low:g} and {quantity.high:g}, got {pair!r}.")
    return low, high


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


# ---------------------------------------------------------------- diagnostics

DIAGNOSTICS = (  # field of the info, its meaning
    ("residual", "how far the last substep's impulses are from the solution; 0 is exact"),
    ("penetration", "m, deepest overlap"),
    ("joint_error", "m, largest gap of a joint"),
    ("energy", "J, of motion, height and springs"),
    ("contacts", "contact points"),
    ("sweeps", "of the solver, all islands and substeps"),
    ("unconverged", "island substeps that ran out of sweeps, and joints off by over 1 % of their length"),
)
WHOLE = ("contacts", "sweeps", "unconverged")
DIAGNOSTICS_DTYPE = np.dtype([(name, "i8" if name in WHOLE else "f8") for name, _ in DIAGNOSTICS])


def read_diagnostics(world: World, out: Array) -> None:
    """What the last step says of itself, of all worlds, into (world,) of DIAGNOSTICS_DTYPE."""
    report = world.diagnostics()
    for name, _ in DIAGNOSTICS:
        out[name] = getattr(report, name)
