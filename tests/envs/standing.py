"""How long figures stand under a policy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll2d import shared_rules as shared

STEPS = 600  # of an episode


def standing_time(
    vector_class: Callable[..., TaskVectorEnv],
    policy: Callable[[Any], Any],
    push: float,
    count: int = 50,
    **arguments: Any,
) -> Any:
    """s that each of `count` worlds stands, at most 20; `success` must say at each step who still does."""
    vector = vector_class(count, push=push, autoreset_mode="Disabled", **arguments)
    vector.reset(seed=2_000_000)
    task = vector.task
    steps, alive = np.zeros(count), np.ones(count, bool)
    for _ in range(STEPS):
        task.step(policy(task.observation))
        steps += alive
        assert (task.infos["success"] == ~task.terminated)[alive].all()
        alive &= ~task.terminated
        if not alive.any():
            break
    return np.where(alive, 20.0, steps * shared.CONTROL_TIME)
