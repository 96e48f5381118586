"""tower_v0's rules over many worlds, and its native vector environment; tower_v0.py is the PettingZoo side."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar

from gymnasium.vector import VectorEnv

from gsenv.envs import time_limit
from gsenv.envs.core.arguments import Setting, whole_within, with_defaults
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.steering import Button, Key, Stick, pair
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.stack import impacts
from gsenv.envs.stack import scene as stack
from gsenv.envs.stack.blocks import TILT_WEIGHT
from gsenv.envs.stack.settings import BLOCK_SETTINGS, HARDCORE_BLOCKS, weights_setting
from gsenv.envs.stack.task import BlocksTask
from gsenv.envs.tower import rules, scene, start
from gsenv.envs.tower.build import build_scene
from gsenv.solver import Scene

REWARD_WEIGHTS = {
    "approach": 0.5, "placed": 1.0, "partner": 0.5, "success": 5.0, "fall": -0.2, "crack": -0.2, "bump": -0.02,
    "time": -0.002, "effort": -0.002,
}  # fmt: skip
_WEIGHTS = REWARD_WEIGHTS
SEEN_BEYOND = 0.7  # m, beyond the grippers' reach: the width of the largest block that hangs off its middle


def check_blocks(blocks: Any) -> int:
    """Return a number of blocks, 2, 4, 6 or 8; raises ValueError for anything else."""
    allowed = range(2, scene.MAX_BLOCKS + 1, 2)
    return whole_within(blocks, allowed, f"blocks must be 2, 4, 6 or {scene.MAX_BLOCKS}")


class TowerTask(BlocksTask):
    """The rules for many worlds with two agents each."""

    agents = ("gripper_0", "gripper_1")
    actions = (
        Entry(f"gripper velocity inwards, relative to {stack.SPEED} m/s", "move_x", -1, 1),
        Entry(f"gripper velocity upwards, relative to {stack.SPEED} m/s", "move_y", -1, 1),
        Entry(f"turning rate inwards, relative to {stack.TURN_SPEED} rad/s", "turn", -1, 1),
        Entry("releases the block where positive", "release", -1, 1),
    )
    controls = (
        (
            *pair("a", "d", "left gripper: move", "move_x"),
            *pair("s", "w", "left gripper: lower, raise", "move_y"),
            *pair("q", "e", "left gripper: turn", "turn"),
            Key("x", "left gripper: let go", {"release": 1.0}),
            Stick("left_x", {"move_x": 1.0}),
            Stick("left_y", {"move_y": 1.0}),
            Stick("right_x", {"turn": 1.0}),
            Button("a", {"release": 1.0}),
        ),
        (
            *pair("right", "left", "right gripper: move", "move_x"),  # inwards is to the left
            *pair("down", "up", "right gripper: lower, raise", "move_y"),
            *pair("m", ",", "right gripper: turn", "turn"),
            Key("return", "right gripper: let go", {"release": 1.0}),
        ),
    )
    observations = (
        Entry("gripper, position inwards of the middle", "gripper_x", -3, 3, "m"),
        Entry("gripper, height", "gripper_y", -1, 6, "m"),
        Entry("gripper, angle", "gripper_angle", -1.6, 1.6, "rad"),
        Entry("gripper, velocity inwards", "gripper_vx", -5, 5, "m/s"),
        Entry("gripper, velocity upwards", "gripper_vy", -5, 5, "m/s"),
        Entry("gripper, turning rate", "gripper_w", -10, 10, "rad/s"),
        Entry("drive, force inwards, relative to its nominal bound", "drive_x", -3, 3),
        Entry("drive, force upwards, relative to its nominal bound", "drive_y", -3, 3),
        Entry("drive, torque, relative to its nominal bound", "drive_torque", -3, 3),
        Entry("1 while a block is held", "holding", 0, 1),
        Entry("block, inwards of the middle of its support", "block_dx", -5, 5, "m"),
        Entry("block, height of its lowest point above its support's top", "block_gap", -5, 6, "m"),
        Entry("block, angle", "block_angle", -3.2, 3.2, "rad"),
        Entry("block, velocity inwards", "block_vx", -10, 10, "m/s"),
        Entry("block, velocity upwards", "block_vy", -10, 10, "m/s"),
        Entry("block, turning rate", "block_w", -20, 20, "rad/s"),
        Entry("block, half-width", "block_half_width", 0, 0.5, "m"),
        Entry("block, half-height", "block_half_height", 0, 0.5, "m"),
        Entry("block, mass", "block_mass", 0, 6, "10 kg"),
        Entry("block, friction coefficient", "block_friction", 0, 3),
        Entry("gripper, inwards of the middle of the block", "grasp_dx", -5, 5, "m"),
        Entry("support, half-width", "support_half_width", 0, 1, "m"),
        Entry("support, angle", "support_angle", -3.2, 3.2, "rad"),
        Entry("support, inwards of the middle of the plinth", "lean", -5, 5, "m"),
        Entry("speed of the fastest released block", "tower_speed", 0, 10, "m/s"),
        Entry("gripper, height above the tower", "clearance", -5, 6, "m"),
        Entry("distance outwards to where blocks arrive", "to_depot", 0, 5, "m"),
        Entry("how much the gripper must rise for its next block", "rise", 0, 2, "m"),
        Entry("other gripper, inwards of this one", "other_dx", -5, 5, "m"),
        Entry("other gripper, above this one", "other_dy", -5, 5, "m"),
        Entry("other gripper, velocity inwards less this one's", "other_vx", -5, 5, "m/s"),
        Entry("other gripper, velocity upwards less this one's", "other_vy", -5, 5, "m/s"),
        Entry("other gripper, angle", "other_angle", -1.6, 1.6, "rad"),
        Entry("1 while the other gripper holds a block", "other_holding", 0, 1),
        Entry("other's block, inwards of the middle of its support", "other_block_dx", -5, 5, "m"),
        Entry("other's block, height of its lowest point above its support's top", "other_block_gap", -5, 6, "m"),
        Entry("other's block, half-width", "other_half_width", 0, 0.5, "m"),
        Entry("other's block, half-height", "other_half_height", 0, 0.5, "m"),
        Entry("blocks placed, divided by 8", "placed", 0, 1),
        Entry("own blocks not yet released, divided by 4", "to_go", 0, 1),
        Entry("other's blocks not yet released, divided by 4", "other_to_go", 0, 1),
        Entry("time that the released blocks have stood, divided by success_time", "stand_time", 0, 1),
        Entry("1 while it is this gripper's turn to build", "turn", 0, 1),
        Entry("block, height above its support's top, finely where it is near", "near_gap", -0.05, 0.1, "m"),
        Entry("block, speed at which it would land if let go now, divided by crack_speed", "drop_speed", 0, 5),
    )
    reward_terms = (
        RewardTerm(
            "approach",
            f"{_WEIGHTS['approach']:g} per m nearer: the held block to the tower's top (across, {TILT_WEIGHT:g} m per "
            f"rad of tilt, and {impacts.DROP_WEIGHT:g} m per m/s of the speed at which it would land if let go) where "
            "the gripper has the turn, else the gripper to where its blocks arrive",
        ),
        RewardTerm("placed", f"{_WEIGHTS['placed']:g} when an own block first rests at its level"),
        RewardTerm("partner", f"{_WEIGHTS['partner']:g} when one of the other's does"),
        RewardTerm("success", f"{_WEIGHTS['success']:g} to both when the whole tower has stood for `success_time`"),
        RewardTerm("fall", f"{_WEIGHTS['fall']:g} to both when a released block falls"),
        RewardTerm("crack", f"{_WEIGHTS['crack']:g} to both when a block cracks"),
        RewardTerm("bump", f"{_WEIGHTS['bump']:g} to both in each step in which grippers, or what they hold, touch"),
        RewardTerm("time", f"{_WEIGHTS['time']:g} to both in each step"),
        RewardTerm("effort", f"{_WEIGHTS['effort']:g} times the mean square of the first 3 own actions"),
    )
    rules: ClassVar[ModuleType] = rules
    first_block = scene.FIRST_BLOCK
    first_shape = scene.FIRST_BLOCK_SHAPE
    task_state_fields = start.TASK_STATE_FIELDS
    info_fields = (*BlocksTask.info_fields, ("bump", "?"))
    max_episode_steps = time_limit("tower_v0")
    draw_count = start.DRAW_COUNT
    arguments: ClassVar[tuple[Setting, ...]] = (
        Setting("blocks", 4, check_blocks, f"levels of the tower: 2, 4, 6 or {scene.MAX_BLOCKS}"),
        *BLOCK_SETTINGS,
        weights_setting(REWARD_WEIGHTS),
    )

    def build_scene(self) -> Scene:
        return build_scene()

    def camera(self, world: int, width: int, height: int) -> Any:
        return self.front_camera(world, width, height, SEEN_BEYOND - scene.REACH_X[0])


class TowerHardcoreTask(TowerTask):
    """TowerTask with harder defaults."""

    arguments = with_defaults(TowerTask.arguments, blocks=6, **HARDCORE_BLOCKS)
    max_episode_steps = time_limit("tower_hardcore_v0")


class TowerVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of tower_v0 in one batch, a Gymnasium vector environment whose worlds have two agents.

    Observations are (world, agent, entry), actions (world, agent, 4), rewards (world, agent); worlds end
    for both agents at once, so terminated and truncated are (world,). World i of `reset(seed=s)` equals
    `tower_v0.parallel_env().reset(seed=s + i)`, bit for bit. See tower_v0.TowerParallelEnv for the task.
    """

    task_class = TowerTask
    blocks: int


class TowerHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of tower_hardcore_v0 in one batch, in all else as TowerVectorEnv."""

    task_class = TowerHardcoreTask
    blocks: int
