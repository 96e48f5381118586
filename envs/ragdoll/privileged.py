"""What the figure cannot feel and a critic may know in training: the pushes to come, and the physics of the episode."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.spec_tables import Entry
from gsenv.envs.ragdoll.env import RagdollTask
from gsenv.envs.ragdoll2d import shared_rules as shared

MOST_TIME = 4.0  # s
SOON = 0.5  # s

ENTRIES = (
    Entry("time to the next push", "push_time", 0, MOST_TIME, "s"),
    Entry("the next push, forwards", "push_x", -2, 2, "m/s"),
    Entry("the next push, to the left", "push_y", -2, 2, "m/s"),
    Entry("what the present push has still to add, forwards", "rest_x", -2, 2, "m/s"),
    Entry("what the present push has still to add, to the left", "rest_y", -2, 2, "m/s"),
    *(Entry(quantity.name, quantity.name, 0, 2) for quantity in RagdollTask.quantities),
    Entry(f"1 where the next push comes within {SOON} s", "push_soon", 0, 1),
)


def privileged_observations(task: RagdollTask) -> NDArray[np.float32]:
    """Return `ENTRIES` of all worlds, (world, entry); forwards is the direction of the pelvis along the ground."""
    state = task.task_state
    seen = np.zeros((len(state), len(ENTRIES)), np.float32)
    next_push = state["push_count"] % shared.PUSHES
    size = np.take_along_axis(state["pushes"], next_push[:, None], 1)[:, 0]
    heading = np.take_along_axis(state["headings"], next_push[:, None], 1)[:, 0]
    never = state["next_push"] >= shared.NEVER
    rest = np.clip(shared.PUSH_STEPS - state["pushed"], 0, shared.PUSH_STEPS) / shared.PUSH_STEPS
    facing = _heading(task)
    seen[:, 0] = np.minimum((state["next_push"] - state["steps"]) * shared.CONTROL_TIME, MOST_TIME)
    seen[:, 1:3] = _level(np.where(never, 0.0, size), heading - facing)
    seen[:, 3:5] = _level(rest * state["push"], state["heading"] - facing)
    seen[:, 5:-1] = task.physics
    seen[:, -1] = seen[:, 0] <= SOON
    return seen


def _level(size: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([size * np.cos(angle), size * np.sin(angle)], 1)


def _heading(task: RagdollTask) -> NDArray[np.float64]:
    """Return the heading of the pelvis' forward axis in rad, (world,)."""
    bodies: Any = task.world.state.bodies
    tables: Any = task.figure
    w, x, y, z = bodies["rotation"][:, int(tables.parts["pelvis"])].T
    return np.asarray(np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z)))
