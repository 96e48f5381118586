"""The one interface behind which all engines run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.records.model import Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Setting:
    """One way of running an engine.

    Attributes:
        engine: its name.
        label: what is set, for people; unique within a case and engine.
        timestep: s, one step.
        values: what the engine reads.
        mark: name of the preset that this is, or "".
    """

    engine: str
    label: str
    timestep: float
    values: Mapping[str, Any] = field(default_factory=dict)
    mark: str = ""


class Simulation(Protocol):
    """A scene inside an engine, ready to step. Only ``step`` is timed."""

    def step(self, count: int) -> None:
        """Take ``count`` timesteps."""

    def read(self) -> Array:
        """(body, trajectory.STATE): where the bodies are, in the scene's order."""


def touching_shapes(model: Model, body: int) -> list[int]:
    """Indices of a body's shapes that may touch a shape of another one; the others are for the eye."""
    category, mask, owner = (model.shapes[name] for name in ("category", "mask", "body"))
    first, count = model.bodies["shape_first"][body], model.bodies["shape_count"][body]
    return [
        k for k in range(first, first + count)
        if ((category & mask[k] != 0) & (category[k] & mask != 0) & (owner != body)).any()
    ]  # fmt: skip
