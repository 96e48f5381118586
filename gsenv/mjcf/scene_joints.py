"""Joints of a model as joints of a Scene.

A body with one slide or hinge gets a Slider or Hinge, one with several perpendicular ones a SixAxis, whose rotations
are successive ones about axes as MuJoCo's hinges are. Other combinations get small bodies in between.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..solver.records.model import Array
from ..solver.specification.axis_spec import ORDERS
from ..solver.specification.joint_base import Axis
from .drives import Drive, Drives
from .frames import Pose, about, from_z, product
from .model import Joint

PERPENDICULAR = 1e-9  # cosine of the angle between axes that count as perpendicular
TOGETHER = 1e-9  # m between anchors that count as one
LETTERS = "xyz"


@dataclass(frozen=True)
class Coordinate:
    """Where a coordinate of the model is in the scene: q of the model = reference + sign * that of the scene."""

    joint: str
    sign: float
    reference: float


@dataclass(frozen=True, eq=False)
class Axes:
    """The axes of a joint with several coordinates.

    Attributes:
        frame: (3, 3) the columns are x, y and z, in the world.
        places: of each joint, the number of its axis and its sign.
        order: of the rotations.
    """

    frame: Array
    places: tuple[tuple[int, float], ...]
    order: str


def servo(joint: Joint, sign: float, drives: Drives, limited: bool = True) -> dict[str, Any]:
    """Return the arguments of an Axis, Hinge or Slider that stands for a joint."""
    spring = drives.spring
    arguments: dict[str, Any] = {
        "stiffness": joint.stiffness if spring is None else spring.stiffness,
        "damping": joint.damping if spring is None else spring.damping,
        "rest": sign * (joint.spring_reference - joint.reference),
        "friction_effort": joint.friction_loss,
        "armature": joint.armature,
    }
    if joint.limits is not None and limited:
        lower, upper = (sign * (bound - joint.reference) for bound in joint.limits)
        arguments["limits"] = (min(lower, upper), max(lower, upper))
    if spring is not None:
        arguments["spring_effort"] = spring.effort
    return arguments | motor(drives.motor)


def motor(drive: Drive | None) -> dict[str, Any]:
    """Return the arguments of a motor for an actuator."""
    if drive is None:
        return {}
    arguments: dict[str, Any] = {"motor_effort": drive.effort}
    if drive.mode == "velocity":
        arguments["motor_gain"] = drive.damping
    return arguments


def beside(drive: Drive) -> Axis:
    """Return the Axis of a drive that acts beside its joint."""
    if drive.mode == "position":
        return Axis(stiffness=drive.stiffness, damping=drive.damping, spring_effort=drive.effort)
    return Axis(**motor(drive))


def axes_of(joints: Sequence[Joint], pose: Pose) -> Axes | None:
    """Return the axes of several joints of a body, None where they are not those of a six-axis joint.

    They are if all slides come before the hinges, hinges share an anchor, and all directions are perpendicular or,
    of a slide and a hinge, parallel. Of all frames the one with the fewest reversed coordinates is chosen.

    Args:
        pose: of the body in the world.
    """
    kinds = [joint.kind for joint in joints]
    hinges = [joint for joint in joints if joint.kind == "hinge"]
    if not {"slide", "hinge"}.issuperset(kinds):
        return None
    if sorted(kinds, reverse=True) != kinds or not 1 <= len(joints) <= 6:
        return None
    if any(np.linalg.norm(one.position - hinges[0].position) > TOGETHER for one in hinges):
        return None
    directions = np.array([pose.axes @ joint.axis for joint in joints])
    best: Axes | None = None
    most = -1
    for frame in _frames(directions):
        places = [_place(direction, frame) for direction in directions]
        if any(place is None for place in places):
            continue
        found = [place for place in places if place is not None]
        turning = [place[0] for place, kind in zip(found, kinds, strict=True) if kind == "hinge"]
        sliding = [place[0] for place, kind in zip(found, kinds, strict=True) if kind == "slide"]
        order = _order(turning)
        if len(set(turning)) < len(turning) or len(set(sliding)) < len(sliding) or order is None:
            continue
        kept = sum(place[1] > 0.0 for place in found)
        if kept > most:
            best, most = Axes(frame, tuple(found), order), kept
    return best


def _frames(directions: Array) -> list[Array]:
    """Return the right-handed frames (3, 3) whose axes are along the directions, in any order and sign."""
    basis: list[Array] = []
    for direction in directions:
        if all(abs(float(direction @ other)) < 0.5 for other in basis):
            basis.append(direction)
    if len(basis) == 1:
        basis.append(Pose(np.zeros(3), from_z(basis[0])).axes[:, 0])
    if len(basis) == 2:
        basis.append(np.cross(basis[0], basis[1]))
    if len(basis) > 3:
        return []
    frames = []
    for order in itertools.permutations(basis):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            frame = np.stack([sign * axis for sign, axis in zip(signs, order, strict=True)], axis=1)
            if abs(float(np.linalg.det(frame)) - 1.0) < 1e-6:
                frames.append(frame)
    return frames


def _place(direction: Array, frame: Array) -> tuple[int, float] | None:
    """Return the number of the axis that a direction is along, and the sign."""
    along = direction @ frame
    k = int(abs(along).argmax())
    others = np.delete(along, k)
    return (k, 1.0 if along[k] > 0.0 else -1.0) if abs(others).max() < PERPENDICULAR else None


def _order(turning: Sequence[int]) -> str | None:
    """Return the cyclic order of rotations in which those about the given axes follow one another."""
    if len(turning) <= 1:
        return "xyz"
    letters = [LETTERS[k] for k in turning]
    for order in ORDERS:
        # a locked rotation does not count, wherever it stands: keep it in the middle, where it is never singular
        if [letter for letter in order if letter in letters] == letters and (
            len(turning) == 3 or order[1] not in letters
        ):
            return order
    return None


def orientation(frame: Array) -> tuple[float, ...]:
    """Return the quaternion (w, x, y, z) of a frame (3, 3)."""
    upright = from_z(frame[:, 2])
    seen = Pose(np.zeros(3), upright).axes.T @ frame[:, 0]
    return tuple(product(upright, about(np.array([0.0, 0.0, 1.0]), float(np.arctan2(seen[1], seen[0])))).tolist())
