"""tower_v0 (PettingZoo): two grippers build one tower together.

    from gsenv.envs import tower_v0

    env = tower_v0.parallel_env()  # or tower_v0.env(), turn by turn
    observations, infos = env.reset(seed=0)

By its registered name, once this module is imported: `pettingzoo.make("parallel", "gsenv/tower_v0")`. The task
is specified in `TowerParallelEnv`; `gsenv.envs.tower.env.TowerVectorEnv` has many worlds in one batch.
"""

from __future__ import annotations

from typing import Any

from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec

from gsenv.envs import register_parallel_envs
from gsenv.envs.core.turns import in_turn
from gsenv.envs.tower.parallel_env import TowerParallelEnv
from gsenv.envs.tower.policy import build_together as scripted_actions

__all__ = ["TowerParallelEnv", "env", "parallel_env", "raw_env", "scripted_actions"]


def env(**kwargs: Any) -> AECEnv:
    """Return the AEC environment: agents act in turn, and the world is stepped after the second one has acted.

    Takes the arguments of `parallel_env`.
    """
    return in_turn(parallel_env(**kwargs))


def raw_env(**kwargs: Any) -> AECEnv:
    """Return the AEC environment without the wrappers that check and clip actions and check the order of calls."""
    return parallel_to_aec(parallel_env(**kwargs))


def parallel_env(**kwargs: Any) -> TowerParallelEnv:
    """Return the environment whose agents act at once; TowerParallelEnv lists the arguments."""
    return TowerParallelEnv(**kwargs)


register_parallel_envs()
