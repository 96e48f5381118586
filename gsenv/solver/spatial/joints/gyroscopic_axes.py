"""Gyroscopic terms of hinges, wheels and universal joints: rows between an axis of a and the last axis of b.

As in gyroscopic.py, the change of the row's constraint is computed from the free rotation of both bodies, from this
midpoint to the next, started with the impulses of the last substep.  A flywheel on an axle that turns thus keeps its
speed of precession, which the change of its velocity before the impulses of this substep would damp.
"""

from __future__ import annotations

from typing import Any

from ...core.rows import EQUATION, relative_velocity, start_rate
from ...jit import njit
from ..math import Quaternion, Vec, conjugate, cross, dot, multiply, norm, quaternion, turned
from ..rotation import expected_spin, in_world, spin_change, spin_of
from .point import rotation_after, start_spin, unit_axis

NUTATES = 0.05  # rad in a substep, above which these terms apply
MOST_PHASE = 0.7  # rad in a substep, above which they are reduced: the lag of the impulses would make them unstable
SLOW = 0.005  # of the spin about the axis: slower velocities across it are no precession
STRICTER = 1.3  # than for tops on a point: their nutation is taken from the impulses of the last substep
_SWING = 3  # bits of the locked rotations, as in axis_joints.py
_NODE = 2


@njit
def set_axis_biases(world: Any, island: Any) -> None:
    """Set the biases of rows of nutating bodies; the solver bodies contain the impulses of the warm start."""
    rows = world.scratch.rows
    solver_bodies = world.scratch.solver_bodies
    substep_bodies = world.scratch.substep_bodies
    h = island.h
    for r in range(island.joint_rows):
        row = rows[r]
        phase = _phase(world, row, h)
        if phase > NUTATES:
            a = expected_spin(substep_bodies[row.body_a], solver_bodies[row.body_a].velocity)
            b = expected_spin(substep_bodies[row.body_b], solver_bodies[row.body_b].velocity)
            spin_a = in_world(substep_bodies[row.body_a], a)
            spin_b = in_world(substep_bodies[row.body_b], b)
            here = _constraint_after(world, row, spin_a, spin_b, h, 0.0)
            there = _constraint_after(world, row, spin_a, spin_b, h, h)
            rate = 0.0
            for k in range(3):
                rate += row.jacobian_a[3 + k] * a[k] + row.jacobian_b[3 + k] * b[k]
            row.bias = min(MOST_PHASE / phase, 1.0) * ((there - here) / h - rate)


@njit
def set_axis_errors(world: Any, island: Any) -> None:
    """Set ``drive`` of rows of nutating bodies: the change of the constraint beyond the mean velocity, over h."""
    rows = world.scratch.rows
    bodies = world.state.bodies
    substep_bodies = world.scratch.substep_bodies
    h = island.h
    for r in range(island.joint_rows):
        row = rows[r]
        if _phase(world, row, h) > NUTATES:
            spin_a = in_world(substep_bodies[row.body_a], spin_of(bodies[row.body_a].velocity))
            spin_b = in_world(substep_bodies[row.body_b], spin_of(bodies[row.body_b].velocity))
            start = _constraint(
                world, row, quaternion(bodies[row.body_a].rotation), quaternion(bodies[row.body_b].rotation)
            )
            end = _constraint_after(world, row, spin_a, spin_b, h, 0.5 * h)
            rate = relative_velocity(row, bodies[row.body_a], bodies[row.body_b])
            row.drive = (end - start) / h - 0.5 * (rate + start_rate(row, substep_bodies))


