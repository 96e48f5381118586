"""Gyroscopic terms of joints: anchors of fast bodies whose own inertia rotates their velocity within a substep.

Without joints such a top nutates about its centre by lambda h, lambda = |1/I_i - 1/I_j| L, in a substep; a
joint prevents this.  The change of J v after the impulses at the midpoint, and the displacement of the arms,
are therefore computed from the free rotation, started with the impulses of the last substep: the velocity of
an arm is that of its chord from this midpoint to the next, which averages the nutation.  A top in steady
precession is thus reproduced at any lambda h.
"""

from __future__ import annotations

from typing import Any

from ...core.rows import EQUATION
from ...jit import njit
from ..math import Vec, add, cross, norm, scaled, sub, turned, vec
from ..rotation import expected_spin, in_world, spin_change, spin_of
from .gyroscopic_axes import set_axis_biases, set_axis_errors
from .point import arm, bend_across, rotation_after

NUTATES = (
    0.1  # fraction of an arm's speed that the body's own inertia changes in a substep, above which these terms apply
)
_ZERO = (0.0, 0.0, 0.0)


@njit
def _arm_after(body: Any, parameters: Any, substep_body: Any, anchor: Any, w: Vec, h: Any, t: Any) -> Vec:
    """Return the arm of an anchor ``t`` s after the midpoint, if the body rotates freely from w, rad/s in the world."""
    local = sub(vec(anchor), vec(parameters.center))
    return turned(rotation_after(body, parameters, substep_body, w, h, t), local)


@njit
def _chord(body: Any, parameters: Any, substep_body: Any, anchor: Any, velocity: Any, h: Any) -> Vec:
    """Return the mean velocity in m/s of an arm from this midpoint to the next, minus w x r.

    ``velocity``: in the body's frame, after the impulses.
    """
    if parameters.inv_mass <= 0.0:
        return _ZERO
    w = in_world(substep_body, expected_spin(substep_body, velocity))
    here = _arm_after(body, parameters, substep_body, anchor, w, h, 0.0)
    chord = sub(_arm_after(body, parameters, substep_body, anchor, w, h, h), here)
    half = min(
        0.5 * norm(chord) / max(norm(here), 1e-300), 1.0
    )  # sine of half the angle; the arc is longer than the chord
    longer = 1.0 + half * half / 6.0
    return sub(scaled(chord, longer / h), cross(w, here))


@njit
def _drift(body: Any, parameters: Any, substep_body: Any, anchor: Any, h: Any) -> Vec:
    """Return the displacement of an arm in the substep beyond that of the mean velocity, divided by h, m/s."""
    if parameters.inv_mass <= 0.0:
        return _ZERO
    w = in_world(substep_body, spin_of(body.velocity))
    mean = scaled(add(w, in_world(substep_body, spin_of(substep_body.start_velocity))), 0.5)
    here = _arm_after(body, parameters, substep_body, anchor, w, h, 0.0)
    end = _arm_after(body, parameters, substep_body, anchor, w, h, 0.5 * h)
    start = arm(body, parameters, anchor)
    return sub(scaled(sub(end, start), 1.0 / h), cross(mean, here))


@njit
def _nutates(body: Any, parameters: Any, substep_body: Any, anchor: Any, h: Any) -> Any:
    """Whether a body's own inertia changes the velocity of an arm by more than NUTATES within the substep."""
    if substep_body.rotated_frame == 0:
        return False
    w = in_world(substep_body, spin_of(substep_body.start_velocity))
    change = in_world(substep_body, spin_change(substep_body, parameters))
    to_anchor = arm(body, parameters, anchor)
    return h * norm(bend_across(w, change, to_anchor)) > NUTATES * norm(cross(w, to_anchor))


@njit
def _is_point(
    rows: Any, r: Any, end: Any, joint_parameters: Any, bodies: Any, body_parameters: Any, substep_bodies: Any, h: Any
) -> Any:
    """Whether rows r to r + 2 connect anchors of a nutating body, at the pose of the midpoint."""
    row = rows[r]
    if row.kind != EQUATION or row.softness > 0.0 or row.slot != 0 or r + 2 >= end:
        return False
    if rows[r + 1].source != row.source or rows[r + 2].source != row.source or rows[r + 2].slot != 2:
        return False
    if row.bias == 0.0 and rows[r + 1].bias == 0.0 and rows[r + 2].bias == 0.0:
        return False  # these rows are at the pose of the start
    p = joint_parameters[row.source]
    a = row.body_a
    b = row.body_b
    return _nutates(bodies[a], body_parameters[a], substep_bodies[a], p.anchor_a, h) or _nutates(
        bodies[b], body_parameters[b], substep_bodies[b], p.anchor_b, h
    )


@njit
def set_gyroscopic_biases(world: Any, island: Any) -> None:
    """Set the biases of rows of nutating bodies; the solver bodies contain the impulses of the warm start."""
    rows = world.scratch.rows
    joint_parameters = world.parameters.joints
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    solver_bodies = world.scratch.solver_bodies
    end = island.joint_rows
    h = island.h
    for r in range(end):
        if not _is_point(rows, r, end, joint_parameters, bodies, body_parameters, substep_bodies, h):
            continue
        p = joint_parameters[rows[r].source]
        a = rows[r].body_a
        b = rows[r].body_b
        bias = sub(
            _chord(bodies[b], body_parameters[b], substep_bodies[b], p.anchor_b, solver_bodies[b].velocity, h),
            _chord(bodies[a], body_parameters[a], substep_bodies[a], p.anchor_a, solver_bodies[a].velocity, h),
        )
        for k in range(3):
            rows[r + k].bias = bias[k]
    _add_axis_biases(world, island, world.variant.axes)


@njit
def _add_axis_biases(world: Any, island: Any, axes: Any) -> None:
    """Set the biases of rows between axes; ``axes`` is None in a scene without joints with axes."""
    if axes is not None:
        set_axis_biases(world, island)


@njit
def _add_axis_errors(world: Any, island: Any, axes: Any) -> None:
    if axes is not None:
        set_axis_errors(world, island)


@njit
def set_gyroscopic_errors(world: Any, island: Any) -> None:
    """Set ``drive`` of rows of nutating bodies: displacement of the anchors beyond the mean velocity, over h."""
    rows = world.scratch.rows
    joint_parameters = world.parameters.joints
    bodies = world.state.bodies
    body_parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    end = island.joint_rows
    h = island.h
    for r in range(end):
        if not _is_point(rows, r, end, joint_parameters, bodies, body_parameters, substep_bodies, h):
            continue
        p = joint_parameters[rows[r].source]
        a = rows[r].body_a
        b = rows[r].body_b
        drift = sub(
            _drift(bodies[b], body_parameters[b], substep_bodies[b], p.anchor_b, h),
            _drift(bodies[a], body_parameters[a], substep_bodies[a], p.anchor_a, h),
        )
        for k in range(3):
            rows[r + k].drive = drift[k]
    _add_axis_errors(world, island, world.variant.axes)
