"""Checks of actuators, and the part of a joint that each drives."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import check
from .handles import Reference, find
from .specs import ActuatorSpec, JointSpec, SceneSpec

DRIVEN = {"velocity": "motor", "position": "spring", "torque": "motor"}  # the part of a joint that a mode needs
AXES = {
    2: {"x": 0, "y": 1, "angle": 2},
    3: {"x": 0, "y": 1, "z": 2, "turn_x": 3, "turn_y": 4, "turn_z": 5},
}


def actuator_spec(
    name: str, joint: Reference, axis: str | None, mode: str, limits: Any, line: Any, scene: SceneSpec
) -> ActuatorSpec:
    """Return the checked actuator.

    Args:
        limits: (lower, upper) of the control; line: (gain, offset).

    Raises:
        ValueError: an unknown joint, one that lacks the part to drive, or one that is driven already.
    """
    what = f"actuator {name!r}"
    index = find(joint, "joint", list(scene.joints), what)
    spec = list(scene.joints.values())[index]
    check.choice(mode, DRIVEN, f"{what}: mode")
    low = float(check.bounds(limits[0], (), f"{what}: lower"))
    high = float(check.bounds(limits[1], (), f"{what}: upper"))
    gain = check.finite(line[0], f"{what}: gain")
    offset = check.finite(line[1], f"{what}: offset")
    check.ordered_bounds(np.array(low), np.array(high), what)
    number = _driven_axis(spec, axis, mode, scene.dim, what)
    taken = [other for other in scene.actuators.values() if (other.joint, other.axis) == (index, number)]
    if any(spec.kind == "target" or DRIVEN[other.mode] == DRIVEN[mode] for other in taken):
        raise ValueError(f"{what}: {taken[0].name!r} drives the same part of joint {spec.name!r}.")
    return ActuatorSpec(name, index, number, mode, low, high, gain, offset)


def _driven_axis(spec: JointSpec, axis: str | None, mode: str, dim: int, what: str) -> int:
    if spec.kind == "target":
        check.choice(mode, ("velocity", "position"), f"{what}: mode of a target")
        number = AXES[dim][check.choice(axis, AXES[dim], f"{what}: axis")]
        if number >= 3 and mode == "position":
            raise ValueError(f"{what}: turning is driven by velocity; {axis} has no position.")
        return number
    if spec.parts and not spec.motor_effort > 0.0 and not spec.has_spring:
        names = ", ".join(repr(part.name) for part in spec.parts)
        raise ValueError(f"{what}: joint {spec.name!r} has the coordinates {names}; drive one of these.")
    if spec.kind in ("rows", "weld", "gear"):
        raise ValueError(f"{what} needs a target, a motor or a spring, {spec.name!r} is a {spec.kind}.")
    if axis is not None:
        raise ValueError(f"{what}: only a target has an axis to choose, got {axis!r}.")
    if DRIVEN[mode] == "motor" and not spec.motor_effort > 0.0:
        wheel, _, part = spec.name.rpartition("/")
        if part == "spin":
            raise ValueError(f"{what}: the motor of a wheel is driven by the wheel's own name, {wheel!r}.")
        raise ValueError(f"{what}: joint {spec.name!r} has no motor; give it a motor_effort.")
    if DRIVEN[mode] == "spring" and (spec.kind == "distance" or not spec.has_spring):
        raise ValueError(f"{what}: joint {spec.name!r} has no spring to set the rest of; give it a frequency.")
    return -1
