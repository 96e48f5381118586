"""Pose and bounding box of a 3D shape."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..jit import njit
from .kinds import CYLINDER, HEIGHTFIELD, HULL, PLANE
from .math import Pose, Quaternion, Vec, add, multiply, pose_of, quaternion, sub, to_world, turned, vec


@njit
def shape_place(body: Any, body_parameter: Any, shape_parameter: Any) -> tuple[Vec, Quaternion]:
    """Return position and rotation of a shape in the world; `body.position` is the centre of mass."""
    q = quaternion(body.rotation)
    offset = sub(vec(shape_parameter.local_position), vec(body_parameter.center))
    return add(vec(body.position), turned(q, offset)), multiply(q, quaternion(shape_parameter.local_rotation))


@njit
def place_shape(entry: Any, body: Any, body_parameter: Any, shape_parameter: Any) -> Pose:
    """Write the world pose of a shape to its record of geometry."""
    at, q = shape_place(body, body_parameter, shape_parameter)
    for d in range(3):
        entry.position[d] = at[d]
    for d in range(4):
        entry.rotation[d] = q[d]
    return pose_of(at, q)


@njit
def pose_in(entry: Any) -> Pose:
    """Return the world pose of a shape from its record of geometry."""
    return pose_of(vec(entry.position), quaternion(entry.rotation))


@njit
def half_widths(shape_model: Any, shape_parameter: Any, pose: Pose) -> Vec:
    """Return the half-widths of the bounding box of a round or box-like shape, m: |R| size plus the radius."""
    s = shape_parameter.size
    r = shape_parameter.radius
    x, y, z = pose.x, pose.y, pose.z
    rx = r
    ry = r
    rz = r
    if shape_model.kind == CYLINDER:  # a disc extends r sqrt(1 - z^2) along an axis
        rx = r * np.sqrt(max(1.0 - z[0] * z[0], 0.0))
        ry = r * np.sqrt(max(1.0 - z[1] * z[1], 0.0))
        rz = r * np.sqrt(max(1.0 - z[2] * z[2], 0.0))
    return (
        abs(x[0]) * s[0] + abs(y[0]) * s[1] + abs(z[0]) * s[2] + rx,
        abs(x[1]) * s[0] + abs(y[1]) * s[1] + abs(z[1]) * s[2] + ry,
        abs(x[2]) * s[0] + abs(y[2]) * s[1] + abs(z[2]) * s[2] + rz,
    )


@njit
def bounding_box(shape_model: Any, shape_parameter: Any, vertices: Any, pose: Pose) -> tuple[Vec, Vec]:
    """Return the (lower, upper) corners of the bounding box of a shape at `pose`, in m."""
    if shape_model.kind == PLANE:
        return (-np.inf, -np.inf, -np.inf), (np.inf, np.inf, np.inf)
    if vertices is not None:
        if shape_model.kind == HULL or shape_model.kind == HEIGHTFIELD:
            return _vertex_box(shape_model, vertices, pose)
    half = half_widths(shape_model, shape_parameter, pose)
    return sub(pose.at, half), add(pose.at, half)


@njit
def _vertex_box(shape_model: Any, vertices: Any, pose: Pose) -> tuple[Vec, Vec]:
    """Return the box of a hull's vertices, or of a heightfield's grid, whose heights are in its first normal."""
    first = shape_model.vertex_first
    if shape_model.kind == HEIGHTFIELD:
        entry = vertices[first]
        count = entry.columns * entry.rows
        one = vec(entry.position)
        last = vec(vertices[first + count - 1].position)
        low, high = entry.normal[0], entry.normal[1]
        mx, my, mz = 0.5 * (one[0] + last[0]), 0.5 * (one[1] + last[1]), 0.5 * (low + high)
        hx, hy, hz = abs(last[0] - mx), abs(last[1] - my), high - mz
        x, y, z = pose.x, pose.y, pose.z
        middle = to_world(pose, (mx, my, mz))
        half = (
            abs(x[0]) * hx + abs(y[0]) * hy + abs(z[0]) * hz,
            abs(x[1]) * hx + abs(y[1]) * hy + abs(z[1]) * hz,
            abs(x[2]) * hx + abs(y[2]) * hy + abs(z[2]) * hz,
        )
        return sub(middle, half), add(middle, half)
    x0, y0, z0 = np.inf, np.inf, np.inf
    x1, y1, z1 = -np.inf, -np.inf, -np.inf
    for i in range(first, first + vertices[first].vertex_count):
        p = vec(vertices[i].position)
        q = to_world(pose, p)
        x0, y0, z0 = min(x0, q[0]), min(y0, q[1]), min(z0, q[2])
        x1, y1, z1 = max(x1, q[0]), max(y1, q[1]), max(z1, q[2])
    return (x0, y0, z0), (x1, y1, z1)
