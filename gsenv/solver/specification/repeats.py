"""Joints that repeat another one: a second hinge on the axis of the first asks for nothing new.

Their rows depend on those of the other joint, exactly at the poses of one time and almost at all others, and almost
dependent equations have solutions of any size.  So they are left out while the other joint is enabled.

The motions that a hinge, slider or ball allows form a group; a joint repeats another one where its group contains
that of the other (J. Herve, "Analyse structurelle des mecanismes par groupe des deplacements", Mechanism and Machine
Theory 13, 1978).  Welds stay out of this: `Parameters.set` may make them soft.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..records.model import Array
from .placement import anchor_of
from .specs import BodySpec, JointSpec

NONE = -1
_ROTATIONS = {"revolute", "hinge"}
_SLIDES = {"prismatic", "slider"}
_GROUPS = {"ball"} | _ROTATIONS | _SLIDES
_OFF = 1e-6  # of the distance of the bodies, and sine of an angle: what counts as the same point or direction


def repeats_of(specs: Sequence[JointSpec], bodies: Sequence[BodySpec]) -> Array:
    """Return, of each joint, the number of the joint that it repeats, or -1.

    Of two joints that repeat each other, one with a limit, spring, motor or friction stays.
    """
    repeats = np.full(len(specs), NONE, np.int32)
    pairs: dict[tuple[int, int], list[int]] = {}
    for j, spec in enumerate(specs):
        if spec.kind in _GROUPS:
            pairs.setdefault((min(spec.body_a, spec.body_b), max(spec.body_a, spec.body_b)), []).append(j)
    for group in pairs.values():
        kept: list[int] = []
        for j in sorted(group, key=lambda j: (_freedom(specs[j]), not _serves(specs[j]))):
            others = [i for i in kept if _contains(specs[j], specs[i], bodies)]
            if others:
                repeats[j] = others[0]
            else:
                kept.append(j)
    return repeats


def _freedom(spec: JointSpec) -> int:
    """Return the number of degrees of freedom of a joint."""
    return 3 if spec.kind == "ball" else 1


def _serves(spec: JointSpec) -> bool:
    """Whether a joint does more than hold."""
    limited = np.isfinite(spec.lower) or np.isfinite(spec.upper)
    efforts = spec.motor_effort > 0.0 or spec.friction_effort > 0.0 or spec.armature > 0.0
    return bool(limited or efforts or spec.has_spring or spec.parts)


def _contains(joint: JointSpec, other: JointSpec, bodies: Sequence[BodySpec]) -> bool:
    """Whether a joint allows all that another one between the same bodies allows."""
    if joint.kind in _SLIDES or other.kind in _SLIDES:
        return joint.kind in _SLIDES and other.kind in _SLIDES and _parallel(joint, other)
    if other.kind == "ball" and joint.kind != "ball":
        return False
    apart = anchor_of(joint, bodies) - anchor_of(other, bodies)
    if other.kind == "hinge":
        assert other.axis is not None
        apart = apart - np.dot(apart, other.axis) * other.axis
    size = np.hypot.reduce(bodies[joint.body_b].position - bodies[joint.body_a].position)
    near = bool(np.hypot.reduce(apart) <= _OFF * size)
    return near and (joint.kind != "hinge" or _parallel(joint, other))


def _parallel(joint: JointSpec, other: JointSpec) -> bool:
    assert joint.axis is not None
    assert other.axis is not None
    rest = joint.axis - np.dot(joint.axis, other.axis) * other.axis
    return bool(np.hypot.reduce(rest) <= _OFF)
