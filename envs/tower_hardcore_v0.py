"""tower_hardcore_v0 (PettingZoo): tower_v0 with more, frailer and more varied blocks.

    from gsenv.envs import tower_hardcore_v0

    env = tower_hardcore_v0.parallel_env()  # or tower_hardcore_v0.env(), turn by turn
    observations, infos = env.reset(seed=0)

By its registered name, once this module is imported: `pettingzoo.make("parallel", "gsenv/tower_hardcore_v0")`. The task
is specified in `TowerHardcoreParallelEnv`; `gsenv.envs.tower.env.TowerHardcoreVectorEnv` has many worlds in one batch.
"""

from __future__ import annotations

from typing import Any

from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec

from gsenv.envs import register_parallel_envs
from gsenv.envs.core.turns import in_turn
from gsenv.envs.tower.parallel_env import TowerHardcoreParallelEnv
from gsenv.envs.tower.policy import build_together as scripted_actions

__all__ = ["TowerHardcoreParallelEnv", "env", "parallel_env", "raw_env", "scripted_actions"]


def env(**kwargs: Any) -> AECEnv:
    """Return the AEC environment: agents act in turn, and the world is stepped after the second one has acted.

    Takes the arguments of `parallel_env`.
    """
    return in_turn(parallel_env(**kwargs))


def raw_env(**kwargs: Any) -> AECEnv:
    """Return the AEC environment without the wrappers that check and clip actions and check the order of calls."""
    return parallel_to_aec(parallel_env(**kwargs))


def parallel_env(**kwargs: Any) -> TowerHardcoreParallelEnv:
    """Return the environment whose agents act at once; TowerHardcoreParallelEnv lists the arguments."""
    return TowerHardcoreParallelEnv(**kwargs)


register_parallel_envs()