@njit
def _phase(world: Any, row: Any, h: Any) -> float:
    """Return the angle by which a free body would nutate in the substep; 0 for a row that is not between axes."""
    if row.kind != EQUATION or row.softness > 0.0 or row.slot < 3 or row.slot > 4:
        return 0.0
    if not _has_axis_rows(world.model.joints[row.source]):
        return 0.0
    substep_bodies = world.scratch.substep_bodies
    u = _last_axis(world, row.source, row.body_b)
    fastest = 0.0
    for side in range(2):
        i = row.body_a if side == 0 else row.body_b
        change = in_world(substep_bodies[i], spin_change(substep_bodies[i], world.parameters.bodies[i]))
        fastest = max(fastest, _nutation(start_spin(substep_bodies[i]), change, u))
    return h * fastest


@njit
def _has_axis_rows(model: Any) -> bool:
    """Whether a joint keeps an axis of b perpendicular to axes of a."""
    return model.locked >> 3 == _SWING or model.locked >> 3 == _NODE


@njit
def _last_axis(world: Any, j: Any, b: Any) -> Vec:
    """Return the last axis of joint j on body b, in the world."""
    p = world.parameters.joints[j]
    on_b = multiply(conjugate(quaternion(p.reference)), quaternion(p.frame))
    return turned(multiply(quaternion(world.state.bodies[b].rotation), on_b), unit_axis(2))


@njit
def _nutation(w: Vec, change: Vec, u: Vec) -> float:
    """Return in rad/s how fast the velocity across an axis u rotates about it, from spin w and its change."""
    across = norm(cross(w, u))
    spin = abs(dot(w, u))
    if across <= SLOW * spin:
        return 0.0
    return norm(cross(change, u)) / across + spin


@njit
def axle_nutation(world: Any, j: Any, axes: Any) -> float:
    """Return the largest speed in rad/s at which bodies of joint j would nutate; ``axes`` is None without such joints.

    Before the substeps, when velocities are in the world.
    """
    if axes is None:
        return 0.0
    model = world.model.joints[j]
    if not _has_axis_rows(model):
        return 0.0
    u = _last_axis(world, j, model.body_b)
    fastest = 0.0
    for side in range(2):
        i = model.body_a if side == 0 else model.body_b
        body = world.state.bodies[i]
        masses = world.parameters.bodies[i]
        w = spin_of(body.velocity)
        inertia = masses.inertia
        if masses.inv_mass > 0.0 and inertia[0] > 0.0 and inertia[1] > 0.0 and inertia[2] > 0.0:
            axes_q = multiply(quaternion(body.rotation), quaternion(masses.axes))
            own = turned(conjugate(axes_q), w)
            turning = cross((inertia[0] * own[0], inertia[1] * own[1], inertia[2] * own[2]), own)
            change = turned(axes_q, (turning[0] / inertia[0], turning[1] / inertia[1], turning[2] / inertia[2]))
            fastest = max(fastest, _nutation(w, change, u))
    return STRICTER * fastest


@njit
def _constraint_after(world: Any, row: Any, spin_a: Vec, spin_b: Vec, h: Any, t: Any) -> float:
    """Return the constraint of a row ``t`` s after the midpoint, if both bodies rotate freely from these spins."""
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    a = row.body_a
    b = row.body_b
    rotation_a = rotation_after(bodies[a], body_parameters[a], substep_bodies[a], spin_a, h, t)
    rotation_b = rotation_after(bodies[b], body_parameters[b], substep_bodies[b], spin_b, h, t)
    return _constraint(world, row, rotation_a, rotation_b)


@njit
def _constraint(world: Any, row: Any, rotation_a: Quaternion, rotation_b: Quaternion) -> float:
    """Return the cosine, with the row's sign, of the angle between its axis of a and the last of b; 0 if it holds."""
    p = world.parameters.joints[row.source]
    frame = quaternion(p.frame)
    k = 1 if row.slot == 3 else 0
    axis = turned(multiply(rotation_a, frame), unit_axis(k))
    last = turned(multiply(rotation_b, multiply(conjugate(quaternion(p.reference)), frame)), unit_axis(2))
    return -dot(axis, last) if row.slot == 3 else dot(axis, last)
