"""Readings of 3D joints: coordinates, rates, errors and spring energies, as arrays over the worlds."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.joint_rows import has_limit
from ..core.springs import beyond_limit, distance_reading, limit_energy, stored_energy
from ..jit import njit
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.state import State
from .initial_state import multiplied, rotation_from, turn_about, turned_by
from .joints.axes import (
    BALL_ANGLE,
    BALL_TURN,
    FIRST_TURN,
    LAST_TURN,
    NODE_TURN,
    SWING,
    TWIST,
    axis_of,
    counts_turns,
    turn_coordinate,
    unwrapped,
)
from .joints.point import arm
from .joints.reference import anchor_give, reference_give, turn_give
from .math import Vec, add, conjugate, dot, multiply, norm, quaternion, sub, turn_between, vec

WITHOUT_COORDINATE = (
    JointKind.WELD, JointKind.ROWS, JointKind.TARGET, JointKind.BALL, JointKind.UNIVERSAL, JointKind.SIX_AXIS,
)  # fmt: skip
_WELD = int(JointKind.WELD)
_BALL = int(JointKind.BALL)
_DISTANCE = int(JointKind.DISTANCE)


class _Ends(NamedTuple):
    """The ends of one joint in all worlds, in the world."""

    apart: Array  # m (world, 3), anchor_b - anchor_a
    rate: Array  # m/s (world, 3)
    spin_a: Array  # rad/s (world, 3)
    spin_b: Array
    a: Array  # (world, 3, 3): [:, k] is axis k of the joint's frame in body a
    b: Array


def rotated(rotation: Array, vector: Array) -> Array:
    """Rotate vectors (..., 3) by quaternions (..., 4)."""
    return turned_by(rotation, vector)


def has_coordinate(model: Model, j: int) -> bool:
    """Return whether a joint has a coordinate of its own."""
    return JointKind(int(model.joints["kind"][j])) not in WITHOUT_COORDINATE


def coordinate(model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return the coordinate (world,): rad or m of a joint with axes, m between the anchors of a distance joint, or the
    error of a gear.

    Raises:
        ValueError: the joint is of another kind, or has several coordinates with names of their own.
    """
    kind = _with_coordinate(model, j)
    if kind == JointKind.GEAR:
        return _coupled(coordinate, model, parameters, state, j) - parameters.joints["reference_angle"][:, j]
    ends = _ends(model, parameters, state, j)
    if kind == JointKind.DISTANCE:
        return np.sqrt((ends.apart**2).sum(-1))
    number = int(model.joints["coordinate"][j])
    if number < 3:
        return _dot(ends.a[:, number], ends.apart)
    angle = turn_coordinates(number, ends.a, ends.b)
    if number in (FIRST_TURN, LAST_TURN, TWIST):
        turns = np.round((state.joints["angle"][:, j] - angle) / (2.0 * np.pi))
        angle = angle + 2.0 * np.pi * turns
    return angle


