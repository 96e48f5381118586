"""GStack's records, and the jitted pass that starts its episodes: blocks are drawn and handed over."""

from __future__ import annotations

from typing import Any

from gsenv.envs import blocks as parts
from gsenv.envs import stack_scene as scene
from gsenv.envs.blocks import DRAWS_PER_BLOCK
from gsenv.solver.jit import njit

RECORD_FIELDS: list[tuple[Any, ...]] = [
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

DRAW_COUNT = 2 + DRAWS_PER_BLOCK * scene.MAX_BLOCKS

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
def hand_over(record, k, bodies, body_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Block k appears in the gripper."""
    parts.hand_over(bodies[_GRIPPER], bodies[_BLOCK + k], body_parameters[_BLOCK + k], joint_parameters[_WELD + k])
    record.held = k
    record.arrived = k + 1
    record.distance = -1.0


@njit
def start_worlds(  # type: ignore[no-untyped-def]
    worlds, draws, records, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states,
):  # fmt: skip
    """Episodes begin: the gripper at a drawn place, the first block in it."""
    for i in range(len(worlds)):
        w = worlds[i]
        gripper = bodies[w, _GRIPPER]
        gripper.position[0] = parts.between(-_START_X, _START_X, draws[i, 0])
        gripper.position[1] = parts.between(_START_Y, _START_TOP, draws[i, 1])
        drive = joint_states[w, _DRIVE]
        drive.target_position[0] = gripper.position[0]
        drive.target_position[1] = gripper.position[1]
        record = records[w]
        for k in range(_MAX_BLOCKS):
            parts.make_block(
                record, draws[i], 2 + DRAWS_PER_BLOCK * k, body_parameters[w, _BLOCK + k],
                shape_parameters[w, _SHAPE + k], joint_parameters[w, _WELD + k],
            )  # fmt: skip
        hand_over(record, 0, bodies[w], body_parameters[w], joint_parameters[w])
        parts.move_mast(bodies[w, _MAST], gripper)
