"""Checks of 3D joints with axes: the frame of the axes, which of them are locked, and the coordinates of the others.

A joint with several coordinates is compiled to one entry for what is locked and one, of kind "axis", for each
coordinate, whose name is that of the joint, a slash and the name of the coordinate.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..dimension import dimension
from ..records.model import Array
from . import check
from .axis_joints import Hinge, SixAxis, Slider, Universal
from .joint_base import Axis
from .joints import Ball, Wheel
from .specs import JointSpec

# numbers of coordinates, as in spatial/joints/axes.py
FIRST_TURN, NODE_TURN, LAST_TURN, SWING, TWIST, BALL_TURN, BALL_ANGLE = 3, 4, 5, 6, 7, 8, 11
OF_EACH_TURN = (  # arguments of a ball for each of its three rotations
    "frequency", "damping_ratio", "stiffness", "damping", "rest", "spring_effort", "motor_speed", "motor_effort",
    "motor_gain", "friction_effort", "armature",
)  # fmt: skip
_POINT = 0b111
_LETTERS = "xyz"
ORDERS = ("xyz", "yzx", "zxy")  # of the rotations of a six-axis joint
_CYCLES = ((1.0, 0.0, 0.0, 0.0), (0.5, 0.5, 0.5, 0.5), (0.5, -0.5, -0.5, -0.5))  # x to x, to y, to z
_PERPENDICULAR = 1e-6  # cosine of the angle between axes that count as perpendicular


def set_axis(spec: JointSpec, axis: Axis, what: str) -> None:
    """Check limits, spring, motor and friction of a coordinate and write them to its spec."""
    spec.lower, spec.upper = limits_of(axis.limits, what)
    spec.limit_restitution = check.not_negative(axis.limit_restitution, f"{what}: limit_restitution")
    if spec.limit_restitution > 1.0:
        raise ValueError(f"{what}: limit_restitution must not exceed 1, got {axis.limit_restitution!r}.")
    spec.limit_frequency = check.not_negative(axis.limit_frequency, f"{what}: limit_frequency")
    spec.limit_damping_ratio = check.not_negative(axis.limit_damping_ratio, f"{what}: limit_damping_ratio")
    if spec.limit_restitution > 0.0 and spec.limit_frequency > 0.0:
        raise ValueError(f"{what}: give limit_restitution or limit_frequency, not both.")
    spec.spring_effort = check.bound(axis.spring_effort, f"{what}: spring_effort")
    spec.rest = check.finite(axis.rest, f"{what}: rest")
    spec.motor_speed = check.finite(axis.motor_speed, f"{what}: motor_speed")
    spec.motor_effort = check.bound(axis.motor_effort, f"{what}: motor_effort")
    if spec.motor_speed != 0.0 and spec.motor_effort == 0.0:
        raise ValueError(f"{what}: a motor needs a motor_effort, its bound in N or N m.")
    spec.motor_gain = check.bound(axis.motor_gain, f"{what}: motor_gain")
    if spec.motor_gain == 0.0:
        raise ValueError(f"{what}: motor_gain must be positive, got {axis.motor_gain!r}.")
    spec.friction_effort = check.bound(axis.friction_effort, f"{what}: friction_effort")
    spec.armature = check.not_negative(axis.armature, f"{what}: armature")


def set_spring(spec: JointSpec, spring: Any, what: str) -> None:
    """Check a spring and write it to its spec."""
    for word in ("frequency", "damping_ratio", "stiffness", "damping"):
        setattr(spec, word, check.not_negative(getattr(spring, word), f"{what}: {word}"))
    if spec.frequency > 0.0 and (spec.stiffness > 0.0 or spec.damping > 0.0):
        raise ValueError(f"{what}: give its spring by frequency or by stiffness and damping, not both.")


def limits_of(limits: Any, what: str) -> tuple[float, float]:
    """Return the checked limits; infinite ones for None."""
    if limits is None:
        return -np.inf, np.inf
    try:
        low, high = limits
    except (TypeError, ValueError):
        raise ValueError(f"{what}: limits must be two numbers, got {limits!r}.") from None
    lower, upper = check.bounds((low, high), (2,), f"{what}: limits").tolist()
    if not (lower <= upper and lower < np.inf and upper > -np.inf):
        raise ValueError(f"{what}: the lower limit must not be above the upper one, got {limits!r}.")
    return lower, upper


def unit(axis: Any, dim: int, what: str) -> Array:
    """Return a checked direction of length 1."""
    if axis is None and dim == 3:
        raise ValueError(f"{what} is missing.")
    vector = check.vector(axis, dim, what)
    length = float(np.hypot.reduce(vector))
    if not length > 0.0:
        raise ValueError(f"{what} must have a direction, got {axis!r}.")
    return np.asarray(vector / length)


def add_axes(spec: JointSpec, joint: Any, index: int) -> None:
    """Write the frame, the locked axes and the coordinates of a 3D joint to its spec, number ``index`` of the scene."""
    what = f"joint {spec.name!r}"
    spec.parent = index
    if isinstance(joint, (Hinge, Slider)):
        spec.axis = unit(joint.axis, 3, f"{what}: axis")
        spec.orientation = _frame(spec.axis, 2)
        hinge = isinstance(joint, Hinge)
        spec.locked = _POINT | 0b011 << 3 if hinge else 0b011 | _POINT << 3
        spec.coordinate = spec.motor_coordinate = TWIST if hinge else 2
    elif isinstance(joint, Universal):
        _add_universal(spec, joint, what)
    elif isinstance(joint, Wheel):
        _add_wheel(spec, joint, what)
    elif isinstance(joint, SixAxis):
        _add_six_axis(spec, joint, what)
    elif isinstance(joint, Ball):
        _add_ball(spec, joint, what)
    if isinstance(joint, (Hinge, Slider, Universal, Wheel, SixAxis)):
        spec.row_count = spec.locked.bit_count()


def _entry(spec: JointSpec, word: str, axis: Any) -> JointSpec:
    """Return the entry of a coordinate of a joint, with the checked arguments of its axis."""
    name = f"{spec.name}/{word}"
    what = f"joint {name!r}"
    if type(axis) is not Axis:
        raise ValueError(f"{what} must be an Axis such as Axis(limits=(-1, 1)), got {axis!r}.")
    part = JointSpec(name, "axis", spec.body_a, spec.body_b, spec.enabled)
    set_spring(part, axis, what)
    set_axis(part, axis, what)
    return part


def _part(spec: JointSpec, word: str, number: int, axis: Axis, axis_in_world: Array | None = None) -> None:
    """Add a coordinate to a joint."""
    part = _entry(spec, word, axis)
    part.joint_a = spec.parent
    part.anchor_a, part.anchor_b = spec.anchor_a, spec.anchor_b
    part.orientation = spec.orientation
    part.coordinate = part.motor_coordinate = number
    part.axis = axis_in_world
    if number == NODE_TURN and any(0.5 * math.pi < abs(limit) < np.inf for limit in (part.lower, part.upper)):
        raise ValueError(
            f"joint {part.name!r}: limits of the second rotation must be within +-pi/2, got {axis.limits!r}."
        )
    spec.parts.append(part)


def _add_universal(spec: JointSpec, joint: Universal, what: str) -> None:
    first = unit(joint.axis_a, 3, f"{what}: axis_a")
    last = unit(joint.axis_b, 3, f"{what}: axis_b")
    spec.orientation = _cross_frame(first, last, f"{what}: axis_a and axis_b")
    spec.locked = _POINT | 0b010 << 3
    _part(spec, "turn_a", FIRST_TURN, joint.turn_a)
    _part(spec, "turn_b", LAST_TURN, joint.turn_b)


def _add_wheel(spec: JointSpec, joint: Wheel, what: str) -> None:
    spec.axis = unit(joint.axis, 3, f"{what}: axis")
    spin = unit(joint.spin_axis, 3, f"{what}: spin_axis")
    spec.orientation = _cross_frame(spec.axis, spin, f"{what}: axis and spin_axis")
    spec.locked = 0b110 | (0b011 if joint.steering is None else 0b010) << 3
    spec.coordinate = 0
    spec.motor_coordinate = TWIST if joint.steering is None else LAST_TURN
    _part(spec, "spin", spec.motor_coordinate, Axis())
    if joint.steering is not None:
        _part(spec, "steering", FIRST_TURN, joint.steering)


def _add_six_axis(spec: JointSpec, joint: SixAxis, what: str) -> None:
    slides = [joint.x, joint.y, joint.z]
    turns = [joint.turn_x, joint.turn_y, joint.turn_z]
    for word, axis in zip(("x", "y", "z", "turn_x", "turn_y", "turn_z"), slides + turns, strict=True):
        if axis is not None:
            _entry(spec, word, axis)
    if all(axis is not None for axis in slides + turns) and not any(_acts(axis) for axis in slides + turns):
        raise ValueError(f"{what}: all of its axes are free; lock, limit, spring or drive one.")
    initial_state = dimension(3).initial_state
    given = (1, 0, 0, 0) if joint.orientation is None else joint.orientation
    orientation = initial_state.rotation_of(check.orientation(given, f"{what}: orientation"))
    shift = _first_axis(turns)
    if joint.order is not None:
        check.choice(joint.order, ORDERS, f"{what}: order")
        if None not in turns:
            shift = _LETTERS.index(joint.order[0])
    spec.orientation = initial_state.multiplied(orientation, _CYCLES[shift])
    spec.locked = sum(1 << (k - shift) % 3 for k in range(3) if slides[k] is None)
    spec.locked |= sum(8 << (k - shift) % 3 for k in range(3) if turns[k] is None)
    alone = sum(axis is not None for axis in turns) == 1
    for k, axis in enumerate(slides):
        if axis is not None:
            _part(spec, _LETTERS[k], (k - shift) % 3, axis, initial_state.turned_by(orientation, np.eye(3)[k]))
    for k, axis in enumerate(turns):
        if axis is not None:
            _part(spec, f"turn_{_LETTERS[k]}", TWIST if alone else FIRST_TURN + (k - shift) % 3, axis)


def _acts(axis: Axis | None) -> bool:
    return axis != Axis()


def _first_axis(turns: list[Axis | None]) -> int:
    """Return which of x, y, z is the first of the cyclic order of rotations.

    A single free rotation is the last one, a single locked one the second, as is else the most narrowly limited one.
    """
    free = [k for k in range(3) if turns[k] is not None]
    if len(free) == 1:
        return (free[0] - 2) % 3
    if len(free) == 2:
        return (3 - sum(free) - 1) % 3
    widths = [np.ptp(axis.limits) if axis is not None and axis.limits is not None else np.inf for axis in turns]
    if len(free) == 0 or min(widths) == np.inf:
        return 0
    return (int(np.argmin(widths)) - 1) % 3


def _add_ball(spec: JointSpec, joint: Ball, what: str) -> None:
    if joint.limits is not None:
        raise ValueError(f"{what}: a ball has no limits; give cone, twist or angle.")
    names = ("limit_restitution", "limit_frequency", "limit_damping_ratio")
    soft = {name: check.not_negative(getattr(joint, name), f"{what}: {name}") for name in names}
    if joint.axis is not None or joint.cone is not None or joint.twist is not None:
        spec.orientation = _frame(unit(joint.axis, 3, f"{what}: axis, which cone and twist need,"), 2)
    if joint.cone is not None:
        _part(spec, "swing", SWING, Axis(limits=(-np.inf, _below_pi(joint.cone, f"{what}: cone")), **soft))
    if joint.twist is not None:
        lower, upper = limits_of(joint.twist, f"{what}: twist")
        if not -math.pi < lower <= upper < math.pi:
            raise ValueError(f"{what}: twist must be within (-pi, pi), got {joint.twist!r}.")
        _part(spec, "twist", TWIST, Axis(limits=(lower, upper), **soft))
    if joint.angle is not None:
        _part(spec, "angle", BALL_ANGLE, Axis(limits=(-np.inf, _below_pi(joint.angle, f"{what}: angle")), **soft))
    axis = Axis(**{name: getattr(joint, name) for name in OF_EACH_TURN})
    _entry(spec, "turn_x", axis)
    if axis != Axis():
        frame = spec.orientation
        spec.orientation = np.array((1.0, 0.0, 0.0, 0.0))
        for k in range(3):
            _part(spec, f"turn_{_LETTERS[k]}", BALL_TURN + k, axis)
        spec.orientation = frame


def _below_pi(value: Any, what: str) -> float:
    angle = check.positive(value, what)
    if angle >= math.pi:
        raise ValueError(f"{what} must be below pi, got {value!r}.")
    return angle


def _frame(axis: Array, k: int) -> Array:
    """Return the rotation of a frame whose axis k is the given one."""
    other = np.eye(3)[int(np.argmin(abs(axis)))]
    first = np.cross(other, axis)
    first /= np.hypot.reduce(first)
    columns = np.stack([first, np.cross(axis, first), axis], 1)
    return _rotation_from(np.roll(columns, k - 2, 1))


def _cross_frame(first: Array, last: Array, what: str) -> Array:
    """Return the rotation of the frame with these first and last axes."""
    cosine = float(first @ last)
    if abs(cosine) > _PERPENDICULAR:
        raise ValueError(f"{what} must be perpendicular, the cosine of their angle is {cosine:.3g}.")
    last = last - cosine * first
    last /= np.hypot.reduce(last)
    return _rotation_from(np.stack([first, np.cross(last, first), last], 1))


def _rotation_from(matrix: Array) -> Array:
    """Return the quaternion of a rotation matrix."""
    rotation: Array = dimension(3).initial_state.rotation_from(matrix)
    return rotation
