"""What the actuators ask of each joint: motors for forces and speeds, springs for positions.

The force of an actuator is gain * control + bias[0] + bias[1] * length + bias[2] * speed, with the joint's coordinate
times the gear as length. It is a torque, a speed regulator or a position regulator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..solver.records.model import Array
from .errors import Notes
from .kinematics import mass_matrix
from .model import Actuator, Joint, MjcfModel
from .relations import initial_coordinates

NOT_AFFINE = "an actuator of this kind is not supported"
NOT_A_JOINT = "only actuators of slides and hinges are supported"
NOT_A_DRIVE = "its force grows with coordinate or speed, as that of no motor or spring does"
UNEQUAL = "the force range of a position or velocity actuator counts with the larger bound in both directions"
OF_EACH = "the force range of a joint with several actuators bounds each of them, not their sum"


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
    inertias = _apparent_inertias(model)
    for k, actuator in enumerate(model.actuators):
        title = f"{actuator.place}: {actuator.kind}" + (f" {actuator.name!r}" if actuator.name else "")
        if not actuator.affine:
            notes.add(NOT_AFFINE, title)
            continue
        index = numbers.get(actuator.target, -1) if actuator.target_kind in ("joint", "jointinparent") else -1
        if index < 0 or model.joints[index].kind not in ("slide", "hinge"):
            notes.add(NOT_A_JOINT, title)
            continue
        drive = _drive(actuator, actuator.name or f"actuator {k}", model.joints[index], inertias, notes, title)
        if drive is None:
            notes.add(NOT_A_DRIVE, title)
            continue
        if index in found and model.joints[index].force_range is not None:
            notes.add(OF_EACH, title)
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


def _apparent_inertias(model: MjcfModel) -> Array:
    """Return the inertia (rate,) against a force on each joint in the initial pose, where no other joint is held."""
    if not any(actuator.damping_ratio > 0.0 for actuator in model.actuators):
        return np.zeros(0)
    return np.asarray(1.0 / np.diag(np.linalg.inv(mass_matrix(model, np.array(initial_coordinates(model))))))


def _drive(actuator: Actuator, name: str, joint: Joint, inertias: Array, notes: Notes, title: str) -> Drive | None:
    """Return the drive of an affine actuator, None where its force grows with coordinate or speed."""
    gear = float(actuator.gear[0])
    constant, of_length, of_speed = (float(b) for b in actuator.bias)
    gain, constant = gear * actuator.gain, gear * constant
    stiffness, damping = -of_length * gear**2, -of_speed * gear**2
    if min(stiffness, damping) < 0.0:
        return None
    if actuator.damping_ratio > 0.0:
        damping = 2.0 * actuator.damping_ratio * math.sqrt(stiffness * inertias[joint.rate])
    limits = (-np.inf, np.inf) if actuator.control_range is None else actuator.control_range
    low, high = _bounds(actuator, joint, gear)
    effort = max(abs(low), abs(high))
    if effort == 0.0 or max(abs(gain), abs(constant), stiffness, damping) == 0.0:
        return Drive(name, "torque", 0.0, 0.0, limits, np.inf)
    if stiffness == damping == 0.0:
        gain, constant, limits = _within(gain, constant, limits, (low, high))
        return Drive(name, "torque", gain, constant, limits, effort)
    if low != -high:
        notes.add(UNEQUAL, title)
    if stiffness > 0.0:
        return Drive(name, "position", gain / stiffness, constant / stiffness, limits, effort, stiffness, damping)
    return Drive(name, "velocity", gain / damping, constant / damping, limits, effort, damping=damping)


def _bounds(actuator: Actuator, joint: Joint, gear: float) -> tuple[float, float]:
    """Return the least and the largest force of an actuator on its joint."""
    low, high = -np.inf, np.inf
    if actuator.force_range is not None and gear != 0.0:
        low, high = sorted(gear * bound for bound in actuator.force_range)
    if joint.force_range is not None:
        low, high = (min(max(bound, joint.force_range[0]), joint.force_range[1]) for bound in (low, high))
    return low, high


def _within(
    gain: float, constant: float, limits: tuple[float, float], bounds: tuple[float, float]
) -> tuple[float, float, tuple[float, float]]:
    """Return gain, constant and control limits of a torque that stays within its bounds.

    A motor has one effort for both directions, so the controls are limited where the bounds are unequal.
    """
    low, high = bounds
    if low == -high:
        return gain, constant, limits
    if gain == 0.0:
        return gain, min(max(constant, low), high), limits
    first, last = sorted(((low - constant) / gain, (high - constant) / gain))
    lower, upper = (min(max(limit, first), last) for limit in limits)
    return gain, constant, (lower, upper)
