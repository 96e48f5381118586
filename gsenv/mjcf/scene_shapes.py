"""Geoms as shapes of a Scene."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..solver.records.model import Array
from ..solver.spatial import Box, Capsule, Cylinder, Heightfield, Hull, Plane, Shape, Sphere
from ..solver.spatial.hulls import MAX_HULL_VERTICES
from .errors import MjcfError, Notes
from .frames import Pose
from .model import Geom, MjcfModel

SIMPLER = f"the hull of a mesh is simplified to {MAX_HULL_VERTICES} corners"
ROUND = f"an ellipsoid touches as a hull of {MAX_HULL_VERTICES} corners"


def shape_of(geom: Geom, model: MjcfModel, place: Pose, material: dict[str, Any], notes: Notes) -> Shape:
    """Return the shape of a geom.

    Args:
        place: pose of the geom in the frame of the scene's body.
        material: friction and filter.

    Raises:
        MjcfError: a mesh that has no hull.
    """
    common = {**material, "position": tuple(place.position.tolist()), "orientation": tuple(place.orientation.tolist())}
    common["name"] = geom.name or None
    common["density"] = 0.0  # the body is given its mass
    a, b, c = geom.size.tolist()
    if geom.kind == "plane":
        return Plane(**common)
    if geom.kind == "sphere":
        return Sphere(a, **common)
    if geom.kind == "capsule":
        return Capsule(b, a, **common)
    if geom.kind == "cylinder":
        return Cylinder(b, a, **common)
    if geom.kind == "box":
        return Box((a, b, c), **common)
    if geom.kind == "hfield":
        grid = model.grids[geom.asset]
        return Heightfield(grid.heights, tuple(grid.size.tolist()), **common)
    if geom.kind == "ellipsoid":
        notes.add(ROUND, _title(geom))
        return Hull(_ellipsoid(geom.size), **common)
    return _mesh_hull(geom, model.meshes[geom.asset].vertices, common, notes)


def _title(geom: Geom) -> str:
    return f"{geom.place}: geom" + (f" {geom.name!r}" if geom.name else "")


def _mesh_hull(geom: Geom, vertices: Array, common: dict[str, Any], notes: Notes) -> Hull:
    """Return the hull of a mesh, of its farthest points in evenly spread directions where it has too many."""
    chosen = np.unique(vertices, axis=0)
    if len(chosen) > MAX_HULL_VERTICES:
        directions = _directions(MAX_HULL_VERTICES)
        chosen = np.unique(chosen[(chosen @ directions.T).argmax(axis=0)], axis=0)
        notes.add(SIMPLER, _title(geom))
    try:
        hull = Hull(chosen, **common)
        from ..solver.spatial.hulls import convex_hull

        convex_hull(hull.vertices)
    except ValueError as error:
        raise MjcfError(f"{_title(geom)}: its mesh cannot be made a hull: {error}.") from None
    return hull


def _directions(count: int) -> Array:
    """Return unit vectors (count, 3), spread by the golden angle and symmetric about the origin."""
    half = count // 2
    k = np.arange(half) + 0.5
    height = k / half
    angle = math.pi * (3.0 - math.sqrt(5.0)) * k
    across = np.sqrt(1.0 - height**2)
    upper = np.stack([across * np.cos(angle), across * np.sin(angle), height], axis=1)
    return np.concatenate([upper, -upper])


def _ellipsoid(semi_axes: Array) -> Array:
    """Return the corners of a hull that lies halfway inside and outside of an ellipsoid."""
    directions = _directions(MAX_HULL_VERTICES)
    reach = directions @ directions.T
    nearest = np.sort(reach, axis=1)[:, -4:-1].mean()  # cosine of the angle between neighbours
    return directions * semi_axes / math.sqrt(0.5 * (1.0 + nearest))
