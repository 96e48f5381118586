"""Fast bodies: put back to where they first hit something that they would have passed through."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from gsenv.solver.broadphase import may_touch
from gsenv.solver.jit import njit
from gsenv.solver.planar.geometry import DYNAMIC, bounding_box
from gsenv.solver.planar.math import Pose, rotate, turn
from gsenv.solver.planar.narrowphase.find import chain_contacts
from gsenv.solver.planar.narrowphase.manifold import bare_manifold
from gsenv.solver.planar.narrowphase.motion import Motion, advanced
from gsenv.solver.planar.narrowphase.table import CHAINS, NONE, PAIR_TABLE, collide
from gsenv.solver.planar.shapes import TERRAIN

Array = NDArray[Any]

MAX_ADVANCES = 256
TURN = 0.1  # rad: so far a body turns between two looks
TOUCHING = 0.005  # of the extent: this near counts as hit
DEPTH = 0.1  # of the extent: what would not go deeper is left to the contacts of the next step


def sweep_start_dtype() -> np.dtype[Any]:
    """Where a body was before the step."""
    return np.dtype([("position", "f8", (2,)), ("rotation", "f8", (2,)), ("angle", "f8")], align=True)


@njit
def keep_start(bodies: Array, start: Array) -> None:
    """Remember in `start` (body,) of sweep_start_dtype() where the bodies are."""
    for b in range(len(bodies)):
        body = bodies[b]
        for axis in range(2):
            start[b].position[axis] = body.position[axis]
            start[b].rotation[axis] = body.rotation[axis]
        start[b].angle = body.angle


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
    contacts: Array,
    motions: Array,
    timestep: float,
) -> int:
    """After a step: stop fast dynamic bodies at their time of impact; returns how many.

    Motions are relative: everything else goes from its old to its new pose meanwhile.  `start` as
    keep_start left it before the step, `geometry` of this step (only `active` is read),
    `exclusions` as for find_pairs, `motions` for accelerations; `contacts` is only a type here,
    nothing is written.  The next step sees the hit as a contact.  The rest of the step is lost for
    the body, so what gravity and force gave it in that time is taken back.
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
            vertices, geometry, exclusions, start, contacts,
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
    spare = parameter.radius * parameter.radius - parameter.extent * parameter.extent
    return Motion(
        start.position[0],
        start.position[1],
        body.position[0] - start.position[0],
        body.position[1] - start.position[1],
        body.angle - start.angle,
        np.sqrt(max(spare, 0.0)),
    )


@njit
def put_back(body: Any, start: Any, motion: Motion, time: float) -> None:
    body.position[0] = motion.x + motion.velocity_x * time
    body.position[1] = motion.y + motion.velocity_y * time
    body.angle = start.angle + motion.spin * time
    body.rotation[0], body.rotation[1] = turn(start.rotation[0], start.rotation[1], motion.spin * time)


