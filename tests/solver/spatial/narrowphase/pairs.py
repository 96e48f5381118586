"""Two shapes and what the narrowphase says of them; support functions as an independent view of the shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from gsenv.solver.core.geometry import PlacedShape
from gsenv.solver.records.model import Array, shape_model_dtype, shape_parameter_dtype
from gsenv.solver.spatial.kinds import BOX, CAPSULE, CYLINDER, HULL, PLANE, SPHERE
from gsenv.solver.spatial.math import Pose
from gsenv.solver.spatial.narrowphase.table import collide
from gsenv.solver.spatial.vertices import vertex_dtype
from tests.solver.kernel_worlds import narrowphase_bundle, shapes_bundle

KINDS = {"sphere": SPHERE, "box": BOX, "capsule": CAPSULE, "cylinder": CYLINDER, "hull": HULL, "plane": PLANE}


@dataclass(frozen=True)
class Shape:
    kind: int
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float = 0.0
    points: Any = None  # of a hull (n, 3)
    at: Any = (0.0, 0.0, 0.0)
    axes: Any = None  # (3, 3) rotation, columns are the shape's axes

    @property
    def rotation(self) -> Array:
        return np.eye(3) if self.axes is None else np.asarray(self.axes, float)

    @property
    def extent(self) -> float:
        if self.kind == BOX:
            return min(self.size)
        if self.kind == CYLINDER:
            return min(self.size[2], self.radius)
        if self.kind == HULL:
            return float(np.ptp(self.points, axis=0).min()) / 2
        return self.radius if self.kind != PLANE else np.inf

    def placed(self, at: Any, axes: Any = None) -> Shape:
        return replace(self, at=tuple(at), axes=self.rotation if axes is None else axes)

    def moved(self, rotation: Array, shift: Any) -> Shape:
        return self.placed(rotation @ np.asarray(self.at) + shift, rotation @ self.rotation)

    def pose(self) -> Pose:
        columns = [tuple(float(x) for x in column) for column in self.rotation.T]
        return Pose(tuple(float(x) for x in self.at), columns[0], columns[1], columns[2])  # type: ignore[arg-type]

    def support(self, d: Any) -> Array:
        """Farthest points of the shape along the unit vectors d (..., 3)."""
        d = np.asarray(d, float)
        local = d @ self.rotation
        if self.kind == HULL:
            p = self.points[np.argmax(local @ self.points.T, axis=-1)]
        else:
            p = np.where(local >= 0, 1.0, -1.0) * self.size
            if self.kind == CYLINDER:
                across = np.maximum(np.hypot(local[..., 0], local[..., 1]), 1e-300)
                p[..., 0] = self.radius * local[..., 0] / across
                p[..., 1] = self.radius * local[..., 1] / across
        p = p @ self.rotation.T + self.at
        if self.kind in (SPHERE, CAPSULE):
            p = p + self.radius * d
        return p


def sphere(radius: float) -> Shape:
    return Shape(SPHERE, radius=radius)


def box(x: float, y: float, z: float) -> Shape:
    return Shape(BOX, size=(x, y, z))


def capsule(half_length: float, radius: float) -> Shape:
    return Shape(CAPSULE, size=(0.0, 0.0, half_length), radius=radius)


def cylinder(half_length: float, radius: float) -> Shape:
    return Shape(CYLINDER, size=(0.0, 0.0, half_length), radius=radius)


def plane() -> Shape:
    return Shape(PLANE)


def hull(points: Any) -> Shape:
    return Shape(HULL, points=np.asarray(points, float))


def box_hull(x: float, y: float, z: float) -> Shape:
    corners = [(i, j, k) for i in (-x, x) for j in (-y, y) for k in (-z, z)]
    return hull(corners)


def tetrahedron(size: float = 1.0) -> Shape:
    return hull(size * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / 2)


def icosahedron(size: float = 1.0) -> Shape:
    g = 0.5 * (1 + np.sqrt(5))
    points = [(0, i, j * g) for i in (-1, 1) for j in (-1, 1)]
    points = points + [(y, z, x) for x, y, z in points] + [(z, x, y) for x, y, z in points]
    return hull(size * np.array(points) / np.sqrt(1 + g * g))


def random_hull(rng: np.random.Generator, count: int, size: float = 1.0) -> Shape:
    points = rng.normal(size=(count, 3))
    return hull(size * points / np.linalg.norm(points, axis=1)[:, None])


def rotation(rng: np.random.Generator) -> Array:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def turn(axis: Any, angle: float) -> Array:
    """Rodrigues' rotation by `angle` rad."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def hull_faces(points: Array) -> list[list[int]]:
    """Corners of each face, counter-clockwise seen from outside; triangles in one plane are one face."""
    found = ConvexHull(points)
    groups: list[tuple[Array, set[int]]] = []
    for equation, simplex in zip(found.equations, found.simplices, strict=True):
        for plane_of, members in groups:
            if np.allclose(plane_of, equation, atol=1e-9):
                members.update(simplex)
                break
        else:
            groups.append((equation, set(simplex)))
    faces = []
    for equation, members in groups:
        corners = np.array(sorted(members))
        middle = points[corners].mean(axis=0)
        u = points[corners[0]] - middle
        v = np.cross(equation[:3], u)
        angles = np.arctan2((points[corners] - middle) @ v, (points[corners] - middle) @ u)
        faces.append(corners[np.argsort(angles)].tolist())
    return faces


