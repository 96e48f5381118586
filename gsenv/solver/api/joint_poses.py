"""Coordinates of joints that are set: all bodies beyond the joint move with it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..dimension import Dimension
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.state import State

SETTABLE = (
    JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.WHEEL, JointKind.HINGE, JointKind.SLIDER, JointKind.AXIS,
)  # fmt: skip
# joints that a motion of one of their bodies alone would tear
RIGID = (
    JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.WHEEL, JointKind.BALL, JointKind.HINGE, JointKind.SLIDER,
    JointKind.UNIVERSAL, JointKind.SIX_AXIS, JointKind.WELD,
)  # fmt: skip


class Move(NamedTuple):
    """A change of the coordinate and the rate of one joint in some worlds."""

    joint: int
    worlds: Array  # (chosen world,)
    bodies: Array  # (body,), those beyond the joint
    shift: Array  # (chosen world,) rad or m
    speed: Array  # (chosen world,) rad/s or m/s, change of the rate


def bodies_beyond(model: Model, enabled: Array, joint: int) -> Array:
    """Return the bodies that hang on the second side of a joint of a tree, away from its root.

    Args:
        enabled: (joint,), whether each joint is.

    Raises:
        ValueError: the joint is of a kind without a coordinate that can be set, is in no tree, is disabled, or one
            of the bodies is also held by a rigid joint on a body that would not move.
    """
    name = repr(model.joint_names[joint])
    parts = [model.joint_names[k] for k in model.parts_of(joint)]
    kind = JointKind(int(model.joints["kind"][joint]))
    if parts and kind not in SETTABLE:
        raise ValueError(
            f"set_joint: joint {name} has the coordinates {', '.join(map(repr, parts))}; name one of these."
        )
    if kind not in SETTABLE:
        raise ValueError(f"set_joint: joint {name} is a {kind.name.lower()}, which has no coordinate that can be set.")
    main = main_joint(model, joint)
    if not enabled[main]:
        raise ValueError(f"set_joint: joint {name} is disabled.")
    trees = model.trees
    beyond = trees["joint"] == main
    if not beyond.any():
        raise ValueError(f"set_joint: joint {name} closes a loop, so its coordinate follows from those of the others.")
    for body in np.argsort(trees["rank"]):
        held = trees["joint"][body]
        if held >= 0 and enabled[held] and beyond[trees["parent"][body]]:
            beyond[body] = True
    joints = model.joints
    torn = np.isin(joints["kind"], RIGID) & (enabled != 0) & (np.arange(len(joints)) != main)
    torn &= beyond[joints["body_a"]] != beyond[joints["body_b"]]
    if torn.any():
        other = model.joint_names[int(np.argmax(torn))]
        raise ValueError(f"set_joint: joint {name} is in a loop, which joint {other!r} closes and which would open.")
    return np.flatnonzero(beyond)


def main_joint(model: Model, joint: int) -> int:
    """Return the joint that a coordinate belongs to."""
    record = model.joints[joint]
    return int(record["joint_a"]) if record["kind"] == JointKind.AXIS else joint


def move_bodies(dimension: Dimension, model: Model, parameters: ParameterArrays, state: State, move: Move) -> None:
    """Move the bodies beyond a joint; the rates of all other coordinates stay, also those of the same joint."""
    j, worlds = move.joint, move.worlds
    readings, poses = dimension.joint_readings, dimension.initial_state
    main = main_joint(model, j)
    child = move.bodies[np.isin(move.bodies, [model.joints["body_a"][main], model.joints["body_b"][main]])][0]
    flipped = model.joints["body_a"][main] == child
    parent = state.bodies[worlds, int(model.joints["body_b" if flipped else "body_a"][main])]
    sign = -1.0 if flipped else 1.0
    coordinates = readings.beside(model, j)
    rates = {k: readings.rate(model, parameters, state, k)[worlds] for k in coordinates}
    rates[j] = rates[j] + move.speed
    shift = np.zeros(len(state.worlds))
    shift[worlds] = move.shift
    pivot, turn, slide = (one[worlds] for one in readings.displacement(model, parameters, state, j, shift, sign))
    for body in move.bodies:
        record = state.bodies[worlds, body]
        start = record["position"].copy()
        poses.turn_bodies(record, turn, pivot)
        record["position"] += slide
        _carry(model.dim, record, start, parent, turn, dimension)
        state.bodies[worlds, body] = record
        state.forget_impulses(worlds, int(body))
    if "angle" in (state.joints.dtype.names or ()):
        state.joints["angle"][worlds, j] += move.shift
    for k in coordinates:
        missing = rates[k] - readings.rate(model, parameters, state, k)[worlds]
        motion = (one[worlds] * sign * missing[:, None] for one in readings.unit_motion(model, parameters, state, k))
        _add_motion(model.dim, state, move, pivot, *motion)
    state.joints["rate"][worlds, j] += move.speed


def _carry(dim: int, record: Array, start: Array, parent: Array, turn: Any, dimension: Dimension) -> None:
    """Rotate the velocity of bodies relative to the body that holds them, which stays where it is."""
    v, w = parent["velocity"][:, :dim], parent["velocity"][:, dim:]
    before = v + _moment(dim, w, start - parent["position"])
    after = v + _moment(dim, w, record["position"] - parent["position"])
    relative = record["velocity"][:, :dim] - before
    record["velocity"][:, :dim] = after + dimension.initial_state.turned_vectors(turn, relative)
    if dim == 3:
        own = record["velocity"][:, 3:] - w
        record["velocity"][:, 3:] = w + dimension.initial_state.turned_vectors(turn, own)


def _add_motion(dim: int, state: State, move: Move, pivot: Array, spin: Array, slide: Array) -> None:
    """Add a rotation about points and a translation to the velocities of the bodies beyond the joint."""
    for body in move.bodies:
        arm = state.bodies["position"][move.worlds, body] - pivot
        state.bodies["velocity"][move.worlds, body] += np.concatenate([slide + _moment(dim, spin, arm), spin], -1)


def _moment(dim: int, w: Array, arm: Array) -> Array:
    """Return w x arm, with w (world, 1) or (world, 3)."""
    if dim == 3:
        return np.cross(w, arm)
    return w * np.stack([-arm[:, 1], arm[:, 0]], -1)
