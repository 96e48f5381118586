"""Typed reading of an element's attributes, after its defaults are filled in."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..solver.records.model import Array
from .errors import MjcfError, Notes
from .reader import Element

# Lists of which an element may give the first entries alone; the others keep their defaults.
PARTIAL = frozenset(
    ("size", "friction", "gear", "solref", "solimp", "gainprm", "biasprm", "dynprm", "stiffness", "damping", "polycoef")
)
# Attributes of appearance and bookkeeping, which concern no simulation.
SILENT = frozenset(
    (
        "name", "class", "childclass", "material", "rgba", "group", "user", "castshadow", "ipd", "resolution", "output",
        "fitscale", "sensorsize", "focal", "focalpixel", "principal", "principalpixel", "simple", "sleep", "fuse",
        "width", "projection", "orthographic", "content_type", "texcoord", "normal", "maxhullvert",
    )
)  # fmt: skip
SOFT_CONTACT = frozenset(
    (
        "solref", "solimp", "solmix", "solreflimit", "solimplimit", "solreffriction", "solimpfriction", "margin", "gap",
        "priority",
    )
)  # fmt: skip
FLUID = frozenset(("fluidshape", "fluidcoef"))
SOFT_TOPIC = "soft-contact parameters are ignored, contacts and limits are rigid"
FLUID_TOPIC = "fluid forces are not simulated"
COUNTS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def number_list(text: str, what: str) -> list[float]:
    """Return the finite numbers of a text; ``what`` names it in messages.

    Raises:
        MjcfError: a word that is no finite number.
    """
    numbers = []
    for word in text.split():
        try:
            number = float(word)
        except ValueError:
            number = math.nan
        if not math.isfinite(number) or "_" in word:
            raise MjcfError(f"{what} must be finite numbers, got {word!r}.")
        numbers.append(number)
    return numbers


class Attributes:
    """The attributes of an element, its own before those of its default class.

    Args:
        values: own and default attributes.
        notes: takes the warnings about attributes that nobody reads.
    """

    def __init__(self, element: Element, values: Mapping[str, str], notes: Notes) -> None:
        self.element = element
        self.values = values
        self.notes = notes
        self.read = set(SILENT)

    def __contains__(self, name: str) -> bool:
        return name in self.values

    @property
    def title(self) -> str:
        """Place, tag and name for messages."""
        return self.element.title()

    def error(self, text: str) -> MjcfError:
        """Return an error about this element."""
        return MjcfError(f"{self.title}: {text}.")

    def text(self, name: str, default: str = "") -> str:
        """Return an attribute as it stands."""
        self.read.add(name)
        return self.values.get(name, default)

    def needed(self, name: str) -> str:
        """Return an attribute; raises MjcfError where it is missing."""
        text = self.text(name)
        if not text:
            raise self.error(f"{name} is missing")
        return text

    def choice(self, name: str, options: Sequence[str], default: str) -> str:
        """Return one of ``options``."""
        text = self.text(name, default)
        if text not in options:
            raise self.error(f"{name} must be one of {', '.join(options)}, got {text!r}")
        return text

    def flag(self, name: str, default: bool) -> bool:
        """Return whether an attribute is ``true``."""
        return self.choice(name, ("false", "true"), "true" if default else "false") == "true"

    def number(self, name: str, default: float) -> float:
        """Return one finite number."""
        return self.vector(name, (default,))[0]

    def whole(self, name: str, default: int) -> int:
        """Return an integer."""
        number = self.number(name, default)
        if number != int(number):
            raise self.error(f"{name} must be a whole number, got {number!r}")
        return int(number)

    def vector(self, name: str, default: Sequence[float]) -> list[float]:
        """Return as many finite numbers as ``default`` has; of ``PARTIAL`` names an element may give fewer."""
        self.read.add(name)
        if name not in self.values:
            return list(default)
        numbers = self.numbers(name)
        count = len(default)
        if len(numbers) != count and not (name in PARTIAL and 0 < len(numbers) < count):
            words = COUNTS[count] if count < len(COUNTS) else str(count)
            most = "at most " if name in PARTIAL else ""
            noun = "number" if count == 1 else "numbers"
            raise self.error(f"{name} must be {most}{words} {noun}, got {self.values[name]!r}")
        return numbers + list(default[len(numbers) :])

    def numbers(self, name: str) -> list[float]:
        """Return any count of finite numbers."""
        return number_list(self.text(name), f"{self.title}: {name}")

    def array(self, name: str, default: Sequence[float]) -> Array:
        """Return ``vector`` as an array."""
        return np.array(self.vector(name, default))

    def limits(self, name: str, flag: str, autolimits: bool) -> tuple[float, float] | None:
        """Return a range (lower, upper), or None where ``flag`` or the lack of a range says that there is none.

        Raises:
            MjcfError: an empty range, or a range of which nothing says whether it holds.
        """
        state = self.choice(flag, ("auto", "true", "false"), "auto")
        given = name in self.values
        lower, upper = self.vector(name, (0.0, 0.0))
        if state == "false" or (state == "auto" and not given):
            return None
        if state == "auto" and not autolimits:
            raise self.error(f"{name} is given, so {flag} must say true or false, for autolimits is false")
        if state == "auto" and lower == upper == 0.0:
            return None
        if not lower < upper:
            raise self.error(f"{name} must be two numbers, the lower one first, got {lower:g} {upper:g}")
        return lower, upper

    def finish(self) -> None:
        """Note each attribute that is not honoured."""
        for name in self.values:
            if name in self.read:
                continue
            if name in SOFT_CONTACT:
                self.notes.add(SOFT_TOPIC, self.title)
            elif name in FLUID:
                self.notes.add(FLUID_TOPIC, self.title)
            else:
                self.notes.add(f"the attribute {name} of {self.element.tag} is ignored", self.title)