def rate(model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return the rate of change of the coordinate (world,), rad/s or m/s."""
    kind = _with_coordinate(model, j)
    if kind == JointKind.GEAR:
        return _coupled(rate, model, parameters, state, j)
    ends = _ends(model, parameters, state, j)
    if kind == JointKind.DISTANCE:
        length = np.sqrt((ends.apart**2).sum(-1))
        return np.asarray((ends.apart * ends.rate).sum(-1) / np.maximum(length, 1e-300))
    number = int(model.joints["coordinate"][j])
    if number < 3:
        turning = np.cross(ends.spin_a, ends.apart)
        return _dot(ends.a[:, number], ends.rate - turning)
    return _dot(turn_directions(number, ends.a, ends.b), ends.spin_b - ends.spin_a)


def beside(model: Model, j: int) -> list[int]:
    """Return the coordinates of a joint whose rates stay where one of them, j, is set; with j.

    Those of a ball overlap: its swing and twist, the components of its rotation vector, and its angle.
    """
    record = model.joints[j]
    main = int(record["joint_a"]) if record["kind"] == JointKind.AXIS else j
    coordinates = [k for k in (main, *model.parts_of(main).tolist()) if has_coordinate(model, k)]
    if model.joints["kind"][main] != JointKind.BALL:
        return coordinates
    groups = {SWING: 0, TWIST: 0, BALL_ANGLE: 1}
    group = groups.get(int(record["coordinate"]), 2)
    return [k for k in coordinates if groups.get(int(model.joints["coordinate"][k]), 2) == group]


def unit_motion(model: Model, parameters: ParameterArrays, state: State, j: int) -> tuple[Array, Array]:
    """Return the angular and linear velocity (world, 3) of body b at its anchor for a rate of 1, other rates 0."""
    _with_coordinate(model, j)
    ends = _ends(model, parameters, state, j)
    number = int(model.joints["coordinate"][j])
    none = np.zeros((len(state.worlds), 3))
    if number < 3:
        return none, ends.a[:, number]
    first, last = ends.a[:, 0], ends.b[:, 2]
    if number == FIRST_TURN:
        return first, none
    if number in (LAST_TURN, TWIST):
        return last, none
    if number == NODE_TURN:
        across = np.cross(last, first)
    elif number == SWING:
        across = np.cross(ends.a[:, 2], last)
    else:
        return turn_directions(number, ends.a, ends.b), none
    size = np.sqrt((across**2).sum(-1, keepdims=True))
    return np.where(size > 1e-12, across / np.maximum(size, 1e-300), ends.a[:, 1 if number == NODE_TURN else 0]), none


def displacement(
    model: Model, parameters: ParameterArrays, state: State, j: int, shift: Array, sign: float
) -> tuple[Array, Array, Array]:
    """Return how one body moves for a change of the coordinate: (pivot, turn, translation), each for all worlds.

    ``sign``: 1 moves body b, -1 body a.
    """
    spin, slide = unit_motion(model, parameters, state, j)
    ends = _ends(model, parameters, state, j)
    i = model.joints["body_b"][j]
    local = parameters.joints["anchor_b"][:, j] - parameters.bodies["center"][:, i]
    pivot = state.bodies["position"][:, i] + turned_by(state.bodies["rotation"][:, i], local)
    number = int(model.joints["coordinate"][j])
    turns = shift if number >= 3 else 0.0 * shift
    if number < BALL_TURN:
        return pivot, turn_about(spin, sign * turns), sign * shift[:, None] * slide
    before = _rotation_vectors(ends.a, ends.b)
    after = before.copy()
    if number == BALL_ANGLE:
        size = np.sqrt((before**2).sum(-1, keepdims=True))
        after += shift[:, None] * np.where(size > 1e-12, before / np.maximum(size, 1e-300), np.eye(3)[0])
    else:
        after[:, number - BALL_TURN] += shift
    turn = multiplied(_turn_by_vector(ends.a, after), _turn_by_vector(ends.a, -before))
    return pivot, turn * np.array([1.0, sign, sign, sign]), slide


def _turn_by_vector(a: Array, vectors: Array) -> Array:
    """Return the quaternions (world, 4) of rotation vectors (world, 3) in frames a."""
    size = np.sqrt((vectors**2).sum(-1, keepdims=True))
    axis = np.einsum("wi,wij->wj", vectors / np.maximum(size, 1e-300), a)
    return turn_about(axis, size[:, 0])


def slides(model: Model, j: int) -> bool:
    """Return whether the coordinate of a joint is a length."""
    return bool(model.joints["kind"][j] == JointKind.DISTANCE or model.joints["coordinate"][j] < 3)


def _coupled(read: Any, model: Model, parameters: ParameterArrays, state: State, j: int) -> Array:
    """Return q_a + ratio q_b of a gear, or its rate."""
    a, b = (read(model, parameters, state, int(model.joints[side][j])) for side in ("joint_a", "joint_b"))
    return np.asarray(a + parameters.joints["ratio"][:, j] * b)


def _with_coordinate(model: Model, j: int) -> JointKind:
    kind = JointKind(int(model.joints["kind"][j]))
    name = model.joint_names[j]
    if kind in WITHOUT_COORDINATE:
        parts = [model.joint_names[k] for k in model.parts_of(j)]
        if parts:
            raise ValueError(f"joint {name!r} has the coordinates {', '.join(map(repr, parts))}; name one of these.")
        raise ValueError(f"joint {name!r} is a {kind.name.lower()} and has no coordinate.")
    return kind


def _dot(a: Array, b: Array) -> Array:
    return np.asarray((a * b).sum(-1))


def _ends(model: Model, parameters: ParameterArrays, state: State, j: int) -> _Ends:
    points, speeds, spins, frames = [], [], [], []
    frame = parameters.joints["frame"][:, j]
    back = parameters.joints["reference"][:, j] * np.array([1.0, -1.0, -1.0, -1.0])
    for side in ("a", "b"):
        i = model.joints[f"body_{side}"][j]
        body = state.bodies[:, i]
        local = parameters.joints[f"anchor_{side}"][:, j] - parameters.bodies["center"][:, i]
        to_anchor = turned_by(body["rotation"], local)
        points.append(body["position"] + to_anchor)
        speeds.append(body["velocity"][:, :3] + np.cross(body["velocity"][:, 3:], to_anchor))
        spins.append(body["velocity"][:, 3:])
        own = multiplied(body["rotation"], frame if side == "a" else multiplied(back, frame))
        frames.append(np.stack([turned_by(own, np.eye(3)[k]) for k in range(3)], 1))
    return _Ends(points[1] - points[0], speeds[1] - speeds[0], spins[0], spins[1], frames[0], frames[1])


def turn_coordinates(number: int, a: Array, b: Array) -> Array:
    """Return ``axes.turn_coordinate`` of many frames (world, 3, 3), rad."""
    first, last = a[:, 0], b[:, 2]
    if number == FIRST_TURN:
        return np.arctan2(-_dot(a[:, 1], last), _dot(a[:, 2], last))
    if number == LAST_TURN:
        return np.arctan2(-_dot(first, b[:, 1]), _dot(first, b[:, 0]))
    if number == NODE_TURN:
        return np.arctan2(_dot(first, last), np.sqrt((np.cross(last, first) ** 2).sum(-1)))
    if number == SWING:
        return np.arctan2(np.sqrt((np.cross(a[:, 2], last) ** 2).sum(-1)), _dot(a[:, 2], last))
    if number == TWIST:  # rotate b's last axis back to a's; the angle is then that between their first axes
        whole = (1.0 + _dot(a[:, 2], last))[:, None]
        half = a[:, 2] + last
        sine = _dot(b[:, 0] - half * _dot(b[:, 0], half)[:, None] / np.maximum(whole, 1e-300), a[:, 1])
        cosine = _dot(b[:, 0] - half * _dot(b[:, 0], half)[:, None] / np.maximum(whole, 1e-300), a[:, 0])
        return np.arctan2(sine, cosine)
    vectors = _rotation_vectors(a, b)
    return np.sqrt((vectors**2).sum(-1)) if number == BALL_ANGLE else vectors[:, number - BALL_TURN]


def _rotation_vectors(a: Array, b: Array) -> Array:
    """Return the rotation vectors (world, 3) of frames b in frames a, rad."""
    m = np.einsum("wik,wjk->wij", a, b)  # [i, j]: component of axis j of b along axis i of a
    return np.array([_rotation_vector(one) for one in m])


def _rotation_vector(m: Array) -> Array:
    q = rotation_from(m)
    q = q if q[0] >= 0.0 else -q
    sine = float(np.sqrt((q[1:] ** 2).sum()))
    return np.asarray(q[1:] * (2.0 * np.arctan2(sine, q[0]) / sine if sine > 1e-8 else 2.0))


def turn_directions(number: int, a: Array, b: Array) -> Array:
    """Return ``axes.turn_direction`` of many frames (world, 3, 3)."""
    first, last = a[:, 0], b[:, 2]
    if number == BALL_ANGLE:
        vectors = _rotation_vectors(a, b)
        axis = vectors / np.maximum(np.sqrt((vectors**2).sum(-1, keepdims=True)), 1e-300)
        return np.asarray(np.einsum("wi,wij->wj", axis, a))
    if number >= BALL_TURN:
        return a[:, number - BALL_TURN]
    if number == TWIST:
        return (a[:, 2] + last) / np.maximum(1.0 + _dot(a[:, 2], last), 1e-300)[:, None]
    across = np.cross(a[:, 2], last) if number == SWING else np.cross(last, first)
    if number in (SWING, NODE_TURN):
        return np.asarray(across / np.maximum(np.sqrt((across**2).sum(-1)), 1e-300)[:, None])
    sine, square = _dot(first, last)[:, None], np.maximum((across**2).sum(-1), 1e-300)[:, None]
    return np.asarray((first - sine * last if number == FIRST_TURN else last - sine * first) / square)


@njit
def read_joint(body_a: Any, body_b: Any, a: Any, b: Any, joint: Any) -> Any:
    """Return (error in m, energy of the springs in J) of one joint; a, b: parameters of the bodies."""
    p = joint.parameters
    model = joint.model
    arm_a = arm(body_a, a, p.anchor_a)
    arm_b = arm(body_b, b, p.anchor_b)
    d = sub(add(vec(body_b.position), arm_b), add(vec(body_a.position), arm_a))
    arm_a = add(arm_a, d)  # a spring acts on both bodies at b's anchor
    apart = norm(d)
    sprung = p.frequency > 0.0 or p.stiffness > 0.0
    if model.kind == _DISTANCE:
        return distance_reading(p, apart, anchor_give(p, a, b))
    if model.kind == _BALL:
        return apart, 0.0
    if model.kind != _WELD:
        return _read_axes(body_a, body_b, a, b, joint, arm_a, arm_b, d)
    if not sprung:
        return (0.0 if p.damping > 0.0 else apart), 0.0
    wanted = multiply(quaternion(body_a.rotation), quaternion(p.reference))
    turn = norm(turn_between(wanted, quaternion(body_b.rotation)))
    return 0.0, stored_energy(p, apart, anchor_give(p, a, b)) + stored_energy(p, turn, turn_give(a, b))


@njit
def turned_off(body_a: Any, body_b: Any, joint: Any) -> Any:
    """Return the largest angle in rad by which a rotation that the joint locks or limits is off; 0 without any."""
    p = joint.parameters
    if joint.model.kind == _WELD:
        if p.frequency > 0.0 or p.stiffness > 0.0 or p.damping > 0.0:
            return 0.0
        wanted = multiply(quaternion(body_a.rotation), quaternion(p.reference))
        return norm(turn_between(wanted, quaternion(body_b.rotation)))
    frame = quaternion(p.frame)
    on_a = multiply(quaternion(body_a.rotation), frame)
    on_b = multiply(quaternion(body_b.rotation), multiply(conjugate(quaternion(p.reference)), frame))
    off = _turned_off(joint.model.locked >> 3, on_a, on_b)
    if joint.model.coordinate >= 3 and has_limit(p):
        off = max(off, beyond_limit(p, _angle_of(joint, on_a, on_b)))
    return off


@njit
def _angle_of(joint: Any, on_a: Any, on_b: Any) -> float:
    """Return a rotational coordinate in rad, with its turns."""
    q = turn_coordinate(joint.model.coordinate, on_a, on_b)
    return unwrapped(q, joint.state.angle) if counts_turns(joint.model.coordinate) else q


@njit
def _read_axes(body_a: Any, body_b: Any, a: Any, b: Any, joint: Any, arm_a: Vec, arm_b: Vec, d: Vec) -> Any:
    """Return ``read_joint`` of a joint with axes: arms to b's anchor, which is d m from a's."""
    p = joint.parameters
    model = joint.model
    frame = quaternion(p.frame)
    on_a = multiply(quaternion(body_a.rotation), frame)
    on_b = multiply(quaternion(body_b.rotation), multiply(conjugate(quaternion(p.reference)), frame))
    off = 0.0
    for k in range(3):
        if (model.locked >> k) & 1:
            off += dot(axis_of(on_a, k), d) ** 2
    error = max(off**0.5, _turned_off(model.locked >> 3, on_a, on_b) * max(a.radius, b.radius))
    sprung = p.frequency > 0.0 or p.stiffness > 0.0
    slides = model.coordinate < 3
    if model.coordinate < 0 or not (sprung or p.limit_frequency > 0.0 or (slides and has_limit(p))):
        return error, 0.0
    q = dot(axis_of(on_a, model.coordinate), d) if slides else _angle_of(joint, on_a, on_b)
    if slides:
        error = max(error, beyond_limit(p, q))
    give = reference_give(joint, a, b)
    energy = limit_energy(p, q, give)
    return error, energy + (stored_energy(p, q - joint.state.rest, give) if sprung else 0.0)


@njit
def _turned_off(bits: Any, on_a: Any, on_b: Any) -> float:
    """Return the largest angle in rad by which locked rotations are off; ``bits`` as in spatial/joints/axis_joints."""
    if bits == 7:
        return norm(turn_between(on_a, on_b))
    if bits == 3:
        return turn_coordinate(SWING, on_a, on_b)
    if bits == 2:
        return abs(turn_coordinate(NODE_TURN, on_a, on_b))
    return 0.0
