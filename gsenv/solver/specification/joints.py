"""The joints, one dataclass for each kind; ``Scene.add_joint`` checks them.

``body_a`` and ``body_b`` are handles, names or indices. A joint to the world needs a static body.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar

import numpy as np

from . import check
from .axis_joints import Hinge, SixAxis, Slider, Universal
from .handles import Reference
from .joint_base import SERVO, SPRING, Axis, Joint, PairJoint, Servo, Sprung, Vector


@dataclass(frozen=True)
class Weld(Sprung, PairJoint):
    """body_b is fixed to body_a; a spring makes position and angle soft.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        frequency: Hz, of a spring on the mean effective mass of the anchors over all directions, and of one on the
            mean effective inertia, and damping_ratio (default 1); or
            stiffness, N/m and N m/rad, and damping, N s/m and N m s/rad. Default 0: rigid.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "weld"
    row_counts: ClassVar[Mapping[int, int]] = {2: 3, 3: 6}
    tunable: ClassVar[tuple[str, ...]] = SPRING


@dataclass(frozen=True)
class Ball(Axis, PairJoint):
    """3D: body_b rotates about a point of body_a, freely or within a cone, a twist or an angle.

    A spring, motor or friction acts about each of three axes fixed in body_a, which are those of the world at the
    initial poses. Then ``"<name>/turn_x"``, ``/turn_y`` and ``/turn_z`` name their coordinates for actuators, readings
    and ``Parameters.set``: the components in rad of the rotation vector of body_b relative to its initial pose. The
    limits are ``"<name>/swing"``, ``"<name>/twist"`` and ``"<name>/angle"``.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        axis: direction in the world at the initial poses, fixed in both bodies from then on; needed for cone and twist.
        cone: rad, largest angle between the axis of body_b and that of body_a, below pi. Default: none.
        twist: rad, (lower, upper) of the rotation of body_b about the axis, within (-pi, pi). Default: none.
        angle: rad, largest angle of rotation from the initial pose about any axis, below pi. Default: none.
        limit_restitution: of these, 0 to 1, default 0; limit_frequency: Hz, and limit_damping_ratio: of soft
            limits, default 0: rigid.
        frequency: Hz, of a spring on the effective inertia of the joint, and damping_ratio (default 1); or
            stiffness, N m/rad, and damping, N m s/rad. Default 0: no spring.
        rest: rad, of each coordinate, default 0.
        spring_effort: N m, largest torque of the spring about each axis, default unbounded.
        motor_speed: rad/s about each axis, default 0; motor_effort: N m, its largest torque about each axis, default
            0: no motor; motor_gain: N m s/rad, default unbounded.
        friction_effort: N m, dry friction about each axis, default 0.
        armature: kg m^2, inertia of a rotor about each axis, default 0.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "ball"
    row_counts: ClassVar[Mapping[int, int]] = {3: 3}

    _: KW_ONLY
    axis: Vector | None = None
    cone: float | None = None
    twist: tuple[float, float] | None = None
    angle: float | None = None


@dataclass(frozen=True)
class Revolute(Servo, PairJoint):
    """2D: body_b rotates about a point of body_a. Its coordinate q is the angle since the initial poses, rad.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        limits: rad, (lower, upper) of q, infinite for none. Default: none.
        limit_restitution: of an impact on a limit, 0 to 1, default 0; limit_frequency: Hz, and limit_damping_ratio:
            of soft limits, default 0: rigid.
        frequency: Hz, of a spring on the effective inertia of the joint, and damping_ratio (default 1); or
            stiffness, N m/rad, and damping, N m s/rad. Default 0: no spring.
        rest: rad, q at which the spring is relaxed, default 0.
        spring_effort: N m, largest torque of the spring, default unbounded.
        motor_speed: rad/s, default 0; motor_effort: N m, its largest torque, default 0: no motor; motor_gain:
            N m s/rad, torque for each rad/s of the error of speed, default unbounded.
        friction_effort: N m, dry friction, default 0.
        armature: kg m^2, inertia of a rotor that turns with q alone, default 0.
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
        limit_restitution: of an impact on a limit, 0 to 1, default 0; limit_frequency: Hz, and limit_damping_ratio:
            of soft limits, default 0: rigid.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m, and damping, N s/m. Default 0: no spring.
        rest: m, q at which the spring is relaxed, default 0.
        spring_effort: N, largest force of the spring, default unbounded.
        motor_speed: m/s, default 0; motor_effort: N, its largest force, default 0: no motor; motor_gain:
            N s/m, force for each m/s of the error of speed, default unbounded.
        friction_effort: N, dry friction, default 0.
        armature: kg, inertia of a rotor that turns with q alone, default 0.
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
    """body_b rotates freely and slides along an axis of body_a, its suspension; in 3D it may also be steered.

    Its coordinate q is the translation, m; limits and spring act on q, the motor on the rotation of the wheel.

    In 3D ``"<name>/spin"`` names the angle of the wheel about its own axis, and ``"<name>/steering"`` that of its axis
    about the suspension, rad, for readings, gears and, of the steering, actuators and ``Parameters.set``.  The motor of
    the rotation is driven by the joint's own name.

    Args:
        axis: direction in the world at the initial poses; fixed in body_a from then on.
        spin_axis: 3D: axis of the wheel, perpendicular to ``axis``, in the world at the initial poses; fixed in body_b.
        steering: 3D: an Axis, of limits, spring and motor of the steering. Default: not steered.
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        limits: m, (lower, upper) of q, infinite for none. Default: none.
        limit_restitution: of an impact on a limit, 0 to 1, default 0; limit_frequency: Hz, and limit_damping_ratio:
            of soft limits, default 0: rigid.
        frequency: Hz, of a spring on the effective mass of the joint, and damping_ratio (default 1); or
            stiffness, N/m, and damping, N s/m. Default 0: no spring.
        rest: m, q at which the spring is relaxed, default 0.
        spring_effort: N, largest force of the spring, default unbounded.
        motor_speed: rad/s, default 0; motor_effort: N m, its largest torque, default 0: no motor.
        friction_effort: N m, dry friction of the rotation, default 0.
        armature: kg m^2, inertia of a rotor that turns with the wheel alone, default 0.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "wheel"
    row_counts: ClassVar[Mapping[int, int]] = {2: 1, 3: 4}  # in 3D one less with steering
    tunable: ClassVar[tuple[str, ...]] = SERVO

    _: KW_ONLY
    axis: Vector
    spin_axis: Vector | None = None
    steering: Axis | None = None


@dataclass(frozen=True)
class Distance(Sprung, PairJoint):
    """A rod, a spring, or with ``limits`` alone a rope. Its coordinate q is the distance of the anchors, m.

    Args:
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of each body.
        length: m, of the rod or relaxed spring. Default: the initial distance.
        limits: m, (lower, upper) of q, infinite for none. Default: none. Only a spring has both.
        frequency: Hz, of a spring on the mean effective mass of the anchors over all directions, and damping_ratio
            (default 1); or
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
    """q of joint_a + ratio * q of joint_b is kept at its initial value + offset.

    Args:
        joint_a, joint_b: revolute or prismatic joints; in 3D hinges, sliders, or coordinates such as "wheel/spin".
            They may be in series, on moving bodies, or two coordinates of one joint, as of a screw.  Without joint_b
            the gear is a brake: it keeps q of joint_a.
        ratio: rad or m of q of joint_a for each rad or m of q of joint_b, default 1.
        offset: rad or m, added to the initial value, default 0; the first step moves the joints by it.
        collide: whether the two driven bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "gear"
    row_counts: ClassVar[Mapping[int, int]] = {2: 1, 3: 1}

    joint_a: Reference
    joint_b: Reference | None = None
    _: KW_ONLY
    ratio: float = 1.0
    offset: float = 0.0
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
    cls.kind: cls
    for cls in (Weld, Target, Ball, Revolute, Prismatic, Distance, Wheel, Gear, Hinge, Slider, Universal, SixAxis)
}


def wrong_dimension(joint: Any, dim: int) -> str | None:
    """Return why a scene of ``dim`` dimensions cannot have a joint, or None."""
    if not isinstance(joint, Joint) or type(joint) not in JOINT_TYPES.values():
        return f"{joint!r} is not a joint such as Weld(body_a, body_b)"
    if dim not in joint.row_counts:
        return check.other_dimension(joint, dim)
    return None
