"""Arguments of GStack and tower_v0: defaults, checks, and how they get into the task state that kernels read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from gsenv.envs.core.arguments import Setting, number, number_within, numbers, whole_within, with_defaults
from gsenv.envs.stack import scene
from gsenv.solver.records.text import shown

CONTROL_RATE = 30.0  # Hz
SUCCESS_TIME = 1.0  # s
CRACK_SPEED = 0.4  # m/s

REWARD_WEIGHTS = {
    "approach": 0.5, "placed": 1.0, "success": 5.0, "fall": -0.2, "crack": -0.2, "time": -0.002, "effort": -0.002,
}  # fmt: skip

# What observations, the reach of the gantry and the strength of the drive allow.
LIMITS = {
    "half_width": (0.1, 0.4),
    "half_height": (0.05, 0.25),
    "mass": (0.5, 20.0),
    "friction": (0.0, 1.0),
    "grasp_offset": (0.0, 0.8),
    "grasp_tilt": (0.0, 0.5),
    "success_time": (0.1, 10.0),
    "crack_speed": (0.05, 100.0),
    "sway": (0.0, 0.5),
}

Range = tuple[float, float]
Limits = tuple[float, float]


def blocks_setting(default: int, least: int, most: int) -> Setting:
    """Return the setting `blocks`, a whole number."""

    def check(blocks: Any) -> int:
        allowed = range(least, most + 1)
        return whole_within(blocks, allowed, f"blocks must be a whole number from {least} to {most}")

    return Setting("blocks", default, check, f"levels of the tower, {least} to {most}")


def number_setting(name: str, default: float, text: str, limits: Limits) -> Setting:
    """Return a setting whose value is a number within limits."""
    low, high = limits

    def check(given: Any) -> float:
        return number_within(given, low, high, f"{name} must be a number from {low:g} to {high:g}")

    return Setting(name, default, check, f"{text}, within {low:g} to {high:g}")


def range_setting(name: str, default: Range, text: str, limits: Limits) -> Setting:
    """Return a setting whose value is two numbers within limits, the lower first."""
    least, most = limits

    def check(given: Any) -> Range:
        values = numbers(given)
        if len(values) != 2 or not least <= values[0] <= values[1] <= most:
            wanted = f"two numbers from {least:g} to {most:g}, lowest first"
            raise ValueError(f"{name} must be {wanted}, got {shown(given)}.")
        return values[0], values[1]

    return Setting(name, default, check, f"{text}: (lowest, highest), within {least:g} to {most:g}")


def weights_setting(defaults: Mapping[str, float]) -> Setting:
    """Return the setting `reward_weights`, whose value has the given weights and the defaults of the others."""

    def check(given: Any) -> dict[str, float]:
        weights = dict(defaults)
        if not isinstance(given, Mapping):
            raise ValueError(f"reward_weights must map names of reward terms to numbers, got {shown(given)}.")
        for name, weight in given.items():
            value = number(weight)
            if name not in weights:
                raise ValueError(f"reward_weights: unknown term {name!r}; known are {', '.join(weights)}.")
            if value is None:
                raise ValueError(f"reward_weights: {name} must be a finite number, got {shown(weight)}.")
            weights[name] = value
        return weights

    return Setting("reward_weights", {}, check, "weights of reward terms by name, instead of the table's")


def crack_setting(default: float) -> Setting:
    """Return the setting `crack_speed`."""
    text = "m/s, of the slowest impact that cracks a block"
    return number_setting("crack_speed", default, text, LIMITS["crack_speed"])


def sway_setting(default: float) -> Setting:
    """Return the setting `sway`."""
    return number_setting("sway", default, "m/s, how fast the gantry sways along each axis, at most", LIMITS["sway"])


BLOCK_SETTINGS = (
    range_setting("half_width", scene.HALF_WIDTH, "m, of blocks", LIMITS["half_width"]),
    range_setting("half_height", scene.HALF_HEIGHT, "m, of blocks", LIMITS["half_height"]),
    range_setting("mass", scene.MASS, "kg, of blocks", LIMITS["mass"]),
    range_setting("friction", scene.FRICTION, "coefficient, of blocks", LIMITS["friction"]),
    crack_setting(CRACK_SPEED),
    number_setting(
        "grasp_offset", scene.GRASP_OFFSET, "how far off its middle a block is held, of its half-width",
        LIMITS["grasp_offset"],
    ),
    number_setting(
        "grasp_tilt", scene.GRASP_TILT, "rad, how far a block is tilted in the gripper", LIMITS["grasp_tilt"]
    ),
    number_setting("success_time", SUCCESS_TIME, "s that the whole tower must stand", LIMITS["success_time"]),
)  # fmt: skip

SETTINGS: tuple[Setting, ...] = (
    blocks_setting(5, 1, scene.MAX_BLOCKS), *BLOCK_SETTINGS, sway_setting(0.0), weights_setting(REWARD_WEIGHTS),
)  # fmt: skip
HARDCORE_BLOCKS: dict[str, Any] = {
    "half_width": (0.12, 0.3), "half_height": (0.1, 0.22), "mass": (1.0, 18.0), "friction": (0.3, 0.6),
    "grasp_offset": 0.6, "grasp_tilt": 0.5, "crack_speed": 0.25,
}  # fmt: skip
HARDCORE_SETTINGS = with_defaults(SETTINGS, blocks=7, sway=0.08, **HARDCORE_BLOCKS)

_ELSEWHERE = ("success_time", "reward_weights")


def write_settings(task_states: NDArray[Any], worlds: NDArray[Any], settings: Mapping[str, Any]) -> None:
    """Write checked settings to the task state of worlds whose episodes begin."""
    for name, value in settings.items():
        if name not in _ELSEWHERE:
            task_states[name][worlds] = value
    # 1e-9: one second is 30 steps, whatever the last bit says
    task_states["stand_steps"][worlds] = math.ceil(settings["success_time"] * CONTROL_RATE - 1e-9)
    for name, weight in settings["reward_weights"].items():
        task_states[f"{name}_weight"][worlds] = weight
