"""GStack3D's task state, and the kernels that start its episodes."""

from __future__ import annotations

from typing import Any

from gsenv.envs.core.kernels import between
from gsenv.envs.stack import impacts
from gsenv.envs.stack import shared_rules as shared
from gsenv.envs.stack3d import blocks as parts
from gsenv.envs.stack3d import scene
from gsenv.envs.stack3d.blocks import DRAWS_PER_BLOCK
from gsenv.solver.jit import njit

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    *shared.GRIPPER_FIELDS,
    *shared.setting_fields(("grasp_turn", "f8")),
    *impacts.sway_fields(3),
    *shared.weight_fields("approach", "placed", "success", "fall", "crack", "time", "effort"),
]

SWAY_DRAWS = 3 + DRAWS_PER_BLOCK * scene.MAX_BLOCKS  # the first of those of the sway
DRAW_COUNT = SWAY_DRAWS + 3 * impacts.SWAY_DRAWS

_BLOCK = scene.FIRST_BLOCK
_SHAPE = scene.FIRST_BLOCK_SHAPE
_GRIPPER = scene.GRIPPER_BODY
_MAST = scene.MAST_BODY
_DRIVE = scene.DRIVE_JOINT
_WELD = scene.FIRST_WELD
_MAX_BLOCKS = scene.MAX_BLOCKS
_START = scene.START
_START_Z, _START_TOP = scene.START_Z


@njit
def hand_over(world, k):  # type: ignore[no-untyped-def]
    """Place block k in the gripper."""
    parts.hand_over(world, _GRIPPER, _BLOCK + k, _WELD + k)
    shared.take(world.task.state, k)


@njit
def initialize_world(world, draws):  # type: ignore[no-untyped-def]
    """Begin an episode: put the gripper at a drawn position with the first block in it."""
    parameters = world.parameters
    at = (
        between(-_START, _START, draws[0]),
        between(-_START, _START, draws[1]),
        between(_START_Z, _START_TOP, draws[2]),
    )
    parts.place_upright(world, _GRIPPER, at)
    drive = world.state.joints[_DRIVE]
    for d in range(3):
        drive.target_position[d] = at[d]
    for k in range(_MAX_BLOCKS):
        parts.make_block(
            world.task.state, draws[3 + DRAWS_PER_BLOCK * k :], parameters.bodies[_BLOCK + k],
            parameters.shapes[_SHAPE + k], parameters.joints[_WELD + k],
        )  # fmt: skip
    impacts.draw_sway(world.task.state, draws[SWAY_DRAWS:], 3)
    hand_over(world, 0)
    parts.move_mast(world, _MAST, _GRIPPER)
