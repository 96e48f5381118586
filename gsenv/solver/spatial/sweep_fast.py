"""Fast bodies: put back to where they first hit something that they would have passed through."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.broadphase import may_touch
from gsenv.solver.jit import njit
from gsenv.solver.spatial.geometry import DYNAMIC, bounding_box
from gsenv.solver.spatial.integrate import turn_body
from gsenv.solver.spatial.kinds import HEIGHTFIELD
from gsenv.solver.spatial.math import (
    Pose,
    Vec,
    add,
    along,
    conjugate,
    dot,
    multiply,
    norm,
    pose_of,
    quaternion,
    scaled,
    sub,
    turn_between,
    turned,
    vec,
)
from gsenv.solver.spatial.narrowphase.heightfields import heightfield_gap
from gsenv.solver.spatial.narrowphase.motion import Motion, advanced, at_rest, swing_of
from gsenv.solver.spatial.narrowphase.table import FIELDS, NONE, PAIR_TABLE, collide

Array = NDArray[Any]

MAX_ADVANCES = 256
TURN = 0.1  # rad: so far a body turns between two looks
TOUCHING = 0.005  # of the extent: this near counts as hit
DEPTH = 0.1  # of the extent: what would not go deeper is left to the contacts of the next step


def sweep_start_dtype() -> np.dtype[Any]:
    """Where a body was before the step."""
    return np.dtype([("position", "f8", (3,)), ("rotation", "f8", (4,))], align=True)


@njit
def keep_start(bodies: Array, start: Array) -> None:
    """Remember in `start` (body,) of sweep_start_dtype() where the bodies are."""
    for b in range(len(bodies)):
        for d in range(3):
            start[b].position[d] = bodies[b].position[d]
        for d in range(4):
            start[b].rotation[d] = bodies[b].rotation[d]


@njit
def sweep_fast_bodies(
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    geometry: Array,
    exclusions: Array | None,
    start: Array,
    motions: Array,
    timestep: float,
    manifolds: Array,
    scratches: Array,
    field_scratch: Array | None,
    convex: Any,
) -> int:
    """After a step: stop fast dynamic bodies at their time of impact; returns how many.

    See planar/sweep_fast.py; `manifolds`, `scratches` (1,) are scratch.
    """
    moved = 0
    for b in range(len(bodies)):
        if body_models[b].fast == 0 or body_models[b].kind != DYNAMIC:
            continue
        if body_parameters[b].enabled == 0 or bodies[b].asleep != 0:
            continue
        motion = motion_between(start[b], bodies[b], body_parameters[b])
        time = first_hit(
            b, motion, bodies, body_models, body_parameters, shape_models, shape_parameters,
            vertices, geometry, exclusions, start, manifolds, scratches, field_scratch, convex,
        )  # fmt: skip
        if time < 1.0:
            put_back(bodies[b], start[b], motion, time)
            lost = (1.0 - time) * timestep  # it has not lived through this time: no fall, no speed
            for axis in range(3):
                bodies[b].velocity[axis] -= lost * motions[b].acceleration[axis]
            moved += 1
    return moved


@njit
def motion_between(start: Any, body: Any, parameter: Any) -> Motion:
    """The step as a motion of unit time."""
    at = vec(start.position)
    turn = turn_between(quaternion(start.rotation), quaternion(body.rotation))
    return Motion(at, sub(vec(body.position), at), turn, swing_of(parameter))


@njit
def put_back(body: Any, start: Any, motion: Motion, time: float) -> None:
    """Also the angular velocity, which stands still in the body meanwhile: in the world its energy would change."""
    at = along(motion.at, time, motion.velocity)
    spin = (body.velocity[3], body.velocity[4], body.velocity[5])
    spin = turned(conjugate(quaternion(body.rotation)), spin)
    turn_body(body, start.rotation, scaled(motion.spin, time))
    spin = turned(quaternion(body.rotation), spin)
    for d in range(3):
        body.position[d] = at[d]
        body.velocity[3 + d] = spin[d]


@njit
def start_pose(start: Any, body_parameter: Any, parameter: Any) -> Pose:
    """Pose of a shape of the body before the step; see geometry.shape_place."""
    q = quaternion(start.rotation)
    offset = turned(q, sub(vec(parameter.local_position), vec(body_parameter.center)))
    return pose_of(add(vec(start.position), offset), multiply(q, quaternion(parameter.local_rotation)))


@njit
def swept_box(
    shape_model: Any, parameter: Any, vertices: Array | None, pose: Pose, motion: Motion, radius: float
) -> tuple[Vec, Vec]:
    """Box of a shape over the whole motion."""
    lower, upper = bounding_box(shape_model, parameter, vertices, pose)
    spin = norm(motion.spin)
    swing = min(spin, 2.0) * radius if spin > 0.0 else 0.0  # a plane's radius is infinite
    v = motion.velocity
    return (
        (lower[0] + min(v[0], 0.0) - swing, lower[1] + min(v[1], 0.0) - swing, lower[2] + min(v[2], 0.0) - swing),
        (upper[0] + max(v[0], 0.0) + swing, upper[1] + max(v[1], 0.0) + swing, upper[2] + max(v[2], 0.0) + swing),
    )


@njit
def first_hit(
    b: int,
    motion: Motion,
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    geometry: Array,
    exclusions: Array | None,
    start: Any,
    manifolds: Array,
    scratches: Array,
    field_scratch: Array | None,
    convex: Any,
) -> float:
    """Part of the step after which a shape of body b hits something; 1 if none does."""
    time = 1.0
    model = body_models[b]
    for k in range(model.shape_first, model.shape_first + model.shape_count):
        if geometry[k].active == 0 or shape_models[k].sensor != 0:
            continue
        pose = start_pose(start[b], body_parameters[b], shape_parameters[k])
        lower, upper = swept_box(
            shape_models[k], shape_parameters[k], vertices, pose, motion, body_parameters[b].radius
        )
        for other in range(len(shape_models)):
            if geometry[other].active == 0 or shape_models[other].sensor != 0:
                continue
            if not may_touch(shape_models[k], shape_models[other], exclusions):
                continue
            body = shape_models[other].body
            other_motion = at_rest()
            if body_models[body].kind != 0:
                other_motion = motion_between(start[body], bodies[body], body_parameters[body])
            other_pose = start_pose(start[body], body_parameters[body], shape_parameters[other])
            low, high = swept_box(
                shape_models[other], shape_parameters[other], vertices, other_pose, other_motion,
                body_parameters[body].radius,
            )  # fmt: skip
            if low[0] > upper[0] or low[1] > upper[1] or low[2] > upper[2]:
                continue
            if high[0] < lower[0] or high[1] < lower[1] or high[2] < lower[2]:
                continue
            time = hit_time(
                shape_models, shape_parameters, vertices, k, other, pose, other_pose, motion, other_motion,
                body_parameters[b].extent, time, manifolds, scratches, field_scratch, convex,
            )  # fmt: skip
    return time


@njit
def hit_time(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    motion: Motion,
    motion_b: Motion,
    extent: float,
    latest: float,
    manifolds: Array,
    scratches: Array,
    field_scratch: Array | None,
    convex: Any,
) -> float:
    """When shape a first hits shape b, both moving; `latest` if not before that.

    A hit whose motion would end less than DEPTH behind the surface is none: that is resting and
    sliding, and is dealt with by contacts.
    """
    time = 0.0
    field = PAIR_TABLE[shape_models[a].kind, shape_models[b].kind] == FIELDS
    spins = norm(motion.spin) + norm(motion_b.spin)
    swing = norm(motion.spin) * motion.swing + norm(motion_b.spin) * motion_b.swing
    for _ in range(MAX_ADVANCES):
        normal, separation = gap(
            shape_models, shape_parameters, vertices, a, b,
            advanced(pose_a, motion, time), advanced(pose_b, motion_b, time),
            manifolds, scratches, field_scratch, convex,
        )  # fmt: skip
        if not separation < np.inf:
            return latest
        relative = sub(motion.velocity, motion_b.velocity)
        # to a field the distance is known, but not its direction
        speed = swing + (norm(relative) if field else dot(normal, relative))
        if speed * (latest - time) <= max(separation, 0.0):
            return latest
        if separation <= TOUCHING * extent:
            # the bound above counts spin as approach; whether this is a hit, the true rate says
            # (looked at over a way that is short against the body, which may be thinner than its own motion)
            probe = min(0.01 * (1.0 - time), 0.05 * extent / speed)
            later = time + probe
            _, soon = gap(
                shape_models, shape_parameters, vertices, a, b,
                advanced(pose_a, motion, later), advanced(pose_b, motion_b, later),
                manifolds, scratches, field_scratch, convex,
            )  # fmt: skip
            if (separation - soon) / probe * (1.0 - time) > separation + DEPTH * extent:
                return time
            # a tip that leaves may come round again within the step
            if swing == 0.0:
                return latest
            time += TURN / spins
            if time >= latest:
                return latest
            continue
        time += (separation - 0.5 * TOUCHING * extent) / speed
    return time


@njit
def gap(
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    a: int,
    b: int,
    pose_a: Pose,
    pose_b: Pose,
    manifolds: Array,
    scratches: Array,
    field_scratch: Array | None,
    convex: Any,
) -> tuple[Vec, float]:
    """(normal from a to b, separation in m) of two shapes at any distance."""
    routine = PAIR_TABLE[shape_models[a].kind, shape_models[b].kind]
    m = manifolds[0]
    if routine != FIELDS and routine != NONE:
        collide(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, 1e300, m, scratches[0], convex)
        return vec(m.normal), m.separation
    if field_scratch is not None:
        if routine == FIELDS and shape_models[b].kind == HEIGHTFIELD:
            n, separation = heightfield_gap(
                shape_models, shape_parameters, vertices, b, a, pose_b, pose_a, 1e300, field_scratch
            )
            return (-n[0], -n[1], -n[2]), separation
    return (0.0, 0.0, 1.0), np.inf
