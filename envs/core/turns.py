"""PettingZoo: environments whose agents act in turn, made of those whose agents act at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec
from pettingzoo.utils.wrappers import BaseWrapper, ClipOutOfBoundsWrapper, OrderEnforcingWrapper

from gsenv.envs.core.parallel import TaskParallelEnv, check_action
from gsenv.solver.records.text import shown


def in_turn(env: TaskParallelEnv) -> AECEnv:
    """Return an environment that checks and clips the action of each agent in its turn, and steps after the last."""
    return OrderEnforcingWrapper(CheckedActions(ClipOutOfBoundsWrapper(parallel_to_aec(env))))


class CheckedActions(BaseWrapper):
    """Refuses a bad action in the turn of its agent; the world itself would in that of the second agent."""

    def step(self, action: Any) -> None:
        """Take the action of the agent whose turn it is, finite numbers, or None for one that has ended.

        Raises:
            ValueError: any other action; nothing has changed then, and it is still the agent's turn.
        """
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            if action is not None:
                raise ValueError(f"step: the episode of {agent!r} is over, so its action must be None.")
            return super().step(None)
        given = check_action(action, agent, self.action_space(agent).shape[0])
        try:
            with np.errstate(over="ignore"):
                numbers = given.astype(np.float32)
        except (TypeError, ValueError):
            raise ValueError(f"step: the action of {agent!r} must be numbers, got {shown(action)}.") from None
        if not np.isfinite(numbers).all():
            raise ValueError(f"step: the action of {agent!r} must be finite, got {numbers}.")
        return super().step(numbers)

    def __str__(self) -> str:
        return str(self.env)
