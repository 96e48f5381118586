"""What a figure cannot feel and a critic may know in training: the pushes to come, and the physics of the episode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.arguments import Quantity
from gsenv.envs.core.spec_tables import Entry
from gsenv.envs.ragdoll2d import shared_rules as shared

MOST_TIME = 4.0  # s
MOST_PUSH = 3.0  # m/s, of the argument `push`
SOON = 0.5  # s

Array = NDArray[np.float64]


def entries(quantities: Sequence[Quantity], sides: Sequence[str]) -> tuple[Entry, ...]:
    """Return the table of `privileged_observations`; `sides` has the words for the directions of a push."""
    axes = "xyz"[: len(sides)]
    return (
        Entry("time to the next push", "push_time", 0, MOST_TIME, "s"),
        *(
            Entry(f"the next push, {side}", f"push_{axis}", -MOST_PUSH, MOST_PUSH, "m/s")
            for axis, side in zip(axes, sides, strict=True)
        ),
        *(
            Entry(f"what the present push has still to add, {side}", f"rest_{axis}", -MOST_PUSH, MOST_PUSH, "m/s")
            for axis, side in zip(axes, sides, strict=True)
        ),
        *(Entry(quantity.name, quantity.name, 0, 3) for quantity in quantities),
        Entry(f"1 where the next push comes within {SOON} s", "push_soon", 0, 1),
    )


def next_push(state: Any) -> NDArray[np.int64]:
    """Return the number of the next push in the schedule of each world, (world, 1)."""
    return np.asarray(state["push_count"] % shared.PUSHES)[:, None]


def privileged_observations(state: Any, physics: Array, following: Array, present: Array) -> NDArray[np.float32]:
    """Return what `entries` names, (world, entry).

    `following` and `present` are the directions of the next and of the last push, seen by the figure, (world, axis).
    """
    size = np.take_along_axis(state["pushes"], next_push(state), 1)
    none = (state["next_push"] >= shared.NEVER)[:, None]
    rest = np.clip(shared.PUSH_STEPS - state["pushed"], 0, shared.PUSH_STEPS) / shared.PUSH_STEPS
    time = np.minimum((state["next_push"] - state["steps"]) * shared.CONTROL_TIME, MOST_TIME).astype(np.float32)
    columns = (
        time[:, None],
        np.where(none, 0.0, size) * following,
        (rest * state["push"])[:, None] * present,
        physics,
        (time <= SOON)[:, None],
    )
    return np.concatenate([column.astype(np.float32) for column in columns], 1)
