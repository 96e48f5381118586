"""Masses and extents of 3D bodies: of one when a scene is compiled, of many worlds when sizes differ."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations, product
from typing import Any

import numpy as np

from ..records.model import Array, Model
from . import shapes as spatial_shapes
from .kinds import HULL
from .math import Quaternion, conjugate, multiply

SAME_MOMENT = 1e-7  # of the trace: moments that differ by less count as equal
AT_REST = (1.0, 0.0, 0.0, 0.0)
NO_INERTIA = (np.zeros(3), AT_REST)

_multiply = getattr(multiply, "py_func", multiply)
_conjugate = getattr(conjugate, "py_func", conjugate)


# ---------------------------------------------------------------- principal axes


def principal_axes(tensor: Any, near: Quaternion = AT_REST) -> tuple[Array, Quaternion]:
    """Return (moments (3,), quaternion of the principal axes in the tensor's frame) of a symmetric (3, 3).

    Of all right-handed choices and orders of the axes, this is the one with the smallest rotation from the
    frame `near`; axes of equal moments are rotated no further than necessary.  It is computed by Jacobi
    rotations, so the bits are equal on all machines.
    """
    frame = spatial_shapes.rotation_matrix(near)
    seen = _turned(np.asarray(tensor, float), frame)
    scale = float(np.trace(seen))
    if scale <= 0.0 or abs(seen - np.diag(np.diag(seen))).max() <= 1e-12 * scale:
        return np.diag(seen).copy(), near
    vectors = _jacobi(seen, 1e-14 * scale)
    moments = np.diag(_turned(seen, vectors)).copy()
    if np.ptp(moments) <= SAME_MOMENT * scale:
        return np.diag(seen).copy(), near
    best, most = np.eye(3), -np.inf
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            axes = vectors[:, order] * np.array(signs)
            if np.linalg.det(axes) < 0.0:
                continue
            axes = _untwisted(axes, moments[list(order)], SAME_MOMENT * scale)
            if float(np.trace(axes)) > most + 1e-9:  # ties go to the first
                best, most = axes, float(np.trace(axes))
    return np.diag(_turned(seen, best)).copy(), _multiply(near, _quaternion_of(best))


def _turned(tensor: Array, axes: Array) -> Array:
    """Return a symmetric tensor in axes that are the columns of a matrix."""
    return (axes[:, None, :, None] * axes[None, :, None, :] * tensor[:, :, None, None]).sum(axis=(0, 1))


def _jacobi(tensor: Array, small: float) -> Array:
    """Return the eigenvectors as columns, by cyclic Jacobi rotations."""
    a, vectors = tensor.copy(), np.eye(3)
    for _ in range(30):
        if max(abs(a[0, 1]), abs(a[0, 2]), abs(a[1, 2])) <= small:
            break
        for p, q in ((0, 1), (0, 2), (1, 2)):
            if abs(a[p, q]) <= small:
                continue
            ratio = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
            tangent = (1.0 if ratio >= 0.0 else -1.0) / (abs(ratio) + np.sqrt(ratio * ratio + 1.0))
            c = 1.0 / np.sqrt(tangent * tangent + 1.0)
            s = tangent * c
            turn = np.eye(3)
            turn[p, p] = turn[q, q] = c
            turn[p, q], turn[q, p] = s, -s
            vectors = (vectors[:, :, None] * turn[None]).sum(axis=1)
            a = _turned(tensor, vectors)
    return vectors


def _untwisted(axes: Array, moments: Array, small: float) -> Array:
    """Rotate the axes of two equal moments within their plane until they are nearest to those of the frame."""
    for i, j in ((0, 1), (0, 2), (1, 2)):
        if abs(moments[i] - moments[j]) > small:
            continue
        c, s = axes[i, i] + axes[j, j], axes[i, j] - axes[j, i]
        length = np.sqrt(c * c + s * s)
        if length > 1e-9:
            first, second = axes[:, i].copy(), axes[:, j].copy()
            axes[:, i] = (c * first + s * second) / length
            axes[:, j] = (c * second - s * first) / length
    return axes


def _quaternion_of(axes: Array) -> Quaternion:
    """Return the quaternion of a rotation matrix, w not negative, computed from its largest component."""
    trace = axes[0, 0] + axes[1, 1] + axes[2, 2]
    squares = [1.0 + trace] + [1.0 + 2.0 * axes[k, k] - trace for k in range(3)]
    k = int(np.argmax(squares))
    r = axes
    if k == 0:
        q = np.array([squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    elif k == 1:
        q = np.array([r[2, 1] - r[1, 2], squares[1], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0]])
    elif k == 2:
        q = np.array([r[0, 2] - r[2, 0], r[1, 0] + r[0, 1], squares[2], r[2, 1] + r[1, 2]])
    else:
        q = np.array([r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], squares[3]])
    q *= (-1.0 if q[0] < 0.0 else 1.0) / np.sqrt((q**2).sum())
    w, x, y, z = q.tolist()
    return w, x, y, z


# ---------------------------------------------------------------- one body of a scene


def inertia_about(middle: Array, parts: Sequence[Any], shapes: Sequence[Any]) -> tuple[Array, Quaternion]:
    """Return (principal moments (3,) kg m^2 about the centre of mass, quaternion of their axes) of a body.

    The axes of a body of one box, sphere, capsule or cylinder are those of the shape, so that they stay
    principal when its size changes.

    Args:
        middle: its centre of mass (3,) m.
        parts: (mass, centroid, inertia (3, 3) about that) of its solid shapes.
        shapes: all its shapes.
    """
    if len(shapes) == 1 and int(shapes[0].kind) != HULL:
        return principal_axes(parts[0][2], spatial_shapes.unit_rotation(shapes[0]))
    total = np.zeros((3, 3))
    for m, c, inertia in parts:
        d = c - middle
        total += inertia + m * ((d**2).sum() * np.eye(3) - d[:, None] * d[None, :])
    return principal_axes(total)


def principal_inertia(given: Array) -> tuple[Array, Quaternion]:
    """Return the principal moments and axes of an inertia, given as moments about the body's axes or as a tensor."""
    return principal_axes(np.diag(given) if given.ndim == 1 else given)


# ---------------------------------------------------------------- many worlds


def own_inertia(model: Model, index: int, kind: int, records: Array) -> tuple[Any, Array]:
    """Return (volume m^3, principal moments m^5) of a shape for density 1, from its records (chosen,)."""
    if kind == HULL:
        rotation = records["local_rotation"][0] if len(records) else AT_REST
        return _hull_moments(model, index, rotation)
    if spatial_shapes.CLASSES[kind].solid:
        volume, moments = spatial_shapes.own_moments(kind, records["size"], records["radius"])
        return volume, np.stack(moments, axis=-1)
    return 0.0, np.zeros(3)  # planes and heightfields


def _hull_moments(model: Model, index: int, rotation: Any) -> tuple[float, Array]:
    """Return (volume m^3, principal moments m^5) of a compiled hull, for density 1."""
    first = int(model.shapes["vertex_first"][index])
    count = int(model.nominal_vertices["vertex_count"][first])
    points = model.nominal_vertices["position"][first : first + count]
    w, x, y, z = (float(n) for n in rotation)
    volume, _, inertia = spatial_shapes.mass_properties(spatial_shapes.Hull(vertices=points, orientation=(w, x, y, z)))
    return volume, principal_axes(inertia)[0]
