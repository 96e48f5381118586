"""Small worlds for collision tests, and an independent oracle: convex shapes by their support functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from gsenv.solver.core.detection import collide_pairs, find_contacts
from gsenv.solver.core.geometry import update_geometry
from gsenv.solver.core.status import OK
from gsenv.solver.planar import shapes as planar
from gsenv.solver.planar.vertices import vertex_dtype
from gsenv.solver.records import model as records
from gsenv.solver.records import scratch_dtypes
from gsenv.solver.records.model import Array, BodyKind
from tests.solver.kernel_worlds import kernel_world

STATIC, KINEMATIC, DYNAMIC = BodyKind.STATIC, BodyKind.KINEMATIC, BodyKind.DYNAMIC
GRAVITY = np.array([0.0, -9.81])
TIMESTEP = 1.0 / 60.0


@dataclass
class Arrays:
    """One world's arrays, as the kernels take them."""

    bodies: Array
    body_models: Array
    body_parameters: Array
    shape_models: Array
    shape_parameters: Array
    vertices: Array | None
    geometry: Array

    def world(self, gravity: Array = GRAVITY, timestep: float = TIMESTEP, **buffers: Any) -> Any:
        """The kernels' argument, with its geometry up to date; see kernel_world."""
        world = kernel_world(self, gravity, timestep, **buffers)
        update_geometry(world)
        return world

    def contacts(
        self, gravity: Array = GRAVITY, timestep: float = TIMESTEP, pairs: Array | None = None, room: int = 256
    ) -> Array:
        """Contacts of the given pairs, or of those that the broadphase finds."""
        found = np.zeros(room, records.contact_dtype(2))
        if pairs is None:
            status, _, _, count, _ = find_contacts(self.world(gravity, timestep, found=found))
            assert status == OK
        else:
            count = collide_pairs(self.world(gravity, timestep, pairs=pairs, found=found), len(pairs), 0.0)
            assert count <= room
        return found[:count]


def body(
    *shapes: planar.Shape,
    at: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    kind: BodyKind = DYNAMIC,
    continuous: bool = False,
) -> dict[str, Any]:
    """A body by its frame's pose; `velocity` is that of the centre of mass."""
    return {"shapes": shapes, "at": at, "angle": angle, "velocity": velocity, "kind": kind, "continuous": continuous}


def world(*bodies: dict[str, Any], with_vertices: bool = True) -> Arrays:
    """`with_vertices=False` for scenes without polygons and terrains: kernels are pruned."""
    states = np.zeros(len(bodies), records.body_state_dtype(2))
    models = np.zeros(len(bodies), records.body_model_dtype())
    parameters = np.zeros(len(bodies), records.body_parameter_dtype(2))
    vertices = [np.zeros(0, vertex_dtype())]
    shape_models: list[Array] = []
    shape_parameters: list[Array] = []
    vertex = 0
    for b, spec in enumerate(bodies):
        c, s = np.cos(spec["angle"]), np.sin(spec["angle"])
        mass, center, inertia = solid(spec["shapes"])
        models[b]["kind"] = spec["kind"]
        models[b]["continuous"] = spec["continuous"]
        models[b]["shape_first"] = len(shape_models)
        models[b]["shape_count"] = len(spec["shapes"])
        states[b]["position"] = spec["at"] + np.array([[c, -s], [s, c]]) @ center
        states[b]["rotation"] = c, s
        states[b]["angle"] = spec["angle"]
        states[b]["velocity"] = spec["velocity"]
        entry = parameters[b]
        entry["mass"], entry["inertia"], entry["center"] = mass, inertia, center
        if spec["kind"] == DYNAMIC:
            entry["inv_mass"], entry["inv_inertia"] = 1.0 / mass, 1.0 / inertia
        entry["gravity_scale"] = 1.0
        entry["enabled"] = 1
        entry["extent"] = min(shape.extent() for shape in spec["shapes"])
        entry["radius"] = max(
            (planar.bounding_radius(shape, center) for shape in spec["shapes"] if shape.solid), default=0.0
        )
        for shape in spec["shapes"]:
            compiled = planar.shape_record(shape, records.shape_parameter_dtype(2))
            model = np.zeros((), records.shape_model_dtype())
            model["kind"], model["body"], model["sensor"] = shape.kind, b, shape.sensor
            model["category"], model["mask"] = shape.category, shape.mask
            model["vertex_first"], model["vertex_count"] = vertex, len(compiled.vertices)
            vertex += len(compiled.vertices)
            shape_models.append(model)
            shape_parameters.append(compiled.record)
            vertices.append(compiled.vertices)
    return Arrays(
        states, models, parameters, np.array(shape_models), np.array(shape_parameters),
        np.concatenate(vertices) if with_vertices else None,
        np.zeros(len(shape_models), scratch_dtypes.shape_geometry_dtype(2)),
    )  # fmt: skip


