"""The environments, installed as `gsenv.envs`, and the table that registers them.

A new environment is its own module and one entry of `ENVS`. This module imports none of them, so that
registering stays as light as importing gymnasium.
"""

if __name__ != "gsenv.envs":  # a stray `import envs` would make two classes of everything
    raise ImportError("the package is gsenv.envs: write `import gsenv.envs`")

from dataclasses import dataclass

import gymnasium


@dataclass(frozen=True)
class EnvEntry:
    """One registered environment. The classes are named as strings, "module:Class" within gsenv.envs."""

    id: str
    env: str
    vector_env: str
    max_episode_steps: int
    summary: str  # for `gsenv list`


ENVS = (
    EnvEntry("GStack-v0", "stack:StackEnv", "stack:StackVectorEnv", 600, "2D: build a tower of blocks that stands"),
)


def register_envs() -> None:
    """Register all environments with gymnasium; those that are registered already stay as they are."""
    for entry in ENVS:
        if entry.id not in gymnasium.registry:
            gymnasium.register(
                id=entry.id,
                entry_point=f"gsenv.envs.{entry.env}",
                vector_entry_point=f"gsenv.envs.{entry.vector_env}",
                max_episode_steps=entry.max_episode_steps,
            )
