"""Coordinates of joints that are set: all bodies beyond the joint move with it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..dimension import Dimension
from ..records.model import Array, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.state import State

TURNS = (JointKind.REVOLUTE, JointKind.HINGE)
SLIDES = (JointKind.PRISMATIC, JointKind.SLIDER)
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
    kind = JointKind(int(model.joints["kind"][joint]))
    if kind not in TURNS and kind not in SLIDES:
        raise ValueError(f"set_joint: joint {name} is a {kind.name.lower()}; it needs a revolute, hinge, prismatic or "
                         "slider joint.")  # fmt: skip
    if not enabled[joint]:
        raise ValueError(f"set_joint: joint {name} is disabled.")
    trees = model.trees
    beyond = trees["joint"] == joint
    if not beyond.any():
        raise ValueError(f"set_joint: joint {name} closes a loop, so its coordinate follows from those of the others.")
    for body in np.argsort(trees["rank"]):
        held = trees["joint"][body]
        if held >= 0 and enabled[held] and beyond[trees["parent"][body]]:
            beyond[body] = True
    joints = model.joints
    torn = np.isin(joints["kind"], RIGID) & (enabled != 0) & (np.arange(len(joints)) != joint)
    torn &= beyond[joints["body_a"]] != beyond[joints["body_b"]]
    if torn.any():
        other = model.joint_names[int(np.argmax(torn))]
        raise ValueError(f"set_joint: joint {name} is in a loop, which joint {other!r} closes and which would open.")
    return np.flatnonzero(beyond)


def move_bodies(dimension: Dimension, model: Model, parameters: ParameterArrays, state: State, move: Move) -> None:
    """Move the bodies beyond a joint about its axis; the rates of all other joints stay."""
    j, worlds = move.joint, move.worlds
    child = move.bodies[np.isin(move.bodies, [model.joints["body_a"][j], model.joints["body_b"][j]])][0]
    flipped = model.joints["body_a"][j] == child
    holder = int(model.joints["body_b" if flipped else "body_a"][j])
    sign = -1.0 if flipped else 1.0
    frame = state.bodies[worlds, int(model.joints["body_a"][j])]
    axis = dimension.joint_readings.rotated(frame["rotation"], parameters.joints["axis"][worlds, j])
    turns = JointKind(int(model.joints["kind"][j])) in TURNS
    local = parameters.joints["anchor_b" if flipped else "anchor_a"][worlds, j]
    parent = state.bodies[worlds, holder]
    center = parameters.bodies["center"][worlds, holder]
    pivot = parent["position"] + dimension.joint_readings.rotated(parent["rotation"], local - center)
    turn = dimension.initial_state.turn_about(axis, sign * move.shift if turns else 0.0 * move.shift)
    shift, speed = (sign * move.shift)[:, None] * axis, (sign * move.speed)[:, None]
    for body in move.bodies:
        record = state.bodies[worlds, body]
        start = record["position"].copy()
        dimension.initial_state.turn_bodies(record, turn, pivot)
        if not turns:
            record["position"] += shift
        _carry(model.dim, record, start, parent, turn, dimension)
        spin = speed * (axis if model.dim == 3 else 1.0) if turns else None
        _add_motion(model.dim, record, pivot, spin, None if turns else speed * axis)
        state.bodies[worlds, body] = record
        state.forget_impulses(worlds, int(body))
    state.joints["rate"][worlds, j] += move.speed
    if "angle" in (state.joints.dtype.names or ()):
        state.joints["angle"][worlds, j] += move.shift


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


def _add_motion(dim: int, record: Array, pivot: Array, spin: Array | None, slide: Array | None) -> None:
    if slide is not None:
        record["velocity"][:, :dim] += slide
    if spin is not None:
        record["velocity"][:, :dim] += _moment(dim, spin, record["position"] - pivot)
        record["velocity"][:, dim:] += spin


def _moment(dim: int, w: Array, arm: Array) -> Array:
    """Return w x arm, with w (world, 1) or (world, 3)."""
    if dim == 3:
        return np.cross(w, arm)
    return w * np.stack([-arm[:, 1], arm[:, 0]], -1)
