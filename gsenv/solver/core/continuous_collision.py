"""Continuous collision: moves marked bodies back to their first time of impact, so that they pass through nothing.

The time of impact of a pair is found by conservative advancement from its old poses: each advance is at most
the gap divided by the largest speed at which it can close.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..jit import njit
from .broadphase import may_touch
from .dispatch import by_dimension
from .geometry import DYNAMIC, KINEMATIC, STATIC, MovingShape, bounding_box, placed, swing_speed
from .integrate import copy_pose

MAX_ADVANCES = 256
TURN = 0.1  # rad: rotation of a body between two checks
TOUCHING = 0.005  # of the extent: a gap up to this counts as a hit
DEPTH = 0.1  # of the extent: hits that go no deeper are left to the contacts of the next step


@njit
def stay(body: Any, motion: Any, rest: float) -> None:
    """Do nothing: contacts of the next step push a body that has hit a kinematic one."""


motion_between = by_dimension("continuous_collision", "motion_between")
no_motion = by_dimension("continuous_collision", "no_motion")
start_pose = by_dimension("continuous_collision", "start_pose")
widened = by_dimension("continuous_collision", "widened")
gap = by_dimension("continuous_collision", "gap")
move_back = by_dimension("continuous_collision", "move_back")
move_with = by_dimension("continuous_collision", "move_with", otherwise=stay)
spin_rate = by_dimension("narrowphase.motion", "spin_rate")


@njit
def keep_start(world: Any, start_poses: Any) -> None:
    """Store the poses of the bodies in `start_poses` (body,) of start_pose_dtype; None where no body is continuous."""
    if start_poses is None:
        return
    bodies = world.state.bodies
    for b in range(len(bodies)):
        copy_pose(bodies[b], start_poses[b])


@njit
def resolve_continuous_collisions(world: Any, start_poses: Any) -> int:
    """Move continuous dynamic bodies back to their time of impact after a step; returns the number of these bodies.

    Motions are relative: all other bodies move from their old to their new pose.  `start_poses` are those
    that keep_start stored before the step.  The next step finds the hit as a contact.  The body loses the rest
    of the step, so the velocity that gravity and forces added in that time is subtracted.
    """
    if start_poses is None:
        return 0
    bodies = world.state.bodies
    models = world.model.bodies
    parameters = world.parameters.bodies
    substep_bodies = world.scratch.substep_bodies
    moved = 0
    for b in range(len(bodies)):
        if models[b].continuous == 0 or models[b].kind != DYNAMIC:
            continue
        if parameters[b].enabled == 0 or bodies[b].asleep != 0:
            continue
        motion = motion_between(start_poses[b], bodies[b], parameters[b])
        time, hit = first_hit(world, start_poses, b, motion)
        if time < 1.0:
            move_back(bodies[b], start_poses[b], motion, time)
            if models[hit].kind == KINEMATIC:
                move_with(bodies[b], motion_between(start_poses[hit], bodies[hit], parameters[hit]), 1.0 - time)
            bodies[b].sleep_time = 0.0  # its contacts are those of another place
            lost = (1.0 - time) * world.options.timestep  # s that the body does not move in
            for axis in range(3):  # the whole velocity in 2D, the linear part in 3D
                bodies[b].velocity[axis] -= lost * substep_bodies[b].acceleration[axis]
            moved += 1
    return moved


@njit
def first_hit(world: Any, start_poses: Any, b: int, motion: Any) -> tuple[float, int]:
    """Return the fraction of the step after which a shape of body b first hits another, else 1; and the other body."""
    shapes = world.shapes
    models = shapes.models
    parameters = shapes.parameters
    bodies = world.state.bodies
    body_models = world.model.bodies
    body_parameters = world.parameters.bodies
    geometry = world.scratch.geometry
    time = 1.0
    hit = int64(b)
    first = body_models[b].shape_first
    for k in range(first, first + body_models[b].shape_count):
        if geometry[k].active == 0 or models[k].sensor != 0:
            continue
        pose = start_pose(start_poses[b], body_parameters[b], parameters[k])
        one = MovingShape(int64(k), pose, motion, body_parameters[b].inv_mass)
        lower, upper = swept_box(models[k], parameters[k], shapes.vertices, pose, motion, body_parameters[b].radius)
        for other in range(len(models)):
            if geometry[other].active == 0 or models[other].sensor != 0:
                continue
            if not may_touch(models[k], models[other], world.model.exclusions):
                continue
            body = models[other].body
            parameter = body_parameters[body]
            other_motion = no_motion(start_poses[body])
            if body_models[body].kind != STATIC:
                other_motion = motion_between(start_poses[body], bodies[body], parameter)
            other_pose = start_pose(start_poses[body], parameter, parameters[other])
            low, high = swept_box(
                models[other], parameters[other], shapes.vertices, other_pose, other_motion, parameter.radius
            )
            if boxes_apart(lower, upper, low, high):
                continue
            before = time
            two = MovingShape(int64(other), other_pose, other_motion, parameter.inv_mass)
            time = hit_time(shapes, one, two, body_parameters[b].extent, time, world.scratch.narrowphase)
            if time < before:
                hit = int64(body)
    return time, hit


@njit
def swept_box(shape_model: Any, parameter: Any, vertices: Any, pose: Any, motion: Any, radius: float) -> Any:
    """Return the bounding box (lower, upper) of a shape over the whole motion, in m; `radius`: that of its body."""
    lower, upper = bounding_box(shape_model, parameter, vertices, pose)
    spin = spin_rate(motion)
    arc = min(spin, 2.0) * radius if spin > 0.0 else 0.0  # the radius of a half-plane or plane is infinite
    return widened(lower, upper, motion, arc)


@njit
def boxes_apart(lower: Any, upper: Any, low: Any, high: Any) -> bool:
    for d in range(len(lower)):
        if low[d] > upper[d] or high[d] < lower[d]:
            return True
    return False


@njit
def hit_time(shapes: Any, a: MovingShape, b: MovingShape, extent: float, latest: float, narrowphase: Any) -> float:
    """Return the fraction of the step at which moving shapes a and b first touch; `latest` if not before that.

    A hit after which the motion would end less than DEPTH below the surface does not count: that is resting
    and sliding, which contacts resolve.
    """
    time = 0.0
    spins = spin_rate(a.motion) + spin_rate(b.motion)
    swing = swing_speed(a, b)
    for _ in range(MAX_ADVANCES):
        separation, speed = gap_after(shapes, a, b, time, swing, narrowphase)
        if not separation < np.inf:
            return latest
        if speed * (latest - time) <= max(separation, 0.0):
            return latest
        if separation <= TOUCHING * extent:
            # the bound above counts rotation as approach; the true rate tells whether this is a hit
            # (measured over a span short against the body, which may be thinner than its own displacement)
            probe = min(0.01 * (1.0 - time), 0.05 * extent / speed)
            soon, _ = gap_after(shapes, a, b, time + probe, swing, narrowphase)
            if (separation - soon) / probe * (1.0 - time) > separation + DEPTH * extent:
                return time
            # a tip that moves away may return within the step
            if swing == 0.0:
                return latest
            time += TURN / spins
            if time >= latest:
                return latest
            continue
        time += (separation - 0.5 * TOUCHING * extent) / speed
    return time


@njit
def gap_after(
    shapes: Any, a: MovingShape, b: MovingShape, time: float, swing: float, narrowphase: Any
) -> tuple[float, float]:
    """Return (separation in m of two shapes after ``time``, largest speed at which it can close).

    ``swing``: largest contribution of rotation to the speed.
    """
    return gap(shapes, placed(a, time), placed(b, time), a.motion, b.motion, swing, narrowphase)
