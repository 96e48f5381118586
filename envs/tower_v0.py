"""tower_v0 (PettingZoo): two grippers build one tower together.

    from gsenv.envs import tower_v0

    env = tower_v0.parallel_env()  # or tower_v0.env(), turn by turn
    observations, infos = env.reset(seed=0)

By its registered name, once this module is imported: `pettingzoo.make("parallel", "gsenv/tower_v0")`. The task
is specified in `TowerParallelEnv`; `gsenv.envs.tower.env.TowerVectorEnv` has many worlds in one batch.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec
from pettingzoo.utils.wrappers import BaseWrapper, ClipOutOfBoundsWrapper, OrderEnforcingWrapper

from gsenv.envs import register_parallel_envs
from gsenv.envs.core.parallel import check_action
from gsenv.envs.tower.env import TowerTask
from gsenv.envs.tower.parallel_env import TowerParallelEnv
from gsenv.envs.tower.policy import build_together as scripted_actions
from gsenv.solver.records.text import shown

__all__ = ["TowerParallelEnv", "env", "parallel_env", "raw_env", "scripted_actions"]


def env(**kwargs: Any) -> AECEnv:
    """Return the AEC environment: agents act in turn, and the world is stepped after the second one has acted.

    Takes the arguments of `parallel_env`.
    """
    return OrderEnforcingWrapper(_CheckedActions(ClipOutOfBoundsWrapper(raw_env(**kwargs))))


def raw_env(**kwargs: Any) -> AECEnv:
    """Return the AEC environment without the wrappers that check and clip actions and check the order of calls."""
    return parallel_to_aec(parallel_env(**kwargs))


class _CheckedActions(BaseWrapper):
    """Refuses a bad action in the turn of its agent; the world itself would in that of the second agent."""

    def step(self, action: Any) -> None:
        """Take the action of the agent whose turn it is, four finite numbers, or None for one that has ended.

        Raises:
            ValueError: any other action; nothing has changed then, and it is still the agent's turn.
        """
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            if action is not None:
                raise ValueError(f"step: the episode of {agent!r} is over, so its action must be None.")
            return super().step(None)
        given = check_action(action, agent, len(TowerTask.actions))
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


def parallel_env(**kwargs: Any) -> TowerParallelEnv:
    """Return the environment whose agents act at once; TowerParallelEnv lists the arguments."""
    return TowerParallelEnv(**kwargs)


register_parallel_envs()
