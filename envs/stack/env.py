"""GStack-v0: a force-limited gantry gripper builds a tower from blocks of all sizes."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar

from gymnasium import Env
from gymnasium.vector import VectorEnv

from gsenv.envs import time_limit
from gsenv.envs.core.env import TaskEnv
from gsenv.envs.core.spec_tables import Entry, RewardTerm
from gsenv.envs.core.steering import Button, Key, Stick, pair
from gsenv.envs.core.task import documented
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.stack import blocks, impacts, rules, scene, start
from gsenv.envs.stack.build import build_scene
from gsenv.envs.stack.settings import HARDCORE_SETTINGS, REWARD_WEIGHTS, SETTINGS
from gsenv.envs.stack.task import BlocksTask
from gsenv.solver import Scene

MAX_BLOCKS = scene.MAX_BLOCKS
_WEIGHTS = REWARD_WEIGHTS


class StackTask(BlocksTask):
    """The rules for many worlds; `settings` has the defaults of a reset."""

    actions = (
        Entry(f"gripper velocity to the right, relative to {scene.SPEED} m/s", "move_x", -1, 1),
        Entry(f"gripper velocity upwards, relative to {scene.SPEED} m/s", "move_y", -1, 1),
        Entry(f"turning rate, relative to {scene.TURN_SPEED} rad/s", "turn", -1, 1),
        Entry("releases the block where positive", "release", -1, 1),
    )
    controls = (
        (
            *pair("left", "right", "move", "move_x"),
            *pair("down", "up", "lower, raise", "move_y"),
            *pair("d", "a", "turn", "turn"),
            Key("return", "let go", {"release": 1.0}),
            Stick("left_x", {"move_x": 1.0}),
            Stick("left_y", {"move_y": 1.0}),
            Stick("right_x", {"turn": -1.0}),
            Button("a", {"release": 1.0}),
        ),
    )
    observations = (
        Entry("gripper, position to the right", "gripper_x", -3, 3, "m"),
        Entry("gripper, height", "gripper_y", -1, 6, "m"),
        Entry("gripper, angle", "gripper_angle", -1.6, 1.6, "rad"),
        Entry("gripper, velocity to the right", "gripper_vx", -5, 5, "m/s"),
        Entry("gripper, velocity upwards", "gripper_vy", -5, 5, "m/s"),
        Entry("gripper, turning rate", "gripper_w", -10, 10, "rad/s"),
        Entry("drive, force to the right, relative to its nominal bound", "drive_x", -3, 3),
        Entry("drive, force upwards, relative to its nominal bound", "drive_y", -3, 3),
        Entry("drive, torque, relative to its nominal bound", "drive_torque", -3, 3),
        Entry("1 while a block is held", "holding", 0, 1),
        Entry("block, distance to the right of its support's middle", "block_dx", -5, 5, "m"),
        Entry("block, height of its lowest point above its support's top", "block_gap", -5, 6, "m"),
        Entry("block, angle", "block_angle", -3.2, 3.2, "rad"),
        Entry("block, velocity to the right", "block_vx", -10, 10, "m/s"),
        Entry("block, velocity upwards", "block_vy", -10, 10, "m/s"),
        Entry("block, turning rate", "block_w", -20, 20, "rad/s"),
        Entry("block, half-width", "block_half_width", 0, 0.5, "m"),
        Entry("block, half-height", "block_half_height", 0, 0.5, "m"),
        Entry("block, mass", "block_mass", 0, 6, "10 kg"),
        Entry("block, friction coefficient", "block_friction", 0, 3),
        Entry("gripper, distance to the right of the block's middle", "grasp_dx", -5, 5, "m"),
        Entry("support, half-width (ground: 1)", "support_half_width", 0, 1, "m"),
        Entry("support, angle", "support_angle", -1, 1, "rad"),
        Entry("block, distance to the right of the first block's middle", "lean", -5, 5, "m"),
        Entry("speed of the fastest released block", "tower_speed", 0, 10, "m/s"),
        Entry("gripper, height above the released blocks", "clearance", -5, 6, "m"),
        Entry("how much the gripper must rise for the next block", "rise", 0, 2, "m"),
        Entry("blocks placed, divided by 8", "placed", 0, 1),
        Entry("blocks to go, divided by 8", "to_go", 0, 1),
        Entry("time that the released blocks have stood, divided by success_time", "stand_time", 0, 1),
        Entry("block, height above its support's top, finely where it is near", "near_gap", -0.05, 0.1, "m"),
        Entry("block, speed at which it would land if let go now, divided by crack_speed", "drop_speed", 0, 5),
    )
    reward_terms = (
        RewardTerm(
            "approach",
            f"{_WEIGHTS['approach']:g} per m nearer: the held block to its place (across, "
            f"{blocks.TILT_WEIGHT:g} m per rad of tilt, and {impacts.DROP_WEIGHT:g} m per m/s of the speed at which it "
            "would land if let go), the empty gripper to where the next block comes",
        ),
        RewardTerm("placed", f"{_WEIGHTS['placed']:g} when a block first rests at its level"),
        RewardTerm("success", f"{_WEIGHTS['success']:g} when the whole tower has stood for `success_time`"),
        RewardTerm("fall", f"{_WEIGHTS['fall']:g} when a released block falls"),
        RewardTerm("crack", f"{_WEIGHTS['crack']:g} when a block cracks"),
        RewardTerm("time", f"{_WEIGHTS['time']:g} in each step"),
        RewardTerm("effort", f"{_WEIGHTS['effort']:g} times the mean square of the first 3 actions"),
    )
    rules: ClassVar[ModuleType] = rules
    first_block = scene.FIRST_BLOCK
    first_shape = scene.FIRST_BLOCK_SHAPE
    task_state_fields = start.TASK_STATE_FIELDS
    max_episode_steps = time_limit("GStack-v0")
    draw_count = start.DRAW_COUNT
    arguments = SETTINGS

    def build_scene(self) -> Scene:
        return build_scene()

    def camera(self, world: int, width: int, height: int) -> Any:
        return self.front_camera(world, width, height, scene.REACH_X + 0.2)


class StackHardcoreTask(StackTask):
    """StackTask with harder defaults."""

    arguments = HARDCORE_SETTINGS
    max_episode_steps = time_limit("GStack-hardcore-v0")


_SPECIFICATION = """Build a tower: {id}.

    ## Description
    A gripper hangs from a gantry and holds a block by a magnet. Set the block down, let go, rise,
    and the next block appears in the gripper, until all blocks stand on one another. Blocks differ
    in size, mass and friction; each is held off its middle and tilted, so it must be levelled and
    centred. The gripper is a body of 10 kg that a drive moves by at most 400 N along each axis and
    80 N m: it sags under heavy blocks, stops at obstacles and topples what it hits. Control runs at
    30 Hz.

    A block belongs on the one that came before it, the first on the ground wherever you like. It is
    *placed* once it touches what it belongs on, moves slower than 0.08 m/s and 0.12 rad/s, and the
    gripper is off it. The next one arrives when all released blocks have been placed and the circle
    around its place in the gripper, 5 cm wider than the block, is clear of blocks and ground.

    A block *cracks* where it meets the ground or another block faster than `crack_speed`: 0.4 m/s is a fall
    of 8 mm. The speed of an impact is that at which the two bodies of a contact approach along its normal,
    at its point, when they meet. What rests on a block, and the gripper, crack nothing. So a block must be
    set down, not dropped. Frames show the cracks.

    ## Action Space
    `Box(-1, 1, (4,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    The drive's target stays within 1.8 m of the middle, between 0.15 and 4.4 m high, and within
    0.6 rad.

    ## Observation Space
    `Box(low, high, (32,), float32)`, always within its bounds. "Block" is the one in the gripper,
    or the last one that was; "support" is what it belongs on.

    {observation_table}

    ## Rewards
    The sum of these terms; `info` has each as `reward_<term>`:

    {reward_table}

    Each block can be placed once, and "approach" is a difference of distances within one phase, so
    going to and fro earns nothing.

    ## Starting State
    The gripper is at rest with the first block, up to 1.2 m left or right of the middle and 1 to
    1.4 m high. Uniform and independent for each block, within the ranges of the table of arguments:
    half-width, half-height, mass, friction, how far off its middle it is held, and its tilt. Where
    `sway` is not 0, the velocity that it adds to the gantry's along each axis is
    `sway` (0.6 sin a + 0.4 sin b), with frequencies of 0.2 to 0.5 Hz and 0.6 to 1.2 Hz and phases that
    are drawn for each axis. Equal seeds give equal blocks for any number of blocks.

    ## Episode End
    - Termination, success: all blocks have stood for `success_time`, each on the one below, the
      gripper off them.
    - Termination, failure: a block cracks, or a released block is tilted by more than 0.5 rad, or its
      middle is more than a quarter of its height below its level.
    - Truncation: after {steps}, by `gymnasium.make`, `gymnasium.make_vec` and the vector environment.

    `info` has `success` and `is_success` (bool), `placed` (blocks), `stand_time` (s that the released
    blocks have stood), `cracked` (bool) and `impact` (m/s, the fastest impact of the step, or 0).

    ## Arguments
    The arguments of this table can also be set for one episode: `reset(options={"blocks": 3})`.

    {argument_table}

    {shared_arguments}
    - `randomize`: domain randomisation, `dict(friction=(0.5, 1.5))`: at each reset each world draws
      these quantities uniformly from (low, high), independently of earlier episodes; the others
      stay nominal.

    {quantity_table}

    - `diagnostics`: True adds these entries to `info`, which describe the last 1/60 s of each step (0 after a reset):

    {diagnostics_table}

    ## Version History
    - v0: first version.
    """


@documented
class StackEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _SPECIFICATION.replace("{id}", "GStack-v0").replace("{steps}", "600 steps (20 s)")

    task_class = StackTask
    blocks: int


class StackVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GStack-v0 in one batch; see StackEnv for the task, TaskVectorEnv for the rest."""

    task_class = StackTask
    blocks: int


@documented
class StackHardcoreEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _SPECIFICATION.replace("{id}", "GStack-hardcore-v0").replace("{steps}", "900 steps (30 s)")

    task_class = StackHardcoreTask
    blocks: int


class StackHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GStack-hardcore-v0 in one batch; see StackEnv for the task, TaskVectorEnv for the rest."""

    task_class = StackHardcoreTask
    blocks: int
