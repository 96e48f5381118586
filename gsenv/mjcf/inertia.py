"""Masses, centres of mass and inertia tensors: of geoms, of elements ``inertial``, of bodies."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from ..solver.records.model import Array
from ..solver.spatial import shapes
from ..solver.spatial.hulls import convex_hull, hull_mass
from ..solver.spatial.kinds import ShapeKind
from .attributes import Attributes
from .compiler import Compiler
from .errors import MjcfError
from .frames import Angles, Pose
from .model import NO_INERTIA, Body, Geom, Inertia, Mesh

KINDS = {
    "sphere": ShapeKind.SPHERE,
    "capsule": ShapeKind.CAPSULE,
    "cylinder": ShapeKind.CYLINDER,
    "box": ShapeKind.BOX,
}


LEAST = 1e-15  # kg and kg m^2: a body that moves must have more


def unit_inertia(kind: str, size: Array, mesh: Mesh | None) -> tuple[float, Array, Array]:
    """Return (volume m^3, centroid (3,) m, tensor (3, 3) m^5 about it) in the geom's frame, for density 1.

    Raises:
        ValueError: a mesh without volume.
    """
    if kind in ("plane", "hfield"):
        return 0.0, np.zeros(3), np.zeros((3, 3))
    if kind == "mesh":
        assert mesh is not None
        return mesh_inertia(mesh)
    if kind == "ellipsoid":
        volume = 4.0 / 3.0 * math.pi * float(np.prod(size))
        a, b, c = (size**2).tolist()
        return volume, np.zeros(3), 0.2 * volume * np.diag([b + c, a + c, a + b])
    extents = size if kind == "box" else np.array([0.0, 0.0, size[1]])
    volume, moments = shapes.own_moments(KINDS[kind], extents, float(size[0]))
    return float(volume), np.zeros(3), np.diag([float(m) for m in moments])


def mesh_inertia(mesh: Mesh) -> tuple[float, Array, Array]:
    """Return ``unit_inertia`` of a mesh, by its own rule: of its hull, its volume or its surface.

    A mesh of points alone counts as its hull. The rule "legacy" counts every tetrahedron between the centre
    and a face as positive, as MuJoCo does.
    """
    rule = mesh.inertia
    if rule == "convex" or not len(mesh.faces):
        volume, center, tensor = hull_mass(*convex_hull(mesh.vertices))
        return float(volume), center, tensor
    corners = mesh.vertices[mesh.faces]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total_area = float(areas.sum())
    if not total_area > 0.0:
        raise ValueError("its mesh has no area")
    middle = (areas[:, None] * corners.mean(axis=1)).sum(axis=0) / total_area
    if rule == "shell":
        return total_area, middle, _tensor(corners - middle, areas / 12.0)
    volumes = _tetrahedra(corners - middle, rule)
    volume = float(volumes.sum())
    if not volume > 0.0:
        raise ValueError("its mesh has no volume, or its faces point inwards")
    center = middle + 0.75 * (volumes[:, None] * (corners - middle).mean(axis=1)).sum(axis=0) / volume
    volumes = _tetrahedra(corners - center, rule)
    return float(volumes.sum()), center, _tensor(corners - center, volumes / 20.0)


def _tetrahedra(corners: Array, rule: str) -> Array:
    volumes = np.linalg.det(corners) / 6.0
    return np.abs(volumes) if rule == "legacy" else volumes


def _tensor(corners: Array, weights: Array) -> Array:
    """Return the inertia of simplices with given corners, the origin among them for tetrahedra."""
    sums = corners.sum(axis=1)
    second = np.einsum("m,mki,mkj->ij", weights, corners, corners) + np.einsum("m,mi,mj->ij", weights, sums, sums)
    return np.trace(second) * np.eye(3) - second


def placed(volume: float, center: Array, tensor: Array, density: float, pose: Pose) -> Inertia:
    """Return the inertia of a geom in its body's frame."""
    axes = pose.axes
    return Inertia(volume * density, pose.point(center), density * (axes @ tensor @ axes.T))


def combined(parts: Sequence[Inertia]) -> Inertia:
    """Return the inertia of several parts in one frame."""
    parts = [part for part in parts if part.mass > 0.0]
    mass = sum(part.mass for part in parts)
    if not mass > 0.0:
        return NO_INERTIA
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for part in parts:
        arm = part.center - center
        tensor += part.tensor + part.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return Inertia(mass, center, tensor)


