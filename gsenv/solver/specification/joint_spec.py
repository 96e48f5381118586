"""Checks of joints: from the dataclass that a user wrote to a JointSpec with indices for names."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..records.model import Array, BodyKind
from . import check
from .axis_spec import BALL_TURN, SWING, add_axes, limits_of, set_axis, set_spring, unit
from .handles import find
from .joint_base import Joint, PairJoint, Servo, Sprung
from .joints import Distance, Gear, Prismatic, Target, Wheel, wrong_dimension
from .placement import anchor_of, to_local
from .specs import BodySpec, JointSpec, SceneSpec

TURNING = {2: "revolute", 3: "hinge"}
COUPLED = {2: ("revolute", "prismatic"), 3: ("hinge", "slider", "axis")}  # joints that gears can couple


def joint_spec(name: str, joint: Joint, scene: SceneSpec) -> JointSpec:
    """Return the checked joint, whose ``parts`` are its further coordinates.

    Raises:
        ValueError: not a joint of this dimension, an unknown body, or an argument out of its range.
    """
    what = f"joint {name!r}"
    wrong = wrong_dimension(joint, scene.dim)
    if wrong is not None:
        raise ValueError(f"{what}: {wrong}.")
    if isinstance(joint, (PairJoint, Gear)):
        check.flag(joint.collide, f"{what}: collide")
    if isinstance(joint, Gear):
        spec = _gear(name, joint, scene)
    elif isinstance(joint, Target):
        spec = _target(name, joint, scene)
    else:
        spec = _pair(name, joint, scene)
    spec.row_count = joint.row_counts[scene.dim] * spec.halves
    if scene.dim == 3:
        add_axes(spec, joint, len(scene.joints))
    elif isinstance(joint, Wheel) and (joint.spin_axis is not None or joint.steering is not None):
        raise ValueError(f"{what}: in 2D a wheel has no spin_axis and no steering.")
    return spec


def excluded_pair(joint: Joint, spec: JointSpec) -> set[tuple[int, int]]:
    """Return the pair of bodies that a joint keeps from colliding, or an empty set."""
    if isinstance(joint, (PairJoint, Gear)) and not joint.collide and not spec.drives_one:
        return {(min(spec.body_a, spec.body_b), max(spec.body_a, spec.body_b))}
    return set()


def _body(body: Any, word: str, scene: SceneSpec, what: str) -> int:
    if body is None:
        raise ValueError(f"{what}: {word} is missing.")
    return find(body, "body", list(scene.bodies), what)


def _pair(name: str, joint: Any, scene: SceneSpec) -> JointSpec:
    what = f"joint {name!r}"
    a, b = _body(joint.body_a, "body_a", scene, what), _body(joint.body_b, "body_b", scene, what)
    if a == b:
        raise ValueError(f"{what} needs two different bodies, got {joint.body_b!r} twice.")
    bodies = list(scene.bodies.values())
    spec = JointSpec(name, joint.kind, a, b, check.flag(joint.enabled, f"{what}: enabled"))
    _set_anchors(spec, joint, bodies[a], bodies[b], what)
    if isinstance(joint, (Prismatic, Wheel)):
        spec.axis = unit(joint.axis, scene.dim, f"{what}: axis")
    if isinstance(joint, Sprung):
        set_spring(spec, joint, what)
    if isinstance(joint, Servo):
        set_axis(spec, joint, what)
    if isinstance(joint, Distance):
        spec.lower, spec.upper = limits_of(joint.limits, what)
        spec.spring_effort = check.bound(joint.spring_effort, f"{what}: spring_effort")
    if isinstance(joint, Distance):
        _set_length(spec, joint, what)
    if BodyKind.DYNAMIC not in (bodies[a].kind, bodies[b].kind):
        raise ValueError(f"{what} needs at least one dynamic body.")
    return spec


def _set_anchors(spec: JointSpec, joint: PairJoint, a: BodySpec, b: BodySpec, what: str) -> None:
    if joint.anchor is not None:
        if joint.anchor_a is not None or joint.anchor_b is not None:
            raise ValueError(f"{what}: give anchor or anchor_a and anchor_b, not both.")
        point = check.vector(joint.anchor, a.dim, f"{what}: anchor")
        spec.anchor_a, spec.anchor_b = to_local(a, point), to_local(b, point)
        return
    origin = np.zeros(a.dim) if isinstance(joint, Distance) else None  # of other joints it follows from body b's anchor
    spec.anchor_a = _local(joint.anchor_a, a.dim, f"{what}: anchor_a", origin)
    spec.anchor_b = _local(joint.anchor_b, a.dim, f"{what}: anchor_b", origin)


def _local(anchor: Any, dim: int, what: str, default: Array | None = None) -> Array | None:
    return default if anchor is None else check.vector(anchor, dim, what)


def _set_length(spec: JointSpec, joint: Distance, what: str) -> None:
    if spec.upper < 0.0:
        raise ValueError(f"{what}: a distance can't be below {spec.upper!r}.")
    if joint.length is not None:
        spec.length = check.not_negative(joint.length, f"{what}: length")
        if joint.limits is not None and not spec.has_spring:
            raise ValueError(f"{what}: give length for a rod or limits for a rope; only a spring has both.")


def _target(name: str, joint: Target, scene: SceneSpec) -> JointSpec:
    what = f"joint {name!r}"
    b = _body(joint.body, "body", scene, what)
    body = list(scene.bodies.values())[b]
    spec = JointSpec(name, joint.kind, b, b, check.flag(joint.enabled, f"{what}: enabled"))
    if joint.anchor is None:
        spec.anchor_b = _local(joint.local_anchor, scene.dim, f"{what}: local_anchor")
    elif joint.local_anchor is None:
        spec.anchor_a = spec.anchor_b = to_local(body, check.vector(joint.anchor, scene.dim, f"{what}: anchor"))
    else:
        raise ValueError(f"{what}: give anchor or local_anchor, not both.")
    if body.kind != BodyKind.DYNAMIC:
        raise ValueError(f"{what}: a target pulls a dynamic body, got {body.name!r}.")
    spec.frequency = check.positive(joint.frequency, f"{what}: frequency")
    spec.damping_ratio = check.not_negative(joint.damping_ratio, f"{what}: damping_ratio")
    spec.max_force = check.bound(joint.max_force, f"{what}: max_force")
    spec.max_torque = check.bound(joint.max_torque, f"{what}: max_torque")
    return spec


def _gear(name: str, joint: Gear, scene: SceneSpec) -> JointSpec:
    what = f"joint {name!r}"
    if joint.joint_a is None:
        raise ValueError(f"{what}: joint_a is missing.")
    joints, bodies = list(scene.joints.values()), list(scene.bodies.values())
    a = find(joint.joint_a, "joint", list(scene.joints), what)
    b = a if joint.joint_b is None else find(joint.joint_b, "joint", list(scene.joints), what)
    first, second = joints[a], joints[b]
    if a == b and joint.joint_b is not None:
        raise ValueError(f"{what}: a gear couples two different joints, got {first.name!r} twice.")
    kinds = COUPLED[scene.dim]
    for spec in (first, second):
        if spec.kind not in kinds or spec.coordinate == SWING or spec.coordinate >= BALL_TURN:
            known = f"{', '.join(kinds[:-1])} and {kinds[-1]} joints".replace("axis joints", "joints' coordinates")
            raise ValueError(f"{what}: a gear couples {known}, {spec.name!r} is a {spec.kind}.")
    ratio = check.finite(joint.ratio, f"{what}: ratio")
    if ratio == 0.0:
        raise ValueError(f"{what}: ratio must not be 0.")
    if joint.joint_b is None:
        ratio = 0.0  # the second half of the row does nothing
    one = first.body_b == second.body_b
    moving = any(bodies[spec.body_a].kind != BodyKind.STATIC for spec in (first, second))
    meshing = first.body_a == second.body_a and first.kind == second.kind == TURNING[scene.dim] and not one
    meshing = meshing and _can_react(first, second, ratio, anchor_of(first, bodies) - anchor_of(second, bodies))
    return JointSpec(
        name,
        joint.kind,
        first.body_a if one else first.body_b,
        second.body_b,
        check.flag(joint.enabled, f"{what}: enabled"),
        joint_a=a,
        joint_b=b,
        ratio=ratio,
        offset=check.finite(joint.offset, f"{what}: offset"),
        halves=2 if one or (moving and not meshing) else 1,
        drives_one=one,
    )


def _can_react(first: JointSpec, second: JointSpec, ratio: float, apart: Array) -> bool:
    """Whether the body that two rotations share can take the torque of their gear, with axes ``apart`` m."""
    if first.axis is None or second.axis is None:  # 2D
        return ratio == -1.0 or bool(np.hypot.reduce(apart) >= 1e-6)
    across = np.cross(first.axis, second.axis)
    if across @ across > 0.01:
        return True
    same = float(first.axis @ second.axis)
    return abs(1.0 + ratio * same) < 1e-9 or bool(np.hypot.reduce(np.cross(first.axis, apart)) >= 1e-6)