def solid(shapes: tuple[planar.Shape, ...]) -> tuple[float, Array, Any]:
    parts = [planar.mass_properties(shape) for shape in shapes]
    mass = sum(area for area, _, _ in parts)
    if mass == 0.0:
        return 0.0, np.zeros(2), 0.0
    center = np.array([area * np.array(middle) for area, middle, _ in parts]).sum(axis=0) / mass
    inertia = sum(i + area * ((np.array(middle) - center) ** 2).sum() for area, middle, i in parts)
    return mass, center, inertia


# ---------------------------------------------------------------- the oracle


def core(shape: planar.Shape, at: Any, angle: float) -> tuple[Array, float]:
    """World corners (n, 2) and the radius around them."""
    if isinstance(shape, planar.Circle):
        points, radius = np.zeros((1, 2)), shape.radius
    elif isinstance(shape, planar.Box):
        hx, hy = shape.half_extents
        points, radius = np.array([(-hx, -hy), (hx, -hy), (hx, hy), (-hx, hy)]), 0.0
    elif isinstance(shape, planar.Capsule):
        points, radius = np.array([(-shape.half_length, 0.0), (shape.half_length, 0.0)]), shape.radius
    elif isinstance(shape, planar.Polygon):
        points, radius = np.array(shape.vertices, float), 0.0
    else:
        raise TypeError(shape)
    for turn, shift in ((shape.angle, shape.position), (angle, at)):
        c, s = np.cos(turn), np.sin(turn)
        points = points @ np.array([[c, s], [-s, c]]) + np.asarray(shift)
    return points, radius


def gap_along(a: tuple[Array, float], b: tuple[Array, float], angle: Any) -> Any:
    """Room between two shapes along a direction from a to b: the greatest over all is the distance."""
    direction = np.stack([np.cos(angle), np.sin(angle)])
    return (b[0] @ direction).min(axis=0) - (a[0] @ direction).max(axis=0) - a[1] - b[1]


def signed_distance(a: tuple[Array, float], b: tuple[Array, float]) -> float:
    """Distance of two convex shapes, or minus the shortest way out of each other."""
    angles = np.linspace(-np.pi, np.pi, 2001)
    edges = [np.diff(np.vstack([points, points[:1]]), axis=0) for points, _ in (a, b) if len(points) > 1]
    if edges:
        e = np.vstack(edges)
        exact = np.arctan2(-e[:, 0], e[:, 1])
        angles = np.concatenate([angles, exact, exact + np.pi])
    gaps = gap_along(a, b, angles)
    best = float(gaps.max())
    for start in angles[np.argsort(gaps)[-3:]]:
        found = minimize_scalar(
            lambda t: -float(gap_along(a, b, t)), bounds=(start - 4e-3, start + 4e-3),
            method="bounded", options={"xatol": 1e-12},
        )  # fmt: skip
        best = max(best, -float(found.fun))
    return best


def distance_to_point(shape: tuple[Array, float], point: Any) -> float:
    return signed_distance(shape, (np.asarray(point, float).reshape(1, 2), 0.0))
