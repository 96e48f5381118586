"""Points of bodies that spin fast, whose velocity their own inertia turns by much within a substep.

Such a top nutates about its centre by lambda h, lambda = |1/I_i - 1/I_j| L, in a substep; a joint lets it do
nothing of the kind.  What J v gains after the kick in the middle, and how far the arms move, are then
taken from the free motion itself, started with the impulses of the last substep: the velocity of an arm is
that of its chord from this middle to the next, in which the nutation has its mean.  A top in steady
precession is so reproduced at any lambda h.
"""

from __future__ import annotations

from typing import Any

from ...jit import njit
from ...rows import EQUATION
from ..frames import in_world, spin_change, spin_of
from ..math import Vec, add, conjugate, cross, multiply, norm, quaternion, scaled, sub, turn_of, turned, vec
from ..spin import spin_freely
from .point import arm, bend_across, rotation_ahead

NUTATES = 0.1  # part of the speed at which an arm swings that the body's own inertia adds in a substep
_ZERO = (0.0, 0.0, 0.0)


@njit
def _arm_after(body: Any, parameters: Any, motion: Any, anchor: Any, w: Vec, h: Any, t: Any) -> Vec:
    """Arm of an anchor ``t`` s after the middle of the substep, the body turning freely from w, rad/s in the world."""
    middle = rotation_ahead(body, motion, h, 0.5 * h)
    local = sub(vec(anchor), vec(parameters.center))
    if motion.tilted == 0:
        return turned(multiply(turn_of(scaled(w, t)), middle), local)
    axes = quaternion(parameters.axes)
    after, _ = spin_freely(multiply(middle, axes), vec(parameters.inertia), w, t)
    return turned(multiply(after, conjugate(axes)), local)


@njit
def _chord(body: Any, parameters: Any, motion: Any, anchor: Any, velocity: Any, h: Any) -> Vec:
    """m/s of an arm from this middle to the next, beyond w x r; ``velocity``: of the frame, after the kick."""
    if parameters.inv_mass <= 0.0:
        return _ZERO
    w = in_world(motion, spin_of(velocity))
    here = _arm_after(body, parameters, motion, anchor, w, h, 0.0)
    way = sub(_arm_after(body, parameters, motion, anchor, w, h, h), here)
    half = min(0.5 * norm(way) / max(norm(here), 1e-300), 1.0)  # sine of half the angle; the arc is longer
    longer = 1.0 + half * half / 6.0
    return sub(scaled(way, longer / h), cross(w, here))


@njit
def _drift(body: Any, parameters: Any, motion: Any, anchor: Any, h: Any) -> Vec:
    """m/s by which an arm moves more in the substep than the mean velocity says."""
    if parameters.inv_mass <= 0.0:
        return _ZERO
    w = in_world(motion, spin_of(body.velocity))
    mean = scaled(add(w, in_world(motion, spin_of(motion.start_velocity))), 0.5)
    here = _arm_after(body, parameters, motion, anchor, w, h, 0.0)
    end = _arm_after(body, parameters, motion, anchor, w, h, 0.5 * h)
    start = arm(body, parameters, anchor)
    return sub(scaled(sub(end, start), 1.0 / h), cross(mean, here))


@njit
def _nutates(body: Any, parameters: Any, motion: Any, anchor: Any, h: Any) -> Any:
    """Whether a body's own inertia changes the motion of an arm by much within the substep."""
    if motion.tilted == 0:
        return False
    w = in_world(motion, spin_of(motion.start_velocity))
    change = in_world(motion, spin_change(motion, parameters))
    to_anchor = arm(body, parameters, anchor)
    return h * norm(bend_across(w, change, to_anchor)) > NUTATES * norm(cross(w, to_anchor))


@njit
def _is_point(
    rows: Any, r: Any, end: Any, joint_parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> Any:
    """Whether rows r to r + 2 hold the anchors of a spinning body together, at the pose of the middle."""
    row = rows[r]
    if row.kind != EQUATION or row.softness > 0.0 or row.slot != 0 or r + 2 >= end:
        return False
    if rows[r + 1].source != row.source or rows[r + 2].source != row.source or rows[r + 2].slot != 2:
        return False
    if row.bias == 0.0 and rows[r + 1].bias == 0.0 and rows[r + 2].bias == 0.0:
        return False  # set at the pose of the start
    p = joint_parameters[row.source]
    a = row.body_a
    b = row.body_b
    return _nutates(bodies[a], body_parameters[a], motions[a], p.anchor_a, h) or _nutates(
        bodies[b], body_parameters[b], motions[b], p.anchor_b, h
    )


@njit
def bend_spinning(
    rows: Any, end: Any, joint_parameters: Any, bodies: Any, body_parameters: Any, motions: Any, movers: Any, h: Any
) -> None:
    """Biases of the anchors of spinning bodies; movers have taken the impulses that the rows start from."""
    for r in range(end):
        if not _is_point(rows, r, end, joint_parameters, bodies, body_parameters, motions, h):
            continue
        p = joint_parameters[rows[r].source]
        a = rows[r].body_a
        b = rows[r].body_b
        bend = sub(
            _chord(bodies[b], body_parameters[b], motions[b], p.anchor_b, movers[b].velocity, h),
            _chord(bodies[a], body_parameters[a], motions[a], p.anchor_a, movers[a].velocity, h),
        )
        for k in range(3):
            rows[r + k].bias = bend[k]


@njit
def drift_spinning(
    rows: Any, end: Any, joint_parameters: Any, bodies: Any, body_parameters: Any, motions: Any, h: Any
) -> None:
    """How far the anchors of spinning bodies move beyond the mean velocity, for the position pass."""
    for r in range(end):
        if not _is_point(rows, r, end, joint_parameters, bodies, body_parameters, motions, h):
            continue
        p = joint_parameters[rows[r].source]
        a = rows[r].body_a
        b = rows[r].body_b
        apart = sub(
            _drift(bodies[b], body_parameters[b], motions[b], p.anchor_b, h),
            _drift(bodies[a], body_parameters[a], motions[a], p.anchor_a, h),
        )
        for k in range(3):
            rows[r + k].drive = apart[k]
