"""The joints, one dataclass for each kind; ``Scene.add_joint`` checks them.

``body_a`` and ``body_b`` are handles, names or indices. A joint to the world needs a static body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from ..records.model import Array
from . import check
from .handles import Reference

Vector = Sequence[float] | Array

SPRING = ("frequency", "damping_ratio", "stiffness", "damping")
SERVO = ("lower", "upper", *SPRING, "spring_effort", "motor_effort")


@dataclass(frozen=True, kw_only=True)
class Joint:
    """The arguments that all joints have.

    Args:
        enabled: False excludes the joint until ``Parameters.set`` enables it.
    """

    kind: ClassVar[str]
    row_counts: ClassVar[Mapping[int, int]]  # dimension: rows besides those of limit, motor and spring
    tunable: ClassVar[tuple[str, ...]] = ()  # fields that ``Parameters.set`` may change besides `enabled`

    enabled: bool = True


@dataclass(frozen=True)
class PairJoint(Joint):
    """A joint between two bodies.

    Args:
        anchor: m, world point at the initial poses; or
        anchor_a, anchor_b: m, in the bodies' own frames. Default: the origin of body_b.
        collide: whether the two bodies collide with each other.
    """

    body_a: Reference
    body_b: Reference
    _: KW_ONLY
    anchor: Vector | None = None
    anchor_a: Vector | None = None
    anchor_b: Vector | None = None
    collide: bool = False


@dataclass(frozen=True, kw_only=True)
class Sprung(Joint):
    """A joint that may have a spring, given by ``frequency`` or by ``stiffness`` and ``damping``; 0 is no spring.

    Args:
        frequency: Hz, on the effective mass of the joint.
        damping_ratio: of that spring, 1 is critical.
        stiffness: N/m or N m/rad.
        damping: N s/m or N m s/rad.
    """

    frequency: float = 0.0
    damping_ratio: float = 1.0
    stiffness: float = 0.0
    damping: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Servo(Sprung):
    """A joint whose coordinate q may have limits, a spring and a motor.

    Args:
        limits: (lower, upper) of q, rad or m, infinite for none; q is 0 at the initial poses.
        rest: rad or m, q at which the spring is relaxed.
        spring_effort: N m or N, largest effort of the spring.
        motor_speed: rad/s or m/s, set point of the motor; see ``World.set_motor``.
        motor_effort: N m or N, largest effort of the motor; 0 is no motor.
    """

    limits: tuple[float, float] | None = None
    rest: float = 0.0
    spring_effort: float = np.inf
    motor_speed: float = 0.0
    motor_effort: float = 0.0


@dataclass(frozen=True)
class Weld(Sprung, PairJoint):
    """body_b is fixed to body_a; a spring makes position and angle soft.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m and N m/rad, and damping, N s/m and N m s/rad. Default 0: rigid.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "weld"
    row_counts: ClassVar[Mapping[int, int]] = {2: 3, 3: 6}
    tunable: ClassVar[tuple[str, ...]] = SPRING


@dataclass(frozen=True)
class Ball(PairJoint):
    """3D: body_b rotates freely about a point of body_a.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "ball"
    row_counts: ClassVar[Mapping[int, int]] = {3: 3}


@dataclass(frozen=True)
class Revolute(Servo, PairJoint):
    """2D: body_b rotates about a point of body_a. Its coordinate q is the angle since the initial poses, rad.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        limits: rad, (lower, upper) of q, infinite for none. Default: none.
        frequency: Hz, of a spring on the effective inertia of the joint, and damping_ratio (default 1); or
            stiffness, N m/rad, and damping, N m s/rad. Default 0: no spring.
        rest: rad, q at which the spring is relaxed, default 0.
        spring_effort: N m, largest torque of the spring, default unbounded.
        motor_speed: rad/s, default 0; motor_effort: N m, its largest torque, default 0: no motor.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "revolute"
    row_counts: ClassVar[Mapping[int, int]] = {2: 2}
    tunable: ClassVar[tuple[str, ...]] = SERVO


