"""Vectors as tuples of three scalars, rotations as unit quaternions (w, x, y, z) or as three axes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.trig import atan2, sin_cos
from ..jit import inline_njit, njit

Vec = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class Pose(NamedTuple):
    """The pose of a frame in its parent: origin in m, and its three unit axes."""

    at: Vec
    x: Vec
    y: Vec
    z: Vec


@inline_njit
def dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inline_njit
def cross(a: Vec, b: Vec) -> Vec:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inline_njit
def add(a: Vec, b: Vec) -> Vec:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inline_njit
def sub(a: Vec, b: Vec) -> Vec:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inline_njit
def scaled(a: Vec, s: float) -> Vec:
    return a[0] * s, a[1] * s, a[2] * s


@inline_njit
def along(a: Vec, s: float, d: Vec) -> Vec:
    """Return a + s d."""
    return a[0] + s * d[0], a[1] + s * d[1], a[2] + s * d[2]


@njit
def norm(a: Vec) -> float:
    return np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@njit
def unit(a: Vec) -> Vec:
    """Return a / |a|; (0, 0, 1) for zero."""
    length = norm(a)
    if not length > 0.0:
        return 0.0, 0.0, 1.0
    return a[0] / length, a[1] / length, a[2] / length


@inline_njit
def vec(array: Any) -> Vec:
    """Return the three numbers of a record's field."""
    return array[0], array[1], array[2]


@njit
def rotate(pose: Pose, v: Vec) -> Vec:
    """Return a direction of the frame in its parent."""
    x, y, z = pose.x, pose.y, pose.z
    return (
        x[0] * v[0] + y[0] * v[1] + z[0] * v[2],
        x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
        x[2] * v[0] + y[2] * v[1] + z[2] * v[2],
    )


@njit
def unrotate(pose: Pose, v: Vec) -> Vec:
    return dot(pose.x, v), dot(pose.y, v), dot(pose.z, v)


@njit
def to_world(pose: Pose, p: Vec) -> Vec:
    return add(pose.at, rotate(pose, p))


@njit
def to_local(pose: Pose, p: Vec) -> Vec:
    return unrotate(pose, sub(p, pose.at))


@njit
def relative(frame: Pose, pose: Pose) -> Pose:
    """Return `pose` relative to `frame`."""
    return Pose(to_local(frame, pose.at), unrotate(frame, pose.x), unrotate(frame, pose.y), unrotate(frame, pose.z))


# ---------------------------------------------------------------- quaternions


@inline_njit
def quaternion(array: Any) -> Quaternion:
    """Return the four numbers of a record's field."""
    return array[0], array[1], array[2], array[3]


@inline_njit
def multiply(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the rotation by q, then by p."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@inline_njit
def conjugate(q: Quaternion) -> Quaternion:
    return q[0], -q[1], -q[2], -q[3]


@njit
def normalised(q: Quaternion) -> Quaternion:
    """Return the nearest unit quaternion; the identity for zero."""
    length = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    if not length > 0.0:
        return 1.0, 0.0, 0.0, 0.0
    return q[0] / length, q[1] / length, q[2] / length, q[3] / length


@inline_njit
def turned(q: Quaternion, v: Vec) -> Vec:
    """Return v rotated by q: v + 2 w (u x v) + 2 u x (u x v)."""
    u = (q[1], q[2], q[3])
    t = cross(u, v)
    t = (t[0] + t[0], t[1] + t[1], t[2] + t[2])
    s = cross(u, t)
    return v[0] + q[0] * t[0] + s[0], v[1] + q[0] * t[1] + s[1], v[2] + q[0] * t[2] + s[2]


@inline_njit
def turn_of(r: Vec) -> Quaternion:
    """Return the rotation by |r| rad about r."""
    angle = norm(r)
    c, s = sin_cos(0.5 * angle)
    # series of sin(x)/x near 0, against division by zero
    k = s / angle if angle > 1e-8 else 0.5 - angle * angle / 48.0
    return c, k * r[0], k * r[1], k * r[2]


@inline_njit
def turn_about(axis: Vec, angle: float) -> Quaternion:
    """Return the rotation by an angle in rad about a unit axis."""
    c, s = sin_cos(0.5 * angle)
    return c, s * axis[0], s * axis[1], s * axis[2]


@inline_njit
def near_turn_of(r: Vec) -> Quaternion:
    """Return ``turn_of`` to rounding, by series of the half angle below 0.2 rad, in a quarter of the time."""
    z = 0.25 * dot(r, r)
    if not z < 0.01:
        return turn_of(r)
    c = 1.0 - z * (0.5 - z * (1.0 / 24.0 - z * (1.0 / 720.0 - z * (1.0 / 40320.0))))
    k = 0.5 - z * (1.0 / 12.0 - z * (1.0 / 240.0 - z * (1.0 / 10080.0 - z * (1.0 / 725760.0))))
    return c, k * r[0], k * r[1], k * r[2]


@inline_njit
def near_unit(q: Quaternion) -> Quaternion:
    """Return the nearest unit quaternion, without a root where only rounding has changed the length."""
    excess = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0
    if not abs(excess) < 1e-8:
        return normalised(q)
    s = 1.0 - 0.5 * excess
    return q[0] * s, q[1] * s, q[2] * s, q[3] * s


@njit
def turn_between(wanted: Quaternion, q: Quaternion) -> Vec:
    """Return the shortest rotation vector, rad in the world, that takes ``wanted`` to q."""
    e = multiply(q, conjugate(wanted))
    if e[0] < 0.0:
        e = (-e[0], -e[1], -e[2], -e[3])
    v = (e[1], e[2], e[3])
    size = norm(v)
    if size < 1e-8:
        return scaled(v, 2.0)
    return scaled(v, 2.0 * atan2(size, e[0]) / size)


@njit
def pose_of(at: Vec, q: Quaternion) -> Pose:
    """Return the pose at a position with a rotation."""
    w, x, y, z = q
    return Pose(
        at,
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@njit
def tangents(n: Vec) -> tuple[Vec, Vec]:
    """Return unit vectors t, s with t x s = n, continuous in n except where n_z passes 0.62."""
    if abs(n[2]) > 0.62:
        t = unit((1.0 - n[0] * n[0], -n[0] * n[1], -n[0] * n[2]))  # the x axis projected on the tangent plane
    else:
        t = unit((-n[1], n[0], 0.0))  # horizontal
    return t, cross(n, t)
