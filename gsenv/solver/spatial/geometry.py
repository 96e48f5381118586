"""Where each shape is now, and the box that it can reach within the step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.model import BodyKind
from gsenv.solver.spatial.kinds import CYLINDER, HEIGHTFIELD, HULL, PLANE
from gsenv.solver.spatial.math import (
    Pose,
    Quaternion,
    Vec,
    add,
    multiply,
    norm,
    pose_of,
    quaternion,
    sub,
    to_world,
    turned,
    vec,
)

Array = NDArray[Any]

DYNAMIC = int(BodyKind.DYNAMIC)
KINEMATIC = int(BodyKind.KINEMATIC)
STATIC = int(BodyKind.STATIC)
BASE_MARGIN = 0.02  # of a body's extent: contacts this near are kept even at rest


@njit
def shape_place(body: Any, body_parameter: Any, shape_parameter: Any) -> tuple[Vec, Quaternion]:
    """Where a shape's frame is in the world; `body.position` is the centre of mass."""
    q = quaternion(body.rotation)
    offset = sub(vec(shape_parameter.local_position), vec(body_parameter.center))
    return add(vec(body.position), turned(q, offset)), multiply(q, quaternion(shape_parameter.local_rotation))


@njit
def half_widths(shape_model: Any, shape_parameter: Any, pose: Pose) -> Vec:
    """Half of the bounding box of a round or box-like shape, m: |R| size, and what is round around it."""
    s = shape_parameter.size
    r = shape_parameter.radius
    x, y, z = pose.x, pose.y, pose.z
    rx = r
    ry = r
    rz = r
    if shape_model.kind == CYLINDER:  # a disc reaches r sqrt(1 - z^2) along an axis
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
    """(lower, upper) corner of the box around a shape at `pose`, m."""
    if shape_model.kind == PLANE:
        return (-np.inf, -np.inf, -np.inf), (np.inf, np.inf, np.inf)
    if vertices is not None:
        if shape_model.kind == HULL or shape_model.kind == HEIGHTFIELD:
            return _vertex_box(shape_model, vertices, pose)
    half = half_widths(shape_model, shape_parameter, pose)
    return sub(pose.at, half), add(pose.at, half)


@njit
def _vertex_box(shape_model: Any, vertices: Any, pose: Pose) -> tuple[Vec, Vec]:
    """Of a hull its vertices; of a heightfield the box of its grid, whose height the first normal has."""
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


@njit
def reach_of(body: Any, kind: int, parameter: Any, pull: float, timestep: float) -> float:
    """How far beyond its linear motion a body's surface can come within the step, in m; see planar/geometry.py."""
    if kind == STATIC:
        return 0.0
    spare = parameter.radius * parameter.radius - parameter.extent * parameter.extent
    spin = norm((body.velocity[3], body.velocity[4], body.velocity[5]))
    reach = min(timestep * spin * np.sqrt(max(spare, 0.0)), 2.0 * parameter.radius)
    if kind == DYNAMIC:
        push = norm(vec(body.force))
        reach += timestep * timestep * (pull * abs(parameter.gravity_scale) + push * parameter.inv_mass)
    return reach


@njit
def is_moving(body: Any) -> bool:
    for d in range(6):
        if body.velocity[d] != 0.0:
            return True
    return False


@njit
def update_geometry(
    bodies: Array,
    body_models: Array,
    body_parameters: Array,
    shape_models: Array,
    shape_parameters: Array,
    vertices: Array | None,
    gravity: Array,
    timestep: float,
    geometry: Array,
) -> None:
    """Fill `geometry` (shape,) of shape_geometry_dtype(3) for one world.

    `bodies`, `body_models`, `body_parameters` (body,); `shape_models`, `shape_parameters`
    (shape,); `vertices` (vertex,) or None; `gravity` (3,) m/s^2; `timestep` s.
    """
    pull = norm(vec(gravity))
    for k in range(len(shape_models)):
        shape_model = shape_models[k]
        parameter = shape_parameters[k]
        body = bodies[shape_model.body]
        body_parameter = body_parameters[shape_model.body]
        kind = body_models[shape_model.body].kind
        entry = geometry[k]
        active = parameter.enabled != 0 and body_parameter.enabled != 0
        entry.active = 1 if active else 0
        entry.dynamic = 1 if active and kind == DYNAMIC else 0
        awake = kind == DYNAMIC and body.asleep == 0
        if kind == KINEMATIC:
            awake = is_moving(body)
        entry.awake = 1 if active and awake else 0
        if not active:
            continue
        at, q = shape_place(body, body_parameter, parameter)
        for d in range(4):
            entry.rotation[d] = q[d]
        entry.reach = reach_of(body, kind, body_parameter, pull, timestep)
        margin = entry.reach
        entry.extent = np.inf
        if kind == DYNAMIC:
            entry.extent = min(body_parameter.extent, parameter.extent)
            margin += BASE_MARGIN * entry.extent
        lower, upper = bounding_box(shape_model, parameter, vertices, pose_of(at, q))
        for d in range(3):
            entry.position[d] = at[d]
            way = timestep * body.velocity[d] if kind != STATIC else 0.0
            entry.lower[d] = lower[d] + min(way, 0.0) - margin
            entry.upper[d] = upper[d] + max(way, 0.0) + margin
