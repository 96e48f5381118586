"""Poses of all shapes, and the boxes that they can reach within the step."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import njit
from ..records.model import BodyKind
from .dispatch import by_dimension
from .recycling import form_of
from .sleep import is_calm

Array = NDArray[Any]

DYNAMIC = int(BodyKind.DYNAMIC)
KINEMATIC = int(BodyKind.KINEMATIC)
STATIC = int(BodyKind.STATIC)
BASE_MARGIN = 0.02  # of a body's extent: margin of a body at rest
# of the prediction of contacts: largest number of advances, and what it finds
MAX_ADVANCES = 12
APART, MISS, MEET = 0, 1, 2

place_shape = by_dimension("geometry", "place_shape")
bounding_box = by_dimension("geometry", "bounding_box")
advanced = by_dimension("narrowphase.motion", "advanced")
spin_rate = by_dimension("narrowphase.motion", "spin_rate")


class PlacedShape(NamedTuple):
    """A shape and the pose of its frame."""

    number: int
    pose: Any


class MovingShape(NamedTuple):
    """A shape on a moving body."""

    number: int
    pose: Any
    motion: Any  # of the body
    inv_mass: float  # 1/kg, of the body


@njit
def placed(shape: MovingShape, time: float) -> PlacedShape:
    """Return a shape on a moving body `time` s later."""
    return PlacedShape(shape.number, advanced(shape.pose, shape.motion, time))


@njit
def share_of(a: MovingShape, b: MovingShape) -> float:
    """Return the share of a's motion in that of a point that moves with the lighter of two bodies; 1 if b is fixed."""
    total = a.inv_mass + b.inv_mass
    return a.inv_mass / total if total > 0.0 else 0.5


@njit
def linear_norm(vector: Any, dim: int) -> float:
    """Return the Euclidean norm of the linear part of a vector [linear, angular] of ``dim`` dimensions."""
    square = 0.0
    for d in range(dim):
        square += vector[d] * vector[d]
    return np.sqrt(square)


@njit
def gravity_norm(parameters: Any) -> float:
    """Return |gravity| in m/s^2 of a world's parameters."""
    return linear_norm(parameters.gravity, len(parameters.gravity))


@njit
def angular_norm(vector: Any, dim: int) -> float:
    """Return the Euclidean norm of the angular part of such a vector."""
    square = 0.0
    for d in range(dim, len(vector)):
        square += vector[d] * vector[d]
    return np.sqrt(square)


@njit
def is_moving(body: Any) -> bool:
    """Whether a body has a velocity."""
    for d in range(len(body.velocity)):
        if body.velocity[d] != 0.0:
            return True
    return False


@njit
def swing_of(parameter: Any) -> float:
    """Return the largest speed of a body's support planes by rotation, in m/s per rad/s."""
    spare = parameter.radius * parameter.radius - parameter.extent * parameter.extent
    return np.sqrt(max(spare, 0.0))


@njit
def swing_speed(a: MovingShape, b: MovingShape) -> float:
    """Return the largest speed in m/s at which rotation of the two bodies can close a gap."""
    return spin_rate(a.motion) * a.motion.swing + spin_rate(b.motion) * b.motion.swing


@njit
def reach_of(body: Any, kind: int, parameter: Any, gravity: float, timestep: float) -> float:
    """Return how far beyond its linear motion a body's surface can move within the step, in m.

    `gravity`: its norm, m/s^2.

    Rotation moves a support plane by at most w sqrt(radius^2 - extent^2); gravity and force add
    timestep^2 a, so that a small body at rest above the floor does not fall into it in one step.
    """
    if kind == STATIC:
        return 0.0
    dim = len(body.position)
    reach = timestep * angular_norm(body.velocity, dim) * swing_of(parameter)
    reach = min(reach, 2.0 * parameter.radius)
    if kind == DYNAMIC:
        push = linear_norm(body.force, dim)
        reach += timestep * timestep * (gravity * abs(parameter.gravity_scale) + push * parameter.inv_mass)
    return reach


@njit
def update_geometry(world: Any) -> None:
    """Fill `world.scratch.geometry` (shape,) from the present poses of the bodies."""
    models = world.shapes.models
    parameters = world.shapes.parameters
    vertices = world.shapes.vertices
    bodies = world.state.bodies
    body_models = world.model.bodies
    body_parameters = world.parameters.bodies
    gravity = gravity_norm(world.parameters.world)
    timestep = world.options.timestep
    geometry = world.scratch.geometry
    for k in range(len(models)):
        b = models[k].body
        kind = body_models[b].kind
        calm = kind == STATIC
        if kind == DYNAMIC and body_models[b].jointed == 0:
            calm = is_calm(bodies[b], body_parameters[b], gravity, timestep)
        geometry[k].calm = 1 if calm and parameters[k].radius == 0.0 else 0
        geometry[k].form = form_of(parameters[k])
        if mark_shape(geometry[k], models[k], parameters[k], bodies[b], kind, body_parameters[b]):
            pose = place_shape(geometry[k], bodies[b], body_parameters[b], parameters[k])
            lower, upper = bounding_box(models[k], parameters[k], vertices, pose)
            reach = reach_of(bodies[b], kind, body_parameters[b], gravity, timestep)
            extent = min(body_parameters[b].extent, parameters[k].extent) if kind == DYNAMIC else np.inf
            sweep_box(geometry[k], lower, upper, reach, extent, bodies[b].velocity, timestep if kind != STATIC else 0.0)


@njit
def mark_shape(entry: Any, model: Any, parameter: Any, body: Any, kind: int, body_parameter: Any) -> bool:
    """Write whether the shape is active (it may touch others), dynamic and awake; returns whether it is active."""
    active = parameter.enabled != 0 and body_parameter.enabled != 0 and model.category != 0 and model.mask != 0
    entry.active = 1 if active else 0
    entry.dynamic = 1 if active and kind == DYNAMIC else 0
    awake = kind == DYNAMIC and body.asleep == 0
    if kind == KINEMATIC:
        awake = is_moving(body)
    entry.awake = 1 if active and awake else 0
    return active


@njit
def sweep_box(entry: Any, lower: Any, upper: Any, reach: float, extent: float, velocity: Any, timestep: float) -> None:
    """Write the bounding box in m: (lower, upper) swept over the step and widened by the margin."""
    entry.reach = reach
    entry.extent = extent
    margin = reach
    if entry.dynamic != 0:
        margin += BASE_MARGIN * extent
    for d in range(len(entry.lower)):
        translation = timestep * velocity[d]
        entry.lower[d] = lower[d] + min(translation, 0.0) - margin
        entry.upper[d] = upper[d] + max(translation, 0.0) + margin
