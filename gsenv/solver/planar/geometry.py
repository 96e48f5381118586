"""Where each shape is now, and the box that it can reach within the step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.jit import njit
from gsenv.solver.model import BodyKind
from gsenv.solver.planar.math import Pose, to_world
from gsenv.solver.planar.shapes import HALF_PLANE, POLYGON, TERRAIN

Array = NDArray[Any]

DYNAMIC = int(BodyKind.DYNAMIC)
KINEMATIC = int(BodyKind.KINEMATIC)
STATIC = int(BodyKind.STATIC)
BASE_MARGIN = 0.02  # of a body's extent: contacts this near are kept even at rest


@njit
def shape_pose(body: Any, body_parameter: Any, shape_parameter: Any) -> Pose:
    """World pose of a shape; `body.position` is the centre of mass."""
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
def bounding_box(
    shape_model: Any, shape_parameter: Any, vertices: Any, pose: Pose
) -> tuple[float, float, float, float]:
    """(lower x, lower y, upper x, upper y) of a shape at `pose`, in m."""
    if shape_model.kind == HALF_PLANE:
        return -np.inf, -np.inf, np.inf, np.inf
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
    return x - wide, y - high, x + wide, y + high


@njit
def polygon_box(shape_model: Any, vertices: Any, pose: Pose) -> tuple[float, float, float, float]:
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
    return lower_x, lower_y, upper_x, upper_y


@njit
def reach_of(body: Any, kind: int, parameter: Any, pull: float, timestep: float) -> float:
    """How far beyond its linear motion a body's surface can come within the step, in m.

    `pull` = |gravity|, m/s^2.

    Spin moves a support plane at most w sqrt(radius^2 - extent^2); gravity and force add
    timestep^2 a, so that a small body at rest above the floor does not fall into it in one step.
    """
    if kind == STATIC:
        return 0.0
    spare = parameter.radius * parameter.radius - parameter.extent * parameter.extent
    reach = timestep * abs(body.velocity[2]) * np.sqrt(max(spare, 0.0))
    reach = min(reach, 2.0 * parameter.radius)
    if kind == DYNAMIC:
        push = np.sqrt(body.force[0] * body.force[0] + body.force[1] * body.force[1])
        reach += timestep * timestep * (pull * abs(parameter.gravity_scale) + push * parameter.inv_mass)
    return reach


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
    """Fill `geometry` (shape,) of shape_geometry_dtype(2) for one world.

    `bodies`, `body_models`, `body_parameters` (body,); `shape_models`, `shape_parameters`
    (shape,); `vertices` (vertex,) or None; `gravity` (2,) m/s^2; `timestep` s.
    """
    pull = np.sqrt(gravity[0] * gravity[0] + gravity[1] * gravity[1])
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
        if kind == KINEMATIC:  # moving, at all
            awake = body.velocity[0] != 0.0 or body.velocity[1] != 0.0 or body.velocity[2] != 0.0
        entry.awake = 1 if active and awake else 0
        if not active:
            continue
        pose = shape_pose(body, body_parameter, parameter)
        entry.position[0] = pose.x
        entry.position[1] = pose.y
        entry.rotation[0] = pose.cos
        entry.rotation[1] = pose.sin
        entry.reach = reach_of(body, kind, body_parameter, pull, timestep)
        margin = entry.reach
        entry.extent = np.inf
        if kind == DYNAMIC:
            entry.extent = min(body_parameter.extent, parameter.extent)
            margin += BASE_MARGIN * entry.extent
        x0, y0, x1, y1 = bounding_box(shape_model, parameter, vertices, pose)
        dx = timestep * body.velocity[0] if kind != STATIC else 0.0
        dy = timestep * body.velocity[1] if kind != STATIC else 0.0
        entry.lower[0] = x0 + min(dx, 0.0) - margin
        entry.lower[1] = y0 + min(dy, 0.0) - margin
        entry.upper[0] = x1 + max(dx, 0.0) + margin
        entry.upper[1] = y1 + max(dy, 0.0) + margin
