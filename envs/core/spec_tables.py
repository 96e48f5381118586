"""Tables of actions, observations and rewards, from which spaces and docstrings are made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from gymnasium import spaces

from gsenv.envs.core.arguments import Quantity, Setting

_Class = TypeVar("_Class", bound=type)


@dataclass(frozen=True)
class Entry:
    """One number of an action or an observation: what it is, its bounds and its unit."""

    text: str
    name: str
    low: float
    high: float
    unit: str = "-"


@dataclass(frozen=True)
class RewardTerm:
    """One addend of the reward."""

    name: str
    text: str


def box_of(entries: Sequence[Entry], agents: Sequence[str] = ()) -> spaces.Box:
    """Return the float32 space of the entries; its shape is (agent, entry) where there are agents."""
    low = np.array([entry.low for entry in entries], np.float32)
    high = np.array([entry.high for entry in entries], np.float32)
    if agents:
        low, high = (np.tile(bound, (len(agents), 1)) for bound in (low, high))
    return spaces.Box(low, high, dtype=np.float32)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table with aligned columns."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    lines.insert(1, ["-" * width for width in widths])
    cells = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in lines)
    return "\n".join("| " + " | ".join(row) + " |" for row in cells)


def entry_table(title: str, entries: Sequence[Entry]) -> str:
    """Return the table with the columns Num, `title`, Min, Max, Name and Unit."""
    rows = ((str(k), e.text, f"{e.low:g}", f"{e.high:g}", e.name, e.unit) for k, e in enumerate(entries))
    return table(("Num", title, "Min", "Max", "Name", "Unit"), rows)


def reward_table(terms: Sequence[RewardTerm]) -> str:
    return table(("Term", "Value"), ((term.name, term.text) for term in terms))


def quantity_table(quantities: Sequence[Quantity]) -> str:
    rows = ((q.name, q.text, f"{q.nominal:g}", f"{q.low:g} to {q.high:g}", q.unit) for q in quantities)
    return table(("Name", "Quantity", "Nominal", "May be", "Unit"), rows)


def argument_table(settings: Sequence[Setting]) -> str:
    return table(("Argument", "Meaning", "Default"), ((s.name, s.text, repr(s.default)) for s in settings))


def fill_docstring(cls: _Class, **texts: str) -> _Class:
    """Put `texts` where a class docstring says {name}, each line indented like the placeholder."""
    doc = cls.__doc__
    if doc is None:  # python -OO
        return cls
    lines = []
    for line in doc.split("\n"):
        key = line.strip()
        if key.startswith("{") and key.endswith("}") and key[1:-1] in texts:
            indent = line[: len(line) - len(line.lstrip())]
            lines += [indent + row for row in texts[key[1:-1]].split("\n")]
        else:
            lines.append(line)
    cls.__doc__ = "\n".join(lines)
    return cls
