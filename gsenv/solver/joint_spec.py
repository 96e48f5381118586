"""What a user writes down of a joint, checked: which kinds there are and which arguments each takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from . import check
from .model import Array, BodyKind

if TYPE_CHECKING:
    from .scene import BodySpec

SPRING = ("frequency", "damping_ratio", "stiffness", "damping")
SERVO = ("limits", "rest", "spring_effort", "motor_speed", "motor_effort", *SPRING)
ANCHORS = ("anchor", "anchor_a", "anchor_b")
TAKES = {
    "weld": (*ANCHORS, *SPRING),
    "target": ("anchor", "anchor_b", "frequency", "damping_ratio", "max_force", "max_torque"),
    "revolute": (*ANCHORS, *SERVO),
    "prismatic": (*ANCHORS, "axis", *SERVO),
    "distance": (*ANCHORS, "length", "limits", "spring_effort", *SPRING),
    "wheel": (*ANCHORS, "axis", *SERVO),
    "gear": ("joint_a", "joint_b", "ratio"),
    "ball": ANCHORS,
}
KINDS_OF = {  # by dimension
    2: ("weld", "target", "revolute", "prismatic", "distance", "wheel", "gear"),
    3: ("weld", "target", "ball", "distance"),
}
DEFAULTS: dict[str, Any] = {
    "anchor": None, "anchor_a": None, "anchor_b": None, "axis": None, "length": None, "limits": None,
    "frequency": None, "damping_ratio": 1.0, "stiffness": None, "damping": 0.0, "rest": 0.0,
    "spring_effort": np.inf, "motor_speed": 0.0, "motor_effort": 0.0, "max_force": np.inf, "max_torque": np.inf,
    "joint_a": None, "joint_b": None, "ratio": 1.0,
}  # fmt: skip
COUPLED = ("revolute", "prismatic")  # by gears
DRIVEN = {"velocity": "motor", "position": "spring", "torque": "motor"}  # what an actuator's mode needs


@dataclass
class JointSpec:
    """A joint or a constraint, checked. Anchors and axis as given; ``compile`` puts them into the bodies."""

    name: str
    kind: str
    body_a: int
    body_b: int
    enabled: bool
    anchor_a: Array | None = None
    anchor_b: Array | None = None
    axis: Array | None = None  # unit, in the world
    length: float | None = None
    lower: float = -np.inf
    upper: float = np.inf
    frequency: float = 0.0
    damping_ratio: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    spring_effort: float = np.inf
    motor_speed: float = 0.0
    motor_effort: float = 0.0
    max_force: float = np.inf
    max_torque: float = np.inf
    joint_a: int = 0
    joint_b: int = 0
    ratio: float = 0.0
    rows: list[dict[str, Any]] = field(default_factory=list)
    frame: str = "world"
    update: Any = None

    @property
    def has_spring(self) -> bool:
        return self.frequency > 0.0 or self.stiffness > 0.0 or self.damping > 0.0

    @property
    def rigid(self) -> bool:
        """Whether the joint has its rows of position without softness."""
        if self.kind == "distance":
            return not self.has_spring and not (np.isfinite(self.lower) or np.isfinite(self.upper))
        return not self.has_spring


def joint_spec(
    name: str, kind: str, a: int, b: int, bodies: Sequence[BodySpec], given: Mapping[str, Any], enabled: bool
) -> JointSpec:
    """A joint between bodies a and b from the arguments of ``Scene.add_joint``.

    Raises:
        ValueError: an argument that the kind does not take, or one out of its range.
    """
    what = f"joint {name!r}"
    for word, value in given.items():
        if word not in TAKES[kind] and not _same(value, DEFAULTS[word]):
            raise ValueError(f"{what}: a {kind} has no {word}, got {value!r}.")
    spec = JointSpec(name, kind, a, b, bool(enabled))
    _set_anchors(spec, bodies, given, what)
    _set_spring(spec, given, what)
    _set_servo(spec, given, what)
    if kind == "target":
        if bodies[b].kind != BodyKind.DYNAMIC:
            raise ValueError(f"{what}: a target pulls a dynamic body, got {bodies[b].name!r}.")
        check.positive(spec.frequency, f"{what}: frequency")
    elif kind != "gear" and BodyKind.DYNAMIC not in (bodies[a].kind, bodies[b].kind):
        raise ValueError(f"{what} needs at least one dynamic body.")
    return spec


def fields_of(kind: str) -> tuple[str, ...]:
    """Fields of a joint that ``Parameters.set`` may change."""
    takes = TAKES[kind]
    limits = ("lower", "upper") if "limits" in takes else ()
    tuned = ("frequency", "damping_ratio", "stiffness", "damping", "length", "spring_effort", "motor_effort")
    return (*limits, *(name for name in (*tuned, "max_force", "max_torque") if name in takes), "enabled")


def _same(value: Any, default: Any) -> bool:
    return value is default or (np.isscalar(value) and not isinstance(value, str) and value == default)


def _set_anchors(spec: JointSpec, bodies: Sequence[BodySpec], given: Mapping[str, Any], what: str) -> None:
    dim = bodies[spec.body_b].dim
    if given["anchor"] is not None:
        if given["anchor_a"] is not None or given["anchor_b"] is not None:
            raise ValueError(f"{what}: give anchor or anchor_a and anchor_b, not both.")
        from .compile import local_point

        point = check.vector(given["anchor"], dim, f"{what}: anchor")
        spec.anchor_a = local_point(bodies[spec.body_a], point)
        spec.anchor_b = local_point(bodies[spec.body_b], point)
    for word in ("anchor_a", "anchor_b"):
        if given[word] is not None:
            setattr(spec, word, check.vector(given[word], dim, f"{what}: {word}"))
        elif spec.kind == "distance" and given["anchor"] is None:
            setattr(spec, word, np.zeros(dim))
    if spec.kind in ("prismatic", "wheel"):
        if given["axis"] is None:
            raise ValueError(f"{what}: a {spec.kind} needs an axis.")
        axis = check.vector(given["axis"], 2, f"{what}: axis")
        length = float(np.hypot(*axis))
        if not length > 0.0:
            raise ValueError(f"{what}: axis must have a direction, got {given['axis']!r}.")
        spec.axis = axis / length


def _set_spring(spec: JointSpec, given: Mapping[str, Any], what: str) -> None:
    frequency = given["frequency"]
    if frequency is None:
        frequency = 5.0 if spec.kind == "target" else 0.0
    spec.frequency = check.not_negative(frequency, f"{what}: frequency")
    spec.damping_ratio = check.not_negative(given["damping_ratio"], f"{what}: damping_ratio")
    spec.stiffness = check.not_negative(given["stiffness"] or 0.0, f"{what}: stiffness")
    spec.damping = check.not_negative(given["damping"], f"{what}: damping")
    if spec.frequency > 0.0 and (spec.stiffness > 0.0 or spec.damping > 0.0):
        raise ValueError(f"{what}: give its spring by frequency or by stiffness and damping, not both.")
    spec.spring_effort = check.bound(given["spring_effort"], f"{what}: spring_effort")
    spec.rest = check.finite(given["rest"], f"{what}: rest")


def _set_servo(spec: JointSpec, given: Mapping[str, Any], what: str) -> None:
    if given["limits"] is not None:
        try:
            low, high = given["limits"]
        except (TypeError, ValueError):
            raise ValueError(f"{what}: limits must be two numbers, got {given['limits']!r}.") from None
        bounds = check.bounds((low, high), (2,), f"{what}: limits")
        spec.lower, spec.upper = float(bounds[0]), float(bounds[1])
        if not (spec.lower <= spec.upper and spec.lower < np.inf and spec.upper > -np.inf):
            raise ValueError(f"{what}: the lower limit must not be above the upper one, got {given['limits']!r}.")
        if spec.kind == "distance" and spec.upper < 0.0:
            raise ValueError(f"{what}: a distance can't be below {spec.upper!r}.")
    if given["length"] is not None:
        spec.length = check.not_negative(given["length"], f"{what}: length")
    spec.motor_speed = check.finite(given["motor_speed"], f"{what}: motor_speed")
    spec.motor_effort = check.bound(given["motor_effort"], f"{what}: motor_effort")
    if spec.motor_speed != 0.0 and spec.motor_effort == 0.0:
        raise ValueError(f"{what}: a motor needs a motor_effort, its bound in N or N m.")
    spec.max_force = check.bound(given["max_force"], f"{what}: max_force")
    spec.max_torque = check.bound(given["max_torque"], f"{what}: max_torque")


def gear_spec(
    name: str, joint_a: int, joint_b: int, ratio: Any, joints: Sequence[JointSpec], bodies: Sequence[BodySpec],
    enabled: bool,
) -> JointSpec:  # fmt: skip
    """A gear between two joints of one frame, or of static ones.

    Raises:
        ValueError: joints that no gear can couple.
    """
    what = f"joint {name!r}"
    first, second = joints[joint_a], joints[joint_b]
    if joint_a == joint_b:
        raise ValueError(f"{what}: a gear couples two different joints, got {first.name!r} twice.")
    for spec in (first, second):
        if spec.kind not in COUPLED:
            raise ValueError(f"{what}: a gear couples revolute and prismatic joints, {spec.name!r} is a {spec.kind}.")
    if first.body_b == second.body_b:
        raise ValueError(f"{what}: {first.name!r} and {second.name!r} move the same body.")
    moving = [spec for spec in (first, second) if bodies[spec.body_a].kind != BodyKind.STATIC]
    if moving and (first.body_a != second.body_a or "prismatic" in (first.kind, second.kind)):
        raise ValueError(
            f"{what}: on moving bodies a gear couples revolute joints that share body_a; "
            f"{moving[0].name!r} is on {bodies[moving[0].body_a].name!r}."
        )
    number = check.finite(ratio, f"{what}: ratio")
    if number == 0.0:
        raise ValueError(f"{what}: ratio must not be 0.")
    if moving and number != -1.0 and _pins_meet(first, second, bodies):
        raise ValueError(
            f"{what}: on a moving body only the ratio -1 couples {first.name!r} and {second.name!r}, "
            f"whose pins are at one point."
        )
    return JointSpec(
        name, "gear", first.body_b, second.body_b, bool(enabled), joint_a=joint_a, joint_b=joint_b, ratio=number
    )


def _pins_meet(first: JointSpec, second: JointSpec, bodies: Sequence[BodySpec]) -> bool:
    from .compile import pin_of

    apart = pin_of(first, bodies) - pin_of(second, bodies)
    return bool(np.hypot(*apart) < 1e-6)
