"""GStack3D's records, its quantities, and the jitted passes that start its episodes."""

from __future__ import annotations

from typing import Any

from gsenv.envs import stack3d_blocks as parts
from gsenv.envs import stack3d_scene as scene
from gsenv.envs.blocks import between
from gsenv.envs.stack3d_blocks import DRAWS_PER_BLOCK
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
        gripper.position[0] = between(-_START, _START, draws[i, 0])
        gripper.position[1] = between(-_START, _START, draws[i, 1])
        gripper.position[2] = between(_START_Z, _START_TOP, draws[i, 2])
        drive = joint_states[w, _DRIVE]
        for d in range(3):
            drive.target_position[d] = gripper.position[d]
        record = records[w]
        for k in range(_MAX_BLOCKS):
            parts.make_block(
                record, draws[i], 3 + DRAWS_PER_BLOCK * k, body_parameters[w, _BLOCK + k],
                shape_parameters[w, _SHAPE + k], joint_parameters[w, _WELD + k],
            )  # fmt: skip
        hand_over(record, 0, bodies[w], body_parameters[w], joint_parameters[w])
        parts.move_mast(bodies[w, _MAST], gripper)


@njit
def apply_physics(  # type: ignore[no-untyped-def]
    worlds, physics, world_parameters, body_parameters, shape_parameters, joint_parameters,
):  # fmt: skip
    """Physics (world, quantity), as in stack_physics.QUANTITIES, of worlds whose blocks have just been made."""
    for i in range(len(worlds)):
        w = worlds[i]
        friction, mass, force, gravity = physics[w, 0], physics[w, 1], physics[w, 2], physics[w, 3]
        for k in range(_MAX_BLOCKS):
            shape_parameters[w, _SHAPE + k].friction *= friction
            shape_parameters[w, _SHAPE + k].density *= mass
            body = body_parameters[w, _BLOCK + k]
            body.mass *= mass
            body.inv_mass /= mass
            for d in range(3):
                body.inertia[d] *= mass
                body.inv_inertia[d] /= mass
        joint_parameters[w, _DRIVE].max_force *= force
        joint_parameters[w, _DRIVE].max_torque *= force
        world_parameters[w].gravity[2] = -gravity
