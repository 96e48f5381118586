"""Makes assets/lying.npz: the poses in which GRagdoll2D-get-up-v0 and GRagdoll-get-up-v0 begin.

    python -m gsenv.envs.falls

Figures that stand are thrown to all sides, with weak drives that ask for random angles, and fall. Then the drives are
weaker still, so that limbs sink. Those that are at rest after that give their poses.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.mlp import write_arrays
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll.env import RagdollVectorEnv as SpatialVectorEnv
from gsenv.envs.ragdoll2d import scene
from gsenv.envs.ragdoll2d.env import RagdollVectorEnv as PlanarVectorEnv
from gsenv.envs.ragdoll2d.lying import FILE
from gsenv.solver.records.model import BodyKind

Array = NDArray[np.float64]

POSES = 1024  # of each figure
WORLDS = 256
SPEEDS = (0.5, 3.0)  # m/s
FALL_STEPS, REST_STEPS = 75, 60  # of 1/30 s
FALL_EFFORT, REST_EFFORT = 0.25, 0.04  # of the drives' torques
STILL = 0.02  # m/s and rad/s
LOW = 0.25  # m, of the middles of pelvis and chest


def fall(vector: TaskVectorEnv, seed: int) -> NDArray[np.bool_]:
    """Throw all figures and let them fall; return which of them lie still."""
    vector.reset(seed=seed)
    task = vector.task
    world, generator = task.world, np.random.default_rng(seed)
    bodies, dim = world.state.bodies, world.model.dim
    moving = np.flatnonzero(world.model.bodies["kind"] == BodyKind.DYNAMIC)
    speed, heading = generator.uniform(*SPEEDS, len(bodies)), generator.uniform(-np.pi, np.pi, len(bodies))
    along = [np.sign(heading)] if dim == 2 else [np.cos(heading), np.sin(heading)]
    for axis, share in enumerate(along):
        bodies["velocity"][:, moving, axis] += (speed * share)[:, None]
    actions = generator.uniform(-1.0, 1.0, task._actions.shape)
    efforts = world.parameters.joints["spring_effort"].copy()
    for steps, effort in ((FALL_STEPS, FALL_EFFORT), (REST_STEPS, REST_EFFORT)):
        world.parameters.joints["spring_effort"][:] = effort * efforts
        for _ in range(steps):
            task.step(actions)
    names = world.model.body_names
    heights = bodies["position"][:, [names.index("pelvis"), names.index("torso")], dim - 1]
    still: NDArray[np.bool_] = np.abs(bodies["velocity"][:, moving]).max((1, 2)) < STILL
    return still & (heights.max(1) < LOW)


def planar_poses(vector: TaskVectorEnv) -> Array:
    angles = vector.task.world.state.bodies["angle"]
    joints = [angles[:, joint.child] - angles[:, joint.parent] - joint.stand for joint in scene.JOINTS]
    return np.stack([angles[:, scene.PELVIS], *joints], axis=1)


def spatial_poses(vector: TaskVectorEnv) -> Array:
    world = vector.task.world
    pelvis = world.state.bodies["rotation"][:, world.model.body_names.index("pelvis")]
    return np.concatenate([pelvis, vector.task.task_state["angles"]], axis=1)


def poses(vector: TaskVectorEnv, read: Any, count: int) -> NDArray[np.float32]:
    found: list[Array] = []
    seed = 0
    while sum(map(len, found)) < count:
        lying = fall(vector, seed)
        found.append(read(vector)[lying])
        seed += 1
    return np.concatenate(found)[:count].astype(np.float32)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m gsenv.envs.falls", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("assets") / FILE, help="(default: %(default)s)")
    parser.add_argument("--poses", type=int, default=POSES, help="of each figure (default: %(default)s)")
    given = parser.parse_args(arguments)
    worlds = min(WORLDS, given.poses)
    nominal: dict[str, Any] = {"push": 0.0, "randomize": {}}
    arrays = {
        "GRagdoll2D-get-up-v0": poses(PlanarVectorEnv(worlds, **nominal), planar_poses, given.poses),
        "GRagdoll-get-up-v0": poses(SpatialVectorEnv(worlds, **nominal), spatial_poses, given.poses),
    }
    write_arrays(given.out, arrays)
    return 0


if __name__ == "__main__":
    sys.exit(main())
