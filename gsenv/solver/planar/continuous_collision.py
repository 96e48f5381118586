"""Continuous collision in 2D: motions over a step, swept boxes, gaps; see core/continuous_collision.py."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import int64

from ..core.geometry import MovingShape, PlacedShape, swing_of
from ..jit import njit
from ..records.model import Array
from .geometry import Point
from .kinds import TERRAIN
from .math import Pose, rotate, turn
from .narrowphase.find import chain_contacts
from .narrowphase.motion import Motion
from .narrowphase.table import CHAINS, NONE, PAIR_TABLE, collide


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
def widened(lower: Point, upper: Point, motion: Motion, arc: float) -> tuple[Point, Point]:
    """Return a box that holds another one over a motion, m: moved along, and grown by `arc` on each side."""
    way_x = motion.velocity_x
    way_y = motion.velocity_y
    return (
        (lower[0] + min(way_x, 0.0) - arc, lower[1] + min(way_y, 0.0) - arc),
        (upper[0] + max(way_x, 0.0) + arc, upper[1] + max(way_y, 0.0) + arc),
    )


@njit
def gap(
    shapes: Any, a: PlacedShape, b: PlacedShape, of_a: Motion, of_b: Motion, swing: float, narrowphase: Any
) -> tuple[float, float]:
    """Return (separation in m of two shapes, largest speed at which it can close); `of_a`, `of_b`: their motions."""
    routine = PAIR_TABLE[shapes.models[a.number].kind, shapes.models[b.number].kind]
    nx, ny, separation = 0.0, 1.0, np.inf
    if routine != CHAINS and routine != NONE:
        m = collide(shapes, shapes.vertices, a, b, 1e300)
        nx, ny, separation = m.normal_x, m.normal_y, m.separation
    elif routine == CHAINS and shapes.models[b.number].kind == TERRAIN:
        nx, ny, separation = terrain_gap(shapes, shapes.vertices, a, b, narrowphase)
    speed = swing + nx * (of_a.velocity_x - of_b.velocity_x)
    return separation, speed + ny * (of_a.velocity_y - of_b.velocity_y)


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
