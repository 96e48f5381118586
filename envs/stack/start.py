"""GStack's task state, and the kernels that start its episodes: blocks are drawn and handed over."""

from __future__ import annotations

from typing import Any

from gsenv.envs.core.kernels import between
from gsenv.envs.stack import blocks as parts
from gsenv.envs.stack import impacts, scene
from gsenv.envs.stack import shared_rules as shared
from gsenv.envs.stack.blocks import DRAWS_PER_BLOCK
from gsenv.solver.jit import njit

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    *shared.GRIPPER_FIELDS,
    *shared.setting_fields(("grasp_tilt", "f8")),
    *impacts.sway_fields(2),
    *shared.weight_fields("approach", "placed", "success", "fall", "crack", "time", "effort"),
]

SWAY_DRAWS = 2 + DRAWS_PER_BLOCK * scene.MAX_BLOCKS  # the first of those of the sway
DRAW_COUNT = SWAY_DRAWS + 2 * impacts.SWAY_DRAWS

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.GRIPPER_BODY
_MAST = scene.MAST_BODY
_DRIVE = scene.DRIVE_JOINT
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_START_X = scene.START_X
_START_Y, _START_TOP = scene.START_Y


@njit
def hand_over(world, k):  # type: ignore[no-untyped-def]
    """Place block k in the gripper."""
    parts.hand_over(world, _GRIPPER, _BLOCK + k, _WELD + k)
    shared.take(world.task.state, k)


@njit
def initialize_world(world, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: put the gripper at a drawn position with the first block in it."""
    x = between(-_START_X, _START_X, draws[0])
    y = between(_START_Y, _START_TOP, draws[1])
    parts.place_gripper(world, _GRIPPER, _DRIVE, x, y)
    parts.make_blocks(world, draws[2:], _BLOCK, _SHAPE, _WELD, _MAX_BLOCKS)
    impacts.draw_sway(world.task.state, draws[SWAY_DRAWS:], 2)
    hand_over(world, 0)
    parts.move_mast(world, _MAST, _GRIPPER)
