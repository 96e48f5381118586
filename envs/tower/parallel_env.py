"""The PettingZoo environments of tower_v0 and tower_hardcore_v0: one world in which both agents act at once."""

from __future__ import annotations

from typing import Any

from pettingzoo import ParallelEnv

from gsenv.envs.core.painter import render_metadata
from gsenv.envs.core.parallel import TaskParallelEnv
from gsenv.envs.core.task import documented
from gsenv.envs.tower.env import TowerHardcoreTask, TowerTask

_SPECIFICATION = """Build one tower with two grippers: {id}.

    ## Description
    Two grippers hang from a gantry, one on either side of a low plinth, and each holds a block by a
    magnet. Together they build one tower on the plinth: each gripper gets half of the blocks, and the
    block that is released next belongs on top, whichever gripper held it. So each must build, both hold
    a block at the same time, and they must agree on who goes first, because grippers and blocks are
    solid and there is no room for two above the plinth. Grippers and blocks are those of GStack-v0: a
    body of 10 kg that a drive moves by at most 400 N along each axis and 80 N m, and blocks of all
    sizes, held off their middle and tilted. Control runs at 30 Hz.

    A released block belongs on the one released before it, the first one on the plinth. It is *placed*
    once it touches what it belongs on, moves slower than 0.08 m/s and 0.12 rad/s, and no gripper is on
    it. An empty gripper gets its next block when its last one has been placed, it is more than 1.2 m
    out on its side, and the circle around the block's place, 5 cm wider than the block, is clear of
    blocks and ground, and a circle 30 cm larger is clear of the other gripper.

    A block *cracks* where it meets the plinth, the ground or another block faster than `crack_speed`:
    0.4 m/s is a fall of 8 mm. The speed of an impact is that at which the two bodies of a contact approach
    along its normal, at its point, when they meet. What rests on a block, and the grippers, crack nothing.

    The observation `turn` says who should build: the gripper that has released fewer blocks, of equals the
    left one. Nothing enforces it; without it, two mirrored agents that act alike would wait for each other.

    The agents are `gripper_0` on the left and `gripper_1` on the right. Each acts and sees in its own
    frame, where x points inwards, from its side towards the other's: the right one's is mirrored, so
    that one policy serves both.

    ## Action Space
    Of each agent: `Box(-1, 1, (4,), float32)`. Values beyond are clipped; NaN and infinity are refused.

    {action_table}

    The drive's target stays between 2 m outwards and 0.6 m inwards of the middle, between 0.15 and
    4.4 m high, and within 0.6 rad.

    ## Observation Space
    Of each agent: `Box(low, high, (45,), float32)`, always within its bounds. "Block" is the one in the
    gripper, or the last one that was; "support" is what it belongs on. `state()` is both agents'
    observations, one after the other. An agent sees pixels in its own frame too: the right one's are
    mirrored.

    {observation_table}

    ## Rewards
    Of each agent the sum of these terms; `infos[agent]` has each as `reward_<term>`:

    {reward_table}

    Each block can be placed once, and "approach" is a difference of distances within one phase, which
    ends when either gripper releases a block, so going to and fro earns nothing.

    ## Starting State
    Uniform and independent: the plinth up to 0.2 m left or right of the middle; each gripper at rest
    with a block, 1.3 to 1.8 m outwards of the middle and 1.4 to 1.9 m high. Blocks as in GStack-v0, see
    Arguments. Equal seeds give equal blocks for any number of blocks.

    ## Episode End
    Both agents end at once, by the same signal.

    - Termination, success: all blocks have stood for `success_time`, each on the one below, the
      grippers off them.
    - Termination, failure: a block cracks, or a released block is tilted by more than 0.5 rad, or its
      middle is more than a quarter of its height below its level.
    - Truncation: after `max_cycles` steps, 900 (30 s) by default.

    `infos[agent]` has `success` and `is_success` (bool), `placed` (blocks), `stand_time` (s that the
    released blocks have stood), `cracked` (bool), `impact` (m/s, the fastest impact of the step, or 0) and
    `bump` (whether the grippers, or what they hold, touch).

    ## Arguments
    The arguments of this table can also be set for one episode: `reset(options={"blocks": 2})`.

    {argument_table}

    - `max_cycles`: steps until truncation; None for 900, -1 for no limit.
    {shared_arguments}
    - `randomize`: domain randomisation, `{"friction": (0.5, 1.5)}`: at each reset these quantities are
      drawn uniformly from (low, high), independently of earlier episodes; the others stay nominal.

    {quantity_table}

    - `diagnostics`: True adds these entries to `infos[agent]`, which describe the last 1/60 s of each step (0 after a
      reset):

    {diagnostics_table}

    ## Version History
    - v0: first version.
    """


@documented
class TowerParallelEnv(TaskParallelEnv, ParallelEnv):
    __doc__ = _SPECIFICATION.replace("{id}", "tower_v0")

    task_class = TowerTask
    metadata: dict[str, Any] = render_metadata(name="tower_v0", is_parallelizable=True)
    blocks: int


@documented
class TowerHardcoreParallelEnv(TaskParallelEnv, ParallelEnv):
    __doc__ = _SPECIFICATION.replace("{id}", "tower_hardcore_v0")

    task_class = TowerHardcoreTask
    metadata: dict[str, Any] = render_metadata(name="tower_hardcore_v0", is_parallelizable=True)
    blocks: int
