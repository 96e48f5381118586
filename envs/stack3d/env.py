"""GStack3D-v0: a force-limited gantry gripper builds a tower from blocks of all sizes, in 3D."""

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
from gsenv.envs.stack import impacts
from gsenv.envs.stack.settings import REWARD_WEIGHTS
from gsenv.envs.stack.task import BlocksTask
from gsenv.envs.stack3d import blocks as parts
from gsenv.envs.stack3d import rules, scene, start
from gsenv.envs.stack3d.build import build_scene
from gsenv.envs.stack3d.settings import HARDCORE_SETTINGS, SETTINGS
from gsenv.solver import Scene

MAX_BLOCKS = scene.MAX_BLOCKS
_WEIGHTS = REWARD_WEIGHTS
_SPEED = scene.SPEED


class Stack3DTask(BlocksTask):
    """The rules for many worlds; `settings` has the defaults of a reset."""

    actions = (
        Entry(f"gripper velocity along x, relative to {_SPEED} m/s", "move_x", -1, 1),
        Entry(f"gripper velocity along y, relative to {_SPEED} m/s", "move_y", -1, 1),
        Entry(f"gripper velocity upwards, relative to {_SPEED} m/s", "move_z", -1, 1),
        Entry(f"turning rate about the vertical, relative to {scene.TURN_SPEED} rad/s", "turn", -1, 1),
        Entry("releases the block where positive", "release", -1, 1),
    )
    controls = (
        (  # as the camera sees them, which looks from the front right
            Key("left", "move", {"move_x": -0.78, "move_y": -0.62}),
            Key("right", "move", {"move_x": 0.78, "move_y": 0.62}),
            Key("up", "move", {"move_x": -0.62, "move_y": 0.78}),
            Key("down", "move", {"move_x": 0.62, "move_y": -0.78}),
            *pair("s", "w", "lower, raise", "move_z"),
            *pair("d", "a", "turn", "turn"),
            Key("return", "let go", {"release": 1.0}),
            Stick("left_x", {"move_x": 0.78, "move_y": 0.62}),
            Stick("left_y", {"move_x": -0.62, "move_y": 0.78}),
            Stick("right_y", {"move_z": 1.0}),
            Stick("right_x", {"turn": -1.0}),
            Button("a", {"release": 1.0}),
        ),
    )
    observations = (
        Entry("gripper, position along x", "gripper_x", -3, 3, "m"),
        Entry("gripper, position along y", "gripper_y", -3, 3, "m"),
        Entry("gripper, height", "gripper_z", -1, 5, "m"),
        Entry("gripper, heading", "gripper_heading", -3.2, 3.2, "rad"),
        Entry("gripper, its upright axis along x", "gripper_tilt_x", -1, 1),
        Entry("gripper, its upright axis along y", "gripper_tilt_y", -1, 1),
        Entry("gripper, velocity along x", "gripper_vx", -5, 5, "m/s"),
        Entry("gripper, velocity along y", "gripper_vy", -5, 5, "m/s"),
        Entry("gripper, velocity upwards", "gripper_vz", -5, 5, "m/s"),
        Entry("gripper, turning rate about the vertical", "gripper_wz", -10, 10, "rad/s"),
        Entry("drive, force along x, relative to its nominal bound", "drive_x", -3, 3),
        Entry("drive, force along y, relative to its nominal bound", "drive_y", -3, 3),
        Entry("drive, force upwards, relative to its nominal bound", "drive_z", -3, 3),
        Entry("drive, torque about x, relative to its nominal bound", "drive_turn_x", -3, 3),
        Entry("drive, torque about y, relative to its nominal bound", "drive_turn_y", -3, 3),
        Entry("drive, torque about the vertical, relative to its nominal bound", "drive_turn_z", -3, 3),
        Entry("1 while a block is held", "holding", 0, 1),
        Entry("block, along x from the middle of its support", "block_dx", -5, 5, "m"),
        Entry("block, along y from the middle of its support", "block_dy", -5, 5, "m"),
        Entry("block, height of its lowest point above its support's top", "block_gap", -5, 6, "m"),
        Entry("block, heading against the nearest sides of its support", "block_twist", -0.8, 0.8, "rad"),
        Entry("block, its upright axis along x", "block_tilt_x", -1, 1),
        Entry("block, its upright axis along y", "block_tilt_y", -1, 1),
        Entry("block, velocity along x", "block_vx", -10, 10, "m/s"),
        Entry("block, velocity along y", "block_vy", -10, 10, "m/s"),
        Entry("block, velocity upwards", "block_vz", -10, 10, "m/s"),
        Entry("block, turning rate about x", "block_wx", -20, 20, "rad/s"),
        Entry("block, turning rate about y", "block_wy", -20, 20, "rad/s"),
        Entry("block, turning rate about the vertical", "block_wz", -20, 20, "rad/s"),
        Entry("block, half-width along its own x", "block_half_x", 0, 0.5, "m"),
        Entry("block, half-width along its own y", "block_half_y", 0, 0.5, "m"),
        Entry("block, half-height", "block_half_height", 0, 0.5, "m"),
        Entry("block, mass", "block_mass", 0, 6, "10 kg"),
        Entry("block, friction coefficient", "block_friction", 0, 3),
        Entry("gripper, along x from the middle of the block", "grasp_dx", -5, 5, "m"),
        Entry("gripper, along y from the middle of the block", "grasp_dy", -5, 5, "m"),
        Entry("support, half-width along its own x (ground: 1)", "support_half_x", 0, 1, "m"),
        Entry("support, half-width along its own y (ground: 1)", "support_half_y", 0, 1, "m"),
        Entry("support, heading of its nearest sides (ground: 0)", "support_heading", -0.8, 0.8, "rad"),
        Entry("support, its upright axis along x", "support_tilt_x", -1, 1),
        Entry("support, its upright axis along y", "support_tilt_y", -1, 1),
        Entry("block, along x from the middle of the first block", "lean_x", -5, 5, "m"),
        Entry("block, along y from the middle of the first block", "lean_y", -5, 5, "m"),
        Entry("speed of the fastest released block", "tower_speed", 0, 10, "m/s"),
        Entry("gripper, height above the released blocks", "clearance", -5, 6, "m"),
        Entry("how much the gripper must rise for the next block", "rise", 0, 2, "m"),
        Entry(f"blocks placed, relative to {MAX_BLOCKS}", "placed", 0, 1),
        Entry(f"blocks to go, relative to {MAX_BLOCKS}", "to_go", 0, 1),
        Entry("time that the released blocks have stood, divided by success_time", "stand_time", 0, 1),
        Entry("block, height above its support's top, finely where it is near", "near_gap", -0.05, 0.1, "m"),
        Entry("block, speed at which it would land if let go now, divided by crack_speed", "drop_speed", 0, 5),
    )
    reward_terms = (
        RewardTerm(
            "approach",
            f"{_WEIGHTS['approach']:g} per m nearer: the held block to its place (across, "
            f"{parts.TWIST_WEIGHT:g} m per rad of twist, and {impacts.DROP_WEIGHT:g} m per m/s of the speed at which "
            "it would land if let go), the empty gripper to where the next block comes",
        ),
        RewardTerm("placed", f"{_WEIGHTS['placed']:g} when a block first rests at its level"),
        RewardTerm("success", f"{_WEIGHTS['success']:g} when the whole tower has stood for `success_time`"),
        RewardTerm("fall", f"{_WEIGHTS['fall']:g} when a released block falls or lies across"),
        RewardTerm("crack", f"{_WEIGHTS['crack']:g} when a block cracks"),
        RewardTerm("time", f"{_WEIGHTS['time']:g} in each step"),
        RewardTerm("effort", f"{_WEIGHTS['effort']:g} times the mean square of the first 4 actions"),
    )
    rules: ClassVar[ModuleType] = rules
    first_block = scene.FIRST_BLOCK
    first_shape = scene.FIRST_BLOCK_SHAPE
    task_state_fields = start.TASK_STATE_FIELDS
    max_episode_steps = time_limit("GStack3D-v0")
    draw_count = start.DRAW_COUNT
    arguments = SETTINGS

    def build_scene(self) -> Scene:
        return build_scene()

    def camera(self, world: int, width: int, height: int) -> Any:
        """Return a camera that looks down obliquely, from farther away for towers of more than three blocks."""
        from gsenv.render.spatial import SpatialCamera

        state = self.task_state[world]
        top = 1.75 + 2.0 * float(state["half_height"][1]) * max(int(state["blocks"]) - 3, 0)
        middle = 0.42 * top
        away = 1.2 + 1.30 * top
        eye = (0.62 * away, -0.78 * away, middle + 0.40 * away)
        return SpatialCamera(eye, (0.0, 0.0, middle), width=width, height=height)


