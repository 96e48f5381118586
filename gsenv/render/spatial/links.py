"""Rods, ropes and springs of 3D worlds, drawn as thin capsules from anchor to anchor."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.primitives import CAPSULE, PLAIN, Primitives
from gsenv.render.spatial.world_view import LinkState, LinkTable
from gsenv.render.theme import LINE_COLOR, ROD_COLOR, ROPE_COLOR, SPRING_COLOR

FloatArray = NDArray[np.float64]

THICKNESS = 0.15  # radius of a link over that of the smaller body
LINE_RADIUS = 0.004  # m
THICKEST = 0.03  # largest radius of a link over its length


def with_links(primitives: Primitives, table: LinkTable, links: LinkState) -> Primitives:
    """Return the primitives of a world with its links appended."""
    if not len(table.joint):
        return primitives
    length = np.sqrt(((links.anchor_b - links.anchor_a) ** 2).sum(axis=-1))
    radius = np.minimum(THICKNESS * table.size, THICKEST * length)
    return _with_capsules(primitives, links.anchor_a, links.anchor_b, radius, find_colors(table), links.enabled)


def with_lines(primitives: Primitives, lines: FloatArray) -> Primitives:
    """Return the primitives of a world with thin dark lines (line, 2, 3) in m appended."""
    n = len(lines)
    color = np.broadcast_to(np.asarray(LINE_COLOR, np.uint8), (n, 3))
    return _with_capsules(primitives, lines[:, 0], lines[:, 1], np.full(n, LINE_RADIUS), color, np.ones(n, np.bool_))


def _with_capsules(
    primitives: Primitives,
    start: FloatArray,
    end: FloatArray,
    radius: FloatArray,
    color: NDArray[np.uint8],
    enabled: NDArray[np.bool_],
) -> Primitives:
    n = len(start)
    span = end - start
    length = np.sqrt((span**2).sum(axis=-1))
    size = np.zeros((n, 3))
    size[:, 2] = 0.5 * length
    added = Primitives(
        kind=np.full(n, CAPSULE, np.int32),
        position=0.5 * (start + end),
        rotation=rotations_along(span, length),
        size=size,
        radius=radius,
        color=color,
        enabled=enabled & (length > 0.0),
        vertex_first=np.zeros(n, np.int32),
        mark=np.full(n, PLAIN, np.int32),
    )
    both: list[tuple[Any, Any]] = list(zip(primitives, added, strict=True))
    return Primitives(*(np.concatenate(pair) for pair in both))


def find_colors(table: LinkTable) -> NDArray[np.uint8]:
    """Return the links' colours (link, 3) RGB."""
    stiff = np.where(table.rigid[:, None], ROD_COLOR, ROPE_COLOR)
    return np.where(table.has_spring[:, None], SPRING_COLOR, stiff).astype(np.uint8)


def rotations_along(span: FloatArray, length: FloatArray) -> FloatArray:
    """Return unit quaternions (link, 4) that rotate the z axis to the direction of `span` (link, 3)."""
    d = np.divide(span, length[:, None], out=np.zeros_like(span), where=length[:, None] > 0.0)
    turns = np.stack([1.0 + d[:, 2], -d[:, 1], d[:, 0], np.zeros(len(d))], axis=-1)
    turns[turns[:, 0] < 1e-9] = (0.0, 1.0, 0.0, 0.0)  # straight down
    return np.asarray(turns / np.sqrt((turns**2).sum(axis=-1, keepdims=True)))
