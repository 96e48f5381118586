"""Coordinates of 2D joints in joint coordinates, and the directions of their rows."""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...records.articulation import TURN
from ...records.model import JointKind
from ..joints.angle import unwrapped_angle
from ..math import cross

_REVOLUTE = int(JointKind.REVOLUTE)
_PRISMATIC = int(JointKind.PRISMATIC)
_WHEEL = int(JointKind.WHEEL)


@njit
def numbers_of(model: Any, parameters: Any) -> tuple[int, int]:
    """Return the numbers of the coordinates of limit and spring, and of the motor; -1: none."""
    if model.kind == _REVOLUTE:
        return TURN, TURN
    if model.kind == _PRISMATIC:
        return 0, 0
    return (0, TURN) if model.kind == _WHEEL else (-1, -1)


@njit
def coordinate_of(link: Any, servo: Any, bodies: Any, joint: Any) -> Any:
    """Return the coordinate of a joint at the start of the substep, rad or m."""
    if servo.number < TURN:
        return link.coordinates[servo.place]
    return unwrapped_angle(bodies[joint.model.body_a], bodies[joint.model.body_b], joint.parameters)


@njit
def set_servo_direction(row: Any, link: Any, place: Any) -> None:
    """Set the Jacobian of J v = rate of a turn or slide."""
    inner = row.jacobian_a if link.flipped else row.jacobian_b
    outer = row.jacobian_b if link.flipped else row.jacobian_a
    x, y = link.directions[place, 0], link.directions[place, 1]
    turns = link.numbers[place] == TURN
    sign = -1.0 if link.flipped else 1.0
    inner[0] = 0.0 if turns else x
    inner[1] = 0.0 if turns else y
    inner[2] = sign if turns else cross(x, y, link.arm[0], link.arm[1])
    outer[0] = -inner[0]
    outer[1] = -inner[1]
    outer[2] = -sign if turns else cross(x, y, link.reach[0], link.reach[1])


@njit
def set_pivot_direction(world: Any, row: Any, links: Any, k: Any, joint: Any, number: Any, h: Any) -> float:
    """2D has no balls."""
    return 0.0


@njit
def is_isotropic(joint_models: Any, joint_parameters: Any, j: Any) -> bool:
    """2D has no balls."""
    return False


@njit
def add_ball_spring(world: Any, articulation: Any, servo: Any, joint: Any, h: Any) -> None:
    """2D has no balls."""
