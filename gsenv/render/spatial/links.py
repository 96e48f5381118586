"""Rods, ropes and springs of 3D worlds: a thin capsule from anchor to anchor."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.primitives import CAPSULE, PLAIN, Primitives
from gsenv.render.spatial.world_view import rotate
from gsenv.render.theme import ROD_COLOR, ROPE_COLOR, SPRING_COLOR
from gsenv.solver.spatial.joints import JointKind

FloatArray = NDArray[np.float64]

THICKNESS = 0.15  # of the smaller body's radius
LONGEST = 0.03  # of a link's own length: thinner still where bodies are large and near


class LinkTable(NamedTuple):
    """What never changes; (link,) arrays."""

    joint: NDArray[np.int64]
    body_a: NDArray[np.int32]
    body_b: NDArray[np.int32]
    radius: FloatArray  # m
    color: NDArray[np.uint8]  # (link, 3)


def read_links(world: Any) -> LinkTable:
    """The distance joints of a 3D World."""
    joints, nominal = world.model.joints, world.model.nominal_joints
    index = np.flatnonzero(joints["kind"] == JointKind.DISTANCE)
    body_a, body_b = joints["body_a"][index], joints["body_b"][index]
    radius = world.model.nominal_bodies["radius"]
    known = np.stack([radius[body_a], radius[body_b]])
    known[known <= 0.0] = np.inf  # bodies without shapes
    chosen = nominal[index]
    sprung = (chosen["frequency"] > 0.0) | (chosen["stiffness"] > 0.0) | (chosen["damping"] > 0.0)
    color = np.where(sprung[:, None], SPRING_COLOR, np.where(chosen["rigid"][:, None] != 0, ROD_COLOR, ROPE_COLOR))
    return LinkTable(index, body_a, body_b, THICKNESS * known.min(axis=0), color.astype(np.uint8))


def with_links(primitives: Primitives, world: Any, index: int, table: LinkTable) -> Primitives:
    """The primitives of one world, and its links where they are now."""
    if not len(table.joint):
        return primitives
    joints = world.parameters.joints[index][table.joint]
    a = _anchors(world, index, table.body_a, joints["anchor_a"])
    b = _anchors(world, index, table.body_b, joints["anchor_b"])
    way = b - a
    length = np.sqrt((way**2).sum(axis=-1))
    n = len(length)
    bodies = world.parameters.bodies[index]["enabled"] != 0
    size = np.zeros((n, 3))
    size[:, 2] = 0.5 * length
    links = Primitives(
        kind=np.full(n, CAPSULE, np.int32),
        position=0.5 * (a + b),
        rotation=_turns(way, length),
        size=size,
        radius=np.minimum(table.radius, LONGEST * length),
        color=table.color,
        enabled=(joints["enabled"] != 0) & bodies[table.body_a] & bodies[table.body_b] & (length > 0.0),
        vertex_first=np.zeros(n, np.int32),
        mark=np.full(n, PLAIN, np.int32),
    )
    both: list[tuple[Any, Any]] = list(zip(primitives, links, strict=True))
    return Primitives(*(np.concatenate(pair) for pair in both))


def _anchors(world: Any, index: int, body: NDArray[np.int32], anchor: FloatArray) -> FloatArray:
    """(link, 3) m in the world."""
    state = world.state.bodies[index][body]
    center = world.parameters.bodies[index]["center"][body]
    place: FloatArray = state["position"] + rotate(state["rotation"], anchor - center)
    return place


def _turns(way: FloatArray, length: FloatArray) -> FloatArray:
    """(link, 4) unit quaternions that turn the z axis into the way."""
    d = np.divide(way, length[:, None], out=np.zeros_like(way), where=length[:, None] > 0.0)
    turns = np.stack([1.0 + d[:, 2], -d[:, 1], d[:, 0], np.zeros(len(d))], axis=-1)
    turns[turns[:, 0] < 1e-9] = (0.0, 1.0, 0.0, 0.0)  # straight down
    return np.asarray(turns / np.sqrt((turns**2).sum(axis=-1, keepdims=True)))