@njit
def start_pose(start: Any, body_parameter: Any, parameter: Any) -> Pose:
    """Pose of a shape of the body before the step; see geometry.shape_pose."""
    x, y = rotate(
        start.rotation[0],
        start.rotation[1],
        parameter.local_position[0] - body_parameter.center[0],
        parameter.local_position[1] - body_parameter.center[1],
    )
    cos, sin = rotate(
        start.rotation[0],
        start.rotation[1],
        parameter.local_rotation[0],
        parameter.local_rotation[1],
    )
    return Pose(start.position[0] + x, start.position[1] + y, cos, sin)


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
    contacts: Array,
) -> float:
    """Part of the step after which a shape of body b hits something; 1 if none does."""
    time = 1.0
    model = body_models[b]
    for k in range(model.shape_first, model.shape_first + model.shape_count):
        if geometry[k].active == 0 or shape_models[k].sensor != 0:
            continue
        parameter = shape_parameters[k]
        pose = start_pose(start[b], body_parameters[b], parameter)
        x0, y0, x1, y1 = bounding_box(shape_models[k], parameter, vertices, pose)
        swing = min(abs(motion.spin), 2.0) * body_parameters[b].radius
        lower_x = x0 + min(motion.velocity_x, 0.0) - swing
        lower_y = y0 + min(motion.velocity_y, 0.0) - swing
        upper_x = x1 + max(motion.velocity_x, 0.0) + swing
        upper_y = y1 + max(motion.velocity_y, 0.0) + swing
        for other in range(len(shape_models)):
            if geometry[other].active == 0 or shape_models[other].sensor != 0:
                continue
            if not may_touch(shape_models[k], shape_models[other], exclusions):
                continue
            body = shape_models[other].body
            still = body_models[body].kind == 0
            other_motion = motion_between(start[body], bodies[body], body_parameters[body])
            if still:
                other_motion = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            other_pose = start_pose(start[body], body_parameters[body], shape_parameters[other])
            x0, y0, x1, y1 = bounding_box(shape_models[other], shape_parameters[other], vertices, other_pose)
            if not still:
                sweep = min(abs(other_motion.spin), 2.0) * body_parameters[body].radius
                x0 += min(other_motion.velocity_x, 0.0) - sweep
                y0 += min(other_motion.velocity_y, 0.0) - sweep
                x1 += max(other_motion.velocity_x, 0.0) + sweep
                y1 += max(other_motion.velocity_y, 0.0) + sweep
            if x0 > upper_x or x1 < lower_x or y0 > upper_y or y1 < lower_y:
                continue
            time = hit_time(
                shape_models, shape_parameters, vertices, k, other, pose, other_pose, motion, other_motion,
                body_parameters[b].extent, time, contacts,
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
    contacts: Array,
) -> float:
    """When shape a first hits shape b, both moving; `latest` if not before that.

    A hit whose motion would end less than DEPTH behind the surface is none: that is resting and
    sliding, and is dealt with by contacts.
    """
    time = 0.0
    spin = abs(motion.spin) * motion.swing + abs(motion_b.spin) * motion_b.swing
    for _ in range(MAX_ADVANCES):
        nx, ny, separation = gap(
            shape_models, shape_parameters, vertices, a, b,
            advanced(pose_a, motion, time), advanced(pose_b, motion_b, time), contacts,
        )  # fmt: skip
        if not separation < np.inf:
            return latest
        speed = spin + nx * (motion.velocity_x - motion_b.velocity_x)
        speed += ny * (motion.velocity_y - motion_b.velocity_y)
        if speed * (latest - time) <= max(separation, 0.0):
            return latest
        if separation <= TOUCHING * extent:
            # the bound above counts spin as approach; whether this is a hit, the true rate says
            # (looked at over a way that is short against the body, which may be thinner than its own motion)
            probe = min(0.01 * (1.0 - time), 0.05 * extent / speed)
            later = time + probe
            _, _, soon = gap(
                shape_models, shape_parameters, vertices, a, b,
                advanced(pose_a, motion, later), advanced(pose_b, motion_b, later), contacts,
            )  # fmt: skip
            if (separation - soon) / probe * (1.0 - time) > separation + DEPTH * extent:
                return time
            # a tip that leaves may come round again within the step
            if spin == 0.0:
                return latest
            time += TURN / (abs(motion.spin) + abs(motion_b.spin))
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
    contacts: Array,
) -> tuple[float, float, float]:
    """(normal from a to b, separation in m) of two shapes at any distance."""
    routine = PAIR_TABLE[shape_models[a].kind, shape_models[b].kind]
    m = bare_manifold(0.0, 1.0, np.inf)
    if routine != CHAINS and routine != NONE:
        m = collide(shape_models, shape_parameters, vertices, a, b, pose_a, pose_b, 1e300)
    elif vertices is not None:
        if routine == CHAINS and shape_models[b].kind == TERRAIN:
            still = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            tally = chain_contacts(
                shape_models, shape_parameters, vertices, b, a, pose_b, pose_a,
                still, still, 1e300, 0.0, contacts[0:0], int64(0),
            )  # fmt: skip
            m = bare_manifold(-tally.normal_x, -tally.normal_y, tally.separation)
    return m.normal_x, m.normal_y, m.separation
