"""What the actuators ask of each joint: motors for forces and speeds, springs for positions.

The force of an actuator is gain * control + bias[0] + bias[1] * length + bias[2] * speed, with the joint's coordinate
times the gear as length. It is a torque, a speed regulator or a position regulator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from .errors import Notes
from .model import Actuator, Joint, MjcfModel, Range

NOT_AFFINE = "an actuator of this kind is not supported"
NOT_A_JOINT = "only actuators of slides and hinges are supported"
NOT_A_DRIVE = "its force grows with coordinate or speed, as that of no motor or spring does"


@dataclass(frozen=True)
class Drive:
    """One actuator of a joint's coordinate, in MuJoCo's own direction.

    Attributes:
        name: of the actuator in the scene.
        mode: "torque", "velocity" or "position".
        gain, offset: the torque or set point is gain * control + offset.
        limits: of the control.
        effort: N or N m, largest effort.
        stiffness, damping: of the spring, or of the motor that regulates the speed.
    """

    name: str
    mode: str
    gain: float
    offset: float
    limits: tuple[float, float]
    effort: float
    stiffness: float = 0.0
    damping: float = 0.0


@dataclass
class Drives:
    """The drives of a joint: at most one motor and one spring on the joint itself, further ones beside it."""

    motor: Drive | None = None
    spring: Drive | None = None
    beside: list[Drive] = field(default_factory=list)


def drives_of(model: MjcfModel, notes: Notes) -> dict[int, Drives]:
    """Return the drives of the joints that have any, by the joints' indices."""
    numbers = {joint.name: k for k, joint in enumerate(model.joints) if joint.name}
    found: dict[int, Drives] = {}
    for k, actuator in enumerate(model.actuators):
        title = f"{actuator.place}: {actuator.kind}" + (f" {actuator.name!r}" if actuator.name else "")
        if not actuator.affine:
            notes.add(NOT_AFFINE, title)
            continue
        index = numbers.get(actuator.target, -1) if actuator.target_kind in ("joint", "jointinparent") else -1
        if index < 0 or model.joints[index].kind not in ("slide", "hinge"):
            notes.add(NOT_A_JOINT, title)
            continue
        drive = _drive(actuator, actuator.name or f"actuator {k}", model.joints[index])
        if drive is None:
            notes.add(NOT_A_DRIVE, title)
            continue
        _place(drive, found.setdefault(index, Drives()), model.joints[index])
    return found


def _place(drive: Drive, drives: Drives, joint: Joint) -> None:
    """Add a drive to the motor or spring of its joint, or beside the joint where these are taken."""
    if drive.mode != "position":
        if drives.motor is None:
            drives.motor = drive
            return
    elif drives.spring is None and (math.isinf(drive.effort) or joint.stiffness == joint.damping == 0.0):
        drives.spring = _with_own_spring(drive, joint)
        return
    drives.beside.append(drive)


def _with_own_spring(drive: Drive, joint: Joint) -> Drive:
    """Return the spring of a position actuator together with that of its joint."""
    stiffness = drive.stiffness + joint.stiffness
    share = drive.stiffness / stiffness
    offset = share * drive.offset + (1.0 - share) * joint.spring_reference
    damping = drive.damping + joint.damping
    return replace(drive, gain=share * drive.gain, offset=offset, stiffness=stiffness, damping=damping)


def _drive(actuator: Actuator, name: str, joint: Joint) -> Drive | None:
    """Return the drive of an affine actuator, None where its force grows with coordinate or speed."""
    gear = float(actuator.gear[0])
    constant, of_length, of_speed = (float(b) for b in actuator.bias)
    gain, constant = gear * actuator.gain, gear * constant
    stiffness, damping = -of_length * gear**2, -of_speed * gear**2
    if min(stiffness, damping) < 0.0:
        return None
    limits = (-np.inf, np.inf) if actuator.control_range is None else actuator.control_range
    effort = min(_largest(actuator.force_range) * abs(gear), _largest(joint.force_range))
    if stiffness > 0.0:
        return Drive(name, "position", gain / stiffness, constant / stiffness, limits, effort, stiffness, damping)
    if damping > 0.0:
        return Drive(name, "velocity", gain / damping, constant / damping, limits, effort, damping=damping)
    return Drive(name, "torque", gain, constant, limits, effort)


def _largest(bounds: Range) -> float:
    """Return the largest effort within bounds; those of an actuator are symmetric in practice."""
    return np.inf if bounds is None else max(abs(bounds[0]), abs(bounds[1]))