def explicit_inertia(attributes: Attributes, angles: Angles) -> Inertia:
    """Return the inertia of an element ``inertial``.

    Raises:
        MjcfError: a mass or moments that no body has.
    """
    mass = attributes.number("mass", -1.0)
    if mass < 0.0:
        raise attributes.error("mass must be given and not negative")
    if "pos" not in attributes:
        raise attributes.error("pos is missing")
    center = attributes.array("pos", (0.0, 0.0, 0.0))
    if "fullinertia" in attributes:
        if "diaginertia" in attributes or any(name in attributes for name in ("quat", "euler", "axisangle", "xyaxes")):
            raise attributes.error("fullinertia is in the body's own axes: give no other inertia and no rotation")
        xx, yy, zz, xy, xz, yz = attributes.vector("fullinertia", (0.0,) * 6)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if float(np.linalg.eigvalsh(tensor)[0]) < 0.0:
            raise attributes.error("fullinertia must be positive")
    else:
        moments = attributes.array("diaginertia", (0.0, 0.0, 0.0))
        if moments.min() < 0.0:
            raise attributes.error("diaginertia must not be negative")
        axes = angles.pose(attributes).axes
        tensor = axes @ np.diag(moments) @ axes.T
    attributes.finish()
    return Inertia(mass, center, tensor)


def settle_inertias(bodies: list[Body], geoms: list[Geom], joints: set[int], compiler: Compiler) -> None:
    """Give each body its inertia, from its own element or its geoms, and scale all to the total mass.

    Args:
        joints: the bodies that have one.

    Raises:
        MjcfError: a body that moves and has no mass, or impossible moments of inertia.
    """
    low, high = compiler.groups
    parts: list[list[Inertia]] = [[] for _ in bodies]
    for geom in geoms:
        if low <= geom.group <= high:
            parts[geom.body].append(geom.inertia)
    for body, inertias in zip(bodies[1:], parts[1:], strict=True):
        own = body.explicit_inertia
        if compiler.from_geoms == "true" or (compiler.from_geoms == "auto" and own is None):
            body.inertia = combined(inertias)
        elif own is not None:
            body.inertia = own
        body.inertia = _bounded(body, compiler)
    _scale(bodies, compiler.total_mass)
    for root, inertia in rigid_inertias(bodies, joints).items():
        if not inertia.mass > LEAST or float(np.linalg.eigvalsh(inertia.tensor)[0]) <= LEAST:
            body = bodies[root]
            raise MjcfError(f"{body.place}: body {body.name!r} moves and needs a mass and moments of inertia.")


def rigid_roots(bodies: Sequence[Body], joints: Collection[int]) -> list[int]:
    """Return for each body the one that it is rigidly attached to: the nearest with a joint, or the world.

    Args:
        joints: the bodies that have one.
    """
    roots = [0] * len(bodies)
    for index, body in enumerate(bodies):
        roots[index] = index if index in joints else roots[body.parent] if index else 0
    return roots


def rigid_inertias(bodies: Sequence[Body], joints: Collection[int]) -> dict[int, Inertia]:
    """Return the inertia of each body with joints and all that is rigidly attached to it, in its own frame."""
    parts: dict[int, list[Inertia]] = {index: [] for index in sorted(joints)}
    for index, root in enumerate(rigid_roots(bodies, joints)):
        if root in parts:
            pose = bodies[root].world_pose.inverse().then(bodies[index].world_pose)
            one = bodies[index].inertia
            parts[root].append(Inertia(one.mass, pose.point(one.center), pose.axes @ one.tensor @ pose.axes.T))
    return {root: combined(inertias) for root, inertias in parts.items()}


def _bounded(body: Body, compiler: Compiler) -> Inertia:
    """Return a body's inertia with the compiler's lower bounds and balance applied.

    Raises:
        MjcfError: impossible moments of inertia.
    """
    inertia = body.inertia
    moments, axes = np.linalg.eigh(inertia.tensor)
    moments = np.maximum(moments, compiler.least_inertia)
    mass = max(inertia.mass, compiler.least_mass)
    if moments[0] + moments[1] < moments[2] - 1e-9 * max(1e-9, moments[2]):
        if not compiler.balance:
            values = ", ".join(f"{m:g}" for m in moments)
            raise MjcfError(
                f"{body.place}: body {body.name!r} has moments of inertia that no body has, {values} kg m^2: "
                "none may exceed the sum of the two others."
            )
        moments = np.full(3, moments.mean())
    elif moments.min() > compiler.least_inertia and mass == inertia.mass:
        return inertia
    return Inertia(mass, inertia.center, axes @ np.diag(moments) @ axes.T)


def _scale(bodies: list[Body], total: float | None) -> None:
    sum_of_masses = sum(body.inertia.mass for body in bodies)
    if total is None or not sum_of_masses > 0.0:
        return
    factor = total / sum_of_masses
    for body in bodies:
        one = body.inertia
        body.inertia = Inertia(one.mass * factor, one.center, one.tensor * factor)
