"""The environments, installed as `gsenv.envs`, and the table that registers them.

Each task has its own folder and one entry of `ENVS`; what all tasks share is in `core`. This module
imports none of them, so that registering stays as light as importing gymnasium.
"""

if __name__ != "gsenv.envs":  # a stray `import envs` would make two classes of everything
    raise ImportError("the package is gsenv.envs: write `import gsenv.envs`")

import sys
from dataclasses import dataclass

import gymnasium


@dataclass(frozen=True)
class EnvEntry:
    """One registered environment. Strings name what it consists of, as "module:name" within gsenv.envs."""

    id: str
    env: str
    vector_env: str
    max_episode_steps: int
    reward_threshold: float  # mean return with which some 80 % of the episodes succeed: the task counts as solved
    summary: str  # for `gsenv list`
    scripted_policy: str | None = None  # (..., entry) observations to (..., action) actions


ENVS = (
    EnvEntry(
        "GStack-v0",
        "stack.env:StackEnv",
        "stack.env:StackVectorEnv",
        600,
        11.5,
        "2D: build a tower of blocks that stands",
        "stack.policy:build_tower",
    ),
    EnvEntry(
        "GStack-hardcore-v0",
        "stack.env:StackHardcoreEnv",
        "stack.env:StackHardcoreVectorEnv",
        900,
        14.5,
        "2D: the same with more, frailer and more varied blocks, by a gantry that sways",
        "stack.policy:build_tower",
    ),
    EnvEntry(
        "GCar-v0",
        "car.env:CarEnv",
        "car.env:CarVectorEnv",
        550,
        10.4,
        "2D: drive a car over hills, bridges and see-saws",
        "car.policy:drive",
    ),
    EnvEntry(
        "GCar-hardcore-v0",
        "car.env:CarHardcoreEnv",
        "car.env:CarHardcoreVectorEnv",
        750,
        9.5,
        "2D: the same over steep hills and wide gaps",
        "car.policy:drive_steep",
    ),
    EnvEntry(
        "GCar3D-v0",
        "car3d.env:Car3DEnv",
        "car3d.env:Car3DVectorEnv",
        585,
        13.0,
        "3D: drive a car along a winding road over hills and obstacles",
        "car3d.policy:pursue",
    ),
    EnvEntry(
        "GCar3D-hardcore-v0",
        "car3d.env:Car3DHardcoreEnv",
        "car3d.env:Car3DHardcoreVectorEnv",
        585,
        12.9,
        "3D: the same along tighter bends and steeper hills",
        "car3d.policy:pursue",
    ),
    EnvEntry(
        "GStack3D-v0",
        "stack3d.env:Stack3DEnv",
        "stack3d.env:Stack3DVectorEnv",
        600,
        9.0,
        "3D: build a tower of blocks that stands",
        "stack3d.policy:build_tower",
    ),
    EnvEntry(
        "GStack3D-hardcore-v0",
        "stack3d.env:Stack3DHardcoreEnv",
        "stack3d.env:Stack3DHardcoreVectorEnv",
        900,
        12.0,
        "3D: the same with more, frailer and more varied blocks, by a gantry that sways",
        "stack3d.policy:build_tower",
    ),
    EnvEntry(
        "GRagdoll2D-v0",
        "ragdoll2d.env:RagdollEnv",
        "ragdoll2d.env:RagdollVectorEnv",
        600,
        19.0,
        "2D: keep a figure on its feet that is pushed",
        "ragdoll2d.policy:balance",
    ),
    EnvEntry(
        "GRagdoll2D-hardcore-v0",
        "ragdoll2d.env:RagdollHardcoreEnv",
        "ragdoll2d.env:RagdollHardcoreVectorEnv",
        600,
        19.0,
        "2D: the same with harder pushes",
        "ragdoll2d.policy:balance",
    ),
    EnvEntry(
        "GRagdoll2D-get-up-v0",
        "ragdoll2d.env:RagdollGetUpEnv",
        "ragdoll2d.env:RagdollGetUpVectorEnv",
        300,
        7.5,
        "2D: the figure lies on the ground and gets up",
        "ragdoll2d.policy:get_up",
    ),
    EnvEntry(
        "GRagdoll-v0",
        "ragdoll.env:RagdollEnv",
        "ragdoll.env:RagdollVectorEnv",
        600,
        19.0,
        "3D: keep a figure on its feet that is pushed",
        "ragdoll.policy:balance",
    ),
    EnvEntry(
        "GRagdoll-hardcore-v0",
        "ragdoll.env:RagdollHardcoreEnv",
        "ragdoll.env:RagdollHardcoreVectorEnv",
        600,
        18.0,
        "3D: the same with harder pushes",
        "ragdoll.policy:balance",
    ),
    EnvEntry(
        "GRagdoll-get-up-v0",
        "ragdoll.env:RagdollGetUpEnv",
        "ragdoll.env:RagdollGetUpVectorEnv",
        300,
        7.2,
        "3D: the figure lies on the ground and gets up",
        "ragdoll.policy:get_up",
    ),
)


@dataclass(frozen=True)
class ParallelEntry:
    """One environment of several agents, a module of gsenv.envs in PettingZoo's style."""

    name: str  # of the module; "gsenv/<name>" in PettingZoo's registries
    vector_env: str  # "module:name" within gsenv.envs
    max_cycles: int
    summary: str  # for `gsenv list`
    scripted_policy: str | None = None  # (..., entry) observations to (..., action) actions, of each agent


PARALLEL_ENVS = (
    ParallelEntry(
        "tower_v0",
        "tower.env:TowerVectorEnv",
        900,
        "2D: two grippers build one tower together",
        "tower.policy:build_together",
    ),
    ParallelEntry(
        "tower_hardcore_v0",
        "tower.env:TowerHardcoreVectorEnv",
        900,
        "2D: the same with more, frailer and more varied blocks",
        "tower.policy:build_together",
    ),
)


def time_limit(name: str) -> int:
    """Return the number of steps after which episodes of a registered environment are truncated."""
    limits = {entry.id: entry.max_episode_steps for entry in ENVS}
    limits |= {entry.name: entry.max_cycles for entry in PARALLEL_ENVS}
    return limits[name]


def register_envs() -> None:
    """Register all environments with gymnasium; those that are registered already stay as they are.

    With PettingZoo too if it has been imported: it is not loaded for this.
    """
    for entry in ENVS:
        if entry.id not in gymnasium.registry:
            gymnasium.register(
                id=entry.id,
                entry_point=f"gsenv.envs.{entry.env}",
                vector_entry_point=f"gsenv.envs.{entry.vector_env}",
                max_episode_steps=entry.max_episode_steps,
                reward_threshold=entry.reward_threshold,
            )
    if "pettingzoo" in sys.modules:
        register_parallel_envs()


def register_parallel_envs() -> None:
    """Register with PettingZoo, "parallel" and "aec", what is not yet. Its releases before 1.27 have no registry.

    Importing a module of PARALLEL_ENVS does this by itself.
    """
    import pettingzoo

    if not hasattr(pettingzoo, "register"):
        return
    kinds = (
        ("parallel", "parallel_env", pettingzoo.parallel_registry),
        ("aec", "env", pettingzoo.aec_registry),
    )
    for entry in PARALLEL_ENVS:
        for kind, function, registry in kinds:
            if f"gsenv/{entry.name.replace('_v', '-v')}" not in registry:
                pettingzoo.register(
                    kind,
                    f"gsenv/{entry.name}",
                    entry_point=f"gsenv.envs.{entry.name}:{function}",
                    max_cycles=entry.max_cycles,
                )
