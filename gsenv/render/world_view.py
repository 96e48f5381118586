"""The only place that knows how a World stores what a picture needs."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.model import BodyKind
from gsenv.solver.planar.shapes import ShapeKind
from gsenv.solver.world import World

FloatArray = NDArray[np.float64]


class ShapeTable(NamedTuple):
    """What never changes; (shape,) arrays."""

    kinds: NDArray[np.int32]  # ShapeKind
    bodies: NDArray[np.int32]
    vertex_first: NDArray[np.int32]
    vertex_count: NDArray[np.int32]
    static: NDArray[np.bool_]
    sensor: NDArray[np.bool_]
    closed: NDArray[np.bool_]  # terrains only
    colors: NDArray[np.uint8] | None  # (shape, 3)


class ShapeState(NamedTuple):
    """Shapes of one world, in the world's frame."""

    position: FloatArray  # (shape, 2) m
    rotation: FloatArray  # (shape, 2) cos, sin
    size: FloatArray  # (shape, 2) m
    radius: FloatArray  # (shape,) m
    enabled: NDArray[np.bool_]  # (shape,)
    vertices: FloatArray  # (vertex, 2) m, in the frames of their shapes


class Frames(NamedTuple):
    """Points with directions, e.g. joints."""

    position: FloatArray  # (frame, 2) m
    rotation: FloatArray  # (frame, 2) cos, sin


def rotate(rotation: FloatArray, vectors: FloatArray) -> FloatArray:
    """(..., 2) vectors turned by (..., 2) (cos, sin): a complex product is the fastest way."""
    a = np.ascontiguousarray(rotation, np.float64).view(np.complex128)
    b = np.ascontiguousarray(vectors, np.float64).view(np.complex128)
    turned: FloatArray = (a * b).view(np.float64)
    return turned


def read_table(world: World) -> ShapeTable:
    shapes = world.model.shapes
    static = world.model.bodies["kind"] == BodyKind.STATIC
    kinds, first, count = shapes["kind"], shapes["vertex_first"], shapes["vertex_count"]
    closed = np.zeros(len(shapes), bool)
    for k in np.flatnonzero(kinds == ShapeKind.TERRAIN):
        closed[k] = world.model.nominal_vertices["next"][first[k] + count[k] - 1] >= 0
    return ShapeTable(
        kinds=kinds,
        bodies=shapes["body"],
        vertex_first=first,
        vertex_count=count,
        static=static[shapes["body"]],
        sensor=shapes["sensor"] != 0,
        closed=closed,
        colors=world.model.shape_colors,
    )


def read_bodies(world: World, index: int) -> Frames:
    """Body frames (body,) of one world."""
    states = world.state.bodies[index]
    rotation = states["rotation"]
    center = rotate(rotation, world.parameters.bodies[index]["center"])
    return Frames(states["position"] - center, rotation)


def read_state(world: World, index: int, table: ShapeTable) -> ShapeState:
    parameters = world.parameters
    shapes = parameters.shapes[index]
    bodies = read_bodies(world, index)
    rotation = bodies.rotation[table.bodies]
    offset = rotate(rotation, shapes["local_position"])
    enabled = (shapes["enabled"] != 0) & (parameters.bodies[index]["enabled"] != 0)[table.bodies]
    return ShapeState(
        position=bodies.position[table.bodies] + offset,
        rotation=rotate(rotation, shapes["local_rotation"]),
        size=shapes["size"],
        radius=shapes["radius"],
        enabled=enabled,
        vertices=parameters.vertices[index]["position"],
    )


def read_time(world: World, index: int) -> float:
    """s since the last reset."""
    return float(world.time[index])


def read_contacts(world: World, index: int) -> tuple[FloatArray, FloatArray]:
    """Points (contact, 2) in m and mean forces (contact, 2) in N of touching contacts."""
    contacts: Any = world.contacts(index)
    touching = contacts.touching & ~contacts.sensor
    return contacts.point[touching], contacts.force_vector(world.timestep)[touching]


def read_joints(world: World, index: int) -> Frames:
    """Frames (joint,) at the anchors on body b."""
    joints = world.model.joints
    bodies = read_bodies(world, index)
    enabled = world.parameters.joints[index]["enabled"] != 0
    of_joint = joints["body_b"][enabled]
    rotation = bodies.rotation[of_joint]
    anchors = world.parameters.joints[index]["anchor_b"][enabled]
    return Frames(bodies.position[of_joint] + rotate(rotation, anchors), rotation)
