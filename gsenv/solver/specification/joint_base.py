"""What joints have in common: bodies and anchors, springs, and the servo of a coordinate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

import numpy as np

from ..records.model import Array
from .handles import Reference

Vector = Sequence[float] | Array

SPRING = ("frequency", "damping_ratio", "stiffness", "damping")
LIMIT = ("limit_restitution", "limit_frequency", "limit_damping_ratio")
SERVO = (
    "lower",
    "upper",
    *LIMIT,
    *SPRING,
    "spring_effort",
    "motor_effort",
    "motor_gain",
    "friction_effort",
    "armature",
)


@dataclass(frozen=True, kw_only=True)
class Joint:
    """The arguments that all joints have.

    Args:
        enabled: False excludes the joint until ``Parameters.set`` enables it.
    """

    kind: ClassVar[str]
    row_counts: ClassVar[Mapping[int, int]]  # dimension: rows besides those of limit, motor, spring and friction
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
class Spring:
    """A spring, given by ``frequency`` or by ``stiffness`` and ``damping``; 0 is no spring.

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
class Sprung(Spring, Joint):
    """A joint that may have a spring."""


@dataclass(frozen=True, kw_only=True)
class Axis(Spring):
    """The free motion of a joint along or about one axis: a coordinate q that may have limits, a spring and a motor.

    Args:
        limits: (lower, upper) of q, rad or m, infinite for none; q is 0 at the initial poses.
        limit_restitution: ratio of the speeds after and before an impact on a limit, 0 to 1, default 0.
        limit_frequency: Hz, of soft limits on the effective mass of the joint, and limit_damping_ratio (default 1).
            Default 0: rigid limits.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m or N m/rad, and damping, N s/m or N m s/rad. Default 0: no spring.
        rest: rad or m, q at which the spring is relaxed, default 0.
        spring_effort: N m or N, largest effort of the spring, default unbounded.
        motor_speed: rad/s or m/s, set point of the motor; see ``World.set_motor``.
        motor_effort: N m or N, largest effort of the motor, default 0: no motor.
        motor_gain: N m s/rad or N s/m, effort for each unit of the error of speed, default unbounded: a motor keeps
            its speed as long as its effort suffices.
        friction_effort: N m or N, dry friction, default 0.
        armature: kg m^2 or kg, inertia of a rotor that turns with q alone, such as that of a geared motor, default 0.
    """

    limits: tuple[float, float] | None = None
    limit_restitution: float = 0.0
    limit_frequency: float = 0.0
    limit_damping_ratio: float = 1.0
    rest: float = 0.0
    spring_effort: float = np.inf
    motor_speed: float = 0.0
    motor_effort: float = 0.0
    motor_gain: float = np.inf
    friction_effort: float = 0.0
    armature: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Servo(Axis, Sprung):
    """A joint with one coordinate, or with one that limits and spring act on and one that the motor acts on."""
