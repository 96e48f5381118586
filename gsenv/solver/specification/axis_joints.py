"""3D joints with axes: hinge, slider, universal and six-axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import ClassVar

from .joint_base import SERVO, Axis, PairJoint, Servo, Vector


@dataclass(frozen=True)
class Hinge(Servo, PairJoint):
    """3D: body_b rotates about an axis of body_a. Its coordinate q is the angle since the initial poses, rad, over any
    number of turns.

    Args:
        axis: direction in the world at the initial poses; fixed in both bodies from then on. q is positive
            counterclockwise about it.
        anchor: m, world point of the axis at the initial poses; or anchor_a and anchor_b, m, in the bodies' own
            frames. Default: the origin of body_b.
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

    kind: ClassVar[str] = "hinge"
    row_counts: ClassVar[Mapping[int, int]] = {3: 5}
    tunable: ClassVar[tuple[str, ...]] = SERVO

    _: KW_ONLY
    axis: Vector


@dataclass(frozen=True)
class Slider(Servo, PairJoint):
    """3D: body_b slides along an axis of body_a without rotation. Its coordinate q is the translation, m.

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

    kind: ClassVar[str] = "slider"
    row_counts: ClassVar[Mapping[int, int]] = {3: 5}
    tunable: ClassVar[tuple[str, ...]] = SERVO

    _: KW_ONLY
    axis: Vector


@dataclass(frozen=True)
class Universal(PairJoint):
    """3D: a cross of two perpendicular axes, one fixed in each body, as in a Cardan shaft.

    ``"<name>/turn_a"`` and ``"<name>/turn_b"`` name the rotations about the axes of the two bodies, rad, for
    actuators, readings, gears and ``Parameters.set``.

    Args:
        axis_a, axis_b: perpendicular directions in the world at the initial poses; fixed in body_a and body_b.
        turn_a, turn_b: an Axis each, of limits, springs and motors. Default: free.
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "universal"
    row_counts: ClassVar[Mapping[int, int]] = {3: 4}

    _: KW_ONLY
    axis_a: Vector
    axis_b: Vector
    turn_a: Axis = field(default_factory=Axis)
    turn_b: Axis = field(default_factory=Axis)


@dataclass(frozen=True)
class SixAxis(PairJoint):
    """3D: each of three translations and three rotations of body_b relative to body_a is locked or free.

    The free ones have names for actuators, readings and ``Parameters.set``: ``"<name>/x"``, ``"<name>/turn_z"`` and so
    on. Translations are along axes fixed in body_a, m. Rotations are Cardan angles, rad: successive rotations about x,
    y and z, or another cyclic order: that of ``order``, else one in which a locked or the most narrowly limited axis is
    second. With three free rotations the second one must stay within +-pi/2.

    Args:
        x, y, z, turn_x, turn_y, turn_z: an Axis, of limits, spring and motor; ``Axis()`` is free. Default: locked.
        orientation: quaternion (w, x, y, z) of the axes in the world at the initial poses. Default: the world's axes.
        order: of three free rotations, "xyz", "yzx" or "zxy"; the first is about an axis of body_a, the last about one
            of body_b. Default: see above.
        anchor: m, world point at the initial poses; or anchor_a and anchor_b, m, in the bodies' own frames.
            Default: the origin of body_b.
        collide: whether the two bodies collide with each other, default False.
        enabled: default True.
    """

    kind: ClassVar[str] = "six_axis"
    row_counts: ClassVar[Mapping[int, int]] = {3: 6}  # less the free ones

    _: KW_ONLY
    x: Axis | None = None
    y: Axis | None = None
    z: Axis | None = None
    turn_x: Axis | None = None
    turn_y: Axis | None = None
    turn_z: Axis | None = None
    orientation: Vector | None = None
    order: str | None = None
