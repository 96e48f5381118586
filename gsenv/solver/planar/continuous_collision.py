"""Continuous collision in 2D: motions over a step, swept boxes, gaps; see core/continuous_collision.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64
from numpy.typing import NDArray

from ..core.geometry import MovingShape, PlacedShape, placed, swing_of
from ..jit import njit
from .geometry import Point, bounding_box
from .kinds import TERRAIN
from .math import Pose, rotate, turn
from .narrowphase.find import chain_contacts
from .narrowphase.motion import Motion
from .narrowphase.table import CHAINS, NONE, PAIR_TABLE, collide

Array = NDArray[Any]


@njit
def motion_between(start: Any, body: Any, parameter: Any) -> Motion:
    """Return the motion of a body in the step, as one of unit time."""
    return Motion(
        start.position[0],
        start.position[1],
        body.position[0] - start.position[0],
        body.position[1] - start.position[1],
        body.angle - start.angle,
        swing_of(parameter),
    )


@njit
def no_motion(start: Any) -> Motion:
    """Return the motion of a body at rest; ``start`` only determines the dimension."""
    return Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@njit
def move_back(body: Any, start: Any, motion: Motion, time: float) -> None:
    """Move a body back to its pose after a fraction ``time`` of the step."""
    body.position[0] = motion.x + motion.velocity_x * time
    body.position[1] = motion.y + motion.velocity_y * time
    body.angle = start.angle + motion.spin * time
    body.rotation[0], body.rotation[1] = turn(start.rotation[0], start.rotation[1], motion.spin * time)


@njit
def move_with(body: Any, motion: Motion, rest: float) -> None:
    """Do nothing: in 2D contacts of the next step push a body that has hit a kinematic one."""


@njit
def start_pose(start: Any, body_parameter: Any, parameter: Any) -> Pose:
    """Return the pose of a shape before the step; see geometry.shape_pose."""
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
def swept_box(
    shape_model: Any, parameter: Any, vertices: Array | None, pose: Pose, motion: Motion, radius: float
) -> tuple[Point, Point]:
    """Return the bounding box of a shape over the whole motion, in m."""
    (x0, y0), (x1, y1) = bounding_box(shape_model, parameter, vertices, pose)
    way_x = motion.velocity_x
    way_y = motion.velocity_y
    spin = abs(motion.spin)
    arc = min(spin, 2.0) * radius if spin > 0.0 else 0.0  # a half-plane's radius is infinite
    return (
        (x0 + min(way_x, 0.0) - arc, y0 + min(way_y, 0.0) - arc),
        (x1 + max(way_x, 0.0) + arc, y1 + max(way_y, 0.0) + arc),
    )


@njit
def gap(
    shapes: Any, a: MovingShape, b: MovingShape, time: float, swing: float, narrowphase: Any
) -> tuple[float, float]:
    """Return (separation in m of two shapes after ``time``, largest speed at which it can close).

    ``swing``: largest contribution of rotation to the speed.
    """
    one = placed(a, time)
    other = placed(b, time)
    routine = PAIR_TABLE[shapes.models[a.number].kind, shapes.models[b.number].kind]
    nx, ny, separation = 0.0, 1.0, np.inf
    if routine != CHAINS and routine != NONE:
        m = collide(shapes, shapes.vertices, one, other, 1e300)
        nx, ny, separation = m.normal_x, m.normal_y, m.separation
    elif routine == CHAINS and shapes.models[b.number].kind == TERRAIN:
        nx, ny, separation = terrain_gap(shapes, shapes.vertices, one, other, narrowphase)
    speed = swing + nx * (a.motion.velocity_x - b.motion.velocity_x)
    return separation, speed + ny * (a.motion.velocity_y - b.motion.velocity_y)


@njit
def terrain_gap(
    shapes: Any, vertices: Array | None, shape: PlacedShape, terrain: PlacedShape, narrowphase: Any
) -> tuple[float, float, float]:
    """Return (normal from the shape to the terrain, separation in m) at any distance."""
    if vertices is None:
        return 0.0, 1.0, np.inf
    still = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    tally = chain_contacts(
        shapes,
        vertices,
        MovingShape(terrain.number, terrain.pose, still, 0.0),
        MovingShape(shape.number, shape.pose, still, 0.0),
        1e300,
        0.0,
        narrowphase.no_contacts,
        int64(0),
    )
    nx, ny = rotate(terrain.pose.cos, terrain.pose.sin, tally.normal_x, tally.normal_y)
    return -nx, -ny, tally.separation
