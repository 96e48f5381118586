"""GStack-v0: a force-limited gantry gripper builds a tower from blocks of all sizes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from gsenv.envs import stack_rules, stack_scene
from gsenv.envs.base import Array, Task, TaskEnv, documented
from gsenv.envs.spec_tables import Entry, RewardTerm
from gsenv.envs.vector import TaskVectorEnv
from gsenv.solver import Scene

MAX_BLOCKS = stack_scene.MAX_BLOCKS


def check_blocks(blocks: Any) -> int:
    """Levels of the goal, 1 to 8, or ValueError."""
    whole = isinstance(blocks, (int, np.integer)) and not isinstance(blocks, bool)
    if not whole or not 1 <= blocks <= MAX_BLOCKS:
        raise ValueError(f"blocks must be a whole number from 1 to {MAX_BLOCKS}, got {blocks!r}.")
    return int(blocks)


class StackTask(Task):
    """The rules, over many worlds; `settings["blocks"]` is the default of a reset."""

    actions = (
        Entry(f"gripper velocity to the right, of {stack_scene.SPEED} m/s", "move_x", -1, 1),
        Entry(f"gripper velocity upwards, of {stack_scene.SPEED} m/s", "move_y", -1, 1),
        Entry(f"turning rate, of {stack_scene.TURN_SPEED} rad/s", "turn", -1, 1),
        Entry("let go of the block where positive", "release", -1, 1),
    )
    observations = (
        Entry("gripper, position to the right", "gripper_x", -3, 3, "m"),
        Entry("gripper, height", "gripper_y", -1, 6, "m"),
        Entry("gripper, angle", "gripper_angle", -1.6, 1.6, "rad"),
        Entry("gripper, velocity to the right", "gripper_vx", -5, 5, "m/s"),
        Entry("gripper, velocity upwards", "gripper_vy", -5, 5, "m/s"),
        Entry("gripper, turning rate", "gripper_w", -10, 10, "rad/s"),
        Entry("drive, force to the right, of its bound", "drive_x", -1, 1),
        Entry("drive, force upwards, of its bound", "drive_y", -1, 1),
        Entry("drive, torque, of its bound", "drive_torque", -1, 1),
        Entry("1 while a block is held", "holding", 0, 1),
        Entry("block, right of the middle of its support", "block_dx", -5, 5, "m"),
        Entry("block, lowest point above the top of its support", "block_gap", -5, 6, "m"),
        Entry("block, angle", "block_angle", -3.2, 3.2, "rad"),
        Entry("block, velocity to the right", "block_vx", -10, 10, "m/s"),
        Entry("block, velocity upwards", "block_vy", -10, 10, "m/s"),
        Entry("block, turning rate", "block_w", -20, 20, "rad/s"),
        Entry("block, half-width", "block_half_width", 0, 0.5, "m"),
        Entry("block, half-height", "block_half_height", 0, 0.5, "m"),
        Entry("block, mass", "block_mass", 0, 2, "10 kg"),
        Entry("block, friction coefficient", "block_friction", 0, 1),
        Entry("gripper, right of the middle of the block", "grasp_dx", -5, 5, "m"),
        Entry("support, half-width (ground: 1)", "support_half_width", 0, 1, "m"),
        Entry("support, angle", "support_angle", -1, 1, "rad"),
        Entry("block, right of the middle of the first block", "lean", -5, 5, "m"),
        Entry("speed of the fastest released block", "tower_speed", 0, 10, "m/s"),
        Entry("gripper, height above the released blocks", "clearance", -5, 6, "m"),
        Entry("how much the gripper must rise for the next block", "rise", 0, 2, "m"),
        Entry("blocks placed, of 8", "placed", 0, 1),
        Entry("blocks to go, of 8", "to_go", 0, 1),
        Entry("time that the released blocks have stood", "stand_time", 0, 1, "s"),
    )
    reward_terms = (
        RewardTerm(
            "approach",
            f"{stack_rules.APPROACH_WEIGHT:g} per m nearer: the held block to its place (across, "
            f"down, and {stack_rules.TILT_WEIGHT:g} m per rad of tilt), the empty gripper to where "
            "the next block comes",
        ),
        RewardTerm(
            "placed", f"{stack_rules.PLACED_REWARD:g} when a block first rests at its level"
        ),
        RewardTerm(
            "success", f"{stack_rules.SUCCESS_REWARD:g} when the whole tower has stood for 1 s"
        ),
        RewardTerm("fall", f"{stack_rules.FALL_REWARD:g} when a released block falls"),
        RewardTerm(
            "effort", f"{stack_rules.EFFORT_WEIGHT:g} times the mean square of the first 3 actions"
        ),
    )
    record_fields = stack_rules.RECORD_FIELDS
    fact_fields = (("success", "?"), ("is_success", "?"), ("placed", "i8"), ("stand_time", "f8"))
    draw_count = stack_rules.DRAW_COUNT

    def __init__(self, world_count: int, threads: int, settings: Mapping[str, Any]) -> None:
        super().__init__(world_count, threads, {"blocks": check_blocks(settings["blocks"])})
        self._low = np.array([entry.low for entry in self.observations], np.float32)
        self._high = np.array([entry.high for entry in self.observations], np.float32)

    def build_scene(self) -> Scene:
        return stack_scene.build_scene()

    def check_options(self, options: Mapping[str, Any]) -> Mapping[str, Any]:
        for name in options:
            if name != "blocks":
                raise ValueError(f"reset: unknown option {name!r}; the only one is 'blocks'.")
        return {"blocks": check_blocks(options.get("blocks", self.settings["blocks"]))}

    def _start(self, worlds: Array, draws: Array, options: Mapping[str, Any]) -> None:
        state, parameters = self.world.state, self.world.parameters
        stack_rules.start_worlds(
            worlds, draws, options["blocks"], self.records, state.bodies,
            parameters.bodies, parameters.shapes, parameters.joints, state.joints,
        )  # fmt: skip
        stack_rules.observe_worlds(
            worlds, self.observation, self._low, self._high, self.records, state.bodies,
            parameters.bodies, parameters.shapes, parameters.joints, state.joints,
            self.world.timestep,
        )  # fmt: skip

    def _act(self, actions: Array) -> int:
        state = self.world.state
        return stack_rules.act(
            actions, self.records, state.control, self.world.parameters.joints, state.joints
        )

    def _judge(self) -> None:
        state, parameters = self.world.state, self.world.parameters
        stack_rules.judge_worlds(
            self.observation, self._low, self._high, self.reward, self.terms, self.facts,
            self.terminated, self.records, state.worlds, state.contacts, state.bodies,
            parameters.bodies, parameters.shapes, parameters.joints, state.joints,
            self.world.timestep,
        )  # fmt: skip

    def camera(self, world: int, width: int, height: int) -> Any:
        from gsenv.render.camera import Bounds, Camera

        blocks = max(int(self.records["blocks"][world]), 3)
        top = 1.1 + 2.0 * stack_scene.HALF_HEIGHT[1] * blocks
        bounds = Bounds(-stack_scene.REACH_X - 0.2, -0.25, stack_scene.REACH_X + 0.2, top)
        return Camera.fit(bounds, width, height, margin=0.0)

    def captions(self, world: int) -> Sequence[str]:
        record = self.records[world]
        lines = [f"blocks {record['placed']} / {record['blocks']}"]
        if record["placed"] == record["blocks"]:
            lines.append(f"stands {self.facts['stand_time'][world]:.1f} s")
        return lines


@documented
class StackEnv(TaskEnv):
    """Build a tower: GStack-v0.

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

    ## Action Space
    `Box(-1, 1, (4,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    The drive's target stays within 1.8 m of the middle, between 0.15 and 4.4 m high, and within
    0.6 rad.

    ## Observation Space
    `Box(low, high, (30,), float32)`, always within its bounds. "Block" is the one in the gripper,
    or the last one that was; "support" is what it belongs on.

    {observation_table}

    ## Rewards
    The sum of these terms, which `info["reward_terms"]` lists by name:

    {reward_table}

    Each block can be placed once, and "approach" is a difference of distances within one phase, so
    going to and fro earns nothing.

    ## Starting State
    The gripper is at rest with the first block, up to 1.2 m left or right of the middle and 1.2 to
    1.6 m high. Uniform and independent for each block: half-width 0.20 to 0.35 m, half-height 0.12
    to 0.20 m, density 20 to 60 kg/m^2 (1.9 to 16.8 kg), friction 0.4 to 0.8, held up to 35 % of the
    half-width off its middle and tilted by up to 0.3 rad. Equal seeds give equal blocks for any
    number of blocks.

    ## Episode End
    - Termination, success: all blocks have stood for 1 s, each on the one below, the gripper off
      them.
    - Termination, failure: a released block is tilted by more than 0.5 rad, or its middle is more
      than a quarter of its height below its level.
    - Truncation: after 600 steps (20 s), by `gymnasium.make` and `gymnasium.make_vec`.

    `info` has `success` and `is_success` (bool), `placed` (blocks), and `stand_time` (s that the
    released blocks have stood).

    ## Arguments
    - `blocks`: levels of the tower, 1 to 8 (default 5). `reset(options={"blocks": k})` overrides
      it for one episode.
    - `render_mode`: None or "rgb_array"; `width`, `height`: of frames, multiples of 16 (640 x 480).

    ## Version History
    - v0: first version.
    """

    task_class = StackTask

    def __init__(
        self,
        blocks: int = 5,
        render_mode: str | None = None,
        width: int = 640,
        height: int = 480,
    ) -> None:
        super().__init__({"blocks": blocks}, render_mode, width, height)

    @property
    def blocks(self) -> int:
        """Levels of the tower from the next reset on, unless its options say otherwise."""
        return int(self.task.settings["blocks"])

    @blocks.setter
    def blocks(self, blocks: int) -> None:
        self.task.settings["blocks"] = check_blocks(blocks)


class StackVectorEnv(TaskVectorEnv):
    """N worlds of GStack-v0 in one batch; see StackEnv for the task.

    World i of `reset(seed=s)` equals the single environment's `reset(seed=s + i)`, bit for bit, for
    every number of worlds, of threads, and in every autoreset mode.

    Args:
        num_envs: worlds.
        blocks: levels of the tower; settable (`set_attr("blocks", 3)`) for episodes to come.
        render_mode: None or "rgb_array"; width, height: px of a frame, multiples of 16.
        max_episode_steps: truncates by itself; None never does.
        autoreset_mode: one of Gymnasium's three.
        threads: worlds are shared out over this many.
    """

    task_class = StackTask

    def __init__(
        self,
        num_envs: int = 1,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        blocks: int = 5,
        width: int = 640,
        height: int = 480,
        threads: int = 1,
    ) -> None:
        super().__init__(
            num_envs, {"blocks": blocks}, render_mode, max_episode_steps, autoreset_mode,
            width, height, threads,
        )  # fmt: skip

    @property
    def blocks(self) -> int:
        """Levels of the tower from the next reset on, unless its options say otherwise."""
        return int(self.task.settings["blocks"])

    @blocks.setter
    def blocks(self, blocks: int) -> None:
        self.task.settings["blocks"] = check_blocks(blocks)