def hull_entries(points: Array) -> Array:
    faces = hull_faces(points)
    edges = [(face, corners[i], corners[(i + 1) % len(corners)])
             for face, corners in enumerate(faces) for i in range(len(corners))]  # fmt: skip
    number = {(p, q): e for e, (_, p, q) in enumerate(edges)}
    entries = np.zeros(max(len(points), len(edges)), vertex_dtype())
    entries["position"][: len(points)] = points
    entries["vertex_count"][0], entries["face_count"][0], entries["edge_count"][0] = len(points), len(faces), len(edges)
    for face, corners in enumerate(faces):
        p, q, r = points[corners[:3]]
        normal = np.cross(q - p, r - p)
        entries["normal"][face] = normal / np.linalg.norm(normal)
        entries["offset"][face] = entries["normal"][face] @ p
        entries["face_edge"][face] = number[corners[0], corners[1]]
        for i, corner in enumerate(corners):
            following = corners[(i + 1) % len(corners)]
            e = number[corner, following]
            entries["origin"][e], entries["face"][e] = corner, face
            entries["twin"][e] = number[following, corner]
            entries["next"][e] = number[following, corners[(i + 2) % len(corners)]]
            entries["vertex_edge"][corner] = e
    return entries


@dataclass
class Contact:
    """A manifold as arrays."""

    normal: Array
    separation: float
    point: Array
    gap: Array
    feature: list[int]

    @property
    def count(self) -> int:
        return len(self.gap)


def shapes_of(a: Shape, b: Shape) -> Any:
    """Both as ``world.shapes``."""
    models = np.zeros(2, shape_model_dtype())
    parameters = np.zeros(2, shape_parameter_dtype(3))
    vertices = []
    first = 0
    for i, shape in enumerate((a, b)):
        models[i]["kind"] = shape.kind
        parameters[i]["size"], parameters[i]["radius"] = shape.size, shape.radius
        parameters[i]["extent"] = shape.extent
        if shape.kind == HULL:
            entries = hull_entries(shape.points)
            models[i]["vertex_first"], models[i]["vertex_count"] = first, len(entries)
            first += len(entries)
            vertices.append(entries)
    return shapes_bundle(3, models, parameters, np.concatenate(vertices) if vertices else None)


def contact_of(a: Shape, b: Shape, margin: float = 0.1) -> Contact:
    narrowphase = narrowphase_bundle(3, convex=True)  # these scenes have all kinds
    collide(shapes_of(a, b).seal(), PlacedShape(0, a.pose()), PlacedShape(1, b.pose()), margin, narrowphase.seal())
    m = narrowphase.manifold
    k = int(m["count"])
    contact = Contact(
        np.array(m["normal"]), float(m["separation"]), np.array(m["point"])[:k], np.array(m["gap"])[:k],
        [int(i) for i in m["feature"][:k]],
    )  # fmt: skip
    assert np.isfinite(contact.normal).all()
    assert np.isfinite(contact.point).all()
    assert np.isfinite(contact.gap).all()
    assert not np.isnan(contact.separation)
    assert abs(np.linalg.norm(contact.normal) - 1) < 1e-12
    assert len(set(contact.feature)) == k
    assert all(0 <= i < 2**31 for i in contact.feature)
    return contact


# ---------------------------------------------------------------- oracles


def reach(a: Shape, b: Shape, n: Any) -> Array:
    """Separation of the shapes along the directions n (..., 3), by their support points."""
    n = np.asarray(n, float)
    n = n / np.linalg.norm(n, axis=-1)[..., None]
    return np.sum((b.support(-n) - a.support(n)) * n, axis=-1)


def best_separation(a: Shape, b: Shape, rng: np.random.Generator, directions: int = 4000) -> float:
    """Largest separation over all directions: the distance, or minus the depth.

    Samples on the sphere, then around the best few of them, closer and closer.
    """
    n = rng.normal(size=(directions, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    start = n[np.argsort(reach(a, b, n))[-8:]]
    best = -np.inf
    for near in start:
        spread = 0.1
        value = float(reach(a, b, near))
        while spread > 1e-10:
            tries = near + spread * rng.normal(size=(40, 3))
            values = reach(a, b, tries)
            k = int(np.argmax(values))
            if values[k] > value:
                value = float(values[k])
                near = tries[k] / np.linalg.norm(tries[k])
            else:
                spread *= 0.6
        best = max(best, value)
    return best
