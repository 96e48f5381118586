"""Stable-Baselines3 with parameter sharing: each agent of each world as one environment of a VecEnv.

from stable_baselines3 import PPO
from gsenv.adapters.sb3_agents import AgentVecEnv

envs = AgentVecEnv("tower_v0", world_count=64)  # 128 environments
PPO("MlpPolicy", envs, n_steps=64).learn(1_000_000)
"""

from __future__ import annotations

from time import time
from typing import Any

from gymnasium.vector import AutoresetMode

from gsenv.adapters.sb3 import SharedVecEnv
from gsenv.envs.core.policies import make_batch
from gsenv.envs.core.spec_tables import box_of


class AgentVecEnv(SharedVecEnv):
    """A batch of worlds with several agents; environment `w * A + a` is agent a, of A, of world w.

    All agents of a world begin and end at once, with the options of all of them, which must be equal, and with the
    seed of environment w. Settings are those of the batch: `set_attr` sets them for all worlds.

    Args:
        name: of an environment of several agents, such as "tower_v0".
        world_count: number of worlds.
        threads: number of threads that the worlds are distributed over.
        arguments: of the environment, such as `blocks=2` or `observation="pixels"`.

    Raises:
        LookupError: there is no such environment of several agents.
        TypeError, ValueError: a bad argument.
    """

    def __init__(self, name: str, world_count: int, threads: int = 1, **arguments: Any) -> None:
        batch = make_batch(name, world_count, threads=threads, autoreset_mode=AutoresetMode.DISABLED, **arguments)
        self.agents = batch.task.agents
        if not self.agents:
            raise LookupError(f"{name} has one agent; BatchedVecEnv is for those.")
        self._began = time()
        spaces = {"observation_space": batch.agent_observation_space, "action_space": box_of(batch.task.actions)}
        super().__init__(batch, spaces)
        self.metadata = dict(batch.metadata)

    def _record(self, i: int, info: dict[str, Any]) -> None:
        info["episode"] = self._episode(i, self._began)
