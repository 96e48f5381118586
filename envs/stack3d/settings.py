"""Arguments of GStack3D: defaults and what they may be."""

from __future__ import annotations

from gsenv.envs.core.arguments import Setting, with_defaults
from gsenv.envs.stack.settings import (
    CRACK_SPEED,
    REWARD_WEIGHTS,
    SUCCESS_TIME,
    blocks_setting,
    crack_setting,
    number_setting,
    range_setting,
    sway_setting,
    weights_setting,
)
from gsenv.envs.stack3d import scene

# What observations, the reach of the gantry and the strength of the drive allow.
LIMITS = {
    "half_width": (0.1, 0.3),
    "half_height": (0.05, 0.22),
    "mass": (0.5, 20.0),
    "friction": (0.0, 1.0),
    "grasp_offset": (0.0, 0.8),
    "grasp_turn": (0.0, 0.75),
    "success_time": (0.1, 10.0),
}

SETTINGS: tuple[Setting, ...] = (
    blocks_setting(3, 2, scene.MAX_BLOCKS),
    range_setting("half_width", scene.HALF_WIDTH, "m, of blocks along x and y", LIMITS["half_width"]),
    range_setting("half_height", scene.HALF_HEIGHT, "m, of blocks", LIMITS["half_height"]),
    range_setting("mass", scene.MASS, "kg, of blocks", LIMITS["mass"]),
    range_setting("friction", scene.FRICTION, "coefficient, of blocks", LIMITS["friction"]),
    crack_setting(CRACK_SPEED),
    number_setting(
        "grasp_offset", scene.GRASP_OFFSET, "how far off its middle a block is held, of its half-widths",
        LIMITS["grasp_offset"],
    ),
    number_setting(
        "grasp_turn", scene.GRASP_TURN, "rad, how far a block is turned in the gripper", LIMITS["grasp_turn"]
    ),
    number_setting("success_time", SUCCESS_TIME, "s that the whole tower must stand", LIMITS["success_time"]),
    sway_setting(0.0),
    weights_setting(REWARD_WEIGHTS),
)  # fmt: skip
HARDCORE_SETTINGS = with_defaults(
    SETTINGS, blocks=5, half_width=(0.13, 0.26), half_height=(0.08, 0.2), mass=(1.0, 18.0), friction=(0.3, 0.6),
    grasp_offset=0.5, grasp_turn=0.75, crack_speed=0.25, sway=0.06,
)  # fmt: skip
