"""2D geometry on scalars. A rotation is the unit complex number (cos, sin)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.trig import sin_cos
from ..jit import njit


class Pose(NamedTuple):
    """The pose of a frame in its parent: position in m, rotation as (cos, sin)."""

    x: float
    y: float
    cos: float
    sin: float


@njit
def cross(ax: float, ay: float, bx: float, by: float) -> float:
    return ax * by - ay * bx


@njit
def rotate(cos: float, sin: float, x: float, y: float) -> tuple[float, float]:
    return cos * x - sin * y, sin * x + cos * y


@njit
def unrotate(cos: float, sin: float, x: float, y: float) -> tuple[float, float]:
    return cos * x + sin * y, cos * y - sin * x


@njit
def normalise_rotation(cos: float, sin: float) -> tuple[float, float]:
    """Return the nearest unit complex number; (1, 0) for (0, 0)."""
    length = np.sqrt(cos * cos + sin * sin)
    if not length > 0.0:
        return 1.0, 0.0
    return cos / length, sin / length


@njit
def turn(cos: float, sin: float, angle: float) -> tuple[float, float]:
    """Return the rotation (cos, sin) rotated further by `angle` rad, normalised."""
    c, s = sin_cos(angle)
    x, y = rotate(c, s, cos, sin)
    return normalise_rotation(x, y)


@njit
def to_world(pose: Pose, x: float, y: float) -> tuple[float, float]:
    return pose.x + pose.cos * x - pose.sin * y, pose.y + pose.sin * x + pose.cos * y


@njit
def to_local(pose: Pose, x: float, y: float) -> tuple[float, float]:
    dx = x - pose.x
    dy = y - pose.y
    return pose.cos * dx + pose.sin * dy, pose.cos * dy - pose.sin * dx


@njit
def relative(frame: Pose, pose: Pose) -> Pose:
    """Return `pose` relative to `frame`."""
    x, y = to_local(frame, pose.x, pose.y)
    cos, sin = unrotate(frame.cos, frame.sin, pose.cos, pose.sin)
    return Pose(x, y, cos, sin)
