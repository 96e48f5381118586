"""tower_v0's records, and the jitted pass that starts its episodes."""

from __future__ import annotations

from typing import Any

from gsenv.envs import blocks as parts
from gsenv.envs import tower_scene as scene
from gsenv.envs.blocks import DRAWS_PER_BLOCK
from gsenv.solver.jit import njit

RECORD_FIELDS: list[tuple[Any, ...]] = [
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
    *parts.SETTING_FIELDS,
    ("approach_weight", "f8"),
    ("placed_weight", "f8"),
    ("partner_weight", "f8"),
    ("success_weight", "f8"),
    ("fall_weight", "f8"),
    ("bump_weight", "f8"),
    ("effort_weight", "f8"),
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
_START_X, _START_TO_X = scene.START_X
_START_Y, _START_TO_Y = scene.START_Y


@njit
def hand_over(record, a, bodies, body_parameters, joint_parameters):  # type: ignore[no-untyped-def]
    """Gripper a gets its next block: its n-th one is block 2 n + a."""
    k = 2 * record.arrived[a] + a
    parts.hand_over(bodies[_GRIPPER + a], bodies[_BLOCK + k], body_parameters[_BLOCK + k], joint_parameters[_WELD + k])
    record.block[a] = k
    record.held[a] = 1
    record.arrived[a] += 1
    record.distance[a] = -1.0


@njit
def start_worlds(  # type: ignore[no-untyped-def]
    worlds, draws, records, bodies, body_parameters, shape_parameters, joint_parameters,
    joint_states,
):  # fmt: skip
    """Episodes begin: plinth and grippers at drawn places, a block in each gripper."""
    for i in range(len(worlds)):
        w = worlds[i]
        record = records[w]
        bodies[w, _PLINTH].position[0] = parts.between(-_PLINTH_X, _PLINTH_X, draws[i, 0])
        for k in range(_MAX_BLOCKS):
            record.level[k] = NOT_RELEASED
            parts.make_block(
                record, draws[i], FIRST_DRAWS + DRAWS_PER_BLOCK * k, body_parameters[w, _BLOCK + k],
                shape_parameters[w, _SHAPE + k], joint_parameters[w, _WELD + k],
            )  # fmt: skip
        for a in range(2):
            side = 1.0 - 2.0 * a
            gripper = bodies[w, _GRIPPER + a]
            gripper.position[0] = side * parts.between(_START_X, _START_TO_X, draws[i, 1 + 2 * a])
            gripper.position[1] = parts.between(_START_Y, _START_TO_Y, draws[i, 2 + 2 * a])
            drive = joint_states[w, a]
            drive.target_position[0] = gripper.position[0]
            drive.target_position[1] = gripper.position[1]
            hand_over(record, a, bodies[w], body_parameters[w], joint_parameters[w])
            parts.move_mast(bodies[w, _MAST + a], gripper)
