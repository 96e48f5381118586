"""What a file can be refused for, and the collector of warnings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any


class MjcfError(ValueError):
    """A file that cannot be read: one sentence that names file, line and element."""


class MjcfWarning(UserWarning):
    """A part of a file that is read but not simulated as MuJoCo would."""


@dataclass(frozen=True)
class Place:
    """Where an element stands.

    Attributes:
        file: name of the file without its folder, or "string".
        line: counted from 1.
    """

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}, line {self.line}"


@dataclass
class Notes:
    """Warnings by topic: each topic is told once, with its first place and the number of further ones."""

    topics: dict[str, list[str]] = field(default_factory=dict)

    def add(self, topic: str, what: str) -> None:
        """Note that ``topic``, a sentence without its full stop, concerns an element, named by ``what``."""
        places = self.topics.setdefault(topic, [])
        if not places or places[-1] != what:
            places.append(what)

    def sentences(self) -> tuple[str, ...]:
        """Return one sentence for each topic."""
        sentences = []
        for topic, places in self.topics.items():
            more = f" (and {len(places) - 1} more)" if len(places) > 1 else ""
            sentences.append(f"{places[0]}{more}: {topic}.")
        return tuple(sentences)


def check_names(things: Sequence[Any]) -> None:
    """Raise MjcfError where two of the things, which have a name and a place, have one name."""
    seen: dict[str, Place] = {}
    for thing in things:
        if thing.name and thing.name in seen:
            kind, other = type(thing).__name__.lower(), seen[thing.name]
            raise MjcfError(f"{thing.place}: {kind}: the name {thing.name!r} is given already in {other}.")
        seen[thing.name] = thing.place
