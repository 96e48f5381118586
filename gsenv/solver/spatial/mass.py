"""Mass and extent of spatial bodies: of one when it is compiled, of many worlds' when sizes differ."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations, product
from typing import Any

import numpy as np

from ..model import Array, Model
from . import shapes as spatial_shapes
from .kinds import BOX, CAPSULE, CYLINDER, HULL, SPHERE
from .math import Quaternion, conjugate, multiply

# which size fields a shape of each kind has
SIZE_FIELDS: dict[int, tuple[str, ...]] = {
    SPHERE: ("radius",),
    BOX: ("half_extents",),
    CAPSULE: ("half_length", "radius"),
    CYLINDER: ("half_length", "radius"),
}
SAME_MOMENT = 1e-7  # of the trace: moments that differ by less count as one
AT_REST = (1.0, 0.0, 0.0, 0.0)

_multiply = getattr(multiply, "py_func", multiply)
_conjugate = getattr(conjugate, "py_func", conjugate)


# ---------------------------------------------------------------- principal axes


def principal_axes(tensor: Any, near: Quaternion = AT_REST) -> tuple[Array, Quaternion]:
    """(moments (3,), quaternion of the principal axes in the tensor's frame) of a symmetric (3, 3).

    Of all right-handed choices of axes and of their order the one that is turned least from the frame
    `near`; about an axis of equal moments the axes turn no farther than they must.  By Jacobi
    rotations, so the same on every machine.
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
    """A symmetric tensor seen from axes that are the columns of a matrix."""
    return (axes[:, None, :, None] * axes[None, :, None, :] * tensor[:, :, None, None]).sum(axis=(0, 1))


def _jacobi(tensor: Array, small: float) -> Array:
    """Eigenvectors as columns, by cyclic rotations that zero one pair after the other."""
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
    """Axes of two equal moments, turned within their plane until they are nearest to the frame's."""
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
    """Of a rotation matrix, w not negative; from the largest of its four numbers."""
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


# ---------------------------------------------------------------- one body, as authored


def solid_mass(shapes: Sequence[Any]) -> tuple[float, Array, Array, Quaternion]:
    """Mass of a body from its shapes' densities; sensors and shapes without mass don't count.

    Returns:
        (mass kg, centre of mass (3,) m, principal moments (3,) kg m^2 about it, quaternion of the
        principal axes), all in the body's frame.  A body of one box, sphere, capsule or cylinder has
        that shape's own axes, so that they stay principal when its size changes.
    """
    parts = []
    for shape in shapes:
        if shape.solid and not shape.sensor:
            volume, center, inertia = spatial_shapes.mass_properties(shape)
            parts.append((volume * shape.density, center, inertia * shape.density, shape))
    mass = sum(m for m, _, _, _ in parts)
    if mass <= 0.0:
        return 0.0, np.zeros(3), np.zeros(3), AT_REST
    middle = sum((m * c for m, c, _, _ in parts), np.zeros(3)) / mass
    if len(shapes) == 1 and int(shapes[0].kind) != HULL:
        moments, axes = principal_axes(parts[0][2], spatial_shapes.unit_rotation(shapes[0]))
        return float(mass), middle, moments, axes
    total = np.zeros((3, 3))
    for m, c, inertia, _ in parts:
        d = c - middle
        total += inertia + m * ((d**2).sum() * np.eye(3) - d[:, None] * d[None, :])
    moments, axes = principal_axes(total)
    return float(mass), middle, moments, axes


# ---------------------------------------------------------------- many worlds


def mass_of_body(model: Model, shapes: Array, body: int, chosen: Array) -> tuple[Array, Array]:
    """(mass (n,), principal moments (n, 3) about the centre of mass) of a one-shape body in the chosen worlds.

    Moments are about the axes that `solid_mass` gives such a body.
    """
    index = int(model.bodies["shape_first"][body])
    record = shapes[chosen, index]
    kind = int(model.shapes["kind"][index])
    if kind == HULL:
        volume_one, moments_one = _hull_moments(model, index, record["local_rotation"][0] if len(record) else AT_REST)
        volume = np.full(len(chosen), volume_one)
        inertia = np.broadcast_to(moments_one, (len(chosen), 3))
    else:
        volume, moments = spatial_shapes.own_moments(kind, record["size"], record["radius"])
        inertia = np.stack(moments, axis=-1)
    return volume * record["density"], inertia * record["density"][:, None]


def _hull_moments(model: Model, index: int, rotation: Any) -> tuple[float, Array]:
    """(volume, principal moments), density 1, of a compiled hull."""
    first = int(model.shapes["vertex_first"][index])
    count = int(model.nominal_vertices["vertex_count"][first])
    points = model.nominal_vertices["position"][first : first + count]
    w, x, y, z = (float(n) for n in rotation)
    volume, _, inertia = spatial_shapes.mass_properties(spatial_shapes.Hull(vertices=points, rotation=(w, x, y, z)))
    return volume, principal_axes(inertia)[0]


def derive_extent(model: Model, shapes: Array, bodies: Array, body: int, chosen: Array) -> None:
    """Extent and bounding radius of a one-shape body after a change of its size."""
    index = int(model.bodies["shape_first"][body])
    kind = int(model.shapes["kind"][index])
    size, r = shapes["size"][chosen, index], shapes["radius"][chosen, index]
    if kind == BOX:
        extent, reach = size.min(axis=1), np.sqrt((size**2).sum(axis=1))
    elif kind == SPHERE:
        extent, reach = r, r
    elif kind == CAPSULE:
        extent, reach = r, size[:, 2] + r
    elif kind == CYLINDER:
        extent, reach = np.minimum(size[:, 2], r), np.hypot(size[:, 2], r)
    else:
        return
    shapes["extent"][chosen, index] = extent
    bodies["extent"][chosen, body] = extent
    offset = shapes["local_position"][chosen, index] - bodies["center"][chosen, body]
    bodies["radius"][chosen, body] = reach + np.sqrt((offset**2).sum(axis=1))
