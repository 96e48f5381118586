"""Continuous collision in 3D: motions over a step, swept boxes, gaps; see core/continuous_collision.py."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.geometry import PlacedShape, swing_of
from ..jit import njit
from ..records.model import Array
from .geometry import shape_place
from .kinds import HEIGHTFIELD
from .math import (
    Pose,
    Vec,
    along,
    conjugate,
    dot,
    norm,
    pose_of,
    quaternion,
    scaled,
    sub,
    turn_between,
    turned,
    vec,
)
from .narrowphase.heightfields import heightfield_gap
from .narrowphase.motion import Motion, at_rest, velocity_of
from .narrowphase.table import FIELDS, NONE, PAIR_TABLE, collide
from .rotation import rotate_body


@njit
def motion_between(start: Any, body: Any, parameter: Any) -> Motion:
    """Return the motion of a body in the step, as one of unit time."""
    at = vec(start.position)
    turn = turn_between(quaternion(start.rotation), quaternion(body.rotation))
    return Motion(at, sub(vec(body.position), at), turn, swing_of(parameter))


@njit
def no_motion(start: Any) -> Motion:
    """Return the motion of a body at rest; ``start`` only determines the dimension."""
    return at_rest()


@njit
def move_back(body: Any, start: Any, motion: Motion, time: float) -> None:
    """Move a body back to its pose after a fraction ``time`` of the step.

    Its angular velocity is constant in the body's frame; constant in the world, the energy would change.
    """
    at = along(motion.at, time, motion.velocity)
    spin = (body.velocity[3], body.velocity[4], body.velocity[5])
    spin = turned(conjugate(quaternion(body.rotation)), spin)
    rotate_body(body, start.rotation, scaled(motion.spin, time))
    spin = turned(quaternion(body.rotation), spin)
    for d in range(3):
        body.position[d] = at[d]
        body.velocity[3 + d] = spin[d]


@njit
def move_with(body: Any, motion: Motion, rest: float) -> None:
    """Move a body with a kinematic one, which would pass through it, for the ``rest`` of the step."""
    velocity = velocity_of(motion, vec(body.position), 1.0 - rest)
    for d in range(3):
        body.position[d] += rest * velocity[d]


@njit
def start_pose(start: Any, body_parameter: Any, parameter: Any) -> Pose:
    """Return the pose of a shape before the step; see geometry.shape_place."""
    at, q = shape_place(start, body_parameter, parameter)
    return pose_of(at, q)


@njit
def widened(lower: Vec, upper: Vec, motion: Motion, arc: float) -> tuple[Vec, Vec]:
    """Return a box that holds another one over a motion, m: moved along, and grown by `arc` on each side."""
    v = motion.velocity
    return (
        (lower[0] + min(v[0], 0.0) - arc, lower[1] + min(v[1], 0.0) - arc, lower[2] + min(v[2], 0.0) - arc),
        (upper[0] + max(v[0], 0.0) + arc, upper[1] + max(v[1], 0.0) + arc, upper[2] + max(v[2], 0.0) + arc),
    )


@njit
def gap(
    shapes: Any, a: PlacedShape, b: PlacedShape, of_a: Motion, of_b: Motion, swing: float, narrowphase: Any
) -> tuple[float, float]:
    """Return (separation in m of two shapes, largest speed at which it can close); `of_a`, `of_b`: their motions."""
    velocity = sub(of_a.velocity, of_b.velocity)
    routine = PAIR_TABLE[shapes.models[a.number].kind, shapes.models[b.number].kind]
    if routine != FIELDS and routine != NONE:
        collide(shapes, a, b, 1e300, narrowphase)
        return narrowphase.manifold.separation, swing + dot(vec(narrowphase.manifold.normal), velocity)
    separation = np.inf
    if routine == FIELDS and shapes.models[b.number].kind == HEIGHTFIELD:
        separation = field_gap(shapes, b, a, narrowphase.field)
    # the distance is known, but not its direction
    return separation, swing + norm(velocity)


@njit
def field_gap(shapes: Any, field: PlacedShape, shape: PlacedShape, scratch: Array | None) -> float:
    """Return the separation from a heightfield, m; ``scratch`` is None in a scene without heightfields."""
    if scratch is None:
        return np.inf
    return heightfield_gap(shapes, field, shape, 1e300, scratch)
