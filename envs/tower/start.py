"""tower_v0's task state, and the kernel that starts its episodes."""

from __future__ import annotations

from typing import Any

from gsenv.envs.core.kernels import between
from gsenv.envs.stack import blocks as parts
from gsenv.envs.stack import impacts
from gsenv.envs.stack import shared_rules as shared
from gsenv.envs.stack.blocks import DRAWS_PER_BLOCK
from gsenv.envs.tower import scene
from gsenv.solver.jit import njit

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    ("blocks", "i8"),  # levels of the goal
    ("released", "i8"),  # blocks that were let go
    ("placed", "i8"),  # blocks that came to rest at their level
    ("stand", "i8"),  # control steps that the released blocks have stood
    ("order", "i8", (scene.MAX_BLOCKS,)),  # block at each level
    ("level", "i8", (scene.MAX_BLOCKS,)),  # of each block, or NOT_RELEASED
    # of the two grippers
    ("block", "i8", (2,)),  # the one that is held, or the last one that was
    ("held", "i8", (2,)),  # 1 while it is held
    ("arrived", "i8", (2,)),  # blocks that are or were in the gripper
    ("distance", "f8", (2,)),  # to go, as the approach term sees it; negative: not yet known
    ("effort", "f8", (2,)),  # mean square of the last action
    *impacts.FIELDS,
    *shared.setting_fields(("grasp_tilt", "f8")),
    *shared.weight_fields("approach", "placed", "partner", "success", "fall", "crack", "bump", "time", "effort"),
]

NOT_RELEASED = -9  # next to no level
FIRST_DRAWS = 5  # the plinth's place, and two of each gripper
DRAW_COUNT = FIRST_DRAWS + DRAWS_PER_BLOCK * scene.MAX_BLOCKS

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.FIRST_GRIPPER
_MAST = scene.FIRST_MAST
_PLINTH = scene.PLINTH_BODY
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_PLINTH_X = scene.PLINTH_X
_PLINTH_Y = scene.PLINTH_HEIGHT / 2
_START_X, _START_TO_X = scene.START_X
_START_Y, _START_TO_Y = scene.START_Y


@njit
def hand_over(world, a):  # type: ignore[no-untyped-def]
    """Place the next block in gripper a; its n-th one is block 2 n + a."""
    task = world.task.state
    k = 2 * task.arrived[a] + a
    parts.hand_over(world, _GRIPPER + a, _BLOCK + k, _WELD + k)
    task.block[a] = k
    task.held[a] = 1
    task.arrived[a] += 1
    task.distance[a] = -1.0


@njit
def initialize_world(world, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: put plinth and grippers at drawn positions, with a block in each gripper."""
    task = world.task.state
    parts.place_upright(world, _PLINTH, between(-_PLINTH_X, _PLINTH_X, draws[0]), _PLINTH_Y)
    for k in range(_MAX_BLOCKS):
        task.level[k] = NOT_RELEASED
    parts.make_blocks(world, draws[FIRST_DRAWS:], _BLOCK, _SHAPE, _WELD, _MAX_BLOCKS)
    for a in range(2):
        x = (1.0 - 2.0 * a) * between(_START_X, _START_TO_X, draws[1 + 2 * a])
        y = between(_START_Y, _START_TO_Y, draws[2 + 2 * a])
        parts.place_gripper(world, _GRIPPER + a, a, x, y)
        hand_over(world, a)
        parts.move_mast(world, _MAST + a, _GRIPPER + a)