class Stack3DHardcoreTask(Stack3DTask):
    """Stack3DTask with harder defaults."""

    arguments = HARDCORE_SETTINGS
    max_episode_steps = time_limit("GStack3D-hardcore-v0")


_SPECIFICATION = """Build a tower in 3D: {id}.

    ## Description
    A gripper hangs from a gantry and holds a block by a magnet. Set the block down, let go, rise,
    and the next block appears in the gripper, until all blocks stand on one another. Blocks differ
    in width, depth, height, mass and friction; each is held off its middle and turned about the
    vertical, so it must be centred and its sides brought in line with those of the block below. The
    gripper is a body of 10 kg that a drive moves by at most 400 N along each axis and holds upright
    and turns by at most 80 N m: it sags under heavy blocks, tilts where they hang far off, stops at
    obstacles and topples what it hits. Control runs at 30 Hz. x and y are level, z points up.

    A block belongs on the one that came before it, the first on the ground wherever you like. It is
    *placed* once it touches what it belongs on, moves slower than 0.08 m/s and 0.12 rad/s, and the
    gripper is off it. The next one arrives when all released blocks have been placed and the ball
    around its place in the gripper, 5 cm wider than the block, is clear of blocks and ground.

    A block *cracks* where it meets the ground or another block faster than `crack_speed`: 0.4 m/s is a fall
    of 8 mm. The speed of an impact is that at which the two bodies of a contact approach along its normal,
    at its point, when they meet. What rests on a block, and the gripper, crack nothing. So a block must be
    set down, not dropped. Frames show the cracks.

    ## Action Space
    `Box(-1, 1, (5,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    The drive's target stays within 1.2 m of the middle along x and y, between 0.15 and 3.6 m high,
    and within 1.6 rad.

    ## Observation Space
    `Box(low, high, (51,), float32)`, always within its bounds. "Block" is the one in the gripper,
    or the last one that was; "support" is what it belongs on. An upright axis is the body's own z
    axis, seen from above.

    {observation_table}

    ## Rewards
    The sum of these terms; `info` has each as `reward_<term>`:

    {reward_table}

    Each block can be placed once, and "approach" is a difference of distances within one phase, so
    going to and fro earns nothing. Twist is the angle between the sides of a block and the nearest
    sides of the one below; the first block has none.

    ## Starting State
    The gripper is at rest with the first block, up to 0.6 m from the middle along x and y, and 1.0
    to 1.4 m high. Uniform and independent for each block, within the ranges of the table of arguments:
    half-widths, half-height, mass, friction, how far off its middle it is held, and its turn. Where
    `sway` is not 0, the velocity that it adds to the gantry's along each axis is
    `sway` (0.6 sin a + 0.4 sin b), with frequencies of 0.2 to 0.5 Hz and 0.6 to 1.2 Hz and phases that
    are drawn for each axis. Equal seeds give equal blocks for any number of blocks.

    ## Episode End
    - Termination, success: all blocks have stood for `success_time`, each on the one below, the
      gripper off them.
    - Termination, failure: a block cracks, or a released block is tilted by more than 0.5 rad, is twisted by more than
      0.3 rad, or its middle is more than a quarter of its height below its level.
    - Truncation: after {steps}, by `gymnasium.make`, `gymnasium.make_vec` and the vector environment.

    `info` has `success` and `is_success` (bool), `placed` (blocks), `stand_time` (s that the released
    blocks have stood), `cracked` (bool) and `impact` (m/s, the fastest impact of the step, or 0).

    ## Arguments
    The arguments of this table can also be set for one episode: `reset(options={"blocks": 4})`.

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
class Stack3DEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _SPECIFICATION.replace("{id}", "GStack3D-v0").replace("{steps}", "600 steps (20 s)")

    task_class = Stack3DTask
    blocks: int


class Stack3DVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GStack3D-v0 in one batch; see Stack3DEnv for the task, TaskVectorEnv for the rest."""

    task_class = Stack3DTask
    blocks: int


@documented
class Stack3DHardcoreEnv(TaskEnv, Env[Any, Any]):
    __doc__ = _SPECIFICATION.replace("{id}", "GStack3D-hardcore-v0").replace("{steps}", "900 steps (30 s)")

    task_class = Stack3DHardcoreTask
    blocks: int


class Stack3DHardcoreVectorEnv(TaskVectorEnv, VectorEnv[Any, Any, Any]):
    """N worlds of GStack3D-hardcore-v0 in one batch; see Stack3DEnv for the task, TaskVectorEnv for the rest."""

    task_class = Stack3DHardcoreTask
    blocks: int