@dataclass(frozen=True)
class Prismatic(Servo, PairJoint):
    """2D: body_b slides along an axis of body_a. Its coordinate q is the translation, m.

    Args:
        axis: direction in the world at the initial poses; fixed in body_a from then on.
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        limits: m, (lower, upper) of q, infinite for none. Default: none.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m, and damping, N s/m. Default 0: no spring.
        rest: m, q at which the spring is relaxed, default 0.
        spring_effort: N, largest force of the spring, default unbounded.
        motor_speed: m/s, default 0; motor_effort: N, its largest force, default 0: no motor.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "prismatic"
    row_counts: ClassVar[Mapping[int, int]] = {2: 2}
    tunable: ClassVar[tuple[str, ...]] = SERVO

    _: KW_ONLY
    axis: Vector


@dataclass(frozen=True)
class Wheel(Servo, PairJoint):
    """2D: body_b rotates freely and slides along an axis of body_a, its suspension.

    Its coordinate q is the translation, m; limits and spring act on q, the motor on the angle.

    Args:
        axis: direction in the world at the initial poses; fixed in body_a from then on.
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        limits: m, (lower, upper) of q, infinite for none. Default: none.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m, and damping, N s/m. Default 0: no spring.
        rest: m, q at which the spring is relaxed, default 0.
        spring_effort: N, largest force of the spring, default unbounded.
        motor_speed: rad/s, default 0; motor_effort: N m, its largest torque, default 0: no motor.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "wheel"
    row_counts: ClassVar[Mapping[int, int]] = {2: 1}
    tunable: ClassVar[tuple[str, ...]] = SERVO

    _: KW_ONLY
    axis: Vector


@dataclass(frozen=True)
class Distance(Sprung, PairJoint):
    """A rod, a spring, or with ``limits`` alone a rope. Its coordinate q is the distance of the anchors, m.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of each body.
        length: m, of the rod or relaxed spring. Default: the initial distance.
        limits: m, (lower, upper) of q, infinite for none. Default: none.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m, and damping, N s/m. Default 0: no spring.
        spring_effort: N, largest force of the spring, default unbounded.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "distance"
    row_counts: ClassVar[Mapping[int, int]] = {2: 0, 3: 0}
    tunable: ClassVar[tuple[str, ...]] = ("lower", "upper", *SPRING, "length", "spring_effort")

    _: KW_ONLY
    length: float | None = None
    limits: tuple[float, float] | None = None
    spring_effort: float = np.inf


@dataclass(frozen=True)
class Gear(Joint):
    """2D: q of joint_a + ratio * q of joint_b is kept at its initial value.

    Args:
        joint_a, joint_b: revolute or prismatic joints. With a moving body_a both must be revolute and share it.
        ratio: rad or m of q of joint_a for each rad or m of q of joint_b, default 1.
        collide: whether the two driven bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "gear"
    row_counts: ClassVar[Mapping[int, int]] = {2: 1}

    joint_a: Reference
    joint_b: Reference
    _: KW_ONLY
    ratio: float = 1.0
    collide: bool = False


@dataclass(frozen=True)
class Target(Joint):
    """A dynamic body is pulled to a pose in the world, which ``World.set_target`` and actuators move.

    Args:
        anchor: m, point of the body that is pulled, in the world at the initial pose; or
        local_anchor: m, the same point in the body's own frame. Default: its origin.
        frequency: Hz, of the spring on the effective mass of the joint, default 5; damping_ratio: default 1.
        max_force: N, max_torque: N m, default unbounded.
        enabled: default True.
    """

    kind: ClassVar[str] = "target"
    row_counts: ClassVar[Mapping[int, int]] = {2: 3, 3: 6}
    tunable: ClassVar[tuple[str, ...]] = ("frequency", "damping_ratio", "max_force", "max_torque")

    body: Reference
    _: KW_ONLY
    anchor: Vector | None = None
    local_anchor: Vector | None = None
    frequency: float = 5.0
    damping_ratio: float = 1.0
    max_force: float = np.inf
    max_torque: float = np.inf


JOINT_TYPES: dict[str, type[Joint]] = {
    cls.kind: cls for cls in (Weld, Target, Ball, Revolute, Prismatic, Distance, Wheel, Gear)
}


def wrong_dimension(joint: Any, dim: int) -> str | None:
    """Return why a scene of ``dim`` dimensions cannot have a joint, or None."""
    if not isinstance(joint, Joint) or type(joint) not in JOINT_TYPES.values():
        return f"{joint!r} is not a joint such as Weld(body_a, body_b)"
    if dim not in joint.row_counts:
        return check.other_dimension(joint, dim)
    return None
