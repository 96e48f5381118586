"""Draw list: the flat list of primitives between a world and a rasteriser."""

from enum import IntEnum, IntFlag
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class DrawKind(IntEnum):
    """Primitive kinds; a circle is a capsule of half length zero."""

    BOX = 0
    CAPSULE = 1
    POLYGON = 2
    POLYLINE = 3  # a line through its vertices, two or more; round at corners and ends
    HALF_PLANE = 4
    TERRAIN = 5


class DrawFlag(IntFlag):
    """What is drawn besides the flat fill."""

    NONE = 0
    OUTLINE = 1  # inside the silhouette
    SHADE = 2  # vertical gradient
    SHADOW = 4  # casts a drop shadow on grounds and sky
    CLOSED = 8  # TERRAIN: the last vertex is joined to the first


class Layer(IntEnum):
    """Painting order; then list order. Drop shadows fall on GROUND and sky only."""

    GROUND = 0
    LINK = 1  # joints behind the bodies
    BODY = 2
    STRUT = 3
    WHEEL = 4
    PIN = 5  # joints before the bodies
    OVERLAY = 6


SOLID = DrawFlag.OUTLINE | DrawFlag.SHADE | DrawFlag.SHADOW

DRAW_ITEM = np.dtype(
    [
        ("kind", np.int32),  # DrawKind
        ("flags", np.int32),  # DrawFlag
        ("layer", np.int32),  # Layer
        ("vertex_first", np.int32),  # POLYGON, POLYLINE, TERRAIN: into the list's vertices
        ("vertex_count", np.int32),
        ("position", np.float64, 2),  # m; HALF_PLANE: a point of the boundary
        ("rotation", np.float64, 2),  # cos and sin of the angle; HALF_PLANE: local y is outward
        ("size", np.float64, 2),  # m; BOX half extents; CAPSULE half length along local x in [0]
        ("radius", np.float64),  # m; CAPSULE, POLYLINE
        ("alpha", np.float32),  # 0 hides the item
        ("fill", np.float32, 3),  # RGB in 0..255; grounds: just below the edge
        ("line", np.float32, 3),  # outline; grounds: the edge band
        ("deep", np.float32, 3),  # grounds only: colour deep down
    ],
    align=True,
)


class DrawList(NamedTuple):
    """Primitives of one picture.

    items: (item,) DRAW_ITEM
    vertices: (vertex, 2) float64, m, in the frames of their items; polygons are convex with either
        winding; a terrain is a chain with the ground on its right hand
    """

    items: NDArray[np.void]
    vertices: NDArray[np.float64]


NO_VERTICES: NDArray[np.float64] = np.empty((0, 2))


def draw_items(count: int) -> NDArray[np.void]:
    """(count,) opaque, unrotated, black items on the BODY layer."""
    items = np.zeros(count, DRAW_ITEM)
    items["layer"] = Layer.BODY
    items["rotation"][:, 0] = 1.0
    items["alpha"] = 1.0
    return items


def draw_item(
    kind: DrawKind,
    position: ArrayLike = (0.0, 0.0),
    angle: float = 0.0,
    *,
    size: ArrayLike = (0.0, 0.0),
    radius: float = 0.0,
    fill: ArrayLike = (0.0, 0.0, 0.0),
    line: ArrayLike | None = None,
    flags: DrawFlag = DrawFlag.NONE,
    layer: Layer = Layer.BODY,
    vertices: tuple[int, int] = (0, 0),
) -> NDArray[np.void]:
    """(1,) item; `vertices` is (first, count), `line` defaults to the fill colour."""
    items = draw_items(1)
    items["kind"] = kind
    items["position"] = position
    items["rotation"] = (np.cos(angle), np.sin(angle))
    items["size"] = size
    items["radius"] = radius
    items["fill"] = fill
    items["line"] = fill if line is None else line
    items["deep"] = fill
    items["flags"] = flags
    items["layer"] = layer
    items["vertex_first"], items["vertex_count"] = vertices
    return items


def join(*lists: DrawList) -> DrawList:
    """One list after the other."""
    moved = []
    first = 0
    for items, vertices in lists:
        items = items.copy() if first else items
        items["vertex_first"] += first
        first += len(vertices)
        moved.append(items)
    return DrawList(np.concatenate(moved), np.concatenate([part.vertices for part in lists]))
