"""Draw list: the flat list of 2D primitives that the rasteriser paints."""

from enum import IntEnum, IntFlag
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class DrawKind(IntEnum):
    """Primitive kinds; a circle is a capsule of half length zero."""

    BOX = 0
    CAPSULE = 1
    POLYGON = 2
    POLYLINE = 3  # a line through two or more vertices, with round joins and caps
    HALF_PLANE = 4
    TERRAIN = 5


class DrawFlag(IntFlag):
    """Features drawn in addition to the flat fill."""

    NONE = 0
    OUTLINE = 1  # inside the silhouette
    SHADE = 2  # vertical gradient
    SHADOW = 4  # casts a drop shadow on grounds and sky
    CLOSED = 8  # TERRAIN: the last vertex is joined to the first


class Layer(IntEnum):
    """Painting order; items of one layer are painted in list order. Drop shadows fall on GROUND and sky only."""

    GROUND = 0
    LINK = 1  # joint parts behind the bodies
    BODY = 2
    STRUT = 3
    WHEEL = 4
    PIN = 5  # joint parts in front of the bodies
    OVERLAY = 6


SOLID = DrawFlag.OUTLINE | DrawFlag.SHADE | DrawFlag.SHADOW

DRAW_ITEM = np.dtype(
    [
        ("kind", np.int32),  # DrawKind
        ("flags", np.int32),  # DrawFlag
        ("layer", np.int32),  # Layer
        ("vertex_first", np.int32),  # POLYGON, POLYLINE, TERRAIN: index into the list's vertices
        ("vertex_count", np.int32),
        ("position", np.float64, 2),  # m; HALF_PLANE: a point of the boundary
        ("rotation", np.float64, 2),  # cos and sin of the angle; HALF_PLANE: local y is the outward normal
        ("size", np.float64, 2),  # m; BOX: half extents; CAPSULE: [0] is the half length along local x
        ("radius", np.float64),  # m; CAPSULE, POLYLINE
        ("alpha", np.float32),  # 0 hides the item
        ("fill", np.float32, 3),  # RGB in 0..255; grounds: just below the edge band
        ("line", np.float32, 3),  # RGB of the outline; grounds: of the edge band
        ("deep", np.float32, 3),  # RGB of a ground far below its edge
    ],
    align=True,
)


class DrawList(NamedTuple):
    """Primitives of one picture.

    items: (item,) DRAW_ITEM
    vertices: (vertex, 2) float64, m, in the frames of their items; polygons are convex, of either
        winding; a terrain is a chain of segments whose ground is on the right of its direction
    """

    items: NDArray[np.void]
    vertices: NDArray[np.float64]


NO_VERTICES: NDArray[np.float64] = np.empty((0, 2))


def draw_items(count: int) -> NDArray[np.void]:
    """Return (count,) opaque, unrotated, black items on the BODY layer."""
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
    """Return a (1,) item; `vertices` is (first, count), `line` defaults to the fill colour."""
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
    """Concatenate draw lists."""
    moved = []
    first = 0
    for items, vertices in lists:
        items = items.copy() if first else items
        items["vertex_first"] += first
        first += len(vertices)
        moved.append(items)
    return DrawList(np.concatenate(moved), np.concatenate([part.vertices for part in lists]))
