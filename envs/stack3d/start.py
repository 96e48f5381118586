"""GStack3D's task state, and the kernels that start its episodes."""

from __future__ import annotations

from typing import Any

from gsenv.envs.core.kernels import active_contacts, between
from gsenv.envs.stack3d import blocks as parts
from gsenv.envs.stack3d import scene
from gsenv.envs.stack3d.blocks import DRAWS_PER_BLOCK
from gsenv.solver.core.edit import place_body
from gsenv.solver.jit import njit

TASK_STATE_FIELDS: list[tuple[Any, ...]] = [
    ("blocks", "i8"),  # levels of the goal
    ("arrived", "i8"),  # blocks that are or were in the gripper
    ("held", "i8"),  # block in the gripper, or -1
    ("placed", "i8"),  # blocks that came to rest at their level
    ("stand", "i8"),  # control steps that the released blocks have stood
    ("distance", "f8"),  # to go, as the approach term sees it; negative: not yet known
    ("effort", "f8"),  # mean square of the last action
    *parts.SETTING_FIELDS,
    ("approach_weight", "f8"),
    ("placed_weight", "f8"),
    ("success_weight", "f8"),
    ("fall_weight", "f8"),
    ("effort_weight", "f8"),
]

DRAW_COUNT = 3 + DRAWS_PER_BLOCK * scene.MAX_BLOCKS

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
    """Block k appears in the gripper."""
    parts.hand_over(world, _GRIPPER, _BLOCK + k, _WELD + k)
    task = world.task.state
    task.held = k
    task.arrived = k + 1
    task.distance = -1.0


@njit
def initialize_world(world, draws):  # type: ignore[no-untyped-def]
    """An episode begins: the gripper at a drawn place, the first block in it."""
    bodies, parameters = world.state.bodies, world.parameters
    at = (
        between(-_START, _START, draws[0]),
        between(-_START, _START, draws[1]),
        between(_START_Z, _START_TOP, draws[2]),
    )
    place_body(_GRIPPER, bodies, parameters.bodies, active_contacts(world), at, parts.UPRIGHT, parts.AT_REST)
    drive = world.state.joints[_DRIVE]
    for d in range(3):
        drive.target_position[d] = at[d]
    for k in range(_MAX_BLOCKS):
        parts.make_block(
            world.task.state, draws[3 + DRAWS_PER_BLOCK * k :], parameters.bodies[_BLOCK + k],
            parameters.shapes[_SHAPE + k], parameters.joints[_WELD + k],
        )  # fmt: skip
    hand_over(world, 0)
    parts.move_mast(world, _MAST, _GRIPPER)
