"""Reads from a 3D World what its picture shows; no other 3D render module knows how a World stores it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.checks import check_dimension
from gsenv.render.spatial.primitives import HEIGHTFIELD, MARKED, PLAIN, PLANE, SPHERE, Primitives
from gsenv.render.spatial.style import GROUND_COLOR
from gsenv.render.theme import PALETTE, STATIC_COLOR
from gsenv.solver.records.model import BodyKind, JointKind

FloatArray = NDArray[np.float64]


class ShapeTable(NamedTuple):
    """Constant fields of the drawn shapes, which are all but sensors; (shape,) arrays."""

    number: NDArray[np.int64]  # index among all shapes
    kind: NDArray[np.int32]
    body: NDArray[np.int32]
    vertex_first: NDArray[np.int32]
    color: NDArray[np.uint8]  # (shape, 3)
    mark: NDArray[np.int32]
    static: NDArray[np.bool_]


def rotate(rotation: FloatArray, vectors: FloatArray) -> FloatArray:
    """Rotate (..., 3) vectors by (..., 4) unit quaternions (w, u): v + 2 w (u x v) + 2 u x (u x v)."""
    u = rotation[..., 1:]
    t = 2.0 * np.cross(u, vectors)
    turned: FloatArray = vectors + rotation[..., :1] * t + np.cross(u, t)
    return turned


def multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """Multiply (..., 4) quaternions: the rotation q, followed by p."""
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def read_table(world: Any) -> ShapeTable:
    """Return the constant fields of a 3D World's drawn shapes.

    Raises ValueError for a 2D World.
    """
    check_dimension(world, 3, "SpatialRenderer")
    shapes = world.model.shapes
    index = np.flatnonzero(shapes["sensor"] == 0)
    kind, body = shapes["kind"][index], shapes["body"][index]
    static = (world.model.bodies["kind"] == BodyKind.STATIC)[body]
    color = find_colors(kind, body, static)
    if world.model.shape_colors is not None:
        colors = world.model.shape_colors[index]
        given = colors.any(axis=1)
        color[given] = colors[given]
    # Only a sphere that is a body's single shape has stripes.
    alone = np.bincount(shapes["body"], minlength=len(world.model.bodies))[body] == 1
    mark = np.where((kind == SPHERE) & ~alone, PLAIN, MARKED)
    return ShapeTable(
        number=index,
        kind=np.ascontiguousarray(kind, np.int32),
        body=np.ascontiguousarray(body, np.int32),
        vertex_first=np.ascontiguousarray(shapes["vertex_first"][index], np.int32),
        color=np.ascontiguousarray(color, np.uint8),
        mark=np.ascontiguousarray(mark, np.int32),
        static=static,
    )


def find_colors(kind: NDArray[Any], body: NDArray[Any], static: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return (shape, 3) RGB: grey for grounds and static shapes, the palette's colours cyclically for moving bodies."""
    order = np.cumsum(np.bincount(body[~static], minlength=int(body.max(initial=0)) + 1) > 0) - 1
    color = PALETTE[order[body] % len(PALETTE)]
    color[static] = STATIC_COLOR
    color[(kind == PLANE) | (kind == HEIGHTFIELD)] = GROUND_COLOR
    return color


def read_primitives(world: Any, index: int, table: ShapeTable) -> Primitives:
    """Return one world's drawn shapes at their present poses."""
    bodies, states = world.parameters.bodies[index], world.state.bodies[index]
    shapes = world.parameters.shapes[index][table.number]
    rotation = states["rotation"][table.body]
    local = shapes["local_position"] - bodies["center"][table.body]
    enabled = (shapes["enabled"] != 0) & (bodies["enabled"] != 0)[table.body]
    return Primitives(
        kind=table.kind,
        position=np.ascontiguousarray(states["position"][table.body] + rotate(rotation, local)),
        rotation=multiply(rotation, shapes["local_rotation"]),
        size=np.ascontiguousarray(shapes["size"]),
        radius=np.ascontiguousarray(shapes["radius"]),
        color=table.color,
        enabled=enabled,
        vertex_first=table.vertex_first,
        mark=table.mark,
    )


def read_vertices(world: Any, index: int) -> NDArray[np.void]:
    """Return one world's `vertex_dtype` entries."""
    vertices: NDArray[np.void] = world.parameters.vertices[index]
    return vertices


class LinkTable(NamedTuple):
    """Constant fields of links, the distance joints; (link,) arrays."""

    joint: NDArray[np.int64]
    body_a: NDArray[np.int32]
    body_b: NDArray[np.int32]
    size: FloatArray  # m, radius of the smaller body; inf where neither has shapes
    has_spring: NDArray[np.bool_]
    rigid: NDArray[np.bool_]


class LinkState(NamedTuple):
    """Anchors of one world's links."""

    anchor_a: FloatArray  # (link, 3) m
    anchor_b: FloatArray
    enabled: NDArray[np.bool_]  # (link,); the joint and both bodies are enabled


def read_link_table(world: Any) -> LinkTable:
    """Return the constant fields of all distance joints."""
    joints, nominal = world.model.joints, world.model.nominal_joints
    index = np.flatnonzero(joints["kind"] == JointKind.DISTANCE)
    body_a, body_b = joints["body_a"][index], joints["body_b"][index]
    radius = world.model.nominal_bodies["radius"]
    known = np.stack([radius[body_a], radius[body_b]])
    known[known <= 0.0] = np.inf
    chosen = nominal[index]
    has_spring = (chosen["frequency"] > 0.0) | (chosen["stiffness"] > 0.0) | (chosen["damping"] > 0.0)
    return LinkTable(index, body_a, body_b, known.min(axis=0), has_spring, chosen["rigid"] != 0)


def read_links(world: Any, index: int, table: LinkTable) -> LinkState:
    """Return the anchors of one world's links."""
    joints = world.parameters.joints[index][table.joint]
    enabled = world.parameters.bodies[index]["enabled"] != 0
    return LinkState(
        _read_anchors(world, index, table.body_a, joints["anchor_a"]),
        _read_anchors(world, index, table.body_b, joints["anchor_b"]),
        (joints["enabled"] != 0) & enabled[table.body_a] & enabled[table.body_b],
    )


def _read_anchors(world: Any, index: int, body: NDArray[np.int32], anchor: FloatArray) -> FloatArray:
    """Return the anchors (link, 3) in m in the world's frame."""
    state = world.state.bodies[index][body]
    center = world.parameters.bodies[index]["center"][body]
    place: FloatArray = state["position"] + rotate(state["rotation"], anchor - center)
    return place
