"""References to bodies, joints, actuators, sensors and shapes: handles, names, indices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import check


@dataclass(frozen=True)
class Handle:
    """A named item of a scene: its kind ("body", "joint", ...), name and index."""

    what: str
    name: str
    index: int

    def __index__(self) -> int:
        return self.index


Reference = Handle | str | int  # of a body, joint, actuator, sensor or shape


def find(item: Reference, what: str, names: Sequence[str], where: str) -> int:
    """Return the index of an item given by handle, name or index; raises ValueError naming ``where``."""
    if isinstance(item, Handle):
        if item.what != what:
            raise ValueError(f"{where} needs a {what}, got the {item.what} {item.name!r}.")
        if item.index >= len(names) or names[item.index] != item.name:
            raise ValueError(f"{where}: {what} {item.name!r} belongs to another scene.")
        return item.index
    if isinstance(item, str):
        check.choice(item, names, f"{where}: {what}")
        return list(names).index(item)
    if isinstance(item, (int, np.integer)) and not isinstance(item, bool) and 0 <= item < len(names):
        return int(item)
    raise ValueError(f"{where}: {what} {item!r} is unknown.")
