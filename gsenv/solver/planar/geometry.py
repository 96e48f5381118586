"""Pose and bounding box of a 2D shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..jit import inline_njit, njit
from .kinds import HALF_PLANE, POLYGON, TERRAIN
from .math import Pose, to_world

Point = tuple[float, float]  # m


@njit
def shape_pose(body: Any, body_parameter: Any, shape_parameter: Any) -> Pose:
    """Return the world pose of a shape; `body.position` is the centre of mass."""
    cos = body.rotation[0]
    sin = body.rotation[1]
    local = shape_parameter.local_rotation
    x = shape_parameter.local_position[0] - body_parameter.center[0]
    y = shape_parameter.local_position[1] - body_parameter.center[1]
    return Pose(
        body.position[0] + cos * x - sin * y,
        body.position[1] + sin * x + cos * y,
        cos * local[0] - sin * local[1],
        sin * local[0] + cos * local[1],
    )


@njit
def place_shape(entry: Any, body: Any, body_parameter: Any, shape_parameter: Any) -> Pose:
    """Write the world pose of a shape into its record of geometry."""
    pose = shape_pose(body, body_parameter, shape_parameter)
    entry.position[0] = pose.x
    entry.position[1] = pose.y
    entry.rotation[0] = pose.cos
    entry.rotation[1] = pose.sin
    return pose


@inline_njit
def pose_in(entry: Any) -> Pose:
    """Return the world pose of a shape from its record of geometry."""
    return Pose(entry.position[0], entry.position[1], entry.rotation[0], entry.rotation[1])


@njit
def bounding_box(shape_model: Any, shape_parameter: Any, vertices: Any, pose: Pose) -> tuple[Point, Point]:
    """Return the (lower, upper) corners of the bounding box of a shape at `pose`, in m."""
    if shape_model.kind == HALF_PLANE:
        return (-np.inf, -np.inf), (np.inf, np.inf)
    x = pose.x
    y = pose.y
    half_x = shape_parameter.size[0]
    half_y = shape_parameter.size[1]
    if vertices is not None:
        if shape_model.kind == POLYGON:
            return polygon_box(shape_model, vertices, pose)
        if shape_model.kind == TERRAIN:
            root = vertices[shape_model.vertex_first]
            half_x = 0.5 * (root.node_upper[0] - root.node_lower[0])
            half_y = 0.5 * (root.node_upper[1] - root.node_lower[1])
            x, y = to_world(pose, root.node_lower[0] + half_x, root.node_lower[1] + half_y)
    wide = abs(pose.cos) * half_x + abs(pose.sin) * half_y + shape_parameter.radius
    high = abs(pose.sin) * half_x + abs(pose.cos) * half_y + shape_parameter.radius
    return (x - wide, y - high), (x + wide, y + high)


@njit
def polygon_box(shape_model: Any, vertices: Any, pose: Pose) -> tuple[Point, Point]:
    lower_x = np.inf
    lower_y = np.inf
    upper_x = -np.inf
    upper_y = -np.inf
    for i in range(shape_model.vertex_first, shape_model.vertex_first + shape_model.vertex_count):
        x, y = to_world(pose, vertices[i].position[0], vertices[i].position[1])
        lower_x = min(lower_x, x)
        lower_y = min(lower_y, y)
        upper_x = max(upper_x, x)
        upper_y = max(upper_y, y)
    return (lower_x, lower_y), (upper_x, upper_y)
